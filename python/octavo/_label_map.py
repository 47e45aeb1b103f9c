"""Masks and label maps as octrees in memory."""

import functools
import json
import math
import os
import shutil
import tempfile
import weakref

import numpy as np

from . import _octavo
from ._building import _output
from ._errors import ArgumentError
from ._indexing import Selection, read_chosen
from ._tasks import FileTasks
from ._volume import Volume
from ._work import (asked_labels, connectivity_of, grid_affine, number_of, whole_number,
                    work_of)

_MOST_STEPS = 1 << 20
_READ_SIDE = (64, 64, 64)  # of what is read at a time where voxels between are left out
_SET_OPERATIONS = (np.bitwise_and, np.bitwise_or, np.bitwise_xor, np.subtract)


class LabelMap(FileTasks):
    """A mask or a label map, held in memory as an octree.

    Made by `Volume.threshold`, `Volume.mask`, `Volume.label_map` and by what follows here; it does
    not change. Every voxel that is not 0 is in the mask: ``a & b``, ``a | b``, ``a - b``,
    ``a ^ b`` and ``~a`` are masks on the grid of ``a``, and raise where the grids differ, as they
    do with arrays. Memory goes with the surfaces, not with the voxels.

    As an array [z, y, x] it is read where it is indexed, by numpy's basic rules. It pickles as the
    bytes of a file of it.

    Attributes
    ----------
    shape, spacing, origin, dtype
        As of `octavo.View`.
    label_names : dict of int to str
    table : list of dict
        Of what `components` made: a row for each label, ready for ``pandas.DataFrame``; else empty.
    found : int
        Components that there were, kept or not; 0 where it is none of `components`.
    """

    ndim = 3

    def __init__(self, tree, table=(), found=0):
        self._tree = tree
        facts = tree.facts()
        self._facts = facts
        self.shape = tuple(facts["shape"])
        self.dtype = np.dtype(facts["dtype"])
        self.spacing = tuple(facts["spacing"])
        self.origin = tuple(facts["origin"])
        self.is_spacing_known = facts["is_spacing_known"]
        self.label_names = facts["label_names"]
        self.table = list(table)
        self.found = found
        self._saved = None

    @property
    def affine(self):
        """As `octavo.View.affine`."""
        return grid_affine(self._facts["direction"], self.spacing, self.origin)

    @property
    def attrs(self):
        """What a file of it says of where its voxels are from."""
        return json.loads(self._facts["metadata"])

    @property
    def is_mask(self):
        """Whether it holds 0 and 1 alone."""
        return self._facts["is_mask"]

    @property
    def size(self):
        """Number of voxels of the grid."""
        return math.prod(self.shape)

    @property
    def nbytes(self):
        """Bytes of the octree."""
        return self._facts["memory_bytes"]

    @functools.cached_property
    def counts(self):
        """Voxels of each label but 0: a dict, label: voxels."""
        return self._tree.counts()

    @property
    def voxels(self):
        """Voxels that are not 0."""
        return sum(self.counts.values())

    def __len__(self):
        return self.shape[0]

    def __bool__(self):
        return self.voxels > 0

    def __getitem__(self, key):
        chosen = Selection(key, self.shape)
        with work_of() as work:
            return read_chosen(chosen, _READ_SIDE, self.dtype,
                               lambda start, stop, out: self._tree.read(start, stop, out, work))

    def __array__(self, dtype=None, copy=None):
        if copy is False:
            raise ValueError("voxels are made of an octree, so an array of them is always a copy")
        return np.asarray(self[...], dtype=dtype)

    def __array_ufunc__(self, ufunc, method, *inputs, **kwargs):
        # Bits and differences of label numbers are no sets of voxels.
        if ufunc in _SET_OPERATIONS:
            raise TypeError("a LabelMap is combined with a LabelMap, not with an array of voxels; "
                            "octavo.build and Volume.mask make one of it, and .to_numpy() gives "
                            "an array")
        if any(isinstance(given, LabelMap) for given in kwargs.get("out", ())):
            raise TypeError("a LabelMap does not change, so no result goes into one")
        arrays = [given.to_numpy() if isinstance(given, LabelMap) else given for given in inputs]
        return getattr(ufunc, method)(*arrays, **kwargs)

    def to_numpy(self):
        """All voxels, [z, y, x]."""
        return self[...]

    def save(self, path, *, overwrite=False, thumbnail=False, threads=0, max_memory=0,
             progress=None):
        """Write it as a label map.

        Parameters
        ----------
        path : str or os.PathLike
            Ends in .8vo.
        overwrite, thumbnail, threads, max_memory, progress
            As of `octavo.build`.

        Returns
        -------
        Volume
            The file, opened.

        Raises
        ------
        octavo.ArgumentError, octavo.StorageError
        """
        path = _output(path)
        with work_of(threads, max_memory, progress) as work:
            self._tree.save(path, bool(overwrite), bool(thumbnail), work)
        return Volume(path)

    def __and__(self, other):
        return self._combined(other, "intersect")

    def __or__(self, other):
        return self._combined(other, "union")

    def __sub__(self, other):
        return self._combined(other, "subtract")

    def __xor__(self, other):
        return self._combined(other, "xor")

    def __invert__(self):
        with work_of() as work:
            return LabelMap(self._tree.combine(None, "complement", work))

    def select(self, *labels):
        """The mask of some labels, by number or by name.

        Raises
        ------
        octavo.ArgumentError
            For 0, the background, and for names that no label has.
        """
        numbers, names = asked_labels(labels or None)
        for name in names:
            named = [label for label, text in self.label_names.items() if text == name]
            if not named:
                raise ArgumentError(f"no label is called {name}")
            numbers += named
        if not numbers or 0 in numbers:
            raise ArgumentError("give the labels of voxels that are in the mask; 0 is the "
                                "background")
        with work_of() as work:
            return LabelMap(self._tree.select(sorted(set(numbers)), work))

    def fill_holes(self, *, connectivity=26, max_mm3=None, threads=0, max_memory=0,
                   progress=None):
        """The mask with the background that it encloses.

        Parameters
        ----------
        connectivity : {6, 18, 26}
            That of the object; the background takes the dual one.
        max_mm3 : float, optional
            Larger holes are left.
        """
        limit = None if max_mm3 is None else _volume_of(max_mm3, "max_mm3")
        with work_of(threads, max_memory, progress) as work:
            return LabelMap(self._tree.fill_holes(connectivity_of(connectivity), limit, work))

    def dilate(self, voxels=None, *, mm=None, connectivity=None, threads=0, max_memory=0,
               progress=None):
        """The mask grown.

        Parameters
        ----------
        voxels : int, optional
            Steps from voxel to neighbor; 1 where `mm` is not given either.
        mm : float, optional
            In place of steps: the radius of a ball, between centers of voxels.
        connectivity : {6, 18, 26}, optional
            Which voxels are neighbors, of steps; 6 where it is not given. A ball has none.
        """
        return self._morphed("dilate", voxels, mm, connectivity, threads, max_memory, progress)

    def erode(self, voxels=None, *, mm=None, connectivity=None, threads=0, max_memory=0,
              progress=None):
        """The mask shrunk; nothing is taken away at the border of the volume. As `dilate`."""
        return self._morphed("erode", voxels, mm, connectivity, threads, max_memory, progress)

    def open(self, voxels=None, *, mm=None, connectivity=None, threads=0, max_memory=0,
             progress=None):
        """`erode`, then `dilate`: the places that the ball fits into."""
        return self._morphed("open", voxels, mm, connectivity, threads, max_memory, progress)

    def close(self, voxels=None, *, mm=None, connectivity=None, threads=0, max_memory=0,
              progress=None):
        """`dilate`, then `erode`: gaps are closed that the ball does not fit into."""
        return self._morphed("close", voxels, mm, connectivity, threads, max_memory, progress)

    def components(self, *, keep_largest=0, min_mm3=0, connectivity=6, threads=0, max_memory=0,
                   progress=None):
        """What is connected, as labels 1, 2, ... from the largest component on.

        Parameters
        ----------
        keep_largest : int
            So many are kept; 0: all.
        min_mm3 : float
            Smaller ones are not kept.
        connectivity : {6, 18, 26}

        Returns
        -------
        LabelMap
            Its `table` has a row for each label, its `found` says how many there were.
        """
        smallest = _volume_of(min_mm3, "min_mm3")
        kept = _count(keep_largest, "keep_largest")
        with work_of(threads, max_memory, progress) as work:
            made = self._tree.components(connectivity_of(connectivity), kept, smallest, work)
        return LabelMap(*made)

    def agreement(self, other):
        """How alike each label is in two maps on one grid.

        Parameters
        ----------
        other : LabelMap or Volume
            Of a Volume, its `label_map`.

        Returns
        -------
        list of dict
            For each label but 0 of either: label, voxels_a, voxels_b, voxels_both, dice.
        """
        if isinstance(other, Volume):
            other = other.label_map()
        self._require_map(other)
        with work_of() as work:
            return self._tree.agreements(other._tree, work)

    def __eq__(self, other):
        if not isinstance(other, LabelMap):
            return NotImplemented
        if self.shape != other.shape or self.counts != other.counts:
            return False
        try:
            return all(row["dice"] == 1 for row in self.agreement(other))
        except ArgumentError:  # as for maps of other shapes: they lie elsewhere
            return False

    __hash__ = None

    def __reduce__(self):
        with open(self.saved().name, "rb") as file:
            return _unpickled, (file.read(), self.is_mask, self.table, self.found)

    def __repr__(self):
        size = " x ".join(map(str, self.shape))
        if self.is_mask:
            return f"<octavo mask: {size}, {self.voxels:,} voxels, {self.nbytes:,} bytes>"
        return (f"<octavo label map: {size}, {len(self.counts):,} labels, {self.voxels:,} voxels, "
                f"{self.nbytes:,} bytes>")

    def _combined(self, other, operation):
        if not isinstance(other, LabelMap):
            return NotImplemented
        with work_of() as work:
            return LabelMap(self._tree.combine(other._tree, operation, work))

    def _morphed(self, operation, voxels, mm, connectivity, threads, max_memory, progress):
        if voxels is not None and mm is not None:
            raise ArgumentError("give steps in voxels or a radius in mm, not both")
        if mm is not None:
            mm = number_of(mm, "mm")
            if connectivity is not None:
                raise ArgumentError("connectivity says how voxels count; with mm it says nothing")
        steps = 1 if voxels is None else _count(voxels, "voxels")
        neighbors = 6 if connectivity is None else connectivity_of(connectivity)
        with work_of(threads, max_memory, progress) as work:
            return LabelMap(self._tree.morph(operation, mm, steps, neighbors, work))

    def _require_map(self, other):
        if not isinstance(other, LabelMap):
            raise ArgumentError(f"give a LabelMap, not {type(other).__name__}; Volume.mask and "
                                "Volume.label_map make one")

    def saved(self):
        """The map as a Volume with levels, in a file that goes when the map does."""
        # Tasks on files take it from there.
        if self._saved is None:
            folder = tempfile.mkdtemp(prefix="octavo-")
            weakref.finalize(self, _remove_folder, folder, os.getpid())
            self._saved = self.save(os.path.join(folder, "labels.8vo"))
        return self._saved

    def _opened_file(self):
        return "the label map", self.saved()._file._opened()


def _unpickled(saved, is_mask, table, found):
    with Volume(saved) as volume, work_of() as work:
        name, handle = volume._opened_file()
        return LabelMap(_octavo.saved_tree(handle, name, is_mask, work), table, found)


def _remove_folder(folder, process):
    # Of the process that made it: forked ones end while that one still reads there.
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def _volume_of(given, name):
    mm3 = number_of(given, name)
    if mm3 < 0:
        raise ArgumentError(f"{name} is 0 or more, not {given!r}")
    return mm3


def _count(given, name):
    return whole_number(given, name, 0, _MOST_STEPS)
