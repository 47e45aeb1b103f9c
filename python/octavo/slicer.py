"""Volumes as 3D Slicer takes them, for the reader in slicer_module/.

    print(octavo.slicer.module_folder())     # what Slicer's settings take as a module path
"""

import os

import numpy as np

from ._volume import Volume
from ._work import if_given, level_of, whole_number

USUAL_BYTES = 2 << 30


def module_folder():
    """The folder with the scripted module, for Slicer's list of additional module paths."""
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "slicer_module")


def ijk_to_ras(view):
    """4 x 4: the index (i, j, k, 1) of a voxel, along x, y, z, to its center in RAS, mm."""
    return view.affine_ras[:, [2, 1, 0, 3]]


def node_of(path, level=None, nbytes=USUAL_BYTES):
    """What a volume node of Slicer is made of.

    Parameters
    ----------
    path : str or os.PathLike
        As of `octavo.open`.
    level : int, optional
        Without one the finest that takes at most `nbytes`, or else the coarsest.
    nbytes : int

    Returns
    -------
    dict
        narray: [k, j, i], real values as float32 where stored ones are not, or labels; ijkToRAS;
        name; nodeClassName. The arguments of ``slicer.util.addVolumeFromArray``.
    """
    level = if_given(level_of, level)
    with Volume(path) as volume:
        view = volume.at_budget(whole_number(nbytes, "nbytes", 1)) if level is None else (
            volume.levels[level])
        is_labels = volume.kind == "labels"
        is_stored = is_labels or (volume.slope, volume.intercept) == (1, 0)
        voxels = view[...] if is_stored else volume.real.levels[view.level][...]
        name = os.path.basename(volume.name).removesuffix(".8vo")
        if view.level:
            name += f" 1/{max(view.factor)}"
        return dict(narray=np.ascontiguousarray(voxels), ijkToRAS=ijk_to_ras(view), name=name,
                    nodeClassName=("vtkMRMLLabelMapVolumeNode" if is_labels else
                                   "vtkMRMLScalarVolumeNode"))
