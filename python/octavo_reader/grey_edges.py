"""Edges of grey bricks: docs/format-grey.md, section 14. Arrays are indexed [z][y][x]."""

from typing import TYPE_CHECKING

import numpy as np

from .grey_samples import PaddedSamples

if TYPE_CHECKING:
    from .grey_details import DetailStream, ValueGaps


class EdgeTables:
    """Of each context the first slots of both kinds of edges, [context][0..3]: 0, .., 2048."""

    def __init__(self, frequencies: np.ndarray) -> None:
        self.starts = np.insert(np.cumsum(frequencies, axis=1), 0, 0, axis=1).tolist()


def edges_of_split(stream: "DetailStream", tables: EdgeTables, padded: PaddedSamples, axis: int,
                   flagged: np.ndarray, lowest: int, highest: int, rounding: int,
                   gaps: "ValueGaps | None") -> np.ndarray:
    """The details of the pairs of a split that are edges, 0 for others.

    flagged          which pairs lie in flagged cells
    lowest, highest  the samples of the brick's smallest and largest voxel
    gaps             of the split that makes voxels, where some values do not occur
    """
    means = padded.samples
    inside = tuple(slice(0, n) for n in flagged.shape)
    m = means[inside] - lowest
    other = 2 * means[inside] - rounding - lowest
    may_be_even, may_be_odd = (_may_be(other + odd, highest, gaps) for odd in (0, 1))
    # Background ends at the faces of a part; what the means along the axis predict does not.
    alone = PaddedSamples.of_level(means)
    ground = np.array([[_beside(alone, a, side)[inside] for side in (-1, 1)]
                       for a in (axis, *(a for a in range(3) if a != axis))]) == lowest
    along = np.maximum(*(_beside(padded, axis, side)[inside] for side in (-1, 1)))
    before, after = ground[0].astype(np.int64)
    across = ground[1:].sum(axis=(0, 1))
    ratio = _ratios(m, along - lowest)
    base = ((before + after) * 4 + np.minimum(across, 3)) * 5 + ratio
    possible = ~flagged & (m >= 2) & (may_be_even | may_be_odd)
    is_near = ground.any(axis=(0, 1))

    details = np.zeros(flagged.shape, np.int64)
    # 1: the first sample is the lowest; -1: the second. A margin of zeros stands for none.
    kinds = np.zeros((flagged.shape[0] + 1, flagged.shape[1] + 1, flagged.shape[2]), np.int64)
    for z, y in np.argwhere(possible.any(axis=2)).tolist():
        near = is_near[z, y] | (kinds[z + 1, y] != 0) | (kinds[z, y + 1] != 0)
        x = np.flatnonzero(possible[z, y] & near)
        if len(x) == 0:
            continue
        lean = (kinds[z + 1, y] + kinds[z, y + 1])[x]
        turn = before[z, y, x] - after[z, y, x]
        turn = np.where(turn != 0, turn, lean)
        turn = np.where(turn < 0, -1, 1)
        contexts = 2 * (base[z, y, x] * 3 + 1 + np.sign(lean * turn)) + (axis == 0)
        found = np.array(stream.edge_row(tables.starts, contexts.tolist()))
        found = turn * np.array([0, 1, -1])[found]
        for place, kind in zip(x[found != 0].tolist(), found[found != 0].tolist()):
            odd = may_be_odd[z, y, place]
            if odd and may_be_even[z, y, place]:
                odd = stream.plain(1)
            kinds[z + 1, y + 1, place] = kind
            details[z, y, place] = -kind * (other[z, y, place] - lowest + int(odd))
    return details


def _may_be(samples: np.ndarray, highest: int, gaps: "ValueGaps | None") -> np.ndarray:
    allowed = samples <= highest
    return allowed if gaps is None else allowed & gaps.occur(samples)


def _beside(padded: PaddedSamples, axis: int, side: int) -> np.ndarray:
    """The means one place before (-1) or after (1) along an axis."""
    around = padded.with_margins(1)
    at = [slice(1, n - 1) for n in around.shape]
    at[2 - axis] = slice(1 + side, around.shape[2 - axis] - 1 + side)
    return around[tuple(at)]


def _ratios(m: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """The class 0 .. 4 of means beside the larger of those along the axis."""
    return sum((16 * m >= part * beyond).astype(np.int64) for part in (4, 7, 9, 13))
