"""xarray's engine "octavo": ``xarray.open_dataset("scan.8vo", engine="octavo")``."""

import numpy as np
from xarray import DataArray, Dataset, Variable
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from ._volume import Volume
from ._work import whole_number


class _LevelArray(BackendArray):
    """A level that xarray reads where it is indexed."""

    def __init__(self, view):
        self._view = view
        self.shape = view.shape
        self.dtype = view.dtype

    def __getitem__(self, key):
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC,
                                                  self._view.__getitem__)


class OctavoBackend(BackendEntrypoint):
    """Opens .8vo files: one variable, ``voxels``, over z, y, x.

    Coordinates are the centers of voxels in mm, LPS, or in voxels where the spacing is not known;
    where the axes of the grid are not those of the world, they count along the grid from its first
    voxel.
    """

    description = "Octavo volumes (.8vo)"
    open_dataset_parameters = ("filename_or_obj", "drop_variables", "level", "real")

    def open_dataset(self, filename_or_obj, *, drop_variables=None, level=0, real=False):
        """A level of a file, read where it is used.

        Parameters
        ----------
        level : int
        real : bool
            slope * voxel + intercept as float32, instead of stored voxels.
        """
        volume = Volume(filename_or_obj)
        level = whole_number(level, "level", 0, len(volume.levels) - 1)
        view = volume.real.levels[level] if real else volume.levels[level]
        direction = volume.affine[:3, :3] / np.array(volume.spacing)
        is_upright = np.allclose(direction, np.eye(3)[:, ::-1], atol=1e-6)
        start = view.origin if is_upright else view.translation
        units = {"units": "mm"} if volume._file.facts["is_spacing_known"] else {}
        coordinates = {
            axis: DataArray(first + step * np.arange(count), dims=(axis,), attrs=units)
            for axis, first, step, count in zip("zyx", start, view.spacing, view.shape)}
        attributes = {"kind": volume.kind, "affine": view.affine.tolist(), "level": level,
                      "translation": list(view.translation)}
        if volume.unit:
            attributes["units"] = "HU" if volume.unit == "[hnsf'U]" else volume.unit
        data = indexing.LazilyIndexedArray(_LevelArray(view))
        variable = Variable(("z", "y", "x"), data, attributes,
                            encoding={"preferred_chunks": dict(zip("zyx", view.chunks))})
        dataset = Dataset({"voxels": variable}, coordinates)
        if drop_variables:
            dataset = dataset.drop_vars(drop_variables, errors="ignore")
        dataset.set_close(volume.close)
        return dataset

    def guess_can_open(self, filename_or_obj):
        """Whether the name ends in .8vo."""
        return str(filename_or_obj).endswith(".8vo")
