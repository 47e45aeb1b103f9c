"""What can be done with a file: measures, masks, volumes made of it."""

import os
import tempfile

import numpy as np

from . import _octavo
from ._errors import ArgumentError
from ._pictures import PictureTasks
from ._structure import StructureTasks
from ._surfaces import SurfaceTasks
from ._work import (asked_labels, AXES, number_of, range_of, several_of, texts_of, three_of,
                    whole_number, work_of)


class FileTasks(StructureTasks, PictureTasks, SurfaceTasks):
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
        grey_name, grey = ("", None) if of is None else opened_beside(of, "of", name)
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
            The largest difference, in real units, that counts as equal; 0 or more.

        Returns
        -------
        dict
            equal: in shape, place and all real values. same_stored: and in dtype and rescale as
            well. same_shape, same_dtype, same_rescale (slope and intercept), same_place.
            geometry_known: False where a spacing is not known; then places are not compared,
            same_place is True and shift_mm None. different_voxels, nan_in_one (how many of these
            are NaN in one alone), max_difference (of the others, in real units), first_different
            (z, y, x or None).
        """
        other = opened_file(other, "other")[1]
        largest = number_of(max_error, "max_error")
        if largest < 0:
            raise ArgumentError(f"max_error is 0 or more, not {max_error!r}")
        with work_of(threads, max_memory, progress) as work:
            return _octavo.compare(self._opened_file()[1], other, largest, work)

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
            ``affine=``: 4 x 4 or its first three rows, mm in x, y, z (LPS).

        Returns
        -------
        Volume
        """
        from ._building import _output
        from ._volume import Volume
        path = _output(path)
        name, handle = self._opened_file()
        grid_name, grid = (("", None) if grid_of is None else
                           opened_beside(grid_of, "grid_of", name))
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

    def classify(self, classes, *, stored=False, threads=0, max_memory=0, progress=None):
        """A label map of voxels by their values.

        Parameters
        ----------
        classes : dict of int to (low, high)
            The range of each label from 1 to 255, both ends included, None for an open one. Where
            ranges overlap the first counts.
        stored : bool
            The ends are stored values.

        Returns
        -------
        LabelMap
        """
        from ._volume import Volume
        try:
            asked = [(whole_number(label, "a label", 1, 255), *range_of(ends))
                     for label, ends in classes.items()]
        except AttributeError:
            raise ArgumentError(f"classes are a dict, label: (low, high), not {classes!r}"
                                ) from None
        name, handle = self._opened_file()
        with tempfile.TemporaryDirectory(prefix="octavo-") as folder:
            path = os.path.join(folder, "classes.8vo")
            with work_of(threads, max_memory, progress) as work:
                _octavo.classify(handle, name, path, asked, bool(stored), work)
            with Volume(path) as made:
                return made.label_map(threads=threads, max_memory=max_memory)

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

    def self_similarity(self, max_difference=0.0, *, up_to_mean=False, coded=None, threads=0,
                        max_memory=0, progress=None):
        """How many cubes of a grey volume equal another one, and what references would save.

        Parameters
        ----------
        max_difference : float
            The most by which voxels of equal cubes differ, in real units.
        up_to_mean : bool
            Only what differs from the mean of each cube counts.
        coded : Volume, optional
            The same scan in another file, whose bytes references would save.

        Returns
        -------
        dict
            file_bytes, saved_bytes, and levels: a dict for cubes of side 16, 8 and 4, of side,
            cubes, uniform, asked, same_level, next_level, turned, cut_short, coded_bytes,
            reference_bytes.
        """
        name, handle = self._opened_file()
        coded_name, coded_handle = (("", None) if coded is None else
                                    opened_beside(coded, "coded", name))
        with work_of(threads, max_memory, progress) as work:
            return _octavo.self_similarity(handle, name, coded_handle, coded_name,
                                           number_of(max_difference, "max_difference"),
                                           bool(up_to_mean), work)

    def _opened_file(self):
        return self.name, self._file._opened()


def opened_file(given, name):
    """Name and handle of a volume or label map. Raises ArgumentError for anything else."""
    if not isinstance(given, FileTasks):
        raise ArgumentError(f"{name} is a Volume or a LabelMap, not {type(given).__name__}")
    return given._opened_file()


def opened_beside(given, what, *taken):
    """As `opened_file`, under a name that none of `taken` is."""
    name, handle = opened_file(given, what)
    return f"{name} ({what})" if name in taken else name, handle


def _step(name, given):
    """A step as the extension takes it: its name and numbers."""
    if name in ("translate", "translate_mm", "shift"):
        numbers = three_of(given, name)
        if name != "translate_mm" and any(n != int(n) for n in numbers):
            raise ArgumentError(f"{name} counts whole voxels")
        return name, numbers
    if name == "rotate":
        if not isinstance(given, (tuple, list)) or len(given) != 2:
            raise ArgumentError('rotate is an axis and degrees, ("z", 90) or ((z, y, x), 90), not '
                                f"{given!r}")
        axis, degrees = given
        if isinstance(axis, str) and axis in AXES:
            axis = [float(axis == a) for a in "zyx"]
        return name, [*three_of(axis, "the axis of rotate"), number_of(degrees, "rotate")]
    if name == "mirror":
        if not isinstance(given, str) or not given or set(given) - set("xyz"):
            raise ArgumentError(f'mirror is of axes, "x" or "xy", not {given!r}')
        return name, [float(AXES[axis]) for axis in given]
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
        if matrix.shape not in ((3, 4), (4, 4)) or not np.isfinite(matrix).all():
            raise ArgumentError("affine is a 4 x 4 matrix of finite numbers")
        if not np.array_equal(matrix[3:], [(0, 0, 0, 1)][:len(matrix) - 3]):
            raise ArgumentError("affine has 0, 0, 0, 1 as its last row, not "
                                f"{', '.join(f'{n:g}' for n in matrix[3])}")
        return name, [float(n) for n in matrix[:3].ravel()]
    raise ArgumentError(f"no step is called {name}: there are translate, translate_mm, shift, "
                        "rotate, mirror, scale and affine")
