"""Grey bricks: docs/format-grey.md, sections 1 to 5, 12, 13, 16 and 17.

Arrays are indexed [z][y][x]. Inside a brick x, y and z are the axes of the model's order, except in
`decode_grey_brick`, which gets and gives the brick's own.
"""

from dataclasses import dataclass

import numpy as np

from .binary_coder import AdaptiveBit, BinaryDecoder
from .byte_cursor import ByteCursor, crc32c, unpack_bits
from .errors import require, require_known
from .grey_details import DetailDecoder, DetailStream, Lifting, ValueGaps, means_along
from .grey_interpolation import interpolated_split
from .grey_model import GreyModel, ValueMap
from .grey_samples import PaddedSamples
from .header import halved
from .weights import SampleWeights


def decode_grey_brick(model: GreyModel, smallest: int, largest: int, segments: list[bytes],
                      size: tuple[int, int, int], halvings: list[int], weights: SampleWeights,
                      place: int, detailed: int = 0) -> np.ndarray:
    """The samples of one level of a brick that is not uniform, as int64 of shape [z][y][x].

    segments      one per level of the brick, finest first; those finer than `place` are unused
    size          x, y, z of the brick's finest level
    halvings      per level the mask of axes halved to the next, the last to the next tier
    weights       of the samples of the brick's finest level
    place         which level, 0 the finest; behind the last: the brick's sample in the next tier
    detailed      the finest level of the brick that has details
    Raises        OctavoError "corrupt", "unsupported_version"
    """
    order = model.axis_order
    ordered_size = tuple(size[axis] for axis in order)
    ordered_halvings = [_ordered_mask(mask, order) for mask in halvings]
    is_stored = len(segments) - detailed > 1 and not segments[-1]
    require(not is_stored or not any(segments[1:]), "a stored brick has a second segment")
    require(is_stored or not any(segments[:detailed]), "a level without details has bytes")
    values = _BrickValues(model.voxel_step, 0, None)
    if model.value_map is not None:
        segments = list(segments)
        plain = 0 if is_stored else -1
        values, segments[plain] = _take_values(model.value_map, smallest, segments[plain])
        is_of_voxels = weights.each == (1, 1, 1) and detailed == 0
        require(values.codes is None or is_of_voxels, "a brick of means has gaps")
    whole = _Brick(model, values, smallest, largest, ordered_size, ordered_halvings,
                   weights.ordered(order))
    brick = whole.from_level(detailed)
    start = max(place, detailed)
    if is_stored:
        samples, corrections = brick.decode_stored(segments[0], start - detailed), []
    else:
        samples, corrections = brick.decode_levels(segments[detailed:], start - detailed)
    samples = whole.interpolated(samples, start, place)
    own = np.transpose(samples, [2 - order.index(axis) for axis in (2, 1, 0)])
    return brick.to_voxels(own, corrections)


def coarse_codes(model: GreyModel, codes: np.ndarray, halvings: list[int],
                 weights: SampleWeights, place: int) -> np.ndarray:
    """Codes of level `place` of a brick from those of its finest one, both [z][y][x].

    halvings, weights, place as of decode_grey_brick
    """
    order = model.axis_order
    size = tuple(codes.shape[2 - axis] for axis in order)
    brick = _Brick(model, _BrickValues(1, 0, None), 0, 0, size,
                   [_ordered_mask(mask, order) for mask in halvings], weights.ordered(order))
    samples = np.transpose(codes, [2 - order[axis] for axis in (2, 1, 0)])
    for level in range(place):
        samples = brick.coarser(samples, level)
    return np.transpose(samples, [2 - order.index(axis) for axis in (2, 1, 0)])


def _ordered_mask(mask: int, order: tuple[int, int, int]) -> int:
    return sum((mask >> axis & 1) << place for place, axis in enumerate(order))


@dataclass(frozen=True)
class _BrickValues:
    """Voxels are codes * step + offset; `codes` are those that occur, None where all may."""

    step: int
    offset: int
    codes: frozenset[int] | None

    def code(self, voxel: int) -> int:
        return (voxel - self.offset + (self.step - 1) // 2) // self.step


def _take_values(value_map: ValueMap, smallest: int, segment: bytes) -> tuple[_BrickValues, bytes]:
    """The map at the start of a segment, and what follows it (section 13)."""
    cursor = ByteCursor(segment, "a brick's map")
    flags = cursor.u8()
    has_gaps = bool(flags & 2)
    require_known(flags < 4, f"flags {flags} of a brick's map")
    require(not has_gaps or bool(value_map.codes), "a brick's map is wrong")
    step, offset = (value_map.step, value_map.offset) if flags & 1 else (1, 0)
    codes = None
    if has_gaps:
        low = _BrickValues(step, offset, None).code(smallest)
        codes = value_map.codes | {low + extra for extra in cursor.take(cursor.u8())}
    return _BrickValues(step, offset, codes), cursor.rest()


class _Brick:
    """The numbers that all steps of decoding a brick need; samples are codes less `base`."""

    def __init__(self, model: GreyModel, values: _BrickValues, smallest: int, largest: int,
                 size: tuple[int, int, int], halvings: list[int], weights: SampleWeights) -> None:
        self.model = model
        self.values = values
        self.smallest = smallest
        self.largest = largest
        self.low_code = values.code(smallest)
        self.range = values.code(largest) - self.low_code
        require(values.codes is None or self.range < 256, "a brick with gaps has too many codes")
        self.is_narrow = self.range <= 65535
        self.shift = 0 if self.is_narrow else self.range.bit_length() - 16
        self.low = -(1 << 15) if self.is_narrow else -(1 << 31)
        self.halvings = halvings
        self.sizes = [size]
        self.weights = [weights]
        for mask in halvings:
            self.weights.append(self.weights[-1].halved(self.sizes[-1], mask))
            self.sizes.append(halved(self.sizes[-1], mask))

    def from_level(self, level: int) -> "_Brick":
        """The brick that begins at one of the levels of this one."""
        return _Brick(self.model, self.values, self.smallest, self.largest, self.sizes[level],
                      self.halvings[level:], self.weights[level])

    def interpolated(self, samples: np.ndarray, start: int, place: int) -> np.ndarray:
        """Samples of level `place` from those of level `start`, where none between has details."""
        for level in range(start - 1, place - 1, -1):
            for axis in (2, 1, 0):
                if self.halvings[level] >> axis & 1:
                    samples = interpolated_split(samples, 2 - axis, self.sizes[level][axis],
                                                 self._lifting(level, axis), self.low,
                                                 self.low + self.range)
        return samples

    def decode_stored(self, segment: bytes, place: int) -> np.ndarray:
        samples = self._plain(segment, self.sizes[0])
        for level in range(place):
            samples = self.coarser(samples, level)
        return samples

    def coarser(self, samples: np.ndarray, level: int) -> np.ndarray:
        """The next level."""
        for axis in range(3):
            if self.halvings[level] >> axis & 1:
                samples = means_along(samples, 2 - axis, self._lifting(level, axis))
        return samples

    def decode_levels(self, segments: list[bytes], place: int
                      ) -> tuple[np.ndarray, list["_Corrections"]]:
        """Samples of level `place`, and the corrections of their voxels."""
        last = len(segments) - 1
        coarsest = self._plain(segments[last], self.sizes[last])
        if place > last:
            return self.coarser(coarsest, last), []
        samples = PaddedSamples.of_level(coarsest)
        flags = None
        entries: list[_PartEntry] = []
        for level in range(last - 1, max(place, 1) - 1, -1):
            cursor = ByteCursor(segments[level], "a grey segment")
            if level == 1 and self.has_parts:
                entries = [_PartEntry.take(cursor) for _ in self._parts()]
            if level == 1 and last >= 2:
                flags = self._cell_flags(cursor.take(cursor.varint()))
            region = _Region.of_level(self.sizes[level], self.sizes[level + 1])
            samples = self._finer(samples, region, level, flags, cursor.rest())
        if place > 0 or last == 0:
            return samples.samples, []
        if not self.has_parts:
            region = _Region.of_level(self.sizes[0], self.sizes[1])
            return self._decode_finest(samples, region, flags, segments[0])
        cursor = ByteCursor(segments[0], "the parts of a brick")
        result = np.empty(self.sizes[0][::-1], np.int64)
        corrections = []
        for region, entry in zip(self._parts(), entries):
            around = samples.part(region.coarse_first[::-1], region.coarse_size[::-1])
            data = cursor.take(entry.length)
            require(crc32c(data) == entry.crc, "the checksum of a part of a brick is wrong")
            part, own = self._decode_finest(around, region, flags, data)
            result[region.slices()] = part
            corrections += own
        require(not cursor.rest(), "bytes follow the parts of a brick")
        return result, corrections

    @property
    def has_parts(self) -> bool:
        """Whether level 0 falls into more than one part."""
        return len(self._parts()) > 1

    def _parts(self) -> list["_Region"]:
        sides = [32 if self.model.cut_axes >> a & 1 else max(n, 1)
                 for a, n in enumerate(self.sizes[0])]
        if len(self.halvings) < 3:  # levels
            sides = list(self.sizes[0])
        counts = [-(-n // side) for n, side in zip(self.sizes[0], sides)]
        regions = []
        for z, y, x in np.ndindex(counts[2], counts[1], counts[0]):
            first = tuple(int(i) * side for i, side in zip((x, y, z), sides))
            size = tuple(min(side, n - at) for at, n, side in zip(first, self.sizes[0], sides))
            coarse = tuple(at >> (self.halvings[0] >> a & 1) for a, at in enumerate(first))
            regions.append(_Region(first, size, coarse, halved(size, self.halvings[0])))
        return regions

    def _decode_finest(self, means: PaddedSamples, region: "_Region", flags: np.ndarray | None,
                       data: bytes) -> tuple[np.ndarray, list["_Corrections"]]:
        """Samples of level 0, or of a part of it, and the corrections of their voxels."""
        cursor = ByteCursor(data, "a grey segment")
        corrections = []
        if self.model.correction_step > 0:
            corrections = [_Corrections(region, cursor.take(cursor.varint()))]
        samples = self._finer(means, region, 0, flags, cursor.rest())
        return samples.samples, corrections

    def to_voxels(self, samples: np.ndarray, corrections: list["_Corrections"]) -> np.ndarray:
        """Voxels of samples; both along the brick's own axes."""
        codes = samples - self.low + self.low_code
        voxels = codes * self.values.step + self.values.offset
        if self.model.is_lossy:
            voxels = voxels.clip(self.smallest, self.largest)
        for part in corrections:
            if part.data:
                box = part.region.slices(self.model.axis_order)
                steps = decode_corrections(part.data, voxels[box].shape)
                corrected = voxels[box] + steps * self.model.correction_step
                voxels[box] = corrected.clip(self.smallest, self.largest)
        return voxels

    def _plain(self, segment: bytes, size: tuple[int, int, int]) -> np.ndarray:
        count = size[0] * size[1] * size[2]
        fields = unpack_bits(segment, self.range.bit_length(), count, "a segment of plain samples")
        return np.minimum(fields, self.range).reshape(size[::-1]) + self.low

    def _cell_flags(self, data: bytes) -> np.ndarray:
        """One flag per sample of level 2, bool of shape [z][y][x]."""
        nx, ny, nz = self.sizes[2]
        flags = np.zeros((nz + 1, ny + 1, nx + 1), bool)
        if data:
            decoder = BinaryDecoder(data)
            states = [AdaptiveBit() for _ in range(8)]
            for z, y, x in np.ndindex(nz, ny, nx):
                near = flags[z : z + 2, y : y + 2, x : x + 2]
                state = states[near[1, 1, 0] + 2 * near[1, 0, 1] + 4 * near[0, 1, 1]]
                near[1, 1, 1] = decoder.adaptive(state)
            require(decoder.at == len(data), "cell flags do not end where they should")
        return flags[1:, 1:, 1:]

    def _finer(self, samples: PaddedSamples, region: "_Region", level: int,
               flags: np.ndarray | None, data: bytes) -> PaddedSamples:
        """A level of the brick, or a part of it, from the next one and the bytes of its details."""
        mask = self.halvings[level]
        size = list(region.coarse_size)
        splits = []
        for axis in (2, 1, 0):
            if mask >> axis & 1:
                pairs = list(size)
                pairs[axis] = region.size[axis] // 2
                size[axis] = region.size[axis]
                flagged = self._flagged_pairs(flags, level, axis, tuple(pairs), region)
                splits.append((axis, flagged))
        coded_count = sum(int((~flagged).sum()) for _, flagged in splits)
        most_states = 32
        if level == 0 and self.has_parts:
            most_states = 8 if self.model.cut_axes & 1 else 16
        stream = DetailStream(data, coded_count, most_states)
        decoder = DetailDecoder(self.model, level, stream, self.low, self.low + self.range,
                                self.shift, self.is_narrow)
        for axis, flagged in splits:
            lifting = self._lifting(level, axis, region)
            gaps = None
            if level == 0 and axis == splits[-1][0] and self.values.codes is not None:
                gaps = ValueGaps(self._used_samples(), self.low, self.low + self.range,
                                 lifting.rounding)
            samples = decoder.split(samples, axis, region.size[axis], flagged, lifting, gaps)
        stream.end()
        return samples

    def _lifting(self, level: int, axis: int, region: "_Region | None" = None) -> Lifting:
        """How the pairs along an axis of a level, or of a part of it, become means (section 2)."""
        weights = self.weights[level]
        coarse = self.weights[level + 1].each
        turn = sorted(range(3), key=lambda other: -coarse[other]).index(axis)
        halvings = weights.each[axis].bit_length() - 1
        length = self.sizes[level][axis]
        is_at_end = region is None or region.first[axis] + region.size[axis] == length
        first, second = weights.last_pair(axis, length) if is_at_end else (1, 1)
        return Lifting((turn + halvings + 1) & 1, first, second)

    def _used_samples(self) -> list[int]:
        inside = range(self.low_code, self.low_code + self.range + 1)
        return [code - self.low_code + self.low for code in inside if code in self.values.codes]

    def _flagged_pairs(self, flags: np.ndarray | None, level: int, axis: int,
                       pairs: tuple[int, int, int], region: "_Region") -> np.ndarray:
        """Which pairs of a split lie in flagged cells, bool of shape [z][y][x]."""
        if flags is None or level > 1:
            return np.zeros(pairs[::-1], bool)
        places = []
        for a in range(3):
            # Axes split before (z, y, x) count samples of this level, the others of the next.
            first = level if a > axis else level + 1
            start = region.first[a] if a > axis else region.coarse_first[a]
            halvings = sum(self.halvings[i] >> a & 1 for i in range(first, 2))
            places.append((np.arange(pairs[a]) + start) >> halvings)
        return flags[np.ix_(places[2], places[1], places[0])]


@dataclass(frozen=True)
class _Region:
    """A level or a part of level 0: where it lies there and at the next level, x, y, z."""

    first: tuple[int, int, int]
    size: tuple[int, int, int]
    coarse_first: tuple[int, int, int]
    coarse_size: tuple[int, int, int]

    @classmethod
    def of_level(cls, size: tuple[int, int, int], coarse: tuple[int, int, int]) -> "_Region":
        return cls((0, 0, 0), size, (0, 0, 0), coarse)

    def slices(self, axis_order: tuple[int, int, int] = (0, 1, 2)) -> tuple[slice, slice, slice]:
        """Its place in an array [z][y][x], along the brick's own axes where an order is given."""
        return tuple(slice(self.first[place], self.first[place] + self.size[place])
                     for place in (axis_order.index(axis) for axis in (2, 1, 0)))


@dataclass(frozen=True)
class _Corrections:
    """The bytes of the corrections of a region; none: all are 0."""

    region: _Region
    data: bytes


@dataclass(frozen=True)
class _PartEntry:
    """What the list of parts says of one."""

    length: int
    crc: int

    @classmethod
    def take(cls, cursor: ByteCursor) -> "_PartEntry":
        length = cursor.varint()
        return cls(length, cursor.u32() if length > 0 else 0)


def decode_corrections(data: bytes, shape: tuple[int, int, int]) -> np.ndarray:
    """Corrections of the voxels of level 0, within +-31, [z][y][x] along the brick's own axes.

    Source  docs/format-grey.md, section 12
    """
    nz, ny, nx = shape
    decoder = BinaryDecoder(data)
    corrected = [[AdaptiveBit(most=7) for _ in range(2)] for _ in range(19)]
    negative = [AdaptiveBit(most=7) for _ in range(3)]
    larger = AdaptiveBit(most=7)
    # Margins of zeros: one plane behind, a row above and below, two voxels left and right.
    c = np.zeros((nz + 1, ny + 2, nx + 4), np.int64)
    three, five = np.ones(3, np.int64), np.ones(5, np.int64)
    for z in range(1, nz + 1):
        for y in range(1, ny + 1):
            fives = np.stack([c[z, y - 1], c[z - 1, y]])
            threes = np.stack([c[z - 1, y - 1], c[z - 1, y + 1]])
            if threes.any() or fives.any():
                numbers = (np.correlate((fives != 0).sum(0), five)
                           + np.correlate((threes != 0).sum(0), three)[1:-1]).tolist()
                sums = (np.correlate(fives.sum(0), five)
                        + np.correlate(threes.sum(0), three)[1:-1]).tolist()
            else:
                numbers = sums = [0] * nx
            row = [0] * nx
            left = left2 = 0
            for x in range(nx):
                number = numbers[x] + (left != 0) + (left2 != 0)
                value = 0
                if decoder.adaptive(corrected[number][left != 0]):
                    total = sums[x] + left + left2
                    sign = -1 if decoder.adaptive(negative[(total > 0) - (total < 0) + 1]) else 1
                    value = 1
                    while value < 31 and decoder.adaptive(larger):
                        value += 1
                    value *= sign
                row[x] = value
                left2, left = left, value
            c[z, y, 2:-2] = row
    require(decoder.at == len(data), "corrections do not end where they should")
    return c[1:, 1:-1, 2:-2]
