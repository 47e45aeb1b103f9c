"""xarray's engine "octavo": ``xarray.open_dataset("scan.8vo", engine="octavo")``."""

import numpy as np
from xarray import DataArray, Dataset, Variable
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from ._coordinates import ALONG_AXES, WORLD, grid_coordinates
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


# What xarray may be told of conventions by which files of other formats are decoded.
_DECODERS = {"mask_and_scale", "decode_times", "decode_timedelta", "use_cftime",
             "concat_characters", "decode_coords"}


class OctavoBackend(BackendEntrypoint):
    """Opens .8vo files: one variable, ``voxels``, over z, y, x.

    Coordinates are the centers of voxels, LPS and in mm, where each axis of the grid is parallel to
    its own of the world; they descend where it points the other way. Of other grids they are mm
    along the axes, from the first voxel of level 0; where the spacing is not known, its voxels. The
    attribute ``coordinate_system`` says which; ``affine`` has the 4 x 4 numbers, row by row, that
    take an index (z, y, x, 1) to the world, LPS x, y, z.
    """

    description = "Octavo volumes (.8vo)"
    open_dataset_parameters = ("filename_or_obj", "drop_variables", "level", "real")

    def open_dataset(self, filename_or_obj, *, drop_variables=None, level=0, real=False,
                     **decoders):
        """A level of a file, read where it is used.

        Parameters
        ----------
        level : int
        real : bool
            slope * voxel + intercept as float32, instead of stored voxels.
        **decoders
            ``mask_and_scale`` and the like, which mean nothing here.
        """
        if unknown := sorted(decoders.keys() - _DECODERS):
            raise TypeError(f"open_dataset has no option {unknown[0]}")
        volume = Volume(filename_or_obj)
        level = whole_number(level, "level", 0, len(volume.levels) - 1)
        view = volume.real.levels[level] if real else volume.levels[level]
        is_known = volume.is_spacing_known
        if is_known:
            places, is_world = grid_coordinates(view.affine, view.translation)
            system = WORLD if is_world else ALONG_AXES
        else:
            places = [((factor - 1) / 2, factor) for factor in view.factor]
            system = "voxels of level 0"
        units = {"units": "mm"} if is_known else {}
        coordinates = {
            axis: DataArray(first + step * np.arange(count), dims=(axis,), attrs=units)
            for axis, (first, step), count in zip("zyx", places, view.shape)}
        # NetCDF has attributes of one axis at most.
        attributes = {"kind": "grey" if real else volume.kind, "level": level,
                      "affine": view.affine.ravel().tolist(),
                      "translation": list(view.translation), "coordinate_system": system}
        if not real:
            attributes |= {"slope": volume.slope, "intercept": volume.intercept}
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
