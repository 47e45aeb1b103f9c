"""The thumbnail that a file may have: docs/format.md, section 7."""

import struct
import zlib
from collections.abc import Callable, Iterator

import numpy as np

from .header import Header

_SIDE = 256
_SHADES = ((200, 255), (140, 230), (230, 175))  # saturation of 256, brightness
_SHORTEST_MATCH = 3
_LONGEST_MATCH = 258


def thumbnail_of(header: Header, read_level: Callable[[int], np.ndarray]) -> bytes:
    """The PNG of the volume. `read_level` gives all samples of a level, [z][y][x]."""
    across, columns, rows = _axes(header)
    extents = [n * step for n, step in zip(header.size, header.spacing)]
    longest = max(extents[columns[0]], extents[rows[0]]) / _SIDE
    level = _level(header, (columns[0], rows[0]), longest)
    pitches = [step * (1 << _halvings(header, level, axis))
               for axis, step in enumerate(header.spacing)]
    pixel = max(longest, min(pitches[columns[0]], pitches[rows[0]]))

    places: list = [None] * 3  # by axis, of the samples that are shown
    places[across] = np.array([(header.size[across] // 2) >> _halvings(header, level, across)])
    for axis, is_mirrored in (columns, rows):
        count = max(1, int(extents[axis] / pixel + 0.5))
        voxels = (2 * np.arange(count) + 1) * header.size[axis] // (2 * count)
        shown = voxels >> _halvings(header, level, axis)
        places[axis] = shown[::-1] if is_mirrored else shown
    plane = read_level(level)[np.ix_(*places[::-1])].squeeze(2 - across)
    if rows[0] < columns[0]:
        plane = plane.T
    if header.kind == "labels":
        return _png(_colors(plane))
    return _png(_greys(plane, header.slope < 0))


def _axes(header: Header) -> tuple[int, tuple[int, bool], tuple[int, bool]]:
    """The index axis through the picture, and those along it with whether they are mirrored."""
    left, back, head = (header.direction[3 * row : 3 * row + 3] for row in range(3))
    s = max(range(3), key=lambda a: (abs(head[a]), a))
    p = max({0, 1, 2} - {s}, key=lambda a: (abs(back[a]), a))
    l = 3 - s - p  # noqa: E741, the text calls it so
    extents = [n * step for n, step in zip(header.size, header.spacing)]
    thin = [a for a in (s, l) if 4 * extents[a] < extents[p]]
    across = min(thin, key=lambda a: extents[a]) if thin else p
    of_back = (p, back[p] < 0)
    columns = of_back if across == l else (l, left[l] < 0)
    rows = of_back if across == s else (s, not head[s] < 0)
    return across, columns, rows


def _halvings(header: Header, level: int, axis: int) -> int:
    return sum(mask >> axis & 1 for mask in header.halvings[:level])


def _level(header: Header, axes: tuple[int, int], minimum: float) -> int:
    """The first level whose samples are long enough along both axes, or single."""
    def is_coarse(level: int, axis: int) -> bool:
        pitch = header.spacing[axis] * (1 << _halvings(header, level, axis))
        return pitch >= minimum or header.level_size(level)[axis] == 1
    return next(level for level in range(header.level_count)
                if all(is_coarse(level, axis) for axis in axes))


def _greys(plane: np.ndarray, is_negative: bool) -> np.ndarray:
    """Samples from low to high as 0 .. 255, [row][column][1]."""
    samples = plane.astype(np.float64)
    ordered = np.sort(samples[np.isfinite(samples)])
    greys = np.zeros(plane.shape, np.uint8)
    if ordered.size == 0:
        return greys[..., None]
    off = ordered.size // 100
    low, high = ordered[off], ordered[-1 - off]
    if low == high:
        low, high = ordered[0], ordered[-1]
    if low < high:
        known = ~np.isnan(samples)
        shade = np.floor(255 * (samples[known].clip(low, high) - low) / (high - low) + 0.5)
        greys[known] = 255 - shade if is_negative else shade
    return greys[..., None]


def _colors(plane: np.ndarray) -> np.ndarray:
    """The color of each label, [row][column][3]."""
    labels, places = np.unique(plane, return_inverse=True)
    colors = np.array([_color(int(label) % (1 << 64)) for label in labels], np.uint8)
    return colors[places.reshape(plane.shape)]


def _color(label: int) -> tuple[int, int, int]:
    if label == 0:
        return 0, 0, 0
    hue = 6 * (40503 * label % 65536)
    sector, part = hue >> 16, hue >> 8 & 255
    saturation, brightness = _SHADES[label % 3]
    a, b, c, d = (brightness - brightness * saturation * share // 65536
                  for share in (0, part, 256 - part, 256))
    return ((a, c, d), (b, a, d), (d, a, c), (d, b, a), (c, d, a), (a, d, b))[sector]


def _png(pixels: np.ndarray) -> bytes:
    """A PNG of 8 bits a channel, [row][column][1 or 3]."""
    height, width, channels = pixels.shape
    rows = np.zeros((height, 1 + width * channels), np.uint8)  # in front the filter: none
    rows[:, 1:] = pixels.reshape(height, -1)
    data = rows.tobytes()
    deflated = b"\x78\x01" + _deflated(data, (channels, rows.shape[1]))
    deflated += zlib.adler32(data).to_bytes(4, "big")
    color_type = 0 if channels == 1 else 2
    return (b"\x89PNG\r\n\x1a\n"
            + _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, color_type, 0, 0, 0))
            + _chunk(b"IDAT", deflated) + _chunk(b"IEND", b""))


def _chunk(name: bytes, data: bytes) -> bytes:
    crc = zlib.crc32(name + data)
    return len(data).to_bytes(4, "big") + name + data + crc.to_bytes(4, "big")


def _deflated(data: bytes, distances: tuple[int, int]) -> bytes:
    """One block of RFC 1951 with its fixed codes."""
    bits, count = 0b011, 3  # the last block, fixed codes
    out = bytearray()
    for value, length in _symbols(data, distances):
        bits |= value << count
        count += length
        while count >= 8:
            out.append(bits & 255)
            bits >>= 8
            count -= 8
    if count:
        out.append(bits)
    return bytes(out)


def _symbols(data: bytes, distances: tuple[int, int]) -> Iterator[tuple[int, int]]:
    """Bits and their number, lowest first; the longest match is taken wherever there is one."""
    at = 0
    while at < len(data):
        matches = [_match(data, at, distance) for distance in distances]
        longest = max(matches)
        if longest < _SHORTEST_MATCH:
            yield _literal(data[at])
            at += 1
            continue
        yield from _length(longest)
        yield from _distance(distances[matches.index(longest)])
        at += longest
    yield _literal(256)


def _match(data: bytes, at: int, distance: int) -> int:
    if at < distance:
        return 0
    end = min(len(data), at + _LONGEST_MATCH)
    to = at
    while to < end and data[to] == data[to - distance]:
        to += 1
    return to - at


def _code(code: int, length: int) -> tuple[int, int]:
    """A Huffman code, whose highest bit comes first."""
    return int(f"{code:0{length}b}"[::-1], 2), length


def _literal(symbol: int) -> tuple[int, int]:
    if symbol < 144:
        return _code(0x30 + symbol, 8)
    if symbol < 256:
        return _code(0x190 + symbol - 144, 9)
    return _code(symbol - 256, 7) if symbol < 280 else _code(0xC0 + symbol - 280, 8)


def _length(length: int) -> Iterator[tuple[int, int]]:
    rest = length - _SHORTEST_MATCH
    if length == _LONGEST_MATCH:
        yield _literal(285)
    elif rest < 8:
        yield _literal(257 + rest)
    else:
        extra = rest.bit_length() - 3
        yield _literal(257 + 4 * extra + (rest >> extra))
        yield rest & ((1 << extra) - 1), extra


def _distance(distance: int) -> Iterator[tuple[int, int]]:
    rest = distance - 1
    if rest < 4:
        yield _code(rest, 5)
    else:
        extra = rest.bit_length() - 2
        yield _code(2 * extra + (rest >> extra), 5)
        yield rest & ((1 << extra) - 1), extra
