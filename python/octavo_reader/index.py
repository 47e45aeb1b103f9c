"""Index root and pages: docs/format.md, section 6."""

from dataclasses import dataclass, field

import numpy as np

from .byte_cursor import ByteCursor
from .errors import require, require_known
from .header import BRICK_IN_PAGES, BRICKS_PER_PAGE, HEADER_LENGTH, Header

_MODEL_LIMIT = 16 << 20
_PIECE_LIMIT = 4 << 20
_BRICK_PIECES = 4
_SLAB_TRAILER_LIMIT = 1 << 30


@dataclass(frozen=True)
class Model:
    """Where a model lies; `slab` is the layer of tier 0 before which it stands, or their number."""

    slab: int
    offset: int
    length: int
    crc: int


@dataclass
class Page:
    """What the root says of up to 1024 bricks of one layer.

    piece_bytes, piece_offsets  per piece of the tier: length of the page's pieces, their place
    """

    tier: int
    layer: int
    brick_count: int
    offset: int
    length: int
    crc: int
    smallest: int
    largest: int
    error: int
    uniform_count: int
    piece_bytes: list[int]
    piece_offsets: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Brick:
    """Range of a brick's codes and (offset, length, CRC) of each of its pieces."""

    smallest: int
    largest: int
    pieces: list[tuple[int, int, int]]


@dataclass(frozen=True)
class Root:
    """The models and pages of a file; pages[tier][layer] in brick order.

    slab_trailers  (offset, length) of each
    """

    models: list[Model]
    pages: list[list[list[Page]]]
    slab_trailers: list[tuple[int, int]]

    def model_number(self, tier: int, layer: int, slab_count: int) -> int:
        """The number of the model of the bricks of a layer."""
        if tier > 0:
            last = len(self.models) - 1
            return last if self.models[last].slab == slab_count else 0
        return max(n for n, model in enumerate(self.models) if model.slab <= layer)


def parse_root(data: bytes, header: Header) -> Root:
    """Reads and proves the index root. Raises OctavoError "corrupt"."""
    cursor = ByteCursor(data, "index root")
    slab_count = header.bricks(0)[2]
    model_count = cursor.varint()
    require(1 <= model_count <= slab_count + 1, "the number of models is wrong")
    models = []
    slab = 0
    for number in range(model_count):
        step = cursor.varint()
        require((step == 0) == (number == 0), "the models are out of order")
        slab += step
        length, crc = cursor.varint(), cursor.u32()
        require(length <= _MODEL_LIMIT, "a model is too long")
        require(slab < slab_count or (slab == slab_count and header.tier_count > 1),
                "a model begins behind the slabs")
        models.append((slab, length, crc))

    trailers = []
    pages = []
    page_offset = header.pages.offset
    for tier in range(header.tier_count):
        bricks_x, bricks_y, layers = header.bricks(tier)
        pages.append([])
        before = 0
        for layer in range(layers):
            if tier == 0:
                trailers.append(cursor.varint())
                planes = 1 << header.brick_shifts(0)[2]
                limit = min(_SLAB_TRAILER_LIMIT, 30 + 4 * bricks_x * bricks_y + 32 * planes)
                require(trailers[-1] <= limit, "a slab trailer is too long")
            pages[tier].append([])
            for first in range(0, bricks_x * bricks_y, BRICKS_PER_PAGE):
                count = min(BRICKS_PER_PAGE, bricks_x * bricks_y - first)
                page = _parse_page_entry(cursor, header, tier, layer, count, page_offset, before)
                before = page.smallest
                page_offset += page.length
                pages[tier][layer].append(page)
    cursor.end()
    require(page_offset == header.pages.offset + header.pages.length,
            "the pages have a wrong length")
    return Root(*_place(header, models, trailers, pages))


def _parse_page_entry(cursor: ByteCursor, header: Header, tier: int, layer: int, count: int,
                      offset: int, before: int) -> Page:
    length, crc = cursor.varint(), cursor.u32()
    smallest = before + cursor.zigzag()
    largest = smallest + cursor.varint()
    error = cursor.varint() if header.has_errors(tier) else 0
    uniform_count = cursor.varint()
    piece_bytes = [cursor.varint() for _ in range(piece_count(header, tier))]
    fewest, most = (1 + count * each for each in BRICK_IN_PAGES)
    require(fewest <= length <= most and uniform_count <= count,
            "the root describes a page wrongly")
    require(error <= header.most_error, "an error exceeds the max error")
    _prove_range(header, smallest, largest)
    return Page(tier, layer, count, offset, length, crc, smallest, largest, error, uniform_count,
                piece_bytes)


def piece_count(header: Header, tier: int) -> int:
    """Pieces of the bricks of a tier."""
    return min(len(header.tier_levels(tier)), _BRICK_PIECES)


def split_pieces(pieces: list[bytes], level_count: int) -> list[bytes]:
    """The segments of a brick, one per level: section 2. Raises OctavoError "corrupt"."""
    joint_count = level_count - len(pieces) + 1
    if joint_count == 1:
        return pieces
    segments = pieces[:-1]
    if not pieces[-1]:
        return segments + [b""] * joint_count
    cursor = ByteCursor(pieces[-1], "a piece of several levels")
    lengths = [cursor.varint() for _ in range(joint_count - 1)]
    segments += [cursor.take(length) for length in lengths]
    segments.append(cursor.rest())
    require(len(segments[-1]) > 0, "a piece has no coarsest samples")
    return segments


def _prove_range(header: Header, smallest: int, largest: int) -> None:
    limits = np.iinfo(header.code_type)
    lowest = -limits.max if header.is_exact else limits.min
    require(lowest <= smallest <= largest <= limits.max, "a range leaves the voxel type")


def _place(header: Header, models: list[tuple[int, int, int]], trailers: list[int],
           pages: list[list[list[Page]]]
           ) -> tuple[list[Model], list[list[list[Page]]], list[tuple[int, int]]]:
    """Gives models, slab trailers and the pieces of pages their offsets, as in section 3."""
    placed = []
    placed_trailers = []
    cursor = HEADER_LENGTH

    def place_model(slab: int) -> None:
        nonlocal cursor
        if len(placed) < len(models) and models[len(placed)][0] == slab:
            _, length, crc = models[len(placed)]
            placed.append(Model(slab, cursor, length, crc))
            cursor += length

    for slab, layer in enumerate(pages[0]):
        place_model(slab)
        for page in layer:
            page.piece_offsets.append(cursor)
            cursor += page.piece_bytes[0]
        placed_trailers.append((cursor, trailers[slab]))
        cursor += trailers[slab]
    place_model(len(pages[0]))
    for tier, layers in enumerate(pages):
        for place in range(piece_count(header, tier)):
            if tier == 0 and place == 0:
                continue
            for page in (page for layer in layers for page in layer):
                page.piece_offsets.append(cursor)
                cursor += page.piece_bytes[place]
    require(cursor == header.pages.offset, "the lengths of the pieces do not reach the index")
    return placed, pages, placed_trailers


def parse_page(data: bytes, page: Page, header: Header) -> list[Brick]:
    """The bricks of a page, in brick order.

    Raises  OctavoError "corrupt", also where the root disagrees
    """
    cursor = ByteCursor(data, "index page")
    flags = cursor.u8()
    require_known(flags == 0, f"flags {flags} of an index page")
    has_errors = header.has_errors(page.tier)
    ranges = []
    errors = [0]
    before = 0
    for _ in range(page.brick_count):
        before += cursor.zigzag()
        ranges.append((before, before + cursor.varint()))
        _prove_range(header, *ranges[-1])
        if has_errors:
            errors.append(cursor.varint())
    require(min(low for low, _ in ranges) == page.smallest
            and max(high for _, high in ranges) == page.largest and max(errors) == page.error,
            "a page and the root disagree on its ranges")
    uniform = [low == high for low, high in ranges]
    require(sum(uniform) == page.uniform_count, "a page and the root disagree on uniform bricks")

    pieces: list[list[tuple[int, int, int]]] = [[] for _ in ranges]
    for piece_bytes, offset in zip(page.piece_bytes, page.piece_offsets):
        lengths = [0 if is_uniform else cursor.varint() for is_uniform in uniform]
        require(sum(lengths) == piece_bytes, "a page and the root disagree on the pieces")
        require(max(lengths) <= _PIECE_LIMIT, "a piece is too long")
        for place, length in enumerate(lengths):
            crc = cursor.u32() if length > 0 else 0
            pieces[place].append((offset, length, crc))
            offset += length
    cursor.end()
    return [Brick(low, high, of_brick) for (low, high), of_brick in zip(ranges, pieces)]


def o_code(x: int, y: int, z: int) -> int:
    """The digits 4z + 2x + y, one per bit of the coordinates, highest bit first."""
    code = 0
    for bit in range(21):
        digit = (z >> bit & 1) << 2 | (x >> bit & 1) << 1 | (y >> bit & 1)
        code |= digit << (3 * bit)
    return code


def brick_order(bricks_x: int, bricks_y: int) -> list[tuple[int, int]]:
    """The places (x, y) of the bricks of a layer in brick order."""
    places = [(x, y) for y in range(bricks_y) for x in range(bricks_x)]
    return sorted(places, key=lambda place: o_code(place[0], place[1], 0))
