"""An open .8vo file: the scan, its coarser levels, its real values."""

import json
import math
import operator
import os

import numpy as np

from ._errors import ArgumentError, StorageError
from ._indexing import Selection, centers_within, may_overlap_itself, read_chosen
from ._sources import source_of
from ._tasks import VolumeTasks
from ._work import MOST_THREADS, grid_affine, number_of, warn_of, whole_number

DEFAULT_CACHE_BYTES = 256 << 20


class View:
    """A level of a volume as an array that is read where it is indexed, [z, y, x].

    Indexing follows numpy's basic rules (integers, slices with any step, ``...``, ``None``) and
    returns a new ``numpy.ndarray``, or a scalar. Whatever cannot be read raises; nothing is
    filled in.

    Coarse levels of float32 volumes hold means in steps. In lossless files these follow the noise
    of the voxels: of noise of deviation 1 they are 1/8 wide, so that level 3 has three values.
    Files built with a `max_error` have steps of twice that, so that coarse levels are as fine as it
    is small. Integers that all lie a multiple of some number apart have means that do, too: where
    there are two values, levels hold these two. Take means of level 0 where none of it will do.

    Attributes
    ----------
    level : int
        0 is the scan; each further level halves what is finest.
    shape : tuple of int
    dtype : numpy.dtype
    chunks : tuple of int
        Of the bricks that voxels are stored in; reads that follow them decode nothing twice.
    spacing : tuple of float
        mm along z, y, x.
    origin : tuple of float
        Of the center of voxel [0, 0, 0]: LPS, mm, in the order z, y, x.
    factor : tuple of int
        How many voxels of level 0 a voxel spans along z, y, x.
    """

    ndim = 3

    def __init__(self, file, level):
        self._file = file
        self.level = level
        (self.shape, self.spacing, self.origin, self.factor, side) = map(
            tuple, file.facts["levels"][level])
        self._side = side
        self.chunks = tuple(min(a, b) for a, b in zip(side, self.shape))
        self.dtype = np.dtype(file.facts["dtype"])

    @property
    def translation(self):
        """How far the first voxel lies from that of level 0, mm along the axes z, y, x."""
        return tuple((f - 1) / 2 * s / f for f, s in zip(self.factor, self.spacing))

    @property
    def size(self):
        """Number of voxels."""
        return math.prod(self.shape)

    @property
    def nbytes(self):
        """Bytes of all voxels without compression."""
        return self.size * self.dtype.itemsize

    @property
    def affine(self):
        """4 x 4: the index (z, y, x, 1) of a voxel to its center in the world, LPS x, y, z, mm."""
        return grid_affine(self._file.facts["direction"], self.spacing, self.origin)

    @property
    def affine_ras(self):
        """The same in RAS, as NIfTI and nibabel count."""
        return np.diag([-1.0, -1.0, 1.0, 1.0]) @ self.affine

    def __len__(self):
        return self.shape[0]

    def __array__(self, dtype=None, copy=None):
        if copy is False:
            raise ValueError("voxels are decoded, so an array of them is always a copy")
        return np.asarray(self[...], dtype=dtype)

    def __getitem__(self, key):
        chosen = Selection(key, self.shape)
        self._warn_of_size(chosen)
        return read_chosen(chosen, self._side, self.dtype,
                           lambda start, stop, out: self._read_into(start, stop, out, 0))

    def read(self, box=None, *, out=None, threads=0):
        """Voxels of a box.

        Parameters
        ----------
        box : ((z0, y0, x0), (z1, y1, x1)), optional
            Half-open, in voxels of this level; all of it by default.
        out : numpy.ndarray, optional
            What to fill, of the shape of the box and the dtype of the volume; any strides that give
            each voxel a place of its own.
        threads : int
            To decode on; 0: all cores.

        Returns
        -------
        numpy.ndarray
            `out`, or a new array [z, y, x].

        Raises
        ------
        octavo.ArgumentError
            For a box that is empty or not inside, and an `out` that does not fit.
        octavo.CorruptError
            Where stored bytes are damaged.
        """
        threads = whole_number(threads, "threads", 0, MOST_THREADS)
        start, stop = ((0, 0, 0), self.shape) if box is None else _corners_of(box)
        if not all(0 <= a < b <= n for a, b, n in zip(start, stop, self.shape)):
            raise ArgumentError(f"box {tuple(start)} to {tuple(stop)} is empty or not inside "
                                f"the {self.shape} voxels of level {self.level}")
        shape = tuple(b - a for a, b in zip(start, stop))
        if out is None:
            out = np.empty(shape, self.dtype)
        elif not isinstance(out, np.ndarray) or out.shape != shape or out.dtype != self.dtype:
            raise ArgumentError(f"out must be an array of shape {shape} and dtype {self.dtype}")
        elif not out.flags.writeable:
            raise ArgumentError("out cannot be written")
        elif may_overlap_itself(out):
            raise ArgumentError("out has several voxels in one place in memory")
        if out.flags.c_contiguous and out.dtype.isnative:
            self._read_into(start, stop, out, threads)
        else:
            dense = np.empty(shape, self.dtype)
            self._read_into(start, stop, dense, threads)
            out[...] = dense
        return out

    def at_mm(self, box_mm):
        """Voxels at places in the world.

        Parameters
        ----------
        box_mm : (z, y, x) or ((z0, y0, x0), (z1, y1, x1))
            LPS, mm: a point, or two opposite corners of a box whose sides are parallel to the
            axes of the world.

        Returns
        -------
        scalar or numpy.ndarray
            The voxel nearest to the point, halfway between two the one of the higher index; or,
            along each axis of the grid, all voxels between the first and the last one whose center
            lies in the box. Where the grid is oblique, those in its corners lie outside of the box.

        Raises
        ------
        octavo.ArgumentError
            Where the point or the whole box lies outside the volume.
        """
        corners = _places_of(box_mm)
        if len(corners) == 1:
            inverse = np.linalg.inv(self.affine)
            index = inverse[:3, :3] @ corners[0, ::-1] + inverse[:3, 3]
            at = np.floor(index + (0.5 + 1e-6))
            if not all(0 <= a < n for a, n in zip(at, self.shape)):
                place = ", ".join(f"{mm:g}" for mm in corners[0])
                raise ArgumentError(f"({place}) mm lies outside the volume")
            return self[tuple(at.astype(int))]
        found = centers_within(self.affine, self.shape, corners.min(0)[::-1],
                               corners.max(0)[::-1])
        if found is None:
            raise ArgumentError("no voxel has its center in that box")
        return self.read(found)

    def __repr__(self):
        size = " x ".join(map(str, self.shape))
        return f"<octavo level {self.level}: {size} {self.dtype} of {self._file.name}>"

    def __dask_tokenize__(self):
        # Equal for equal voxels, whatever stands under the path by then. Those of coarse levels go
        # with how a file was built as well.
        facts = self._file.facts
        token = ("octavo", facts["voxels_sha256"], facts["dtype"], self.shape, self.level)
        if self.level == 0:
            return token
        return (*token, self.factor, facts["kind"], facts["file_bytes"], facts["metadata"])

    def __reduce__(self):
        return (_opened_view, (self.level, *self._file.state))

    def _read_into(self, start, stop, out, threads):
        self._file.read(start, stop, self.level, out, threads)

    def _warn_of_size(self, chosen):
        wanted = math.prod(map(len, chosen.ranges)) * self.dtype.itemsize
        share = _memory_bytes() // 4
        if wanted > share:
            fitting = self._file.level_in(share)
            warn_of([f"{wanted / 1e9:.1f} GB of voxels are more than a quarter of this machine's "
                     f"memory; level {fitting} of the whole volume would fit"])


class RealView:
    """A level in real values: slope * stored value + intercept, as float32.

    It has what `View` has, but for `read`.
    """

    def __init__(self, view):
        self._view = view
        self.dtype = np.dtype(np.float32)

    def __getattr__(self, name):
        if name.startswith("__") or name == "read":
            raise AttributeError(name)
        return getattr(self._view, name)

    def __len__(self):
        return len(self._view)

    def __dask_tokenize__(self):
        facts = self._view._file.facts
        return ("octavo real", *self._view.__dask_tokenize__(), facts["slope"], facts["intercept"])

    def __getitem__(self, key):
        return self._real(self._view[key])

    def at_mm(self, box_mm):
        """As `View.at_mm`, in real values."""
        return self._real(self._view.at_mm(box_mm))

    def __array__(self, dtype=None, copy=None):
        if copy is False:
            raise ValueError("real values are computed, so an array of them is always a copy")
        return np.asarray(self[...], dtype=dtype)

    @property
    def nbytes(self):
        """Bytes of all voxels as float32."""
        return self._view.size * self.dtype.itemsize

    @property
    def levels(self):
        """All levels in real values, level 0 first."""
        return tuple(RealView(level) for level in self._view._file.levels)

    def __repr__(self):
        return repr(self._view).replace(str(self._view.dtype), "real values", 1)

    def _real(self, stored):
        facts = self._view._file.facts
        real = np.asarray(stored, np.float64) * facts["slope"] + facts["intercept"]
        real = np.asarray(real, np.float32)
        return real if isinstance(stored, np.ndarray) else real[()]


class Volume(VolumeTasks, View):
    """An open .8vo file; as an array, its level 0.

    Made by `octavo.open`; a context manager. It pickles as the place it was opened from, may be
    used by many threads at once, and stays usable in processes forked behind it. Where another file
    stands at that place by then, StorageError is raised.

    Attributes
    ----------
    levels : tuple of View
        The scan and all coarser levels, down to a single voxel.
    real : RealView
        The scan in real values.
    kind : str
        "grey" or "labels".
    unit : str or None
        Of real values, a UCUM code: "[hnsf'U]" is HU.
    slope, intercept : float
        real value = slope * stored value + intercept.
    min, max : int or float
        Smallest and largest stored voxel, from the index; bounds where the file is lossy or holds
        exact floats.
    max_error : float
        No voxel differs from its source by more, in stored units; 0: lossless.
    attrs : dict
        What the file says of where its voxels are from.
    label_names : dict of int to str
    voxels_sha256 : str
        Equal for equal voxels; see the format.
    """

    def __init__(self, source, cache_bytes=DEFAULT_CACHE_BYTES, storage_options=None):
        self._take(_File(source, cache_bytes, storage_options))

    def _take(self, file):
        super().__init__(file, 0)
        facts = file.facts
        self.kind = facts["kind"]
        self.unit = facts["unit"]
        self.slope = facts["slope"]
        self.intercept = facts["intercept"]
        self.min = facts["min"]
        self.max = facts["max"]
        self.max_error = facts["max_error"]
        self.label_names = facts["label_names"]
        self.voxels_sha256 = facts["voxels_sha256"]
        self.is_spacing_known = facts["is_spacing_known"]

    @property
    def name(self):
        """What it was opened from."""
        return self._file.name

    @property
    def file_bytes(self):
        """Length of the file."""
        return self._file.facts["file_bytes"]

    @property
    def attrs(self):
        """The metadata as a dictionary; empty where they cannot be read."""
        try:
            return json.loads(self._file.facts["metadata"])
        except ValueError:
            return {}

    @property
    def levels(self):
        """The scan and all coarser levels."""
        return self._file.levels

    @property
    def real(self):
        """Level 0 in real values."""
        return RealView(self)

    def read(self, box=None, level=0, *, out=None, threads=0):
        """As `View.read`, of any level: the box counts that level's voxels."""
        if isinstance(level, int) and level == 0:
            return super().read(box, out=out, threads=threads)
        return self._level(level).read(box, out=out, threads=threads)

    def at_mm(self, box_mm, level=0):
        """As `View.at_mm`, of any level."""
        if isinstance(level, int) and level == 0:
            return super().at_mm(box_mm)
        return self._level(level).at_mm(box_mm)

    def level_for(self, spacing_mm):
        """The number of the coarsest level whose spacings are all `spacing_mm` or finer; 0 where
        even the scan is coarser."""
        spacing_mm = number_of(spacing_mm, "spacing_mm")
        fitting = [view.level for view in self.levels if max(view.spacing) <= spacing_mm]
        return max(fitting, default=0)

    def at_budget(self, nbytes):
        """The finest level whose voxels take `nbytes` at most, as a view.

        Raises
        ------
        octavo.ArgumentError
            Where not even the last level, a single voxel, does.
        """
        return self.levels[self._file.level_in(number_of(nbytes, "nbytes"))]

    def brick_ranges(self):
        """The smallest and the largest voxel of each brick of level 0, without decoding any.

        Returns
        -------
        (low, high) : numpy.ndarray of float64
            Of the shape of the grid of bricks, whose sides are `chunks`. Bounds where the file is
            lossy or holds exact floats.
        """
        grid = tuple(-(-n // side) for n, side in zip(self.shape, self._side))
        low, high = np.empty(grid), np.empty(grid)
        self._file.read_brick_ranges(low, high)
        return low, high

    def close(self):
        """Lets go of the file; reading raises from then on. May be called again."""
        self._file.close()

    @property
    def closed(self):
        """Whether it was closed."""
        return self._file.is_closed

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __reduce__(self):
        return (_opened_volume, self._file.state)

    def __repr__(self):
        if self.closed:
            return f"<octavo volume {self.name}, closed>"
        size = " x ".join(map(str, self.shape))
        spacing = "unknown spacing"
        if self.is_spacing_known:
            spacing = " x ".join(f"{s:.4g}" for s in self.spacing) + " mm"
        unit = {"[hnsf'U]": " HU"}.get(self.unit, f" {self.unit}" if self.unit else "")
        return (f"<octavo volume {self.name}: {size} {self.dtype}{unit}, {spacing} "
                f"(z, y, x), {len(self.levels)} levels>")

    def _repr_html_(self):
        from ._notebook import html_of
        return repr(self) if self.closed else html_of(self)

    def _level(self, level):
        try:
            number = operator.index(level)
        except TypeError:
            number = -1
        if not 0 <= number < len(self.levels):
            raise ArgumentError(f"level {level!r} is not there: {self.name} has levels 0 to "
                                f"{len(self.levels) - 1}")
        return self.levels[number]


class _File:
    """The file behind the views: opened once, and anew in a process that was forked."""

    def __init__(self, source, cache_bytes, storage_options, identity=None):
        """identity  of the file that is expected there, where one is"""
        self._source = source_of(source, storage_options)
        self._opened_with = cache_bytes, storage_options
        self._cache_bytes = whole_number(cache_bytes, "cache_bytes", 0)
        self._only_thread = False
        self._open(identity)
        self.facts = self._handle.facts()

    @property
    def state(self):
        """What opens the same file elsewhere, as arguments."""
        return _identity_of(self.facts), self.place, *self._opened_with

    @property
    def name(self):
        return self._source.name

    @property
    def place(self):
        """What it is opened from, wherever the process is by now."""
        return self._source.place

    @property
    def levels(self):
        # Made when asked for: what a file holds on to, only the collector of cycles would close.
        return tuple(View(self, level) for level in range(len(self.facts["levels"])))

    @property
    def is_closed(self):
        return self._handle is None

    def _open(self, identity):
        handle = self._source.open(self._cache_bytes)
        if identity is not None and _identity_of(handle.facts()) != identity:
            raise StorageError(f"{self.name}: was replaced by another file", path=self.name)
        self._handle = handle
        self._process = os.getpid()
        return handle

    def _opened(self):
        handle = self._handle
        if handle is None:
            raise ArgumentError(f"{self.name}: is closed")
        if self._process != os.getpid():
            # Threads do not live on in a forked process; what waits for them would wait for ever.
            self._only_thread = True
            own = self._open(_identity_of(self.facts))
            _kept_for_good.append(handle)
            return own
        return handle

    def read(self, start, stop, level, out, threads):
        handle = self._opened()
        handle.read(tuple(map(int, start)), tuple(map(int, stop)), level, out,
                    1 if self._only_thread else int(threads))

    def read_brick_ranges(self, low, high):
        self._opened().read_brick_ranges(low, high)

    def level_in(self, nbytes):
        for view in self.levels:
            if view.nbytes <= nbytes:
                return view.level
        raise ArgumentError(f"{nbytes:g} bytes hold no voxel")

    def close(self):
        self._handle = None


def _identity_of(facts):
    """Equal for files of the same voxels on all levels, real values and places."""
    shape, spacing, origin, *_ = facts["levels"][0]
    same = ("voxels_sha256", "dtype", "kind", "slope", "intercept", "max_error", "detail_level",
            "direction")
    return tuple(facts[name] for name in same), shape, spacing, origin


def _opened_view(level, identity, place, *opened_with):
    return View(_File(place, *opened_with, identity), level)


def _opened_volume(identity, place, *opened_with):
    volume = Volume.__new__(Volume)
    volume._take(_File(place, *opened_with, identity))
    return volume


# Handles of the process before a fork: taking them down could wait for locks of its threads.
_kept_for_good = []


def _corners_of(box):
    try:
        start, stop = box
    except (TypeError, ValueError):
        raise ArgumentError("a box has two corners, (z0, y0, x0) and (z1, y1, x1), not "
                            f"{box!r}") from None
    return _whole_numbers(start), _whole_numbers(stop)


def _whole_numbers(point):
    try:
        numbers = tuple(operator.index(n) for n in point)
    except TypeError:
        numbers = ()
    if len(numbers) != 3:
        raise ArgumentError("a corner of a box has three whole numbers, z, y, x")
    return numbers


def _places_of(box_mm):
    """One or two places as rows z, y, x."""
    try:
        corners = np.atleast_2d(np.asarray(box_mm, float))
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.shape not in ((1, 3), (2, 3)) or not np.isfinite(corners).all():
        raise ArgumentError("give (z, y, x), or two such corners, in mm")
    return corners


def _memory_bytes():
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (ValueError, OSError, AttributeError):
        return 1 << 62
