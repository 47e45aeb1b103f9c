"""The header of a file: docs/format.md, sections 2 and 4."""

import math
from dataclasses import dataclass

import numpy as np

from .byte_cursor import ByteCursor, crc32c
from .errors import OctavoError, require, require_known, require_within
from .weights import SampleWeights

HEADER_LENGTH = 512
MAGIC = b"\x8f8vo\r\n\x1a\n"
TRIAL_MAGIC = b"\x8f8VO\r\n\x1a\n"
TRAILER_LENGTH = 96
LEVELS_PER_TIER = 6
BRICKS_PER_PAGE = 1024
# Bytes that a page and a brick cost in the index, at least and at most: docs/format.md, section 10.
PAGE_IN_ROOT = (9, 44)
BRICK_IN_PAGES = (2, 47)
VOXEL_TYPES = {1: "int8", 2: "uint8", 3: "int16", 4: "uint16", 5: "int32", 6: "uint32",
               7: "float32"}
KINDS = {1: "grey", 2: "labels"}
_CODING_TAG = 0x8001
_CODING_LENGTH = 18
_DETAIL_TAG = 0x8002
_REQUIRED_TAG = 0x8000  # and above
_LEVEL_LIMIT = 32
_AXIS_LIMIT = 1 << 21
_VOXEL_LIMIT = (1 << 63) - 1
_METADATA_LIMIT = 16 << 20
_DIRECTORY_LIMIT = 1024 * 32
_AXIS_TOLERANCE = 1e-4
_SPACING_LIMITS = (1e-9, 1e9)
_ORIGIN_LIMIT = 1e12


@dataclass(frozen=True)
class Section:
    """A part of the file: offset and length in bytes, CRC of its bytes."""

    offset: int
    length: int
    crc: int


@dataclass(frozen=True)
class Header:
    """What the first 512 bytes say.

    kind             "grey" or "labels"
    voxel_type       NumPy's name of the type of the voxels
    code_type        NumPy's name of the type of the integers that bricks hold
    code_scale       float32 only: a voxel is code * code_scale + code_offset
    is_exact         float32 only: voxels are told apart beyond their codes
    halvings         per step from level k to k+1 the halved axes: bit 0 x, bit 1 y, bit 2 z
    size             voxels along x, y, z
    origin, spacing  mm, LPS
    direction        row-major 3 x 3; column a is the unit vector of index axis a
    slope, intercept real value = slope * voxel + intercept
    max_error        no voxel differs from its source by more; 0: lossless, or interpolated
    detail_level     the finest level that has details; finer ones are interpolated
    """

    kind: str
    voxel_type: str
    code_type: str
    code_scale: float
    code_offset: float
    is_exact: bool
    halvings: tuple[int, ...]
    size: tuple[int, int, int]
    origin: tuple[float, float, float]
    spacing: tuple[float, float, float]
    direction: tuple[float, ...]
    slope: float
    intercept: float
    max_error: float
    detail_level: int
    build_id: int
    file_length: int
    metadata: Section
    pages: Section
    root: Section
    directory: Section
    crc: int

    @property
    def most_error(self) -> int:
        """The largest error that the index may hold: 1024ths of the max error for float32."""
        if self.detail_level > 0:
            limits = np.iinfo(self.voxel_type)
            return int(limits.max) - int(limits.min)
        if self.voxel_type == "float32":
            return 1024 if self.max_error > 0 else 0
        return int(self.max_error)

    def has_errors(self, tier: int) -> bool:
        """Whether the index holds errors of the bricks of a tier; their ranges are bounds then."""
        return tier == 0 and (self.max_error > 0 or self.detail_level > 0)

    @property
    def level_count(self) -> int:
        return len(self.halvings) + 1

    @property
    def tier_count(self) -> int:
        return (self.level_count + LEVELS_PER_TIER - 1) // LEVELS_PER_TIER

    def level_size(self, level: int) -> tuple[int, int, int]:
        """Samples of a level along x, y, z."""
        size = self.size
        for mask in self.halvings[:level]:
            size = halved(size, mask)
        return size

    def brick_shifts(self, tier: int) -> tuple[int, int, int]:
        """Along each axis h; bricks of a tier cover 2^h samples of its first level."""
        first = LEVELS_PER_TIER * tier
        masks = self.halvings[first : first + LEVELS_PER_TIER]
        missing = LEVELS_PER_TIER - len(masks)
        return tuple(sum(mask >> axis & 1 for mask in masks) + missing for axis in range(3))

    def bricks(self, tier: int) -> tuple[int, int, int]:
        """Bricks of a tier along x, y, z."""
        size = self.level_size(LEVELS_PER_TIER * tier)
        return tuple(-(-n >> h) for n, h in zip(size, self.brick_shifts(tier)))

    def brick_weights(self, tier: int, at: tuple[int, int, int]) -> SampleWeights:
        """Those of a brick's samples at the first level of its tier."""
        first = LEVELS_PER_TIER * tier
        each, last = [], []
        for axis, shift in enumerate(self.brick_shifts(tier)):
            weight = 1 << sum(mask >> axis & 1 for mask in self.halvings[:first])
            end = min((at[axis] + 1) << shift, self.level_size(first)[axis])
            each.append(weight)
            last.append(min(weight, self.size[axis] - (end - 1) * weight))
        return SampleWeights(tuple(each), tuple(last))

    def tier_levels(self, tier: int) -> range:
        """The levels that bricks of a tier hold."""
        first = LEVELS_PER_TIER * tier
        return range(first, min(first + LEVELS_PER_TIER, self.level_count))


def halved(size: tuple[int, int, int], mask: int) -> tuple[int, int, int]:
    """The size x, y, z of the next level when the axes of `mask` are halved."""
    return tuple((n + 1) // 2 if mask >> axis & 1 else n for axis, n in enumerate(size))


def parse_header(data: bytes) -> Header:
    """Reads and proves the first 512 bytes of a file.

    Raises  OctavoError "not_octavo", "unsupported_version", "truncated", "corrupt" or
            "limit_exceeded"
    """
    if data[:8] == TRIAL_MAGIC:
        raise OctavoError("unsupported_version",
                          "of a trial version of the format, before 1.0; build it again")
    if data[:8] != MAGIC:
        raise OctavoError("not_octavo", "the file does not begin as .8vo files do")
    if len(data) < HEADER_LENGTH:
        raise OctavoError("truncated", "the file is shorter than a header")
    cursor = ByteCursor(data[:HEADER_LENGTH], "header")
    cursor.take(8)
    major, _ = cursor.unpack("HH")
    if major != 1:
        raise OctavoError("unsupported_version", f"format version {major}, this reader knows 1")
    crc = int.from_bytes(data[508:512], "little")
    require(crc32c(data[:508]) == crc, "the header's checksum is wrong")
    extensions = _list_extensions(data)
    _prove_known(data, extensions)
    kind, voxel_type, halving_count, sealed = cursor.unpack("4B")
    masks = cursor.take(32)
    size = cursor.unpack("3Q")
    numbers = cursor.unpack("18d")
    build_id, file_length = cursor.unpack("QQ")
    sections = [Section(*cursor.unpack("QQI4x")) for _ in range(4)]
    require(sealed == 1, "the file was never finished")
    coding, detail_level = _take_extensions(extensions)
    require(KINDS[kind] == "grey" or voxel_type != 7, "labels cannot be float32")
    require((voxel_type == 7) == (coding is not None), "float32 and coding do not go together")
    require_within(halving_count + 1, _LEVEL_LIMIT, "levels")
    require(all(masks[:halving_count]), "halving masks are wrong")
    require(all(size), "an axis has no voxels")
    require_within(max(size), _AXIS_LIMIT, "voxels of an axis")
    require_within(math.prod(size), _VOXEL_LIMIT, "voxels")
    require(all(map(math.isfinite, numbers)), "a number is not finite")
    code_type, is_exact, code_scale, code_offset = coding or (voxel_type, False, 1.0, 0.0)
    header = Header(
        KINDS[kind], VOXEL_TYPES[voxel_type], VOXEL_TYPES[code_type], code_scale, code_offset,
        bool(is_exact), tuple(masks[:halving_count]), size, numbers[0:3], numbers[3:6],
        numbers[6:15], numbers[15], numbers[16], numbers[17], detail_level, build_id, file_length,
        *sections, crc,
    )
    _prove(header)
    return header


@dataclass(frozen=True)
class _Extensions:
    """Tag, length and bytes of each, as far as they stand in the header; `behind` what is left, or
    None where the last one passes its end.
    """

    all: list[tuple[int, int, bytes]]
    behind: bytes | None


def _list_extensions(data: bytes) -> _Extensions:
    count = int.from_bytes(data[330:332], "little")
    left = data[332:508]
    found = []
    for _ in range(count):
        if len(left) < 4:
            return _Extensions(found, None)
        tag, length = (int.from_bytes(left[at : at + 2], "little") for at in (0, 2))
        found.append((tag, length, left[4 : 4 + length]))
        if length > len(left) - 4:
            return _Extensions(found, None)
        left = left[4 + length :]
    return _Extensions(found, left)


def _prove_known(data: bytes, extensions: _Extensions) -> None:
    """No number of the header is one of a later version: before any other rule."""
    kind, voxel_type, halving_count, sealed = data[12:16]
    masks = data[16:48]
    require_known(sealed <= 1, f"seal {sealed}")
    require_known(kind in KINDS, f"kind {kind}")
    require_known(voxel_type in VOXEL_TYPES, f"voxel type {voxel_type}")
    require_known(data[328] == 1, f"{data[328]} channels")
    require_known(data[329] == 1, f"{data[329]} times")
    require_known(all(mask < 8 for mask in masks), "a halved axis")
    require_known(not any(masks[halving_count:]), "halved axes behind the last level")
    require_known(not any(any(data[at + 20 : at + 24]) for at in (232, 256, 280, 304)),
                  "something behind a section")
    for tag, length, body in extensions.all:
        is_whole = len(body) == length
        require_known(tag in (_CODING_TAG, _DETAIL_TAG) or tag < _REQUIRED_TAG,
                      f"extension {tag:#x}")
        if tag == _CODING_TAG and is_whole and length == _CODING_LENGTH:
            require_known(1 <= body[0] <= 6, f"type {body[0]} of codes")
            require_known(body[1] <= 1, f"flags {body[1]} of codes")
        if tag == _DETAIL_TAG and is_whole and length == 1:
            require_known(body[0] < LEVELS_PER_TIER, f"details from level {body[0]} on")
    require_known(not any(extensions.behind or b""), "something behind the extensions")


def _take_extensions(
        extensions: _Extensions) -> tuple[tuple[int, int, float, float] | None, int]:
    """The coding (type, whether it is exact, scale, offset) if the header has one, and the finest
    level that has details.
    """
    coding = None
    detail_level = 0
    require(extensions.behind is not None, "the extensions end too late")
    for tag, _, data in extensions.all:
        body = ByteCursor(data, "an extension")
        if tag == _CODING_TAG:
            require(coding is None, "there are two codings")
            code_type, flags, scale, offset = body.unpack("BBdd")
            body.end()
            require(flags == 0 or code_type == 5, "an exact coding has codes of another type")
            coding = code_type, flags, scale, offset
            require(math.isfinite(offset) and 0 < scale < math.inf, "the coding is wrong")
        elif tag == _DETAIL_TAG:
            require(detail_level == 0, "there are two levels of details")
            detail_level = body.u8()
            body.end()
            require(detail_level > 0, "details are left out below level 0")
    return coding, detail_level


def _prove(header: Header) -> None:
    last_size = header.level_size(header.level_count - 1)
    require(last_size == (1, 1, 1), "the last level is not one sample")
    for level, mask in enumerate(header.halvings):
        size = header.level_size(level)
        require(halved(size, mask) != size, "a step halves nothing")
    fine, wide = _SPACING_LIMITS
    require(all(fine <= step <= wide for step in header.spacing), "spacing is out of its limits")
    require(all(abs(x) <= _ORIGIN_LIMIT for x in header.origin), "the origin is out of its limits")
    lengths = np.sqrt(np.square(np.array(header.direction).reshape(3, 3)).sum(axis=0))
    require(all(abs(lengths - 1) <= _AXIS_TOLERANCE), "an axis of direction has another length")
    _prove_rescale(header)
    determinant = np.linalg.det(np.array(header.direction).reshape(3, 3))
    require(abs(determinant) > 1e-6, "direction is singular")
    require(header.max_error >= 0, "max error is negative")
    if header.kind == "labels":
        require(header.max_error == 0, "labels have a max error")
    if header.voxel_type == "float32":
        require(header.is_exact == (header.max_error == 0), "float32 is exact and has a max error")
    if header.voxel_type != "float32":
        require(header.max_error == int(header.max_error) < 1 << 32, "max error is not whole")
    if header.detail_level > 0:
        require(header.kind == "grey" and header.voxel_type != "float32" and header.max_error == 0
                and header.detail_level < len(header.tier_levels(0)),
                "details are left out wrongly")
    for tier in range(header.tier_count - 1):
        size = header.level_size(LEVELS_PER_TIER * tier)
        shifts = header.brick_shifts(tier)
        require(all(n <= 4 or h >= 2 for n, h in zip(size, shifts)), "a brick is too flat")
    # Parts stand between the pages and the directory that lists them.
    require(header.pages.offset >= HEADER_LENGTH
            and header.directory.offset >= header.pages.offset + header.pages.length,
            "the sections overlap")
    at = header.directory.offset
    for section in (header.directory, header.metadata, header.root):
        require(section.offset == at, "the sections leave a gap")
        at += section.length
    require(at + TRAILER_LENGTH == header.file_length, "the sections do not fill the file")
    require_within(header.metadata.length, _METADATA_LIMIT, "bytes of metadata")
    require_within(header.directory.length, _DIRECTORY_LIMIT, "bytes of the directory")
    _prove_index_lengths(header)


def _prove_rescale(header: Header) -> None:
    limits = np.finfo if header.voxel_type == "float32" else np.iinfo
    ends = limits(header.voxel_type).min, limits(header.voxel_type).max
    require(header.slope != 0, "the slope is 0")
    require(all(math.isfinite(header.slope * float(end) + header.intercept) for end in ends),
            "real values are beyond all numbers")


def _prove_index_lengths(header: Header) -> None:
    """How many bricks a volume has bounds its index from both sides."""
    grids = [header.bricks(tier) for tier in range(header.tier_count)]
    bricks = sum(map(math.prod, grids))
    pages = sum(-(-x * y // BRICKS_PER_PAGE) * z for x, y, z in grids)
    slabs = grids[0][2]
    fewest, most = (pages + bricks * each for each in BRICK_IN_PAGES)
    require(fewest <= header.pages.length <= most, "the index pages do not fit the volume")
    fewest, most = (pages * each for each in PAGE_IN_ROOT)
    require(fewest + slabs <= header.root.length <= most + 16 * slabs + 16,
            "the index root does not fit the volume")
