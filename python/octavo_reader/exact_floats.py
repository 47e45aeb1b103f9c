"""Float32 voxels bit by bit: docs/format-grey.md, section 15. Arrays are indexed [z][y][x]."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .binary_coder import AdaptiveBit, BinaryDecoder
from .byte_cursor import ByteCursor
from .errors import require, require_known
from .header import halved
from .weights import SampleWeights

_INFINITY_RANK = 0x7F800000
_USUAL_NAN = 0x7FC00000
_LARGEST_CODE = (1 << 31) - 2
_MANTISSA_BITS = 23
_LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class ExactCoding:
    """Voxels are the floats nearest to code * scale + offset, or others in the bin of the code."""

    scale: float
    offset: float

    def voxels(self, codes: np.ndarray) -> np.ndarray:
        values = codes.astype(np.float64) * self.scale + self.offset
        # The index has two codes more, for bounds.
        values = np.where(abs(codes) > _LARGEST_CODE, np.sign(codes) * _LARGEST, values)
        return values.clip(-_LARGEST, _LARGEST).astype(np.float32) + np.float32(0)  # no -0

    def first_ranks(self, codes: np.ndarray) -> np.ndarray:
        """The rank of the first float in the bin of each code."""
        begins = (codes.astype(np.float64) - 0.5) * self.scale + self.offset
        inside = begins.clip(-_LARGEST, _LARGEST)
        nearest = inside.astype(np.float32)
        ranks = _ranks(nearest) + (nearest.astype(np.float64) < inside)
        ranks[(codes > _LARGEST_CODE) | (begins > _LARGEST)] = _INFINITY_RANK
        ranks[(codes <= -_LARGEST_CODE) | (begins < -_LARGEST)] = -_INFINITY_RANK
        return ranks

    def codes(self, voxels: np.ndarray) -> np.ndarray:
        """The code of the bin that holds each voxel; 0 for those that are not finite."""
        finite = np.where(np.isfinite(voxels), voxels, np.float32(0))
        steps = (finite.astype(np.float64) - self.offset) / self.scale
        codes = np.rint(steps.clip(-_LARGEST_CODE, _LARGEST_CODE)).astype(np.int64)
        # Rounding may have led to the bin beside.
        ranks = _ranks(finite)
        while (above := ranks < self.first_ranks(codes)).any():
            codes -= above
        while (below := ranks >= self.first_ranks(codes + 1)).any():
            codes += below
        return np.where(np.isfinite(voxels), codes, 0)

    def bins(self, codes: np.ndarray, short_bits: int) -> tuple[np.ndarray, np.ndarray]:
        """Short ranks [first, end) of the bin of each code."""
        ends = []
        for ranks in (self.first_ranks(codes), self.first_ranks(codes + 1)):
            up = (ranks + (1 << short_bits) - 1) >> short_bits
            ends.append(np.where(ranks < 0, ~(~ranks >> short_bits), up))
        return ends[0], ends[1]


def decode_exact_brick(coding: ExactCoding, smallest: int, largest: int, segments: list[bytes],
                       size: tuple[int, int, int], halvings: list[int], first_level: int,
                       place: int, decode_codes: Callable[[int, int, list[bytes]], np.ndarray],
                       weights: SampleWeights, coarse_codes: Callable[[np.ndarray], np.ndarray]
                       ) -> np.ndarray:
    """The samples of one level of a brick that is not uniform, float32 of shape [z][y][x].

    segments, size, halvings, place as of decode_grey_brick
    first_level   global level of the brick's finest level
    decode_codes  gives the codes of the level from their range and what is left of the segments
    weights       of the samples of the brick's finest level
    coarse_codes  gives the codes of the level from those of the finest one
    Raises        OctavoError "corrupt", "unsupported_version"
    """
    sizes = [size]
    for mask in halvings:
        sizes.append(halved(sizes[-1], mask))
    cursors = [ByteCursor(segment, "a float segment") for segment in segments]
    is_stored = len(segments) > 1 and not segments[-1]
    head = cursors[0 if is_stored else -1]
    require(not is_stored or not any(segments[1:]), "a stored brick has a second segment")
    flags = head.u8()
    require_known(flags < 32, f"flags {flags} of a float brick")
    has_absent, has_places = flags & 1, flags & 2
    require(first_level == 0 or not has_places, "a coarse float brick has places")
    low, high = smallest + (flags >> 2 & 1), largest - (flags >> 3 & 1)
    require(-_LARGEST_CODE <= low <= high <= _LARGEST_CODE, "a float brick has no codes")

    if flags & 16:
        is_alone = (is_stored or len(segments) == 1) and first_level == 0
        require(is_alone and not has_absent and not has_places, "plain floats are not alone")
        voxels = _plain_floats(coding, low, high, head.rest(), size)
        if place == 0:
            return voxels
        gone = ~np.isfinite(voxels)
        codes = _filled_codes(coding.codes(voxels), gone, sizes, halvings, weights)
        for level in range(place):
            gone = _coarser(gone, sizes[level], halvings[level])
        samples = coding.voxels(coarse_codes(codes))
        samples.view(np.uint32)[gone] = _USUAL_NAN
        return samples

    absent = bits = None
    if has_absent:
        absent, bits = _take_absent(cursors, sizes, halvings, first_level, place, is_stored)
    places = None
    if has_places and (is_stored or place == 0):
        style = cursors[0].u8()
        require_known(style < 64, f"style {style} of places")
        require(style & 31 <= _MANTISSA_BITS, "places leave out too many bits")
        places = [style, *(cursors[0].take(cursors[0].varint()) for _ in range(2))]

    rests = [cursor.rest() for cursor in cursors]
    require(low == high or is_stored or rests[-1], "a coded float brick has no coarsest codes")
    if low == high:
        require(not any(rests[place:]), "a float brick of one code holds several")
        codes = np.full(sizes[place][::-1], low, np.int64)
    else:
        codes = decode_codes(low, high, rests)
    if place == 0 and has_places:
        voxels = _decode_places(coding, codes, absent, *places)
    else:
        voxels = coding.voxels(codes)
    if absent is not None:
        gone = absent.astype(bool)
        is_finest = first_level == 0 and place == 0
        voxels.view(np.uint32)[gone] = bits[gone] if is_finest else _USUAL_NAN
    return voxels


def _ranks(voxels: np.ndarray) -> np.ndarray:
    bits = voxels.view(np.int32).astype(np.int64)
    return np.where(bits >= 0, bits, ~(bits & 0x7FFFFFFF))


def _plain_floats(coding: ExactCoding, low: int, high: int, data: bytes,
                  size: tuple[int, int, int]) -> np.ndarray:
    require(len(data) == 4 * size[0] * size[1] * size[2], "plain floats of a wrong length")
    voxels = np.frombuffer(data, "<f4").astype(np.float32).reshape(size[::-1])
    first, end = coding.first_ranks(np.array([low, high + 1]))
    ranks = _ranks(voxels)[np.isfinite(voxels)]
    require(bool(((ranks >= first) & (ranks < end)).all()),
            "a plain float lies outside the range of its brick")
    return voxels


def _filled_codes(codes: np.ndarray, gone: np.ndarray, sizes: list[tuple[int, int, int]],
                  halvings: list[int], weights: SampleWeights) -> np.ndarray:
    """Codes of which absent ones have that of the first sample above them that is present."""
    if not gone.any():
        return codes
    means, counts = codes, np.where(gone, 0, 1)
    levels = [(means, counts)]
    for size, mask in zip(sizes, halvings):
        each = [np.array([weights.each[axis]] * (n - 1) + [weights.last[axis]])
                for axis, n in enumerate(size)]
        weighed = np.where(counts > 0, each[2][:, None, None] * each[1][:, None] * each[0], 0)
        sums, counts = _octant_sums(means * weighed, mask), _octant_sums(weighed, mask)
        means, rest = np.divmod(sums, np.maximum(counts, 1))
        means += (2 * rest > counts) | ((2 * rest == counts) & (counts > 0) & (means & 1 == 1))
        levels.append((means, counts))
        weights = weights.halved(size, mask)
    filled = levels[-1][0]
    for (means, counts), size, mask in reversed(list(zip(levels, sizes, halvings))):
        filled = np.where(counts > 0, means, _repeated(filled, size, mask))
    return filled


def _octant_sums(samples: np.ndarray, mask: int) -> np.ndarray:
    for axis in range(3):
        if mask >> axis & 1:
            starts = np.arange(0, samples.shape[2 - axis], 2)
            samples = np.add.reduceat(samples, starts, 2 - axis)
    return samples


def _take_absent(cursors: list[ByteCursor], sizes: list[tuple[int, int, int]],
                 halvings: list[int], first_level: int, place: int, is_stored: bool
                 ) -> tuple[np.ndarray, np.ndarray | None]:
    """The flags of absent samples of level `place`, and their bits at level 0 of the file."""
    absent = bits = None
    last = 0 if is_stored else len(cursors) - 1
    first = 0 if is_stored else min(place, last)
    for level in range(last, first - 1, -1):
        data = cursors[level].take(cursors[level].varint())
        below = None if absent is None else _repeated(absent, sizes[level], halvings[level])
        is_finest = first_level == 0 and level == 0
        absent, bits = _decode_absent(data, sizes[level], below, is_finest)
    for level in range(first, place):
        absent = _coarser(absent, sizes[level], halvings[level])
    return absent, bits


def _repeated(coarse: np.ndarray, size: tuple[int, int, int], mask: int) -> np.ndarray:
    for axis in range(3):
        if mask >> axis & 1:
            coarse = coarse.repeat(2, 2 - axis)
    return coarse[: size[2], : size[1], : size[0]]


def _coarser(fine: np.ndarray, size: tuple[int, int, int], mask: int) -> np.ndarray:
    for axis in range(3):
        if mask >> axis & 1:
            odd = size[axis] & 1
            fine = np.concatenate([fine] + [fine.take([-1], 2 - axis)] * odd, 2 - axis)
            first, second = (fine[(slice(None),) * (2 - axis) + (slice(i, None, 2),)]
                             for i in range(2))
            fine = first & second
    return fine


def _decode_absent(data: bytes, size: tuple[int, int, int], below: np.ndarray | None,
                   has_bits: bool) -> tuple[np.ndarray, np.ndarray | None]:
    decoder = BinaryDecoder(data)
    is_absent = [AdaptiveBit() for _ in range(8)]
    is_other = AdaptiveBit()
    last = _USUAL_NAN
    nx, ny, nz = size
    # One sample of margin before each axis: none is absent there.
    flags = np.zeros((nz + 1, ny + 1, nx + 1), np.uint8)
    bits = np.zeros((nz, ny, nx), np.uint32) if has_bits else None
    for z, y, x in np.ndindex(nz, ny, nx):
        if below is not None and below[z, y, x]:
            flag = 1
        else:
            context = (flags[z + 1, y + 1, x] | flags[z + 1, y, x + 1] << 1
                       | flags[z, y + 1, x + 1] << 2)
            flag = decoder.adaptive(is_absent[context])
        flags[z + 1, y + 1, x + 1] = flag
        if flag and has_bits:
            if decoder.adaptive(is_other):
                last = decoder.even_bits(32)
                require(last & _INFINITY_RANK == _INFINITY_RANK, "an absent voxel is finite")
            bits[z, y, x] = last
    require(decoder.at == len(data), "absent samples of a wrong length")
    return flags[1:, 1:, 1:], bits


class _CentralPlaces:
    """The voxels in bins that reach zero."""

    def __init__(self, decoder: BinaryDecoder, plain: "_PlainBits", short_bits: int) -> None:
        self._decoder = decoder
        self._plain = plain
        self._mantissa_bits = _MANTISSA_BITS - short_bits
        self._is_zero = [AdaptiveBit() for _ in range(8)]
        self._is_negative = [AdaptiveBit() for _ in range(2)]
        self._exponent = [[AdaptiveBit() for _ in range(256)] for _ in range(10)]
        self._context = 0
        self.is_used = False

    def start_row(self) -> None:
        self._context = 0

    def rank(self, first: int, end: int, zeros: int) -> int:
        self.is_used = True
        is_zero = self._decoder.adaptive(self._is_zero[zeros])
        is_negative = self._decoder.adaptive(self._is_negative[is_zero])
        magnitude = 0
        if not is_zero:
            node = 1
            for _ in range(8):
                node = node << 1 | self._decoder.adaptive(self._exponent[self._context][node])
            exponent = node - 256
            highest = max(end - 1, ~first) >> self._mantissa_bits
            self._context = 1 + max(0, highest - exponent).bit_length()
            magnitude = exponent << self._mantissa_bits | self._plain.take(self._mantissa_bits)
        return ~magnitude if is_negative else magnitude


class _Repeats:
    """Voxels that are the last float of the same code."""

    def __init__(self, decoder: BinaryDecoder) -> None:
        self._decoder = decoder
        self._states = [[AdaptiveBit() for _ in range(2)] for _ in range(2)]
        self._slots = {}  # by code mod 4096: the last code and its rank
        self._was_repeated = [0] * 4096
        self._is_repeating = 0
        self.is_used = False

    def start_row(self) -> None:
        self._is_repeating = 0

    def rank(self, code: int) -> int | None:
        slot = code % 4096
        known, rank = self._slots.get(slot, (None, None))
        before, self._is_repeating = self._is_repeating, 0
        if known == code:
            self.is_used = True
            state = self._states[before][self._was_repeated[slot]]
            self._is_repeating = self._decoder.adaptive(state)
        self._was_repeated[slot] = self._is_repeating
        return rank if self._is_repeating else None

    def keep(self, code: int, rank: int) -> None:
        self._slots[code % 4096] = (code, rank)


class _PlainBits:
    """Bits, lowest first."""

    def __init__(self, data: bytes) -> None:
        self._value = np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little")
        self._bytes = len(data)
        self._at = 0

    def take(self, count: int) -> int:
        taken = self._value[self._at : self._at + count]
        self._at += count
        return int.from_bytes(np.packbits(taken, bitorder="little").tobytes(), "little")

    def end(self) -> None:
        require((self._at + 7) // 8 == self._bytes, "places of a wrong length")


def _decode_places(coding: ExactCoding, codes: np.ndarray, absent: np.ndarray | None,
                   style: int, decisions: bytes, plain_bytes: bytes) -> np.ndarray:
    has_repeats, short_bits = style >> 5, style & 31
    first, end = coding.bins(codes, short_bits)
    is_central = (first <= 0) & (end >= 0) & (end - first > 1)
    plain = _PlainBits(plain_bytes)
    decoder = BinaryDecoder(decisions)
    central = _CentralPlaces(decoder, plain, short_bits)
    repeats = _Repeats(decoder)
    nz, ny, nx = codes.shape
    zeros = np.zeros((nz + 1, ny + 1, nx + 1), np.uint8)
    ranks = np.zeros(codes.shape, np.int64)
    for z, y, x in np.ndindex(nz, ny, nx):
        if x == 0:
            central.start_row()
            repeats.start_row()
        if absent is not None and absent[z, y, x]:
            continue
        low, high = int(first[z, y, x]), int(end[z, y, x])
        code = int(codes[z, y, x])
        rank = low
        if high - low > 1:
            rank = repeats.rank(code) if has_repeats else None
            if rank is None and is_central[z, y, x]:
                context = int(zeros[z + 1, y + 1, x] | zeros[z + 1, y, x + 1] << 1
                              | zeros[z, y + 1, x + 1] << 2)
                rank = central.rank(low, high, context)
            elif rank is None:
                rank = low + plain.take((high - low - 1).bit_length())
            repeats.keep(code, rank)
            zeros[z + 1, y + 1, x + 1] = is_central[z, y, x] and rank in (0, -1)
        require(low <= rank < high, "a voxel outside its bin")
        ranks[z, y, x] = rank
    is_used = central.is_used or repeats.is_used
    require(decoder.at == len(decisions) if is_used else not decisions,
            "places of a wrong length")
    plain.end()
    magnitudes = np.where(ranks < 0, ~ranks, ranks) << short_bits
    return (magnitudes | np.where(ranks < 0, 1 << 31, 0)).astype(np.uint32).view(np.float32)
