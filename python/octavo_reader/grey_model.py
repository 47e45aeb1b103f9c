"""Models of grey bricks: docs/format-grey.md, section 11."""

from dataclasses import dataclass

import numpy as np

from .binary_coder import AdaptiveNumber, BinaryDecoder
from .byte_cursor import ByteCursor, unpack_bits
from .errors import OctavoError, require

GROUPS = 3
CLASSES = 5
CONTEXTS = 60
EDGE_CONTEXTS = 360
TOKENS = 64
PROBABILITY_BITS = 11

# The axis that takes the part of x, of y and of z.
_AXIS_ORDERS = ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))

# Places (x, y, z) where the rows of 8 taps start, counted from the first sample of a pair.
TAP_ROWS = (
    ((-8, 0, 0), (0, 0, 0), (-3, -1, 0), (-3, 1, 0), (-3, 0, -1), (-3, 0, 1), (-3, -1, -1),
     (-3, 1, -1), (-3, -1, 1), (-3, 1, 1)),
    ((-3, -2, 0), (-3, -1, 0), (-3, 0, 0), (-3, 1, 0), (-3, 2, 0), (-3, -1, -1), (-3, 0, -1),
     (-3, 1, -1), (-3, 2, -1), (-3, -1, 1), (-3, 0, 1), (-3, 2, 1)),
    ((-3, 0, -2), (-3, -1, -1), (-3, 0, -1), (-3, 1, -1), (-3, -1, 0), (-3, 0, 0), (-3, 1, 0),
     (-3, -1, 1), (-3, 0, 1), (-3, -1, 2), (-3, 0, 2), (-3, 1, 2)),
)
CENTERS = (8, 19, 43)


@dataclass(frozen=True)
class ValueMap:
    """Which values occur: multiples of `step` plus `offset`, and of their codes those in `codes`.

    codes  empty: not known
    """

    step: int
    offset: int
    codes: frozenset[int]


@dataclass(frozen=True)
class GreyModel:
    """What the grey bricks of some layers share.

    predictor        0: taps around a pair; 1: the means before and after it
    axis_order       the axes (0 x, 1 y, 2 z) that take the parts of x, y, z
    cut_axes         mask of the axes, of that order, that are cut at 32 voxels in level 0
    voxel_step       q: a code stands for q voxels
    value_map        None, or which values occur
    has_edges        whether pairs at the edge of the background are told apart
    detail_step      Q8; correction_step in voxel units; both 0 unless details are quantized
    threshold        T of the activity class
    tap_weights      predictor 0: [group][axis], shape (CLASSES, taps), in 4096ths
    mean_weights     predictor 1: [group][axis], shape (CLASSES,), in 4096ths
    far_shares       predictor 1: [group][axis], in 128ths
    behind_weights   predictor 1: [group][axis], shape (CLASSES,), in 128ths
    context_weights  [group][axis], shape (16,)
    frequencies      [table set], shape (CONTEXTS, TOKENS), rows of sum 2048
    edge_frequencies  shape (EDGE_CONTEXTS, 3), rows of sum 2048; None without edges
    """

    predictor: int
    axis_order: tuple[int, int, int]
    cut_axes: int
    is_lossy: bool
    voxel_step: int
    detail_step: int
    correction_step: int
    value_map: "ValueMap | None"
    has_edges: bool
    threshold: int
    tap_weights: list[list[np.ndarray]]
    mean_weights: list[list[np.ndarray]]
    far_shares: list[list[int]]
    behind_weights: list[list[np.ndarray]]
    context_weights: list[list[np.ndarray]]
    frequencies: list[np.ndarray]
    edge_frequencies: "np.ndarray | None"


def parse_grey_model(data: bytes) -> GreyModel:
    """Reads a model. Raises OctavoError "corrupt", or "unsupported_version"."""
    cursor = ByteCursor(data, "grey model")
    flags, cut_axes = cursor.u8(), cursor.u8()
    predictor, is_lossy, order = flags & 1, bool(flags & 2), flags >> 2 & 7
    if order >= len(_AXIS_ORDERS) or flags >= 128 or cut_axes >= 8:
        raise OctavoError("unsupported_version",
                          "a grey model of a later version of the format")
    voxel_step, detail_step, correction_step = 1, 0, 0
    if is_lossy:
        voxel_step, detail_step, correction_step = (cursor.varint() for _ in range(3))
        require(voxel_step & 1 == 1 and voxel_step < 1 << 32 and detail_step <= 1 << 23
                and correction_step < 1 << 32, "the steps of a grey model are wrong")
        require((voxel_step > 1) == (detail_step == 0) == (correction_step == 0),
                "the steps of a grey model exclude each other")
    value_map = _value_map(cursor) if flags & 32 else None
    has_edges = bool(flags & 64)
    require(not is_lossy or (value_map is None and not has_edges),
            "a lossy grey model has what only lossless ones have")
    threshold = cursor.varint()
    weight_step = cursor.u8()
    require(1 <= threshold <= 16383 and weight_step <= 8, "a number of a grey model is wrong")

    body = cursor.rest()
    decoder = BinaryDecoder(body)
    used = AdaptiveNumber(24)
    taps = means = shares = behind = []
    if predictor == 0:
        taps = _tap_weights(decoder, used, weight_step)
    else:
        shares, means, behind = _mean_weights(decoder, used)
    contexts = _context_weights(decoder)
    frequencies = _frequencies(decoder)
    edge_frequencies = _edge_frequencies(decoder) if has_edges else None
    require(decoder.at == len(body), "a grey model does not end where it should")
    return GreyModel(predictor, _AXIS_ORDERS[order], cut_axes, is_lossy, voxel_step, detail_step,
                     correction_step, value_map, has_edges, threshold, taps, means,
                     shares, behind, contexts, frequencies, edge_frequencies)


def _value_map(cursor: ByteCursor) -> ValueMap:
    step, offset, count = (cursor.varint() for _ in range(3))
    require(1 <= step < 1 << 32 and offset < step and count <= 256, "a value map is wrong")
    require(step > 1 or count > 0, "a value map says nothing")
    if count == 0:
        return ValueMap(step, offset, frozenset())
    number = cursor.varint()
    first = number >> 1 ^ -(number & 1)
    require(abs(first) < 1 << 32, "a value map has a code out of range")
    flags = unpack_bits(cursor.take((count + 7) // 8), 1, count, "a value map")
    require(bool(flags[0]) and bool(flags[-1]), "a value map begins or ends with a gap")
    return ValueMap(step, offset, frozenset(first + i for i in range(count) if flags[i]))


def _distance(axis: int, tap: int) -> int:
    """Which adaptive number of an axis codes a tap's weight."""
    if axis == 0 and tap < 16:
        return 0 if 6 <= tap <= 11 else 1
    column = abs(tap % 8 - 3)
    return 0 if column <= 1 else 1 if column == 2 else 2


def _tap_weights(decoder: BinaryDecoder, used: AdaptiveNumber, step: int) -> list[list[np.ndarray]]:
    states = [[AdaptiveNumber(24) for _ in range(3)] for _ in range(3)]
    weights = []
    for _ in range(GROUPS):
        weights.append([])
        for axis in range(3):
            taps = 8 * len(TAP_ROWS[axis])
            table = np.zeros((CLASSES, taps), np.int64)
            for row in table[1:]:
                if decoder.number(used) == 0:
                    continue
                for tap in range(taps):
                    if tap != CENTERS[axis]:
                        row[tap] = decoder.signed(states[axis][_distance(axis, tap)]) << step
                row[CENTERS[axis]] = -row.sum()
            weights[-1].append((table + 32768) % 65536 - 32768)
    return weights


def _mean_weights(decoder: BinaryDecoder, used: AdaptiveNumber) -> tuple[
        list[list[int]], list[list[np.ndarray]], list[list[np.ndarray]]]:
    """The far shares, the weights of the means, and those of what is behind."""
    share_state, behind_state = AdaptiveNumber(24), AdaptiveNumber(24)
    shares: list[list[int]] = []
    weights: list[list[np.ndarray]] = []
    behind: list[list[np.ndarray]] = []
    for _ in range(GROUPS):
        shares.append([])
        weights.append([])
        behind.append([])
        for _ in range(3):
            share = decoder.signed(share_state)
            pairs = [(0, 0)] + [(decoder.signed(used), decoder.signed(behind_state))
                                for _ in range(1, CLASSES)]
            require(abs(share) <= 127 and all(abs(w) <= 8191 and abs(b) <= 127
                                              for w, b in pairs), "a weight is too large")
            shares[-1].append(share)
            weights[-1].append(np.array([w for w, _ in pairs], np.int64))
            behind[-1].append(np.array([b for _, b in pairs], np.int64))
    return shares, weights, behind


def _context_weights(decoder: BinaryDecoder) -> list[list[np.ndarray]]:
    states = AdaptiveNumber(24)
    weights = []
    for _ in range(GROUPS):
        rows = [[decoder.number(states) for _ in range(16)] for _ in range(3)]
        require(all(w <= 8191 for row in rows for w in row), "a context weight is too large")
        weights.append([np.array(row, np.int64) for row in rows])
    return weights


def _frequencies(decoder: BinaryDecoder) -> list[np.ndarray]:
    counts = AdaptiveNumber(24)
    states = [[AdaptiveNumber(24) for _ in range(4)] for _ in range(PROBABILITY_BITS + 1)]
    sets = []
    for _ in range(2):
        table = np.zeros((CONTEXTS, TOKENS), np.int64)
        above = [0] * TOKENS
        for context in range(CONTEXTS):
            count = decoder.number(counts)
            require(count <= TOKENS and (count > 0 or context > 0), "a table has too many tokens")
            if count > 0:
                row = [0] * TOKENS
                for token in range(count - 1):
                    before = row[token - 1] if token > 0 else 0
                    state = states[min(before.bit_length(), 11)][_size(above[token])]
                    row[token] = decoder.number(state)
                row[TOKENS - 1] = (1 << PROBABILITY_BITS) - sum(row)
                require(row[TOKENS - 1] >= 1, "frequencies exceed their sum")
                above = row
            table[context] = above
        sets.append(table)
    return sets


def _edge_frequencies(decoder: BinaryDecoder) -> np.ndarray:
    is_own = AdaptiveNumber(24)
    states = [AdaptiveNumber(24) for _ in range(2)]
    table: list[list[int]] = []
    for context in range(EDGE_CONTEXTS):
        code = decoder.number(is_own)
        require(code <= 1 and (code == 1 or context > 0), "a table of edges is not there")
        if code == 0:
            table.append(table[-1])
            continue
        first, second = (decoder.number(state) + 1 for state in states)
        require(first + second < 1 << PROBABILITY_BITS, "frequencies exceed their sum")
        table.append([(1 << PROBABILITY_BITS) - first - second, first, second])
    return np.array(table, np.int64)


def _size(frequency: int) -> int:
    """The class of a frequency's bit length: 0, 1..3, 4..6, 7 and more."""
    return min((frequency.bit_length() + 2) // 3, 3)
