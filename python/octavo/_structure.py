"""Distances, thickness and poses of masks."""

import contextlib
import os
import tempfile

import numpy as np

from . import _octavo
from ._errors import ArgumentError
from ._sources import if_written, written_path
from ._work import connectivity_of, if_given, number_of, work_of


class StructureTasks:
    """What is measured of a label map, every voxel but 0 of which is in the mask."""

    def distance(self, path=None, *, to="faces", max_mm=None, step_mm=None, within_mm=None,
                 overwrite=False, threads=0, max_memory=0, progress=None):
        """The signed distance of every voxel's center from the surface of the mask.

        Exact on every grid. What lies beyond the volume is not known: no distance ends there.

        Parameters
        ----------
        path : str or os.PathLike, optional
            An .8vo file to write; without one an array is returned.
        to : {"faces", "centers"}
            Where distances end: at the faces of voxels, or at the center of the nearest voxel on
            the other side.
        max_mm : float, optional
            Larger distances become this one, either sign.
        step_mm : float or True, optional
            int16 voxels of so many mm, in the file; True: the smallest power of two that reaches
            all. float32 otherwise.
        within_mm : float, optional
            How far a voxel of the file may be off: it is proven, and makes files far smaller.

        Returns
        -------
        numpy.ndarray of float32, [z, y, x], mm; Volume where a path is given
            Below 0 inside, above 0 outside.

        Raises
        ------
        octavo.ArgumentError
            For a mask that is empty or fills the volume, grey values, a spacing that is not known.
        """
        if step_mm is not None and path is None:
            raise ArgumentError("step_mm is of files: give a path")
        if within_mm is not None and path is None:
            raise ArgumentError("within_mm is of files: give a path")
        is_step_chosen = step_mm is True
        name, handle = self._opened_file()
        asked = dict(to=to, max_mm=if_given(_length, max_mm, "max_mm"), steps=step_mm is not None,
                     step_mm=None if is_step_chosen else if_given(_length, step_mm, "step_mm"),
                     within_mm=if_given(_length, within_mm, "within_mm"),
                     overwrite=bool(overwrite))
        with _Maps() as maps, work_of(threads, max_memory, progress) as work:
            place = maps.place_of("path", True if path is None else path)
            _octavo.distance(handle, name, place, asked, work)
            return maps.made("path")

    def morphometry(self, *, region=None, of=None, calibration=(1, 0), thickness=True,
                    tortuosity=False, diffusion=False, thickness_map=None, spacing_map=None,
                    histogram=None, overwrite=False, threads=0, max_memory=0, progress=None):
        """Measure structure: volume share, surface, thickness, separation, connectivity and more.

        docs/morphometry.md says how each number is computed, and by whom it is defined.

        Parameters
        ----------
        region : Volume or LabelMap, optional
            A label map on the same grid to measure within.
        of : Volume, optional
            The scan on the same grid, for densities.
        calibration : (slope, intercept)
            density = slope * real value of the scan + intercept.
        thickness : bool
            False leaves out Tb.Th, Tb.Sp, Tb.N and what is measured slice by slice.
        tortuosity : bool
            Whether the geodesic tortuosity of what is not in the mask is measured, along x, y, z:
            from end to end of the region, but for axes on which it tapers.
        diffusion : bool
            Whether its effective diffusivity and diffusive tortuosity are.
        thickness_map, spacing_map : True, str or os.PathLike, optional
            The local thickness of the mask, and of what is not in it: a path writes it to an .8vo
            file, True returns it as an array.
        histogram : str or os.PathLike, optional
            A PNG of the histograms of thickness and separation.

        Returns
        -------
        dict
            The members of ``octavo morphometry --json``, among them bv_tv, bs_mm2, tb_th_mm,
            tb_sp_mm, connectivity, degree_of_anisotropy, slices; and thickness_map, spacing_map:
            float32 arrays [z, y, x] in mm, or Volumes, None where they were not asked for.

        Raises
        ------
        octavo.ArgumentError
            For a mask without voxels in the region, grids that differ, a spacing that is not known,
            maps of a mask that fills the volume.
        """
        from ._tasks import opened_beside
        name, handle = self._opened_file()
        line = _line(calibration)
        if not thickness and any(m is not None for m in (thickness_map, spacing_map, histogram)):
            raise ArgumentError("thickness=False leaves out what maps and histograms show")
        if of is None and line != (1, 0):
            raise ArgumentError("calibration is of the scan that `of` gives")
        asked = dict(mask=name, region="", grey="", calibration=line, thickness=bool(thickness),
                     tortuosity=bool(tortuosity), diffusion=bool(diffusion),
                     overwrite=bool(overwrite), histogram=if_written(histogram))
        files = [handle]
        for key, given in (("region", region), ("grey", of)):
            if given is None:
                continue
            asked[key], file = opened_beside(given, "of" if key == "grey" else key, asked["mask"],
                                             asked["region"])
            files.append(file)
        with _Maps() as maps, work_of(threads, max_memory, progress) as work:
            for key, map_given in (("thickness_map", thickness_map), ("spacing_map", spacing_map)):
                asked[key] = maps.place_of(key, map_given)
            facts = _octavo.morphometry(files, asked, work)
            facts["thickness_map"] = maps.made("thickness_map")
            facts["spacing_map"] = maps.made("spacing_map")
        return facts

    def align(self, fixed, *, scale=False, output=None, picture=None, overwrite=False, threads=0,
              max_memory=0, progress=None):
        """The pose that lays the surface of this mask onto that of another.

        Nothing has to be near, and half of a surface may be missing on either side.

        Parameters
        ----------
        fixed : Volume or LabelMap
            The mask that stays.
        scale : bool
            Whether the size is found as well.
        output : str or os.PathLike, optional
            A text file for the matrix, as the program takes it; written where a pose is found.
        picture : str or os.PathLike, optional
            A PNG of both, written where a pose is found.

        Returns
        -------
        dict
            The members of ``octavo align --json``. matrix_mm is 4 x 4, mm in x, y, z (LPS), what
            ``transform(affine=)`` takes; None where found is False. Where doubtful is True,
            fewer points agree than of the same surface do.

        Raises
        ------
        octavo.ArgumentError
            For a mask without a surface, and a spacing that is not known.
        """
        from ._tasks import opened_file
        name, handle = self._opened_file()
        fixed_name, fixed_handle = opened_file(fixed, "fixed")
        # Meshes are laid onto masks as well: the task tells them apart by what names end in.
        name = _volume_name(name)
        fixed_name = _volume_name(fixed_name)
        if fixed_name == name:
            fixed_name = "fixed " + fixed_name
        return _pose(handle, name, fixed_handle, fixed_name, scale, output, picture, overwrite,
                     threads, max_memory, progress)

    def align_features(self, features, *, scale=False, output=None, picture=None, overwrite=False,
                       threads=0, max_memory=0, progress=None):
        """The pose that lays a mesh, points or lines of sight onto the surface of this mask.

        Parameters
        ----------
        features : str, os.PathLike or array_like
            A file: .stl, .ply, .obj, or .csv with three or six numbers a row. Or these as an array:
            points (n, 3), or two places on each line (n, 6), x, y, z in mm (LPS). Lines of sight,
            from the source of X-rays through the outline of a shadow, are laid so that they touch
            the surface.
        scale, output, picture
            As of `align`.

        Returns
        -------
        dict
            As of `align`; points counts lines where has_lines is True.
        """
        name, handle = self._opened_file()
        with tempfile.TemporaryDirectory(prefix="octavo-") as folder:
            if isinstance(features, (str, os.PathLike)):
                moving = written_path(features)
            else:
                moving = os.path.join(folder, "features.csv")
                np.savetxt(moving, _rows_of(features), fmt="%.17g", delimiter=",")
            return _pose(None, moving, handle, _volume_name(name), scale, output, picture,
                         overwrite, threads, max_memory, progress)

    def touch(self, other=None, *, connectivity=6, threads=0, max_memory=0, progress=None):
        """How this mask and another meet, or which labels of a label map lie side by side.

        Parameters
        ----------
        other : Volume or LabelMap, optional
            A mask on the same grid.
        connectivity : {6, 18, 26}
            Which voxels are neighbors.

        Returns
        -------
        dict, or list of dict without `other`
            overlap, contact, contact_of_other: dicts of voxels and box (((z, y, x), (z, y, x)),
            half-open, or None); and area_mm2, None where the spacing is not known. Or for each pair
            of labels: first, second, voxel_pairs, area_mm2.
        """
        from ._tasks import opened_beside
        name, handle = self._opened_file()
        neighbors = connectivity_of(connectivity)
        if other is None:
            with work_of(threads, max_memory, progress) as work:
                return _octavo.contacts(handle, name, neighbors, work)
        other_name, other_handle = opened_beside(other, "other", name)
        with work_of(threads, max_memory, progress) as work:
            return _octavo.touch(handle, name, other_handle, other_name, neighbors, work)

    def shell(self, *, threads=0, max_memory=0, progress=None):
        """The leaves of the octree of the mask that others do not hide on all six sides.

        Returns
        -------
        LabelMap
        """
        from ._volume import Volume
        name, handle = self._opened_file()
        with tempfile.TemporaryDirectory(prefix="octavo-") as folder:
            path = os.path.join(folder, "shell.8vo")
            with work_of(threads, max_memory, progress) as work:
                _octavo.shell(handle, name, path, work)
            with Volume(path) as made:
                return made.mask(threads=threads, max_memory=max_memory)


def _pose(moving_handle, moving, fixed_handle, fixed, scale, output, picture, overwrite, threads,
          max_memory, progress):
    asked = dict(moving=moving, fixed=fixed, scale=bool(scale), output=if_written(output),
                 picture=if_written(picture), overwrite=bool(overwrite))
    with work_of(threads, max_memory, progress) as work:
        facts = _octavo.align(moving_handle, fixed_handle, asked, work)
    if facts["found"]:
        facts["matrix_mm"] = np.vstack((facts["matrix_mm"], (0, 0, 0, 1)))
    return facts


def _rows_of(features):
    try:
        rows = np.asarray(features, float)
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] not in (3, 6) or not np.isfinite(rows).all():
        raise ArgumentError("features are a file, points (n, 3) or lines (n, 6)")
    return rows


class _Maps(contextlib.ExitStack):
    """Files that a task writes: those asked for stay, others become arrays and go."""

    def __init__(self):
        super().__init__()
        self._paths = {}
        self._kept = set()

    def place_of(self, name, given):
        """Where the map of that name goes; empty where none was asked for."""
        from ._building import _output
        if given is None or given is False:
            return ""
        if given is not True:
            self._kept.add(name)
            self._paths[name] = _output(given)
        else:
            folder = self.enter_context(tempfile.TemporaryDirectory(prefix="octavo-"))
            self._paths[name] = os.path.join(folder, "map.8vo")
        return self._paths[name]

    def made(self, name):
        """The map as a Volume or an array of real values; None where none was asked for."""
        from ._volume import Volume
        if name not in self._paths:
            return None
        volume = Volume(self._paths[name])
        if name in self._kept:
            return volume
        with volume:
            return volume.real[...]


def _volume_name(name):
    return name if name.endswith(".8vo") else name + ".8vo"


def _length(given, name):
    mm = number_of(given, name)
    if mm <= 0:
        raise ArgumentError(f"{name} is above 0, not {given!r}")
    return mm


def _line(given):
    try:
        slope, intercept = given
    except (TypeError, ValueError):
        raise ArgumentError(f"calibration is (slope, intercept), not {given!r}") from None
    return number_of(slope, "slope"), number_of(intercept, "intercept")
