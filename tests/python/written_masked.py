"""Value maps, gaps and edges as sections 13 and 14 of docs/format-grey.md have them.

Written from that text alone and sharing nothing with the two readers. Arrays are indexed [z][y][x]
in the axes of the model, axis 0 is x.
"""

import dataclasses

import numpy as np

from written_files import pack, signed, varint


@dataclasses.dataclass
class ValueMap:
    """Of a model all of whose bricks lie on the lattice; codes: those that occur, or none."""

    step: int = 1
    offset: int = 0
    codes: tuple = ()

    def has_gaps(self):
        return len(self.codes) > 0

    def bytes(self):
        if not self.has_gaps():
            return varint(self.step) + varint(self.offset) + varint(0)
        first, count = min(self.codes), max(self.codes) - min(self.codes) + 1
        bits = pack([first + i in self.codes for i in range(count)], 1)
        head = varint(self.step) + varint(self.offset) + varint(count) + varint(signed(first))
        return head + bits

    def occurring(self, codes):
        """Those of a brick: of the model, and its own."""
        low, high = int(codes.min()), int(codes.max())
        known = [code for code in self.codes if low <= code <= high]
        return np.union1d(known, np.unique(codes)).astype(np.int64)

    def brick_bytes(self, codes, has_gaps):
        if not has_gaps:
            return b"\x01"
        others = np.setdiff1d(np.unique(codes), self.codes) - codes.min()
        return bytes([3, len(others), *others.tolist()])


class Gaps:
    """The samples of a brick that occur."""

    def __init__(self, samples):
        self.samples, self.details = samples, {}

    def occurs(self, sample):
        at = np.searchsorted(self.samples, sample)
        return at < len(self.samples) and self.samples[at] == sample

    def details_of(self, mean, term):
        """Those of pairs of samples that occur, of a mean."""
        if mean not in self.details:
            a, b = self.samples[:, None], self.samples[None, :]
            self.details[mean] = np.sort((a - b)[(a + b + term) >> 1 == mean])
        return self.details[mean]

    def residuals(self, means, term, details, predictions, limits):
        """Section 13: from the detail nearest to the prediction, by numbers."""
        residuals = np.zeros_like(details)
        for place in np.argwhere(limits > 0):
            place = tuple(place)
            possible = self.details_of(int(means[place]), term)
            nearest = int(np.argmin(abs(possible - predictions[place])))
            own, last = int(np.searchsorted(possible, details[place])), len(possible) - 1
            assert possible[own] == details[place]
            residuals[place] = folded(own, nearest, last)
        return residuals


def folded(value, start, last):
    """The residual that section 6 unfolds to `value`."""
    if 2 * start < last:
        value, start = last - value, last - start
    if abs(value - start) <= last - start:
        return value - start
    beyond = last - value
    return -(beyond + 1) // 2 if beyond % 2 else beyond // 2


def next_to(grid, place, axis, step):
    at = list(place)
    at[2 - axis] += step
    return grid[tuple(at)]


def edges_of(split, scale):
    """Section 14: which pairs are edges, and [(context, kind, plain bits, number in its row)]."""
    low, shape = scale.low, split.details.shape
    inside = np.zeros_like(split.padded, dtype=bool)
    inside[2:-2, 2:-2, 2:-2] = True
    is_lowest = (split.padded == low) & inside
    # Of the pairs of this split +1 for edges whose first sample is lo, -1 for the others.
    sides = np.zeros(shape, np.int64)
    symbols = []
    for z, y in np.ndindex(shape[:2]):
        number = 0
        for x in range(shape[2]):
            found = candidate(split, scale, (z, y, x), is_lowest, sides)
            if found is None:
                continue
            context, is_mirrored, other, may_be = found
            detail = int(split.details[z, y, x])
            a = int(split.padded[z + 2, y + 2, x + 2]) + ((detail + 1 - split.term) >> 1)
            b = a - detail
            kind, bits = 0, (0, 0)
            if a == low or b == low:
                sides[z, y, x] = 1 if a == low else -1
                kind = 2 if (a == low) == is_mirrored else 1
                odd = max(a, b) - other
                if all(may_be):
                    bits = (odd, 1)
            symbols.append((context, kind, bits, number))
            number += 1
    return sides != 0, symbols


def candidate(split, scale, place, is_lowest, sides):
    """Of a pair that is asked for its context, whether kinds are swapped, what the other sample may
    be one less than, and whether it may be even and odd; None of any other pair."""
    at = tuple(k + 2 for k in place)
    mean = int(split.padded[at])
    other = 2 * mean - split.term - scale.low
    may_be = [sample <= scale.high and (split.gaps is None or split.gaps.occurs(sample))
              for sample in (other, other + 1)]
    flagged = np.broadcast_to(split.is_flagged, split.details.shape)[place]
    if flagged or split.is_weighted[place] or mean < scale.low + 2 or not any(may_be):
        return None
    before, after = (int(next_to(is_lowest, at, split.axis, step)) for step in (-1, 1))
    across = sum(int(next_to(is_lowest, at, axis, step))
                 for axis in range(3) if axis != split.axis for step in (-1, 1))
    z, y, x = place
    near = [sides[z, y - 1, x] if y > 0 else 0, sides[z - 1, y, x] if z > 0 else 0]
    if not (before or after or across or any(near)):
        return None
    lean = int(sum(near))
    is_mirrored = bool(after) if before != after else lean < 0
    beyond = max(int(next_to(split.padded, at, split.axis, step)) for step in (-1, 1)) - scale.low
    ratio = sum(16 * (mean - scale.low) >= part * beyond for part in (4, 7, 9, 13))
    side = int(np.sign(-lean if is_mirrored else lean)) + 1
    context = (((before + after) * 4 + min(across, 3)) * 5 + ratio) * 3 + side
    return 2 * context + (split.axis == 0), is_mirrored, other, may_be
