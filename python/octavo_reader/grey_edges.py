"""Edges of grey bricks: docs/format-grey.md, section 14."""

import numpy as np

from .binary_coder import AdaptiveBit, BinaryDecoder
from .errors import require


class EdgeStates:
    """The adaptive bits of a brick, which go on from level to level."""

    def __init__(self) -> None:
        self.is_edge = [[[AdaptiveBit() for _ in range(4)] for _ in range(5)] for _ in range(3)]
        self.is_first = [[AdaptiveBit() for _ in range(3)] for _ in range(3)]


class EdgeStream:
    """The edges of one level, taken split by split."""

    def __init__(self, data: bytes, states: EdgeStates) -> None:
        self._data = data
        self._decoder = BinaryDecoder(data)
        self._states = states
        self._count = 0

    def split(self, means: np.ndarray, axis: int, flagged: np.ndarray, lowest: int, highest: int,
              rounding: int) -> np.ndarray:
        """The details of the pairs of a split that are edges, 0 for others, [z][y][x]."""
        decoder, states = self._decoder, self._states
        details = np.zeros(flagged.shape, np.int64)
        # 1: the first sample is the lowest; 2: the second. One pair of margin before each axis.
        kinds = np.zeros([n + 1 for n in flagged.shape], np.int64)
        ground = np.pad(means, 1, mode="edge") == lowest
        inside = tuple(slice(0, n) for n in flagged.shape)
        other = 2 * means[inside] - rounding - lowest
        possible = ~flagged & (means[inside] > lowest) & (other <= highest)
        for z, y, x in np.argwhere(possible).tolist():
            near = [[int(ground[_beside(x, y, z, a, s)]) for s in (-1, 1)] for a in range(3)]
            before, after = near[axis]
            across = sum(sum(near[a]) for a in range(3) if a != axis)
            around = (kinds[z + 1, y + 1, x], kinds[z + 1, y, x + 1], kinds[z, y + 1, x + 1])
            firsts, seconds = around.count(1), around.count(2)
            if not decoder.adaptive(states.is_edge[before + after][across][firsts + seconds]):
                continue
            lean = 1 + (firsts > seconds) - (firsts < seconds)
            is_first = decoder.adaptive(states.is_first[1 + before - after][lean])
            odd = other[z, y, x] < highest and decoder.even_bits(1)
            size = other[z, y, x] - lowest + int(odd)
            kinds[z + 1, y + 1, x + 1] = 1 if is_first else 2
            details[z, y, x] = -size if is_first else size
            self._count += 1
        return details

    def end(self, count: int) -> None:
        """Raises OctavoError "corrupt" unless `count` edges and all bytes were taken."""
        require(self._count == count and self._decoder.at == len(self._data),
                "a level has other edges than it says")


def _beside(x: int, y: int, z: int, axis: int, distance: int) -> tuple[int, int, int]:
    """The place next to (x, y, z) along an axis, in an array with a margin of one."""
    place = [z + 1, y + 1, x + 1]
    place[2 - axis] += distance
    return tuple(place)
