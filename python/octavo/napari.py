"""napari's reader of .8vo files: all levels as one layer, read where it is looked at.

Registered by napari.yaml; ``viewer.open("scan.8vo")`` then works.
"""

import itertools
import os

import numpy as np

from ._volume import Volume
from ._zarr import as_dask


def get_reader(path):
    """What reads `path`; None where it is no .8vo file. As npe2 asks for it."""
    paths = [path] if isinstance(path, str) else list(path)
    if paths and all(str(one).endswith(".8vo") for one in paths):
        return read_layers
    return None


def read_layers(path):
    """Layers of one or several files, as napari takes them: (data, attributes, type)."""
    paths = [path] if isinstance(path, str) else list(path)
    return [layer_of(Volume(one)) for one in paths]


def layer_of(volume, smallest_side=16):
    """A volume as a layer: an image, or labels.

    Parameters
    ----------
    volume : Volume
    smallest_side : int
        Coarser levels, whose sides are all shorter, are left out.

    Returns
    -------
    (list of dask.array.Array, dict, str)
        In napari's world, mm in z, y, x; an oblique grid by its affine map. Axes of the arrays are
        in the order of those of the world that they are nearest to, as napari slices arrays.
    """
    levels = [view for view in volume.levels
              if view.level == 0 or max(view.shape) >= smallest_side]
    order = _order_in_world(volume)
    attributes = {"name": os.path.basename(volume.name), "multiscale": True,
                  "affine": _affine_zyx(volume)[:, [*order, 3]],
                  "metadata": {"unit": volume.unit, "sha256": volume.voxels_sha256}}
    if volume.kind == "labels":
        return [as_dask(view).transpose(order) for view in levels], attributes, "labels"
    real = volume.real.levels
    low, high = sorted((volume.slope * volume.min + volume.intercept,
                        volume.slope * volume.max + volume.intercept))
    attributes["contrast_limits"] = (float(low), float(high) if high > low else float(low) + 1)
    arrays = [as_dask(real[view.level]).transpose(order) for view in levels]
    return arrays, attributes, "image"


def _order_in_world(volume):
    """For each axis of the world, z, y, x, the axis of the grid that stands for it."""
    cosines = np.abs(volume.affine[2::-1, :3] / np.linalg.norm(volume.affine[:3, :3], axis=0))
    return max(itertools.permutations(range(3)), key=lambda order: cosines[range(3), order].sum())


def _affine_zyx(volume):
    """Index (z, y, x) to the world in the order z, y, x."""
    matrix = np.eye(4)
    matrix[:3] = volume.affine[2::-1]
    return matrix
