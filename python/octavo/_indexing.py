"""numpy's rules of basic indexing, for arrays of which only boxes can be read."""

import operator

import numpy as np


class Selection:
    """What an index asks of an array.

    Attributes
    ----------
    ranges : list of range
        The indices along each axis, in the order in which they are wanted; one for an integer.
    shape : tuple of int
        Of the result.
    is_scalar : bool
        Whether the result is a number, and no array without axes, as of an index with "...".
    """

    def __init__(self, key, shape):
        entries = _entries_of(key, len(shape))
        self.ranges = []
        self.shape = ()
        axis = 0
        for entry in entries:
            if entry is None:
                self.shape += (1,)
                continue
            chosen, is_kept = _range_of(entry, axis, shape[axis])
            self.ranges.append(chosen)
            if is_kept:
                self.shape += (len(chosen),)
            axis += 1
        is_open = isinstance(key, tuple) and any(entry is Ellipsis for entry in key)
        self.is_scalar = not self.shape and not is_open

    @property
    def is_empty(self):
        """Whether no voxel is chosen."""
        return any(len(chosen) == 0 for chosen in self.ranges)

    @property
    def is_box(self):
        """Whether all voxels of a box are chosen, in their order."""
        return all(chosen.step == 1 or len(chosen) == 1 for chosen in self.ranges)


def _entries_of(key, ndim):
    """The key with an ellipsis written out, and slices for what it leaves open."""
    entries = list(key) if isinstance(key, tuple) else [key]
    places = [place for place, entry in enumerate(entries) if entry is Ellipsis]
    if len(places) > 1:
        raise IndexError("an index can only have a single ellipsis ('...')")
    given = sum(entry is not None and entry is not Ellipsis for entry in entries)
    if given > ndim:
        raise IndexError(f"too many indices: the array has {ndim} dimensions, {given} were given")
    rest = [slice(None)] * (ndim - given)
    if places:
        return entries[:places[0]] + rest + entries[places[0] + 1:]
    return entries + rest


def _range_of(entry, axis, size):
    """The indices that an entry chooses, and whether the axis stays in the result."""
    if isinstance(entry, slice):
        return range(*entry.indices(size)), True
    if isinstance(entry, (bool, np.bool_)) or getattr(entry, "dtype", None) == bool:
        raise IndexError("only integers, slices, ... and None are indices; read the box, then "
                         "choose voxels by a mask")
    try:
        at = operator.index(entry)
    except TypeError:
        raise IndexError("only integers, slices, ... and None are indices; read the box, then "
                         "choose voxels by arrays") from None
    if not -size <= at < size:
        raise IndexError(f"index {at} is out of bounds for axis {axis} with size {size}")
    at %= size
    return range(at, at + 1), False


def boxes_of(ranges, side):
    """The boxes to read for a selection, so that no read holds much more than is wanted.

    An axis with a step is read brick by brick; one whose steps pass whole bricks, index by index.

    Parameters
    ----------
    ranges : list of range
    side : sequence of int
        Of a brick, z, y, x.

    Yields
    ------
    (start, stop, picks, places)
        The box; what to take of it along each axis; where that goes in the result: slices.
    """
    def runs(chosen, brick):
        if len(chosen) == 0:
            return
        if chosen.step == 1:
            yield chosen.start, chosen.stop, slice(None), slice(0, len(chosen))
            return
        first = 0
        while first < len(chosen):
            last = first
            row = chosen[first] // brick
            while last + 1 < len(chosen) and chosen[last + 1] // brick == row:
                last += 1
            low, high = sorted((chosen[first], chosen[last]))
            if chosen.step > 0:
                picks = slice(0, None, chosen.step)
            else:
                picks = slice(None, None, chosen.step)
            yield low, high + 1, picks, slice(first, last + 1)
            first = last + 1

    for z in runs(ranges[0], side[0]):
        for y in runs(ranges[1], side[1]):
            for x in runs(ranges[2], side[2]):
                start, stop, picks, places = zip(z, y, x)
                yield start, stop, picks, places


def read_chosen(chosen, side, dtype, read):
    """The array that a selection chooses.

    Parameters
    ----------
    chosen : Selection
    side : sequence of int
        Of a brick, z, y, x.
    dtype : numpy.dtype
    read : callable
        Called as read(start, stop, out); fills `out` with the voxels of a box.

    Returns
    -------
    numpy.ndarray or scalar
    """
    if chosen.is_empty:
        return np.empty(chosen.shape, dtype)
    out = np.empty(tuple(map(len, chosen.ranges)), dtype)
    for start, stop, picks, places in boxes_of(chosen.ranges, side):
        if chosen.is_box:
            read(start, stop, out)
            continue
        part = np.empty(tuple(b - a for a, b in zip(start, stop)), dtype)
        read(start, stop, part)
        out[places] = part[picks]
    out = out.reshape(chosen.shape)
    return out[()] if chosen.is_scalar else out


def centers_within(affine, shape, low, high):
    """The smallest box of a grid with all voxels whose centers lie in a box of the world.

    Parameters
    ----------
    affine : 4 x 4 array
        The index (z, y, x, 1) to the world.
    shape : (int, int, int)
    low, high : sequence of float
        Of the box, in the order of the world; what lies on its faces is in it.

    Returns
    -------
    (start, stop) or None
        Half-open; None where there is no such voxel.
    """
    matrix, place = affine[:3, :3], affine[:3, 3]
    # What rounding may have moved across a face.
    tolerance = 1e-6 * np.linalg.norm(matrix, axis=0).min()
    low, high = np.asarray(low) - tolerance, np.asarray(high) + tolerance
    corners = np.array([[(low, high)[c >> axis & 1][axis] for axis in range(3)] for c in range(8)])
    inverse = np.linalg.inv(matrix)
    index = (corners - place) @ inverse.T
    start = np.clip(np.ceil(index.min(0)), 0, shape).astype(int)
    stop = np.clip(np.floor(index.max(0)) + 1, 0, shape).astype(int)
    if not (start < stop).all():
        return None
    # Every axis of the grid goes along one of the world: the box is one of the grid.
    if (np.sum(np.abs(matrix) > 1e-9 * np.abs(matrix).max(), axis=0) == 1).all():
        return start, stop

    # The rows of a plane at a time: along each the box leaves one run of voxels.
    first, last = np.array(stop), np.array(start)
    rows = np.arange(start[1], stop[1])
    for z in range(start[0], stop[0]):
        begin = np.full(len(rows), start[2], float)
        end = np.full(len(rows), stop[2] - 1.0)
        for axis in range(3):
            step = matrix[axis, 2]
            at = matrix[axis, 0] * z + matrix[axis, 1] * rows + place[axis]
            if abs(step) * shape[2] < tolerance:
                end[(at < low[axis]) | (at > high[axis])] = -1
                continue
            one, other = (low[axis] - at) / step, (high[axis] - at) / step
            begin = np.maximum(begin, np.ceil(np.minimum(one, other)))
            end = np.minimum(end, np.floor(np.maximum(one, other)))
        met = np.flatnonzero(begin <= end)
        if len(met):
            first = np.minimum(first, (z, rows[met[0]], int(begin[met].min())))
            last = np.maximum(last, (z + 1, rows[met[-1]] + 1, int(end[met].max()) + 1))
    return (first, last) if (first < last).all() else None


def may_overlap_itself(array):
    """False where each axis steps over all that the axes of smaller strides span, so that no two
    elements share a byte."""
    spanned = array.itemsize
    for stride, count in sorted((abs(stride), count) for stride, count
                                in zip(array.strides, array.shape) if count > 1):
        if stride < spanned:
            return True
        spanned = stride * (count - 1) + spanned
    return False
