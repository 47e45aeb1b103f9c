"""Codes grey bricks as docs/format-grey.md has them, predicted from means.

Written from that text alone and sharing nothing with the two readers, so that the tests tell what
the text leaves open. Arrays are indexed [z][y][x] in the axes of the model, axis 0 is x.
"""

import dataclasses
import struct

import numpy as np

from file_bytes import crc32c
from written_files import File, pack, signed, varint
from written_masked import Gaps, ValueMap, edges_of

ORDERS = ("xyz", "xzy", "yxz", "yzx", "zxy", "zyx")
FAR_SHARE, SLOPE, BEHIND = 24, 300, 20  # of all groups, axes and classes
THRESHOLD = 40
CONTEXT_WEIGHTS = (20, 6, 9, 30, 21, 40, 0, 0, 0, 0, 0, 33, 17, 17, 9, 9)
SLOT_BITS = 11


class BinaryEncoder:
    """Section 9."""

    def __init__(self):
        self.range, self.low, self.shifts = 2**32 - 1, 0, 0

    def put(self, bit, chance=32768):
        bound = (self.range >> 16) * chance
        if bit:
            self.range = bound
        else:
            self.low += bound
            self.range -= bound
        while self.range < 2**24:
            self.range <<= 8
            self.low <<= 8
            self.shifts += 1

    def end(self):
        return self.low.to_bytes(4 + self.shifts, "big")


class AdaptiveBit:
    """Section 10."""

    def __init__(self, chance=32768):
        self.chance, self.count = chance, 0

    def put(self, coder, bit):
        coder.put(bit, self.chance)
        rate = min(self.count + 1, 5)
        self.count = min(self.count + 1, 5)
        step = (65504 if bit else 32) - self.chance
        self.chance += int(step / 2**rate)


def cell_flags(flags):
    """Section 5: the bytes of the flags of cells; none where no cell is flagged."""
    if not flags.any():
        return b""
    coder, bits = BinaryEncoder(), [AdaptiveBit() for _ in range(8)]
    near = np.pad(flags.astype(int), [(1, 0)] * 3)
    for z, y, x in np.ndindex(flags.shape):
        number = near[z + 1, y + 1, x] + 2 * near[z + 1, y, x + 1] + 4 * near[z, y + 1, x + 1]
        bits[number].put(coder, flags[z, y, x])
    return coder.end()


class AdaptiveNumber:
    """Section 10; of numbers of at most `longest` bits."""

    def __init__(self, longest=24):
        self.longest = longest
        self.lengths = [AdaptiveBit() for _ in range(longest + 1)]
        self.highs = [AdaptiveBit() for _ in range(longest + 1)]

    def put(self, coder, value):
        length = int(value).bit_length()
        for j in range(self.longest):
            self.lengths[j].put(coder, j == length)
            if j == length:
                break
        if length >= 2:
            self.highs[length].put(coder, value >> (length - 2) & 1)
        for bit in range(length - 3, -1, -1):
            coder.put(value >> bit & 1)


@dataclasses.dataclass
class Split:
    """The pairs of a level along an axis, and the means that a reader has of them."""

    axis: int
    means: np.ndarray
    details: np.ndarray
    is_weighted: np.ndarray  # of each pair, or as numpy spreads it
    term: int
    is_flagged: np.ndarray | bool = False  # of each pair: whether it lies in a flagged cell
    padded: np.ndarray | None = None  # the means and two around them
    gaps: Gaps | None = None  # the samples that occur, where some do not


@dataclasses.dataclass
class Scale:
    """Section 1: the samples of the smallest and the largest code of a brick."""

    low: int
    high: int
    shift: int

    @staticmethod
    def of(span):
        low = -2**15 if span <= 65535 else -2**31
        return Scale(low, low + span, max(0, span.bit_length() - 16))


def along(array, axis, first, step, count):
    """Every step-th of the planes across an axis."""
    where = [slice(None)] * 3
    where[2 - axis] = slice(first, first + step * count, step)
    return array[tuple(where)]


def split_along(samples, axis, each, last, term):
    """Section 2. Returns a Split and the weights of its means."""
    length = samples.shape[2 - axis]
    pairs = length // 2
    a, b = along(samples, axis, 0, 2, pairs), along(samples, axis, 1, 2, pairs)
    second = np.full(pairs, each, np.int64)
    if pairs and length % 2 == 0:
        second[-1] = last
    second = second.reshape([-1 if 2 - axis == k else 1 for k in range(3)])
    details, sums = a - b, each + second
    means = b + (each * details + ((sums - 1 + term) >> 1)) // sums
    if length % 2:
        means = np.concatenate([means, along(samples, axis, length - 1, 1, 1)], axis=2 - axis)
    is_weighted = np.broadcast_to(second != each, details.shape)
    split = Split(axis, means, details, is_weighted, term, padded=np.pad(means, 2, mode="edge"))
    return split, 2 * each, last if length % 2 else each + last


def rounding_term(axis, halvings, mask):
    """halvings: of each axis from level 0 of the file to this level; mask: of the next step."""
    later = [halvings[k] + (mask >> k & 1) for k in range(3)]
    others = sum(later[k] > later[axis] or (later[k] == later[axis] and k < axis)
                 for k in range(3) if k != axis)
    return (others + halvings[axis] + 1) & 1


def levels_of(samples, masks, halvings, each, last):
    """Of each step of a brick its splits, in the order of their making, and what they leave."""
    halvings, each, last, steps = list(halvings), list(each), list(last), []
    for mask in masks:
        splits = []
        for axis in range(3):
            if mask >> axis & 1:
                term = rounding_term(axis, halvings, mask)
                split, each[axis], last[axis] = split_along(samples, axis, each[axis], last[axis],
                                                            term)
                samples = split.means
                splits.append(split)
        halvings = [halvings[k] + (mask >> k & 1) for k in range(3)]
        steps.append((splits, samples))
    return steps


def flag_cells(samples, masks, steps):
    """Finds the cells of a brick that hold one value, and marks their pairs. Returns the flags."""
    shifts = [(masks[0] >> k & 1) + (masks[1] >> k & 1) for k in range(3)]
    shape = steps[1][1].shape
    flags = np.empty(shape, bool)
    for place in np.ndindex(shape):
        cell = samples[tuple(slice(place[2 - k] << shifts[k], (place[2 - k] + 1) << shifts[k])
                             for k in (2, 1, 0))]
        flags[place] = cell.min() == cell.max()
    for level in (0, 1):
        for split in steps[level][0]:
            # Axes behind that of the split are not halved yet.
            left = [(k > split.axis and masks[level] >> k & 1)
                    + (masks[1] >> k & 1 if level == 0 else 0) for k in range(3)]
            places = [np.arange(n) >> left[2 - k] for k, n in enumerate(split.details.shape)]
            split.is_flagged = flags[np.ix_(*places)]
    return flags


def fold(value, start, last):
    """The residual that section 6 unfolds to `value`."""
    is_turned = 2 * start < last
    value = np.where(is_turned, last - value, value)
    start = np.where(is_turned, last - start, start)
    beyond = last - value
    far = np.where(beyond % 2 == 1, -(beyond + 1) // 2, beyond // 2)
    return np.where(abs(value - start) <= last - start, value - start, far)


def shifted(padded, shape, axis, step):
    """Of a padded array what lies `step` further along an axis from each place of `shape`."""
    where = [slice(2, 2 + n) for n in shape]
    where[2 - axis] = slice(2 + step, 2 + step + shape[2 - axis])
    return padded[tuple(where)]


def half_octave(number):
    length = int(number).bit_length() - 1
    return min(2 * length + (number >> (length - 1) & 1) - 6, 29)


def magnitudes_before(split, magnitudes, halved_y):
    """w3 and w4 of section 8; magnitudes: of the splits of the level done before, by axis."""
    shape = split.details.shape

    def taken(axis, y_halved, z_halved):
        before = magnitudes.get(axis)
        if before is None:
            return np.zeros(shape, np.int64)
        places = [np.arange(n) for n in shape]
        places[0], places[1] = places[0] >> z_halved, places[1] >> y_halved
        return before[np.ix_(*[np.minimum(p, n - 1) for p, n in zip(places, before.shape)])]

    zeros = np.zeros(shape, np.int64)
    if split.axis == 2:
        return zeros, zeros
    if split.axis == 1:
        return taken(2, 0, 1), zeros
    return taken(1, 1, 0), taken(2, halved_y, 1)


def residuals_of(split, scale, is_edge, magnitudes, halved_y):
    """Sections 6 to 8: residuals and contexts of a split; those of edges are of no account."""
    low, high, shift = scale.low, scale.high, scale.shift
    details = np.where(is_edge, 0, split.details)
    shape, padded = details.shape, split.padded
    at = {step: shifted(padded, shape, split.axis, step) for step in (-2, -1, 0, 1, 2)}
    mean = at[0]
    e0 = (abs(at[-1] - mean) >> shift) + (abs(at[1] - mean) >> shift)
    e1 = abs(at[-1] + at[1] - 2 * mean) >> shift
    e2 = sum(abs(shifted(padded, shape, axis, step) - mean) >> shift
             for axis in range(3) if axis != split.axis for step in (-1, 1))
    activity = e0 + e2
    has_weights = activity > 0
    limit = np.minimum(2 * (mean - low) + 1 - split.term, 2 * (high - mean) + split.term)
    limit = np.where(split.is_weighted, high - low, limit)
    limit = np.where(split.is_flagged | is_edge, 0, limit)
    slope = at[-1] - at[1] + (((at[-2] - at[2]) * FAR_SHARE + 64) >> 7)
    likely = np.clip((slope * SLOPE + 2048) >> 12, -limit, limit)
    likely = np.where(has_weights, likely, 0)
    excess = np.zeros(shape, np.int64)
    excess[1:] = (details - likely)[:-1]
    prediction = np.clip(likely + ((excess * BEHIND + 64) >> 7), -limit, limit)
    prediction = np.where(has_weights, prediction, 0)
    if split.gaps is None:
        residuals = fold(details + limit, prediction + limit, 2 * limit)
    else:
        residuals = split.gaps.residuals(mean, split.term, details, prediction, limit)

    own = np.minimum(abs(residuals) >> shift, 2047)
    magnitudes[split.axis] = own
    behind = np.zeros(shape, np.int64)
    behind[1:] = own[:-1]
    wide = np.pad(behind, [(0, 0), (0, 0), (1, 1)], mode="edge")
    high_rows = np.pad(behind, [(0, 0), (1, 1), (0, 0)], mode="edge")
    zeros = np.zeros(shape, np.int64)
    features = [np.minimum(e0, 16383), np.minimum(e1, 16383), np.minimum(e2, 16383),
                *magnitudes_before(split, magnitudes, halved_y), zeros + 1, *[zeros] * 5,
                behind, wide[:, :, :-2], wide[:, :, 2:], high_rows[:, :-2], high_rows[:, 2:]]
    total = sum(weight * feature for weight, feature in zip(CONTEXT_WEIGHTS, features))
    bank = total > 128 * ((limit >> shift) - 1)
    total = np.minimum(total, limit >> shift << 8)
    halves = np.array([half_octave(number + 8) for number in total.flat], np.int64)
    return residuals, halves.reshape(shape) + 30 * bank


def token_of(residual, context, shift):
    """Section 4: a token, and its plain bits as (number, how many)."""
    u = signed(residual)
    k = min(7, max(0, context % 30 // 2 - 6)) + shift
    high = u >> k
    if high < 32:
        return high, (u & ((1 << k) - 1), k)
    e = high.bit_length() - 2
    return 32 + 2 * (e - 4) + (high >> e & 1), (u & ((1 << (e + k)) - 1), e + k)


def symbols_of(splits, scale, has_edges=False):
    """[(context, token, plain bits, number in its row)] of a level, in the order of coding; and how
    many details it has. Contexts of edges follow those of residuals."""
    magnitudes, symbols, count = {}, [], 0
    halved_y = any(split.axis == 1 for split in splits)
    for split in reversed(splits):
        if split.details.size == 0:
            continue
        is_edge = np.zeros(split.details.shape, bool)
        is_open = ~np.broadcast_to(split.is_flagged, is_edge.shape)
        count += np.count_nonzero(is_open)
        if has_edges:
            is_edge, kinds = edges_of(split, scale)
            symbols += [(60 + context, kind, bits, j) for context, kind, bits, j in kinds]
        residuals, contexts = residuals_of(split, scale, is_edge, magnitudes, halved_y)
        for z, y in np.ndindex(residuals.shape[:2]):
            coded = (is_open & ~is_edge)[z, y]
            pairs = zip(contexts[z, y][coded].tolist(), residuals[z, y][coded].tolist())
            symbols += [(context, *token_of(residual, context, scale.shift), j)
                        for j, (context, residual) in enumerate(pairs)]
    return symbols, count


def parts_of(steps, mask, cuts):
    """Section 16: the splits of each part of level 0; steps: those of the brick."""
    splits, level1 = steps[0]
    fine = list(level1.shape[::-1])
    for split in splits:
        shape = split.details.shape[2 - split.axis], split.means.shape[2 - split.axis]
        fine[split.axis] = sum(shape)
    runs = [[(at, min(at + 32, n)) for at in range(0, n, 32)] if cuts >> k & 1 else [(0, n)]
            for k, n in enumerate(fine)]
    return [[part_of(split, level1, mask, (x, y, z)) for split in splits]
            for z in runs[2] for y in runs[1] for x in runs[0]]


def part_of(split, level1, mask, box):
    """What a part has of a split; box: [start, end) of its voxels along each axis."""
    means, pairs, places = [], [], []
    for axis, (start, end) in enumerate(box):
        half = mask >> axis & 1
        coarse = (start >> half, (end + half) >> half)
        means.append((start, end) if axis > split.axis else coarse)
        pairs.append((start >> 1, end >> 1) if axis == split.axis else means[axis])
        last = split.means.shape[2 - axis] - 1
        places.append(np.clip(np.arange(means[axis][0] - 2, means[axis][1] + 2), 0, last))
    own = tuple(slice(*pairs[k]) for k in (2, 1, 0))
    is_x, is_y, is_z = ((p >= m[0]) & (p < m[1]) for p, m in zip(places, means))
    over = [p >> (mask >> axis & 1 and axis > split.axis) for axis, p in enumerate(places)]
    padded = np.where(is_z[:, None, None] & is_y[:, None] & is_x,
                      split.means[np.ix_(*places[::-1])], level1[np.ix_(*over[::-1])])
    inside = tuple(slice(*m) for m in means[::-1])
    flagged = np.broadcast_to(split.is_flagged, split.details.shape)[own]
    return dataclasses.replace(split, means=split.means[inside], details=split.details[own],
                               is_weighted=split.is_weighted[own], is_flagged=flagged,
                               padded=padded)


def frequencies_of(levels):
    """Tables of both sets out of [(set, symbols)]; None: that of the context before. And those of
    edges, of the kinds 1 and 2."""
    counts, edges = np.zeros((2, 60, 63), np.int64), np.zeros((360, 3), np.int64)
    for table_set, symbols in levels:
        for context, token, _, _ in symbols:
            if context < 60:
                counts[table_set, context, token] += 1
            else:
                edges[context - 60, token] += 1
    tables = [[None] * 60, [None] * 60]
    for table_set in range(2):
        for context in range(60):
            own = counts[table_set, context]
            if context == 0 or own.sum():
                share = own * 1900 // max(own.sum(), 1)
                tables[table_set][context] = np.maximum(share, own > 0).tolist()
    shares = edges[:, 1:] * 1900 // np.maximum(edges.sum(axis=1, keepdims=True), 1)
    return tables, np.maximum(shares, 1).tolist()


class Model:
    """Section 11, and streams of details under it."""

    def __init__(self, order, levels, cuts=0, has_edges=False, value_map=None, voxel_step=1):
        self.order, self.cuts, self.has_edges = order, cuts, has_edges
        self.value_map, self.voxel_step = value_map, voxel_step
        self.tables, self.edges = frequencies_of(levels)

    def bytes(self):
        coder = BinaryEncoder()
        slopes, far, behind, contexts, lengths = (AdaptiveNumber() for _ in range(5))
        for _ in range(9):
            far.put(coder, signed(FAR_SHARE))
            for _ in range(4):
                slopes.put(coder, signed(SLOPE))
                behind.put(coder, signed(BEHIND))
        for _ in range(9):
            for weight in CONTEXT_WEIGHTS:
                contexts.put(coder, weight)
        self._put_tables(coder, lengths)
        flags = 1 + 2 * (self.voxel_step > 1) + 4 * ORDERS.index(self.order)
        flags += 32 * (self.value_map is not None) + 64 * self.has_edges
        start = bytes([flags, self.cuts])
        if self.voxel_step > 1:
            start += varint(self.voxel_step) + varint(0) + varint(0)
        if self.value_map is not None:
            start += self.value_map.bytes()
        return start + varint(THRESHOLD) + b"\0" + coder.end()

    def _put_tables(self, coder, lengths):
        numbers = {}
        for table in self.tables:
            before = [0] * 64
            for own in table:
                if own is None:
                    lengths.put(coder, 0)
                    continue
                count = max((i + 1 for i, f in enumerate(own) if f), default=0)
                lengths.put(coder, count + 1)
                last = 0
                for frequency, other in zip(own[:count], before):
                    size = other.bit_length()
                    kind = (min(last.bit_length(), 11), (size > 0) + (size > 3) + (size > 6))
                    numbers.setdefault(kind, AdaptiveNumber()).put(coder, frequency)
                    last = frequency
                before = own + [2048 - sum(own)]
        repeats, *kinds = (AdaptiveNumber() for _ in range(3))
        for own, before in zip(self.edges, [None] + self.edges if self.has_edges else []):
            repeats.put(coder, own != before)
            for number, frequency in zip(kinds, own if own != before else []):
                number.put(coder, frequency - 1)

    def slots(self, table_set, context, token):
        """Frequency and first slot."""
        if context >= 60:
            own = self.edges[context - 60]
            own = [2048 - sum(own)] + own
        else:
            while self.tables[table_set][context] is None:
                context -= 1
            own = self.tables[table_set][context]
        return own[token], sum(own[:token])

    def details(self, table_set, symbols, detail_count, most_states=32):
        """Section 4, from the plain bits on."""
        if not detail_count:
            return b""
        count = next(n for lowest, n in ((16384, 32), (1024, 8), (128, 2), (0, 1))
                     if detail_count >= lowest)
        count = min(count, most_states)
        plain, plain_length, tokens = 0, 0, []
        for context, token, (bits, width), number in symbols:
            plain |= bits << plain_length
            plain_length += width
            tokens.append((*self.slots(table_set, context, token), number % count))
        states, words = [65536] * count, []
        for frequency, first, place in reversed(tokens):
            state = states[place]
            while state >= frequency << 21:
                words.append(state & 65535)
                state >>= 16
            states[place] = (state // frequency << SLOT_BITS) + state % frequency + first
        packed = plain.to_bytes((plain_length + 7) // 8, "little")
        return (varint(len(packed)) + packed + struct.pack(f"<{count}I", *states)
                + struct.pack(f"<{len(words)}H", *reversed(words)))


@dataclasses.dataclass
class Coded:
    """What a brick is made of before the model is known."""

    plain: bytes  # with the brick's map, where the model has one
    cells: bytes | None  # None: a brick of fewer than three levels
    parts: list  # symbols and number of details of each part of level 0, one if nothing is cut
    levels: list  # the same of level 1 and up


class GreyFile(File):
    """Of int16, or int32 where voxels need it; its model has an order of axes.

    value_map   which codes there are; its bricks of tier 0 have gaps where it lists them
    voxel_step  above 1: voxels are rounded to multiples of this odd number
    """

    def __init__(self, voxels, masks, order="xyz", spacing=(1.0, 1.0, 1.0), cuts=0,
                 has_edges=False, value_map=None, voxel_step=1):
        self.order, self.cuts, self.has_edges = order, cuts, has_edges
        self.value_map, self.voxel_step = value_map, voxel_step
        self.max_error = (voxel_step - 1) // 2
        self.decoded = voxels.astype(np.int64)
        self.coded = {}
        if abs(self.decoded).max() > 32767:
            self.TYPE, self.DTYPE = 5, "<i4"
        super().__init__(voxels, masks, spacing)

    def planes(self):
        return self.decoded

    def _code_of(self, voxels, step):
        if self.value_map is not None:
            return (voxels - self.value_map.offset) // self.value_map.step
        return (voxels + step // 2) // step

    def _voxel_of(self, codes, step, brick):
        if self.value_map is not None:
            return codes * self.value_map.step + self.value_map.offset
        return np.clip(codes * step, brick.smallest, brick.largest)

    def analyze(self, brick, samples, steps, weights, count):
        turn = ["xyz".index(name) for name in self.order]  # of the model's axes
        is_finest = weights[0] == [0, 0, 0]
        step = self.voxel_step if is_finest else 1
        lowest = self._code_of(brick.smallest, step)
        scale = Scale.of(int(self._code_of(brick.largest, step) - lowest))
        codes = self._code_of(samples, step)
        turned = (codes - lowest + scale.low).transpose([2 - turn[k] for k in (2, 1, 0)])
        masks = [sum((mask >> turn[k] & 1) << k for k in range(3)) for mask in steps]
        made = levels_of(turned, masks, *[[values[turn[k]] for k in range(3)]
                                          for values in weights])
        cells = cell_flags(flag_cells(turned, masks, made)) if count >= 3 else None
        if step > 1:
            box = tuple(slice(p * side, p * side + n) for p, side, n in zip(
                brick.place[::-1], [1 << sum(m >> k & 1 for m in steps) for k in (2, 1, 0)],
                samples.shape))
            self.decoded[box] = self._voxel_of(codes, step, brick)
        brick_map = b""
        if self.value_map is not None:
            has_gaps = is_finest and self.value_map.has_gaps()
            brick_map = self.value_map.brick_bytes(codes, has_gaps)
            if has_gaps and count > 1:
                occurring = self.value_map.occurring(codes) - lowest + scale.low
                made[0][0][0].gaps = Gaps(occurring)
        parts = [made[0][0]]
        if count >= 3 and any(self.cuts >> k & 1 and turned.shape[2 - k] > 32 for k in range(3)):
            parts = parts_of(made, masks[0], self.cuts)
        coarsest = made[count - 2][1] if count > 1 else turned
        self.coded[id(brick)] = Coded(
            brick_map + pack((coarsest - scale.low).flat, (scale.high - scale.low).bit_length()),
            cells, [symbols_of(part, scale, self.has_edges) for part in parts if count > 1],
            [symbols_of(splits, scale, self.has_edges) for splits, _ in made[1:count - 1]])
        root = int(made[-1][1].item()) - scale.low + lowest
        brick.root = int(self._voxel_of(root, step, brick))

    def code_all(self, bricks):
        if self.voxel_step == 1:
            return self._code_some(bricks, self.voxel_step)
        # Those of other tiers leave out nothing.
        finest = self.tiers[0]
        model = self._code_some(finest, self.voxel_step)
        if len(self.tiers) > 1:
            self.coarse_model = self._code_some(bricks[len(finest):], 1)
        return model

    def _code_some(self, bricks, voxel_step):
        """Under a model of their own."""
        coded = [(brick, self.coded[id(brick)]) for brick in bricks if not brick.is_uniform()]
        streams = [(0, symbols) for _, own in coded for symbols, _ in own.parts]
        streams += [(1, symbols) for _, own in coded for symbols, _ in own.levels]
        model = Model(self.order, streams, self.cuts, self.has_edges, self.value_map, voxel_step)
        for brick, own in coded:
            has_parts = len(own.parts) > 1
            most = (8 if self.cuts & 1 else 16) if has_parts else 32
            parts = [model.details(0, *part, most) for part in own.parts]
            segments = [model.details(1, *level) for level in own.levels]
            if own.cells is not None:
                segments[0] = varint(len(own.cells)) + own.cells + segments[0]
            if has_parts:
                segments[0] = b"".join(part_entry(part) for part in parts) + segments[0]
            brick.segments = ([b"".join(parts)] if own.parts else []) + segments + [own.plain]
        return model.bytes()


def part_entry(part):
    """Section 16: what the list of parts has of one."""
    return varint(len(part)) + (struct.pack("<I", crc32c(part)) if part else b"")
