"""Details of grey bricks: docs/format-grey.md, sections 2, 4, 6 to 8 and 13.

Arrays are indexed [z][y][x]; x, y, z are axes 0, 1, 2, so that array axis = 2 - axis.
"""

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np

from .byte_cursor import ByteCursor
from .errors import require
from .grey_edges import EdgeTables, edges_of_split
from .grey_model import CONTEXTS, PROBABILITY_BITS, TAP_ROWS, TOKENS, GreyModel
from .grey_samples import PaddedSamples

_STATE_START = 65536
_SLOT_MASK = (1 << PROBABILITY_BITS) - 1


@dataclass(frozen=True)
class Lifting:
    """How the pairs (a, b) along an axis become means and details, and back (section 2).

    rounding       the rounding term
    first, second  the weights of the last pair, 1 and 1 where they are equal
    """

    rounding: int
    first: int
    second: int

    @property
    def is_weighted(self) -> bool:
        return self.first != self.second

    def above_second(self, details: np.ndarray) -> np.ndarray:
        """How far means lie above the second samples of their pairs, which follow along axis 0."""
        above = (details + self.rounding) >> 1
        if self.is_weighted:
            above[-1] = self.above_last(details[-1])
        return above

    def above_last(self, detail: int | np.ndarray) -> int | np.ndarray:
        """The same of a detail of the last pair."""
        total = self.first + self.second
        return (self.first * detail + (total - 1 + self.rounding) // 2) // total


def means_along(samples: np.ndarray, array_axis: int, lifting: Lifting) -> np.ndarray:
    """Samples of the next level along one axis; a last sample without a partner stays."""
    lines = np.moveaxis(samples, array_axis, 0)
    pairs = len(lines) // 2
    a, b = lines[0 : 2 * pairs : 2], lines[1 : 2 * pairs : 2]
    means = b + lifting.above_second(a - b)
    return np.moveaxis(np.concatenate([means, lines[2 * pairs :]]), 0, array_axis)


def detail_step(model: GreyModel, axis: int, level: int) -> int:
    """The step D of a split, which its details are multiples of."""
    if model.detail_step == 0:
        return 1
    j = 3 * level + axis
    scale = (32768 if j & 1 else 46341) >> (j // 2)
    return max(1, (model.detail_step * scale + (1 << 22)) >> 23)


def unfolded(residual: int, start: int, last: int) -> int:
    """The number of a residual among 0 .. last; `start` is that of the prediction (section 6)."""
    if 2 * start < last:
        return last - unfolded(residual, last - start, last)
    if abs(residual) <= last - start:
        return start + residual
    return max(last - (2 * residual if residual >= 0 else -2 * residual - 1), 0)


def unfolded_details(residuals: np.ndarray, predictions: np.ndarray,
                     limits: np.ndarray) -> np.ndarray:
    """The details of residuals around predictions within +-limit."""
    near = np.abs(predictions) + residuals
    far = np.maximum(limits - np.where(residuals >= 0, 2 * residuals, -2 * residuals - 1), -limits)
    details = np.where(np.abs(residuals) <= limits - np.abs(predictions), near, far)
    return np.where(predictions < 0, -details, details)


def wrapped(value: int | np.ndarray) -> int | np.ndarray:
    """Modulo 2^32, read as two's complement; of a number or an array."""
    return ((value + (1 << 31)) & 0xFFFFFFFF) - (1 << 31)


class DetailStream:
    """The edges and residuals of a level or part, taken row by row.

    coded_count  its pairs that lie in no flagged cell
    most_states  how many states there are at most
    """

    def __init__(self, data: bytes, coded_count: int, most_states: int = 32) -> None:
        self._plain = b""
        self._plain_at = 0
        self._states: list[int] = []
        self._words: list[int] = []
        self._word_at = 0
        if coded_count == 0:
            require(not data, "a level without details has bytes")
            return
        cursor = ByteCursor(data, "a level of details")
        self._plain = cursor.take(cursor.varint())
        counts = ((16384, 32), (1024, 8), (128, 2), (1, 1))
        state_count = next(states for minimum, states in counts if coded_count >= minimum)
        state_count = min(state_count, most_states)
        self._states = list(cursor.unpack(f"{state_count}I"))
        require(min(self._states) >= _STATE_START, "a state of the details is too small")
        words = cursor.rest()
        require(len(words) % 2 == 0, "details end in half a word")
        self._words = np.frombuffer(words, "<u2").tolist()

    def row(self, tables: "TokenTables", contexts: list[int], extra_bits: list[int]) -> list[int]:
        """The numbers u of one row; `extra_bits` holds k of each context."""
        states, tokens_of = self._states, tables.tokens
        frequencies, firsts = tables.frequencies, tables.firsts
        state_count = len(states)
        numbers = []
        for j, context in enumerate(contexts):
            state = states[j % state_count]
            slot = state & _SLOT_MASK
            token = tokens_of[context][slot]
            state = frequencies[context][token] * (state >> PROBABILITY_BITS)
            states[j % state_count] = self._renewed(state + slot - firsts[context][token])
            k = extra_bits[context]
            if token < 32:
                numbers.append(token << k | self.plain(k))
            elif token < 63:
                length = 4 + (token - 32) // 2 + k
                numbers.append((2 + (token & 1)) << length | self.plain(length))
            else:
                numbers.append(self.plain(20 + k))
        return numbers

    def edge_row(self, starts: list[list[int]], contexts: list[int]) -> list[int]:
        """The kinds of the pairs of one row that may be edges; `starts` by context and kind."""
        states = self._states
        kinds = []
        for j, context in enumerate(contexts):
            state = states[j % len(states)]
            slot = state & _SLOT_MASK
            first, second = starts[context][1:3]
            kind = (slot >= first) + (slot >= second)
            start, end = starts[context][kind : kind + 2]
            states[j % len(states)] = self._renewed(
                (end - start) * (state >> PROBABILITY_BITS) + slot - start)
            kinds.append(kind)
        return kinds

    def _renewed(self, state: int) -> int:
        """A state, with the next word below it where it became too small."""
        if state >= _STATE_START:
            return state
        require(self._word_at < len(self._words), "details end too early")
        self._word_at += 1
        return state << 16 | self._words[self._word_at - 1]

    def plain(self, count: int) -> int:
        """The next plain bits."""
        if count == 0:
            return 0
        at = self._plain_at
        self._plain_at = at + count
        window = int.from_bytes(self._plain[at >> 3 : (at + count + 7) >> 3], "little")
        return window >> (at & 7) & ((1 << count) - 1)

    def end(self) -> None:
        """Raises OctavoError "corrupt" unless everything was taken."""
        require(all(state == _STATE_START for state in self._states)
                and self._word_at == len(self._words), "details do not end where they should")
        require((self._plain_at + 7) // 8 == len(self._plain), "plain bits have a wrong length")


class TokenTables:
    """Of each context the token of each slot, and of each token its frequency and first slot."""

    def __init__(self, frequencies: np.ndarray) -> None:
        self.frequencies = frequencies.tolist()
        self.firsts = (np.cumsum(frequencies, axis=1) - frequencies).tolist()
        tokens = np.arange(TOKENS, dtype=np.uint8)
        self.tokens = [bytes(np.repeat(tokens, row)) for row in frequencies]


class ValueGaps:
    """The details that pairs may have where only some samples occur (section 13).

    used             the samples that occur, ascending
    lowest, highest  the samples of the brick's smallest and largest voxel
    """

    def __init__(self, used: list[int], lowest: int, highest: int, rounding: int) -> None:
        self._lowest = lowest
        self._highest = highest
        self._used = np.array(used, np.int64)
        self._details: dict[int, list[int]] = {}
        for a in used:
            for b in used:
                self._details.setdefault((a + b + rounding) >> 1, []).append(a - b)
        for possible in self._details.values():
            possible.sort()

    def occur(self, samples: np.ndarray) -> np.ndarray:
        """Which of the samples are among those that occur."""
        return np.isin(samples, self._used)

    def detail(self, m: int, prediction: int, residual: int) -> int:
        possible = self._details.get(max(self._lowest, min(self._highest, m)))
        if possible is None:
            return 0
        near = bisect_left(possible, prediction)
        if near == len(possible) or (
                near > 0 and prediction - possible[near - 1] <= possible[near] - prediction):
            near -= 1
        return possible[unfolded(residual, near, len(possible) - 1)]


class DetailDecoder:
    """Decodes the splits of one level of a brick, or of a part of it, in the order z, y, x.

    lowest, highest  the samples of the brick's smallest and largest voxel
    shift, is_narrow as in docs/format-grey.md, section 1
    """

    def __init__(self, model: GreyModel, level: int, stream: DetailStream, lowest: int,
                 highest: int, shift: int, is_narrow: bool) -> None:
        self._model = model
        self._level = level
        self._group = min(level, 2)
        self._stream = stream
        self._lowest = lowest
        self._highest = highest
        self._shift = shift
        self._is_narrow = is_narrow
        self._tables = TokenTables(model.frequencies[min(level, 1)])
        self._edge_tables = EdgeTables(model.edge_frequencies) if model.has_edges else None
        self._magnitudes: dict[int, np.ndarray] = {}

    def split(self, padded: PaddedSamples, axis: int, length: int, flagged: np.ndarray,
              lifting: Lifting, gaps: "ValueGaps | None" = None) -> PaddedSamples:
        """The samples whose means are `padded`: `length` of them along `axis`.

        flagged  which pairs lie in flagged cells, [z][y][x]
        gaps     of the split that makes voxels, where some values do not occur
        """
        repeated = padded.repeated(2 - axis, length)
        pairs = flagged.shape
        if 0 in pairs:
            return repeated
        means = padded.samples
        inside = tuple(slice(0, n) for n in pairs)
        m = means[inside]
        rounding = lifting.rounding
        weighted = np.zeros(pairs, bool)
        if lifting.is_weighted:
            np.moveaxis(weighted, 2 - axis, 0)[-1] = True
        details_of_edges = np.zeros(pairs, np.int64)
        if self._edge_tables is not None:
            details_of_edges = edges_of_split(self._stream, self._edge_tables, padded, axis,
                                              flagged | weighted, self._lowest, self._highest,
                                              rounding, gaps)
            flagged = flagged | (details_of_edges != 0)
        step = detail_step(self._model, axis, self._level)
        odd_low, odd_high = (0, 0) if step > 1 else (1 - rounding, rounding)
        limit = np.minimum(2 * (m - self._lowest) + odd_low, 2 * (self._highest - m) + odd_high)
        limit = np.where(weighted, self._highest - self._lowest, limit)
        limit = np.where(flagged, 0, limit)
        e0, e1, e2 = (e[inside] for e in _activities(padded, axis, self._shift))
        weights = self._model.context_weights[self._group][axis]
        t = sum(w * np.minimum(e, 16383) for w, e in zip(weights, (e0, e1, e2))) + weights[5]
        for which in (0, 1):
            t = t + weights[3 + which] * self._earlier(axis, pairs, which)
        residuals = self._residuals(axis, flagged, limit, t, step)

        threshold = self._model.threshold
        activity = e0 + e2
        classes = ((activity > 0).astype(np.int64) + (activity >= threshold // 4)
                   + (activity >= threshold) + (activity >= 4 * threshold))
        if self._model.predictor == 1:
            w = self._model.mean_weights[self._group][axis][classes]
            behind_weights = self._model.behind_weights[self._group][axis][classes]
            slope = _slopes(padded, axis, self._model.far_shares[self._group][axis])[inside]
            likely = ((slope * w + 2048) >> 12).clip(-limit, limit)
            details = np.empty_like(likely)
            excess = np.zeros_like(likely[0])
            for z, room in enumerate(limit):
                prediction = likely[z] + ((excess * behind_weights[z] + 64) >> 7)
                details[z] = _details_of_plane(residuals[z], prediction.clip(-room, room), room,
                                               step, m[z], gaps, ~weighted[z])
                excess = details[z] - likely[z]
            details = np.where(details_of_edges != 0, details_of_edges, details)
            return repeated.replaced(self._merge(means, axis, length, details, lifting))
        return repeated.replaced(self._predicted(means, repeated, axis, classes, limit, residuals,
                                                 lifting, gaps, details_of_edges, weighted, step))

    def _merge(self, means: np.ndarray, axis: int, length: int, details: np.ndarray,
               lifting: Lifting) -> np.ndarray:
        """Samples from means and details; a mean without a detail is a sample."""
        array_axis = 2 - axis
        m = np.moveaxis(means, array_axis, 0)
        d = np.moveaxis(details, array_axis, 0)
        b = m[: len(d)] - lifting.above_second(d)
        out = np.empty((length,) + m.shape[1:], np.int64)
        out[0 : 2 * len(d) : 2] = (b + d).clip(self._lowest, self._highest)
        out[1 : 2 * len(d) : 2] = b.clip(self._lowest, self._highest)
        out[2 * len(d) :] = m[len(d) :]
        return np.moveaxis(out, 0, array_axis)

    def _earlier(self, axis: int, pairs: tuple[int, int, int], which: int) -> np.ndarray | int:
        """Magnitudes at the same places in a split of this level done before, or 0.

        which  0: the y split for x, the z split for y; 1: the z split for x
        """
        source = axis + 1 + which
        magnitudes = self._magnitudes.get(source)
        if magnitudes is None:
            return 0
        places = []
        for a, count in zip((2, 1, 0), pairs):
            at = np.arange(count)
            if axis < a <= source and a in self._magnitudes:
                at = at >> 1
            places.append(np.minimum(at, magnitudes.shape[2 - a] - 1))
        return magnitudes[np.ix_(*places)]

    def _residuals(self, axis: int, flagged: np.ndarray, limit: np.ndarray, t: np.ndarray,
                   step: int) -> np.ndarray:
        """Decodes the residuals of a split and keeps their magnitudes."""
        nz, ny, nx = flagged.shape
        w = self._model.context_weights[self._group][axis]
        above_weights = np.array([w[7], w[9], w[8], w[10], w[6]])
        behind_weights = np.array([0, w[12], w[11], w[13], 0])
        bound = limit >> self._shift
        minimum_upper = 128 * (bound - 1)
        most = bound << 8
        extra = [min(7, max(0, h // 2 - 5 - step.bit_length())) + self._shift for h in range(30)]
        extra *= 2
        residuals = np.zeros(flagged.shape, np.int64)
        # Rows with two more magnitudes at both ends.
        rows = np.zeros((nz, ny, nx + 4), np.int64)
        zeros = np.zeros(nx + 4, np.int64)
        for z in range(nz):
            for y in range(ny):
                behind = rows[z - 1, y] if z > 0 else None
                above = rows[z, y - 1] if y > 0 else behind
                if above is None or self._model.predictor == 1:
                    above = zeros
                if behind is None:
                    behind = above
                upper = rows[z - 1, y - 1] if z > 0 and y > 0 else behind
                lower = rows[z - 1, y + 1] if z > 0 and y + 1 < ny else behind
                sums = (t[z, y] + np.correlate(above, above_weights)
                        + np.correlate(behind, behind_weights)
                        + w[14] * upper[2:-2] + w[15] * lower[2:-2])
                context = _half_octaves(np.minimum(sums, most[z, y]))
                context += 30 * (sums > minimum_upper[z, y])
                coded = ~flagged[z, y]
                numbers = self._stream.row(self._tables, context[coded].tolist(), extra)
                if numbers:
                    u = np.array(numbers, np.int64)
                    row = step * np.where(u & 1, -(u >> 1) - 1, u >> 1)
                    residuals[z, y, coded] = wrapped(row) if self._is_narrow else row
                row = np.minimum(np.abs(residuals[z, y]) >> self._shift, 2047)
                rows[z, y, 2:-2] = row
                rows[z, y, :2] = row[0]
                rows[z, y, -2:] = row[-1]
        self._magnitudes[axis] = rows[:, :, 2:-2]
        return residuals

    def _predicted(self, means: np.ndarray, repeated: PaddedSamples, axis: int,
                   classes: np.ndarray, limit: np.ndarray, residuals: np.ndarray,
                   lifting: Lifting, gaps: "ValueGaps | None", details_of_edges: np.ndarray,
                   weighted: np.ndarray, step: int) -> np.ndarray:
        """Predictor 0: each pair from the pairs before it and the means of those behind."""
        nz, ny, nx = classes.shape
        v = repeated.with_margins().copy()
        weights = self._model.tap_weights[self._group][axis]
        left = _left_taps(axis, weights)
        taps = [(8 * row + tap, (x0 + tap, y0, z0))
                for row, (x0, y0, z0) in enumerate(TAP_ROWS[axis]) for tap in range(8)]
        stride_x, stride_y, stride_z = (2 if axis == a else 1 for a in range(3))

        def line(x: int, y: int, z: int) -> np.ndarray:
            """Samples as far as x, y, z from the first ones of a row's pairs."""
            first = 8 + x
            return v[2 + z, 2 + y, first : first + stride_x * (nx - 1) + 1 : stride_x]

        for z, y in np.ndindex(nz, ny):
            sums = np.zeros(nx, np.int64)
            if classes[z, y].any():
                chosen = weights[classes[z, y]]
                for place, (tap_x, tap_y, tap_z) in taps:
                    at = line(tap_x, stride_y * y + tap_y, stride_z * z + tap_z)
                    sums += chosen[:, place] * at
            pairs = self._decode_row(sums.tolist(), classes[z, y].tolist(), limit[z, y].tolist(),
                                residuals[z, y].tolist(), means[z, y, :nx].tolist(), left,
                                lifting, gaps, details_of_edges[z, y].tolist(),
                                weighted[z, y].tolist(), step)
            first, second = np.array(pairs, np.int64).T
            line(0, stride_y * y, stride_z * z)[:] = first
            line(axis == 0, stride_y * y + (axis == 1), stride_z * z + (axis == 2))[:] = second
        return v[2:-2, 2:-2, 8:-8]

    def _decode_row(self, sums: list[int], classes: list[int], limits: list[int],
                    residuals: list[int], means: list[int], left: list[list[list[int]]],
                    lifting: Lifting, gaps: "ValueGaps | None", details_of_edges: list[int],
                    weighted: list[bool], step: int) -> list[tuple[int, int]]:
        """The pairs of one row; `sums` takes the means for the row's own samples.

        details_of_edges  0 for pairs that are none
        """
        reach = len(left[0])
        pairs = []
        changes: list[tuple[int, int]] = []
        for x, (total, kind, limit, residual, m, edge, is_weighted) in enumerate(
                zip(sums, classes, limits, residuals, means, details_of_edges, weighted)):
            prediction = 0
            if kind:
                for distance in range(1, min(reach, x) + 1):
                    (wa, wb), (da, db) = left[kind][distance - 1], changes[x - distance]
                    total += wa * da + wb * db
                total += 2048
                prediction = (wrapped(total) if self._is_narrow else total) >> 12
                prediction = max(-limit, min(limit, prediction))
            if edge:
                d = edge
            elif step > 1:
                d = max(-limit, min(limit, prediction + residual))
            elif gaps is None or limit == 0 or is_weighted:
                d = unfolded(residual, prediction + limit, 2 * limit) - limit
            else:
                d = gaps.detail(m, prediction, residual)
            b = m - (lifting.above_last(d) if is_weighted else (d + lifting.rounding) >> 1)
            a, b = (max(self._lowest, min(self._highest, sample)) for sample in (b + d, b))
            pairs.append((a, b))
            changes.append((a - m, b - m))
        return pairs


def _left_taps(axis: int, weights: np.ndarray) -> list[list[list[int]]]:
    """Weights of the taps that pairs decoded before in the same row have overwritten.

    [class][distance - 1] -> weights of the first and second sample of the pair that far left
    """
    # Of the x split one row of taps follows the other; of the others these two hold the pairs.
    second = [int(a == axis) for a in (1, 2)]
    rows = [8 * TAP_ROWS[axis].index((-3, 0, 0)) + 3, 8 * TAP_ROWS[axis].index((-3, *second)) + 3
            ] if axis > 0 else [8, 9]
    stride, reach = (1, 3) if axis > 0 else (2, 4)
    return [[[row[at - stride * n] for at in rows] for n in range(1, reach + 1)]
            for row in weights.tolist()]


def _details_of_plane(residuals: np.ndarray, predictions: np.ndarray, limits: np.ndarray,
                      step: int, means: np.ndarray, gaps: "ValueGaps | None",
                      is_gapped: np.ndarray) -> np.ndarray:
    """The details of residuals; `is_gapped` tells the pairs that know of gaps."""
    if step > 1:
        return (predictions + residuals).clip(-limits, limits)
    details = unfolded_details(residuals, predictions, limits)
    if gaps is None:
        return details
    possible = np.vectorize(gaps.detail, otypes=[np.int64])(means, predictions, residuals)
    return np.where((limits > 0) & is_gapped, possible, details)


def _neighbors(means_around: PaddedSamples, array_axis: int, distance: int) -> np.ndarray:
    """The mean so far from each mean along an axis."""
    padded = means_around.with_margins(2)
    at = [slice(2, -2)] * 3
    at[array_axis] = slice(2 + distance, padded.shape[array_axis] - 2 + distance)
    return padded[tuple(at)]


def _slopes(means_around: PaddedSamples, axis: int, far_share: int) -> np.ndarray:
    """The slopes of section 6 that predictor 1 sees."""
    near, far = (_neighbors(means_around, 2 - axis, -distance)
                 - _neighbors(means_around, 2 - axis, distance) for distance in (1, 2))
    return near + ((far * far_share + 64) >> 7)


def _activities(means_around: PaddedSamples, axis: int,
                shift: int) -> tuple[np.ndarray, ...]:
    """e0, e1, e2 of section 7; of the shape of the means."""
    means = means_around.samples
    array_axis = 2 - axis
    before, after = (_neighbors(means_around, array_axis, distance) for distance in (-1, 1))
    e0 = (np.abs(before - means) >> shift) + (np.abs(after - means) >> shift)
    e1 = np.abs(before - means + after - means) >> shift
    e2 = np.zeros_like(e0)
    for other in range(3):
        if other != array_axis:
            for distance in (-1, 1):
                e2 += np.abs(_neighbors(means_around, other, distance) - means) >> shift
    return e0, e1, e2


def _half_octaves(t: np.ndarray) -> np.ndarray:
    """2 * floor(log2(t + 8)) + the next bit, less 6, at most 29."""
    value = t + 8
    exponents = np.frexp(value.astype(np.float64))[1].astype(np.int64) - 1
    return np.minimum(2 * exponents + (value >> (exponents - 1) & 1) - 6, 29)
