"""Codes grey bricks as docs/format-grey.md has them: lossless, narrow, predicted from means.

Written from that text alone and sharing nothing with the two readers, so that the tests tell what
the text leaves open. Arrays are indexed [z][y][x] in the axes of the model, axis 0 is x.
"""

import dataclasses
import struct

import numpy as np

from written_files import File, pack, signed, varint

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
    split = Split(axis, means, details, second != each, term)
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


def residuals_of(split, high, magnitudes, halved_y):
    """Sections 6 to 8: residuals and contexts of a split whose samples lie in [-2^15, high]."""
    low, details = -2**15, split.details
    shape = details.shape
    padded = np.pad(split.means, 2, mode="edge")
    at = {step: shifted(padded, shape, split.axis, step) for step in (-2, -1, 0, 1, 2)}
    mean = at[0]
    e0 = abs(at[-1] - mean) + abs(at[1] - mean)
    e1 = abs(at[-1] + at[1] - 2 * mean)
    e2 = sum(abs(shifted(padded, shape, axis, step) - mean)
             for axis in range(3) if axis != split.axis for step in (-1, 1))
    activity = e0 + e2
    has_weights = activity > 0
    limit = np.minimum(2 * (mean - low) + 1 - split.term, 2 * (high - mean) + split.term)
    limit = np.where(split.is_weighted, high - low, limit)
    limit = np.where(split.is_flagged, 0, limit)
    slope = at[-1] - at[1] + (((at[-2] - at[2]) * FAR_SHARE + 64) >> 7)
    likely = np.clip((slope * SLOPE + 2048) >> 12, -limit, limit)
    likely = np.where(has_weights, likely, 0)
    excess = np.zeros(shape, np.int64)
    excess[1:] = (details - likely)[:-1]
    prediction = np.clip(likely + ((excess * BEHIND + 64) >> 7), -limit, limit)
    prediction = np.where(has_weights, prediction, 0)
    residuals = fold(details + limit, prediction + limit, 2 * limit)

    own = np.minimum(abs(residuals), 2047)
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
    bank = total > 128 * (limit - 1)
    total = np.minimum(total, limit << 8)
    halves = np.array([half_octave(number + 8) for number in total.flat], np.int64)
    return residuals, halves.reshape(shape) + 30 * bank


def token_of(residual, context):
    """Section 4: a token, and its plain bits as (number, how many)."""
    u = signed(residual)
    k = min(7, max(0, context % 30 // 2 - 6))
    high = u >> k
    if high < 32:
        return high, (u & ((1 << k) - 1), k)
    e = high.bit_length() - 2
    return 32 + 2 * (e - 4) + (high >> e & 1), (u & ((1 << (e + k)) - 1), e + k)


def symbols_of(splits, high):
    """[(context, residual, number in its row)] of a level, in the order of coding."""
    magnitudes, symbols = {}, []
    halved_y = any(split.axis == 1 for split in splits)
    for split in reversed(splits):
        if split.details.size == 0:
            continue
        residuals, contexts = residuals_of(split, high, magnitudes, halved_y)
        is_coded = np.broadcast_to(~np.asarray(split.is_flagged), residuals.shape)
        for z, y in np.ndindex(residuals.shape[:2]):
            coded = is_coded[z, y]
            pairs = zip(contexts[z, y][coded].tolist(), residuals[z, y][coded].tolist())
            symbols += [(context, residual, j) for j, (context, residual) in enumerate(pairs)]
    return symbols


def frequencies_of(levels):
    """Tables of both sets out of [(set, symbols)]; None: that of the context before."""
    counts = np.zeros((2, 60, 63), np.int64)
    for table_set, symbols in levels:
        for context, residual, _ in symbols:
            counts[table_set, context, token_of(residual, context)[0]] += 1
    tables = [[None] * 60, [None] * 60]
    for table_set in range(2):
        for context in range(60):
            own = counts[table_set, context]
            if context == 0 or own.sum():
                share = own * 1900 // max(own.sum(), 1)
                tables[table_set][context] = np.maximum(share, own > 0).tolist()
    return tables


class Model:
    """Section 11, and streams of details under it."""

    def __init__(self, order, levels):
        self.order = order
        self.tables = frequencies_of(levels)

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
        start = bytes([1 + 4 * ORDERS.index(self.order), 0]) + varint(THRESHOLD) + b"\0"
        return start + coder.end()

    def slots(self, table_set, context, token):
        """Frequency and first slot."""
        while self.tables[table_set][context] is None:
            context -= 1
        own = self.tables[table_set][context]
        return own[token], sum(own[:token])

    def details(self, table_set, symbols):
        """Section 4, from the plain bits on."""
        if not symbols:
            return b""
        count = next(n for lowest, n in ((16384, 32), (1024, 8), (128, 2), (0, 1))
                     if len(symbols) >= lowest)
        plain, plain_length, tokens = 0, 0, []
        for context, residual, number in symbols:
            token, (bits, width) = token_of(residual, context)
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


class GreyFile(File):
    """Of int16; its model has an order of axes."""

    def __init__(self, voxels, masks, order="xyz", spacing=(1.0, 1.0, 1.0)):
        self.order = order
        self.parts = {}  # of each brick plain bytes, flags of cells, symbols of its levels
        super().__init__(voxels, masks, spacing)

    def analyze(self, brick, samples, steps, weights, count):
        turn = ["xyz".index(name) for name in self.order]  # of the model's axes
        turned = (samples - brick.smallest - 2**15).transpose([2 - turn[k] for k in (2, 1, 0)])
        masks = [sum((mask >> turn[k] & 1) << k for k in range(3)) for mask in steps]
        made = levels_of(turned, masks, *[[values[turn[k]] for k in range(3)]
                                          for values in weights])
        cells = cell_flags(flag_cells(turned, masks, made)) if count >= 3 else b""
        high = brick.largest - brick.smallest - 2**15
        symbols = [symbols_of(splits, high) for splits, _ in made[:count - 1]]
        coarsest = made[count - 2][1] if count > 1 else turned
        width = (brick.largest - brick.smallest).bit_length()
        self.parts[id(brick)] = pack((coarsest + 2**15).flat, width), cells, symbols
        brick.root = int(made[-1][1].item()) + 2**15 + brick.smallest

    def code_all(self, bricks):
        coded = [brick for brick in bricks if not brick.is_uniform()]
        model = Model(self.order, [(min(i, 1), symbols) for brick in coded
                                   for i, symbols in enumerate(self.parts[id(brick)][2])])
        for brick in coded:
            plain, cells, levels = self.parts[id(brick)]
            brick.segments = [model.details(min(i, 1), symbols)
                              for i, symbols in enumerate(levels)] + [plain]
            if len(levels) >= 2:
                brick.segments[1] = varint(len(cells)) + cells + brick.segments[1]
        return model.bytes()
