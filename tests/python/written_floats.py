"""Codes exact floats as section 15 of docs/format-grey.md has them, with bricks of written_grey.py.

Written from that text alone and sharing nothing with the two readers, so that the tests tell what
the text leaves open. Arrays are indexed [z][y][x].
"""

import fractions
import struct

import numpy as np

from written_files import varint
from written_grey import AdaptiveBit, BinaryEncoder, GreyFile
from written_labels import children_of

ABSENT, PLACES, LOWER, HIGHER, PLAIN = 1, 2, 4, 8, 16
SLOTS = 4096


def rank(bits):
    size = bits & 0x7fffffff
    return -1 - size if bits >> 31 else size


class Bins:
    """Codes of floats, and the short ranks of their bins."""

    def __init__(self, scale, offset):
        self.scale, self.offset, self.firsts = scale, offset, {}

    def voxel(self, code):
        return float(np.float32(code * self.scale + self.offset))

    def begin(self, code):
        return (code - 0.5) * self.scale + self.offset

    def code_of(self, value):
        code = int(np.floor((float(value) - self.offset) / self.scale + 0.5))
        while self.begin(code) > value:
            code -= 1
        while self.begin(code + 1) <= value:
            code += 1
        return code

    def first(self, code, cut):
        """F of the text; cut: mantissa bits that are left out."""
        if (code, cut) not in self.firsts:
            begin = self.begin(code)
            near = np.float32(begin)
            if float(near) < begin:
                near = np.nextafter(near, np.float32(np.inf))
            own = rank(int(near.view(np.uint32)))
            short = -(-own >> cut) if own >= 0 else -1 - ((-1 - own) >> cut)
            self.firsts[code, cut] = short
        return self.firsts[code, cut]


def present_means(codes, absent, steps, weights):
    """Codes of absent voxels: of the first sample above below which some are present."""
    _, each, last = weights
    each, last = list(each), list(last)
    levels = [(codes, absent)]
    for mask in steps:
        own, missing = levels[-1]
        shape = tuple((n + 1) // 2 if mask >> a & 1 else n for a, n in zip((2, 1, 0), own.shape))
        made, gone = np.zeros(shape, np.int64), np.ones(shape, bool)
        for z, y, x in np.ndindex(shape):
            total, share = 0, 0
            for _, child in children_of((x, y, z), own.shape, mask):
                weight = 1
                for a in range(3):
                    weight *= last[a] if child[a] == own.shape[2 - a] - 1 else each[a]
                if not missing[child[::-1]]:
                    total += weight * int(own[child[::-1]])
                    share += weight
            if share:
                made[z, y, x], gone[z, y, x] = round(fractions.Fraction(total, share)), False
        for a in range(3):
            if mask >> a & 1:
                is_even = own.shape[2 - a] % 2 == 0
                each[a], last[a] = 2 * each[a], each[a] + last[a] if is_even else last[a]
        levels.append((made, gone))
    for (fine, missing), (coarse, gone), mask in zip(levels[-2::-1], levels[:0:-1], steps[::-1]):
        where = np.ix_(*[np.arange(n) >> (mask >> a & 1) for a, n in zip((2, 1, 0), fine.shape)])
        fine[missing] = coarse[where][missing]
    return [missing for _, missing in levels]


def near_bits(flags, z, y, x):
    """Those to the left, above and behind."""
    return sum(1 << k for k, place in enumerate(((z, y, x - 1), (z, y - 1, x), (z - 1, y, x)))
               if min(place) >= 0 and flags[place])


def absent_bytes(flags, above, mask, voxels):
    """above: flags of the next level, None in a stored brick or at the coarsest level; voxels: bits
    of the floats at level 0, else None."""
    coder, bits, is_other = BinaryEncoder(), [AdaptiveBit() for _ in range(8)], AdaptiveBit()
    before = 0x7fc00000
    for z, y, x in np.ndindex(flags.shape):
        is_known = above is not None and above[tuple(
            p >> (mask >> a & 1) for a, p in zip((2, 1, 0), (z, y, x)))]
        if not is_known:
            bits[near_bits(flags, z, y, x)].put(coder, flags[z, y, x])
        if voxels is None or not flags[z, y, x]:
            continue
        own = int(voxels[z, y, x])
        is_other.put(coder, own != before)
        if own != before:
            for bit in range(31, -1, -1):
                coder.put(own >> bit & 1)
        before = own
    data = coder.end()
    return varint(len(data)) + data


class PlaceEncoder:
    """The places of the floats of a brick within the bins of their codes."""

    def __init__(self, bins, codes, bits, absent, repeats):
        zeros = [int(b) & -int(b) for b in bits[~absent] | 1 << 23]
        self.cut = min(23, min(zeros).bit_length() - 1)
        self.bins, self.codes, self.bits, self.absent = bins, codes, bits, absent
        self.repeats_bit = 32 if repeats else 0
        self.is_zero = np.zeros(codes.shape, bool)
        self.zeros = [AdaptiveBit() for _ in range(8)]
        self.negative = [AdaptiveBit(), AdaptiveBit()]
        self.repeats = [[AdaptiveBit(), AdaptiveBit()] for _ in range(2)]
        self.exponents, self.slots = {}, {}
        self.coder, self.asked = BinaryEncoder(), 0
        self.plain, self.plain_length = 0, 0

    def bytes(self):
        depth, height, width = self.codes.shape
        for z in range(depth):
            for y in range(height):
                self.row_repeats, self.row_exponent = 0, None
                for x in range(width):
                    if not self.absent[z, y, x]:
                        self._put(z, y, x)
        decisions = self.coder.end() if self.asked else b""
        plain = self.plain.to_bytes((self.plain_length + 7) // 8, "little")
        return (bytes([self.cut + self.repeats_bit]) + varint(len(decisions)) + decisions
                + varint(len(plain)) + plain)

    def _ask(self, adaptive, bit):
        adaptive.put(self.coder, bit)
        self.asked += 1

    def _put_plain(self, number, count):
        self.plain |= number << self.plain_length
        self.plain_length += count

    def _put(self, z, y, x):
        code = int(self.codes[z, y, x])
        first, end = self.bins.first(code, self.cut), self.bins.first(code + 1, self.cut)
        size = (int(self.bits[z, y, x]) & 0x7fffffff) >> self.cut
        short = -1 - size if int(self.bits[z, y, x]) >> 31 else size
        assert first <= short < end, (first, short, end)
        if end - first == 1:
            return
        is_repeated = self._is_repeated(code, short)
        spans_zero = first <= 0 <= end
        is_zero = spans_zero and short in (0, -1)
        self.is_zero[z, y, x] = is_zero
        if is_repeated:
            return
        if not spans_zero:
            self._put_plain(short - first, (end - first - 1).bit_length())
            return
        self._ask(self.zeros[near_bits(self.is_zero, z, y, x)], is_zero)
        self._ask(self.negative[is_zero], short < 0)
        if not is_zero:
            self._put_size(size, first, end)

    def _is_repeated(self, code, short):
        if not self.repeats_bit:
            return False
        last_code, last_short, outcome = self.slots.get(code % SLOTS, (None, None, 0))
        is_repeated = False
        if last_code == code:
            is_repeated = short == last_short
            self._ask(self.repeats[self.row_repeats][outcome], is_repeated)
        self.row_repeats = int(is_repeated)
        self.slots[code % SLOTS] = code, short, int(is_repeated)
        return is_repeated

    def _put_size(self, size, first, end):
        width = 23 - self.cut
        exponent, number = size >> width, 0
        if self.row_exponent is not None:
            last_first, last_end, last = self.row_exponent
            number = 1 + max(0, (max(last_end - 1, -1 - last_first) >> width) - last).bit_length()
        self.row_exponent = first, end, exponent
        node = 1
        for bit in range(7, -1, -1):
            self._ask(self.exponents.setdefault((number, node), AdaptiveBit()), exponent >> bit & 1)
            node = 2 * node + (exponent >> bit & 1)
        self._put_plain(size & ((1 << width) - 1), width)


class FloatFile(GreyFile):
    """Of float32; bricks at `plain_at` of tier 0 hold plain floats, others are coded."""

    TYPE, DTYPE = 7, "<f4"

    def __init__(self, floats, masks, scale, offset=0.0, order="xyz", plain_at=(), repeats=False):
        self.floats, self.bins = floats.astype(np.float32), Bins(scale, offset)
        self.plain_at, self.repeats = plain_at, repeats
        self.exact, self.beyond = {}, {}
        codes = np.array([self.bins.code_of(v) if np.isfinite(v) else 0
                          for v in self.floats.flat]).reshape(floats.shape)
        super().__init__(codes, masks, order)

    def extensions(self):
        return [struct.pack("<HHBBdd", 0x8001, 18, 5, 1, self.bins.scale, self.bins.offset)]

    def planes(self):
        return self.floats

    def analyze(self, brick, samples, steps, weights, count):
        if weights[0] == [0, 0, 0]:
            low = [p << sum(mask >> a & 1 for mask in steps) for a, p in enumerate(brick.place)]
            box = tuple(slice(low[a], low[a] + n) for a, n in zip((2, 1, 0), samples.shape))
            absent = ~np.isfinite(self.floats[box])
            levels = present_means(samples, absent, steps, weights)
            brick.smallest, brick.largest = int(samples.min()), int(samples.max())
            assert not brick.is_uniform(), "not written"
            floats = self.floats[box]
            self.exact[id(brick)] = samples.copy(), floats.view(np.uint32), levels, steps
            # The ends of the range in the index bound the floats, those of the codes need not.
            present = floats[~absent]
            flags = LOWER * bool(self.bins.voxel(brick.smallest) > present.min())
            flags += HIGHER * bool(self.bins.voxel(brick.largest) < present.max())
            self.beyond[id(brick)] = flags
        super().analyze(brick, samples, steps, weights, count)

    def code_all(self, bricks):
        model = super().code_all(bricks)
        for number, brick in enumerate(bricks):
            if brick.is_uniform():
                continue
            if id(brick) not in self.exact:
                brick.segments[-1] = b"\0" + brick.segments[-1]
            elif number in self.plain_at:
                floats = self.exact[id(brick)][1]
                brick.segments = [bytes([PLAIN]) + floats.astype("<u4").tobytes()] + [
                    b"" for _ in brick.segments[1:]]
            else:
                self._add_places(brick)
            flags = self.beyond.get(id(brick), 0)
            brick.smallest -= bool(flags & LOWER)
            brick.largest += bool(flags & HIGHER)
        return model

    def _add_places(self, brick):
        codes, bits, levels, steps = self.exact[id(brick)]
        ahead, last = [b""] * len(brick.segments), len(brick.segments) - 1
        has_absent = bool(levels[0].any())
        for i in range(last + 1 if has_absent else 0):
            ahead[i] = absent_bytes(levels[i], levels[i + 1] if i < last else None, steps[i],
                                    bits if i == 0 else None)
        ahead[0] += PlaceEncoder(self.bins, codes, bits, levels[0], self.repeats).bytes()
        flags = PLACES + ABSENT * has_absent + self.beyond[id(brick)]
        ahead[last] = bytes([flags]) + ahead[last]
        brick.segments = [before + segment for before, segment in zip(ahead, brick.segments)]
