"""What can be done with a file: masks of it, measures, surfaces, pictures, volumes made of it."""

import os
from typing import NamedTuple

import numpy as np

from . import _octavo
from ._errors import ArgumentError
from ._sources import written_path
from ._structure import StructureTasks
from ._work import (asked_labels, if_given, level_of, number_of, range_of, several_of, text_of,
                    texts_of, whole_number, work_of)

_AXES = {"z": 2, "y": 1, "x": 0}
_MOST_PICTURES = 999
MODES = ("cubes", "surface", "transparency", "volume", "mip", "minip", "mean", "iso")


class Surface(NamedTuple):
    """A closed surface of triangles.

    Attributes
    ----------
    vertices : numpy.ndarray of float32, (n, 3)
        x, y, z in mm, LPS or RAS as asked for.
    faces : numpy.ndarray of uint32, (m, 3)
        Vertices of each triangle, counterclockwise seen from outside.
    facts : dict
        closed, manifold, components, area_mm2, volume_mm3, max_deviation_mm, full_triangles.
    """

    vertices: np.ndarray
    faces: np.ndarray
    facts: dict


class FileTasks(StructureTasks):
    """What volumes and label maps share: each method is a verb of the program ``octavo``, and gives
    what that gives. All release the GIL, end with Ctrl-C, and take

    threads, max_memory : int
        0: all cores, no limit (bytes).
    progress : callable or True, optional
        Called as progress(done, total, what); True shows a bar of tqdm.
    """

    def measure(self, of=None, *, labels=None, percentiles=(5, 25, 50, 75, 95), threads=0,
                max_memory=0, progress=None):
        """Measure the regions of a label map.

        Parameters
        ----------
        of : Volume, optional
            The grey values to measure under the labels, on the same grid.
        labels : int, str or several, optional
            Only these, by number or name.
        percentiles : sequence of float
            Of the grey values.

        Returns
        -------
        list of dict
            One for each label but 0, ready for ``pandas.DataFrame``, with the columns of
            ``octavo measure --csv``: positions in mm (LPS), boxes in voxels, half-open; None where
            the spacing is not known.

        Raises
        ------
        octavo.ArgumentError
            For grey values in the place of labels, and grids that differ.
        """
        name, handle = self._opened_file()
        grey_name, grey = ("", None) if of is None else opened_file(of, "of")
        if grey_name == name and grey is not handle:
            grey_name += " (grey)"
        numbers, names = asked_labels(labels)
        with work_of(threads, max_memory, progress) as work:
            return _octavo.measure(handle, name, grey, grey_name,
                                   [number_of(p, "a percentile") for p in percentiles], numbers,
                                   names, work)

    def compare(self, other, *, max_error=0.0, threads=0, max_memory=0, progress=None):
        """Compare place and voxels.

        Parameters
        ----------
        other : Volume or LabelMap
        max_error : float
            The largest difference, in real units, that counts as equal.

        Returns
        -------
        dict
            equal, same_stored, same_shape, same_dtype, same_place, shift_mm, different_voxels,
            max_difference, first_different (z, y, x or None).
        """
        other = opened_file(other, "other")[1]
        with work_of(threads, max_memory, progress) as work:
            return _octavo.compare(self._opened_file()[1], other,
                                   number_of(max_error, "max_error"), work)

    def surface(self, isovalue=None, *, labels=None, stored=False, level=0, seed=None,
                max_deviation_mm=0.0, triangles=None, space="lps", threads=0, max_memory=0,
                progress=None):
        """The surface of what lies inside, closed and turned outward.

        Parameters
        ----------
        isovalue : float, optional
            Of grey values, in real units: what is at or above it lies inside.
        labels : int, str or several, optional
            Of a label map these; without any every voxel but 0.
        stored : bool
            The isovalue is a stored value.
        level : int
        seed : (z, y, x), optional
            Only the piece that comes nearest to this place, in voxels of the level.
        max_deviation_mm : float
            Fewer triangles, proven to lie so near to the full surface, and that to them.
        triangles : int, optional
            Instead: so many at most.
        space : {"lps", "ras"}

        Returns
        -------
        Surface
            (vertices, faces, facts)

        Raises
        ------
        octavo.ArgumentError
            Where nothing lies inside.
        """
        name, handle = self._opened_file()
        asked = _asked_surface(isovalue, labels, stored, level, seed, max_deviation_mm, triangles,
                               space, True)
        with work_of(threads, max_memory, progress) as work:
            return Surface(*_octavo.surface(handle, name, asked, work))

    def save_surface(self, path, isovalue=None, *, labels=None, stored=False, level=0, seed=None,
                     max_deviation_mm=0.0, triangles=None, space="lps", allow_faults=False,
                     overwrite=False, threads=0, max_memory=0, progress=None):
        """Write the surface to a file that ends in .stl, .ply, .obj, .glb, .vtp or .3mf.

        As `surface`; nothing is written where the surface is not closed or not manifold, unless
        `allow_faults`.

        Returns
        -------
        dict
            The facts of `Surface`, and points, triangles, file_bytes.
        """
        name, handle = self._opened_file()
        path = written_path(path)
        asked = _asked_surface(isovalue, labels, stored, level, seed, max_deviation_mm, triangles,
                               space, allow_faults)
        with work_of(threads, max_memory, progress) as work:
            return _octavo.save_surface(handle, name, path, bool(overwrite), asked, work)

    def slice(self, axis="z", index=None, *, position_mm=None, level=0, window=None, preset="",
              overlays=(), text=True, minimum_side=512, threads=0, max_memory=0, progress=None):
        """Draw a slice with square pixels.

        Parameters
        ----------
        axis : {"z", "y", "x"}
        index : int, optional
            In voxels of the level; the middle one by default.
        position_mm : float, optional
            In place of it: along the axis of the body, LPS.
        window : (low, high), optional
            Real values from black to white.
        preset : str
            In place of it one of the windows of CT: "bone", "lung", ...
        overlays : Volume or LabelMap, or several
            Drawn over it, where they lie in space.
        text : bool
            Whether scale, sides, position and legend are written on it.
        minimum_side : int
            Smaller pictures are enlarged by a whole number.

        Returns
        -------
        numpy.ndarray of uint8, [y, x, 3]
        """
        if axis not in _AXES:
            raise ArgumentError(f'axis is "z", "y" or "x", not {axis!r}')
        name, handle = self._opened_file()
        asked = dict(axis=_AXES[axis], index=if_given(whole_number, index, "index", -(1 << 62)),
                     level=level_of(level), preset=text_of(preset, "preset"),
                     position_mm=if_given(number_of, position_mm, "position_mm"),
                     window=if_given(range_of, window, "a window"), text=bool(text),
                     minimum_side=whole_number(minimum_side, "minimum_side", 0))
        if isinstance(overlays, FileTasks):
            overlays = (overlays,)
        drawn = []
        for number, overlay in enumerate(several_of(overlays, "overlays")):
            overlay_name, overlay_handle = opened_file(overlay, "an overlay")
            drawn.append((f"{overlay_name} ({number + 2})" if overlay_name in
                          (name, *(n for n, _ in drawn)) else overlay_name, overlay_handle))
        with work_of(threads, max_memory, progress) as work:
            return _octavo.slice(handle, name, drawn, asked, work)

    def render(self, mode=None, *, view="left-front-top", azimuth=None, elevation=None, ranges=(),
               tissues=(), labels=None, level=None, isovalue=None, window=None, transfer=None,
               size=(1024, 1024), zoom=1.0, turntable=0, background="black", text=True, threads=0,
               max_memory=0, progress=None):
        """Draw what is seen from a side.

        Parameters
        ----------
        mode : {"cubes", "surface", "transparency", "volume", "mip", "minip", "mean", "iso"}
            "surface" for label maps, "volume" for grey values where it is not given.
        view : str
            "front", "left-top", ...; or azimuth and elevation in degrees.
        ranges : sequence of (low, high)
            Of modes "cubes", "surface" and "transparency": real values to draw.
        tissues : sequence of str
            The same by name: "bone", ...
        labels : int, str or several, optional
            Of a label map only these.
        isovalue : float, optional
            Of mode "iso".
        window : (low, high), optional
            Of modes "transparency", "mip", "minip" and "mean".
        transfer : str or os.PathLike, optional
            Of modes "volume" and "iso": a preset, or a file of JSON.
        size : (int, int)
            Width and height in pixels.
        turntable : int
            So many pictures once around the patient.

        Returns
        -------
        numpy.ndarray of uint8, [y, x, 3]; of a turntable [picture, y, x, 3]
        """
        is_of_labels = getattr(self, "kind", "labels") == "labels"
        mode = mode or ("surface" if is_of_labels else "volume")
        if mode not in MODES:
            raise ArgumentError(f"mode is one of {', '.join(MODES)}, not {mode!r}")
        name, handle = self._opened_file()
        numbers, names = asked_labels(labels)
        if isinstance(transfer, os.PathLike):
            transfer = os.fspath(transfer)
        asked = dict(mode=mode, view=text_of(view, "view"),
                     azimuth=if_given(number_of, azimuth, "azimuth"),
                     elevation=if_given(number_of, elevation, "elevation"),
                     ranges=[range_of(r) for r in several_of(ranges, "ranges")],
                     tissues=texts_of(tissues, "tissues"), labels=numbers, names=names,
                     level=if_given(level_of, level),
                     isovalue=if_given(number_of, isovalue, "isovalue"),
                     window=if_given(range_of, window, "a window"),
                     transfer=if_given(text_of, transfer, "transfer"), size=_size(size),
                     zoom=number_of(zoom, "zoom"),
                     turntable=whole_number(turntable, "turntable", 0, _MOST_PICTURES),
                     background=text_of(background, "background"), text=bool(text))
        with work_of(threads, max_memory, progress) as work:
            pictures = _octavo.render(handle, name, asked, work)
        return np.stack(pictures) if turntable else pictures[0]

    def transform(self, path, *, grid_of=None, interpolation=None, fill=None, in_place=False,
                  inverse=False, preset="small", max_error=0.0, overwrite=False, threads=0,
                  max_memory=0, progress=None, **steps):
        """Write it moved, turned, mirrored, scaled, or on another grid.

        Parameters
        ----------
        path : str or os.PathLike
            Ends in .8vo.
        grid_of : Volume or LabelMap, optional
            Whose grid is the last one.
        interpolation : {"nearest", "linear", "cubic"}, optional
        fill : float, optional
            The real value of voxels from outside.
        in_place : bool
            The grid stays about its center, and the object turns or grows.
        inverse : bool
            An affine map leads from the new place to the old one.
        **steps
            Done in the order in which they are given:
            ``translate=(z, y, x)`` in voxels, ``translate_mm=(z, y, x)``: the origin moves;
            ``shift=(z, y, x)``: voxels move within the grid;
            ``rotate=("z", 90)`` or ``rotate=((z, y, x), 90)``: degrees about an axis of the grid;
            ``mirror="x"`` or ``"xy"``; ``scale=2``: a grid as much finer, ``scale=0.5``: coarser;
            ``affine=``: 4 x 4, mm in x, y, z (LPS).

        Returns
        -------
        Volume
        """
        from ._building import _output
        from ._volume import Volume
        path = _output(path)
        if preset not in ("small", "fast"):
            raise ArgumentError(f'preset is "small" or "fast", not {preset!r}')
        if interpolation not in (None, "nearest", "linear", "cubic"):
            raise ArgumentError('interpolation is "nearest", "linear" or "cubic", not '
                                f"{interpolation!r}")
        name, handle = self._opened_file()
        grid_name, grid = (("", None) if grid_of is None else
                           opened_file(grid_of, "grid_of"))
        if grid_name == name and grid is not handle:
            grid_name += " (grid)"
        asked = dict(overwrite=bool(overwrite), in_place=bool(in_place), inverse=bool(inverse),
                     interpolation=interpolation, preset=preset,
                     fill=None if fill is None else number_of(fill, "fill"),
                     max_error=number_of(max_error, "max_error"))
        with work_of(threads, max_memory, progress) as work:
            _octavo.transform(handle, name, path, [_step(*step) for step in steps.items()], grid,
                              grid_name, asked, work)
        return Volume(path)


class VolumeTasks(FileTasks):
    """What can be done with an open file alone."""

    def threshold(self, low=None, high=None, *, ranges=(), tissue=(), stored=False, threads=0,
                  max_memory=0, progress=None):
        """The mask of voxels whose values lie in a range, both ends included.

        Parameters
        ----------
        low, high : float, optional
            Real values; an end left out is open, but NaN and infinities are in no range.
        ranges : sequence of (low, high)
            More of them.
        tissue : str or several
            "bone" and others that have ranges in HU.
        stored : bool
            The ends are stored values.

        Returns
        -------
        LabelMap
            Bricks whose minimum and maximum decide are not decoded.
        """
        from ._label_map import LabelMap
        name, handle = self._opened_file()
        asked = [range_of(r) for r in several_of(ranges, "ranges")]
        tissues = texts_of(tissue, "tissue")
        if low is not None or high is not None:
            asked.insert(0, range_of((low, high)))
        with work_of(threads, max_memory, progress) as work:
            return LabelMap(_octavo.threshold(handle, name, asked, tissues, bool(stored), work))

    def label_map(self, labels=None, *, threads=0, max_memory=0, progress=None):
        """The labels of a label map as an octree in memory: all, or those asked for by number or
        name.

        Raises
        ------
        octavo.ArgumentError
            For grey volumes.
        """
        from ._label_map import LabelMap
        name, handle = self._opened_file()
        numbers, names = asked_labels(labels)
        with work_of(threads, max_memory, progress) as work:
            return LabelMap(_octavo.label_tree(handle, name, numbers, names, work))

    def mask(self, labels=None, *, threads=0, max_memory=0, progress=None):
        """Every voxel of a label map that is not 0, or has one of the labels, as a mask."""
        made = self.label_map(labels, threads=threads, max_memory=max_memory, progress=progress)
        numbers = [label for label in made.counts if label != 0]
        return made.select(*numbers) if numbers else made ^ made

    def condense(self, path, flat, *, overwrite=False, threads=0, max_memory=0, progress=None):
        """Write a grey volume whose cubes that hardly vary hold their means.

        Parameters
        ----------
        path : str or os.PathLike
            Ends in .8vo.
        flat : float
            The most by which voxels of a cube may differ, in real units.

        Returns
        -------
        Volume
        """
        from ._building import _output
        path = _output(path)
        name, handle = self._opened_file()
        with work_of(threads, max_memory, progress) as work:
            _octavo.condense(handle, name, path, number_of(flat, "flat"), bool(overwrite), work)
        return type(self)(path)

    def _opened_file(self):
        return self.name, self._file._opened()


def opened_file(given, name):
    """Name and handle of a volume or label map. Raises ArgumentError for anything else."""
    if not isinstance(given, FileTasks):
        raise ArgumentError(f"{name} is a Volume or a LabelMap, not {type(given).__name__}")
    return given._opened_file()


def _asked_surface(isovalue, labels, stored, level, seed, max_deviation_mm, triangles, space,
                   allow_faults):
    if space not in ("lps", "ras"):
        raise ArgumentError(f'space is "lps" or "ras", not {space!r}')
    numbers, names = asked_labels(labels)
    return dict(isovalue=None if isovalue is None else number_of(isovalue, "isovalue"),
                stored=bool(stored), labels=numbers, names=names, level=level_of(level),
                seed=None if seed is None else _three(seed, "seed"),
                max_deviation_mm=number_of(max_deviation_mm, "max_deviation_mm"),
                triangles=None if triangles is None else number_of(triangles, "triangles"),
                space=space, allow_faults=bool(allow_faults))


def _size(given):
    size = several_of(given, "width and height")
    if len(size) != 2:
        raise ArgumentError(f"size is (width, height), not {given!r}")
    return tuple(whole_number(side, "a side of size", 0) for side in size)


def _three(given, name):
    try:
        numbers = [float(n) for n in given]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != 3:
        raise ArgumentError(f"{name} is (z, y, x), not {given!r}")
    return numbers


def _step(name, given):
    """A step as the extension takes it: its name and numbers."""
    if name in ("translate", "translate_mm", "shift"):
        numbers = _three(given, name)
        if name != "translate_mm" and any(n != int(n) for n in numbers):
            raise ArgumentError(f"{name} counts whole voxels")
        return name, numbers
    if name == "rotate":
        axis, degrees = given if isinstance(given, (tuple, list)) and len(given) == 2 else (0, 0)
        if axis in ("z", "y", "x"):
            axis = [float(axis == a) for a in "zyx"]
        return name, [*_three(axis, "the axis of rotate"), number_of(degrees, "rotate")]
    if name == "mirror":
        if not isinstance(given, str) or not given or set(given) - set("xyz"):
            raise ArgumentError(f'mirror is of axes, "x" or "xy", not {given!r}')
        return name, [float(_AXES[axis]) for axis in given]
    if name == "scale":
        factor = number_of(given, "scale")
        whole = 1 / factor if 0 < factor < 1 else factor
        if whole not in (2, 4, 8, 16, 32, 64):
            raise ArgumentError(f"scale is 2, 4, ... 64 or 1/2, 1/4, ... 1/64, not {given!r}")
        return name, [factor]
    if name == "affine":
        try:
            matrix = np.asarray(given, float)
        except (TypeError, ValueError):
            matrix = np.empty(0)
        if matrix.shape not in ((3, 4), (4, 4)):
            raise ArgumentError("affine is a 4 x 4 matrix")
        return name, [float(n) for n in matrix[:3].ravel()]
    raise ArgumentError(f"no step is called {name}: there are translate, translate_mm, shift, "
                        "rotate, mirror, scale and affine")
