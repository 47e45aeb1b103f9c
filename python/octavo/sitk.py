"""Volumes to and from SimpleITK, with their place in the world."""

import numpy as np
import SimpleITK

from ._building import build
from ._errors import ArgumentError


def to_sitk(view, box=None, *, real=False):
    """A level, or a box of it, as a SimpleITK image.

    Parameters
    ----------
    view : Volume or View
    box : ((z0, y0, x0), (z1, y1, x1)), optional
        Half-open, in voxels of the level.
    real : bool
        slope * voxel + intercept as float32, instead of stored voxels.

    Returns
    -------
    SimpleITK.Image
    """
    start = (0, 0, 0) if box is None else box[0]
    voxels = view.read(box)
    if real:
        facts = view._file.facts
        voxels = (voxels.astype(np.float64) * facts["slope"] + facts["intercept"]).astype(
            np.float32)
    image = SimpleITK.GetImageFromArray(voxels)
    image.SetSpacing([float(s) for s in view.spacing[::-1]])
    image.SetOrigin([float(n) for n in (view.affine @ [*start, 1])[:3]])
    image.SetDirection([float(n) for n in view._file.facts["direction"]])
    return image


def from_sitk(image, path, **options):
    """Build an .8vo file of a SimpleITK image of three dimensions and one component.

    Parameters
    ----------
    image : SimpleITK.Image
    path : str or os.PathLike
        Ends in .8vo.
    **options
        Of `octavo.build`.

    Returns
    -------
    Volume
    """
    if image.GetDimension() != 3 or image.GetNumberOfComponentsPerPixel() != 1:
        raise ArgumentError("a volume has three dimensions and one component")
    return build(SimpleITK.GetArrayViewFromImage(image), path,
                 **{"spacing": image.GetSpacing()[::-1], "origin": image.GetOrigin()[::-1],
                    "direction": np.array(image.GetDirection()).reshape(3, 3), **options})
