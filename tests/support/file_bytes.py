"""Bytes of .8vo files as docs/format.md has them: other metadata, and volumes that claim much."""

import functools
import hashlib
import struct

MODEL_LEVEL = 255
PAGE_BRICKS = 1024
TRAILER_LENGTH = 96


def crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


TABLE = crc_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = TABLE[(crc ^ byte) & 255] ^ (crc >> 8)
    return crc ^ 0xFFFFFFFF


def varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def zigzag(value):
    return varint(value << 1 if value >= 0 else (-value << 1) - 1)


def with_metadata(data, text):
    """The file with other metadata: sections 3, 8 and 9."""
    header, trailer = bytearray(data[:512]), bytearray(data[-TRAILER_LENGTH:])
    begin, length = struct.unpack_from("<QQ", header, 232)
    root, = struct.unpack_from("<Q", header, 280)
    growth = len(text) - length
    struct.pack_into("<QQI", header, 232, begin, len(text), crc32c(text))
    struct.pack_into("<Q", header, 280, root + growth)
    struct.pack_into("<Q", header, 224, len(data) + growth)
    between = data[512:begin] + text + data[begin + length:-TRAILER_LENGTH]
    return sealed(header, between, trailer)


def sealed(header, between, trailer):
    """Header, what stands behind it, and the trailer, with the checksums of both."""
    struct.pack_into("<I", header, 508, crc32c(header[:508]))
    trailer[8:24] = header[216:232]
    trailer[24:28] = header[508:512]
    struct.pack_into("<I", trailer, 28, crc32c(between))
    struct.pack_into("<I", trailer, 92, crc32c(trailer[:92]))
    return bytes(header) + between + bytes(trailer)


def first_model(data):
    """The bytes of the model that stands at the begin of a file."""
    begin, length = struct.unpack_from("<QQ", data, 280)
    root = data[begin : begin + length]
    at, size, shift = 2, 0, 0  # behind the number of models and the slab of the first
    while True:
        size |= (root[at] & 127) << shift
        if root[at] < 128:
            return data[512 : 512 + size]
        at, shift = at + 1, shift + 7


def brick_order(bricks_x, bricks_y):
    """The bricks (i, j) of a layer by their o-code."""
    def code(brick):
        return sum(((n >> bit) & 1) << (2 * bit + axis)
                   for axis, n in enumerate(brick) for bit in range(21))

    return sorted(((i, j) for j in range(bricks_y) for i in range(bricks_x)), key=code)


@functools.lru_cache
def plane_digest(values, size_x, size_y):
    """SHA-256 of a plane of bytes whose squares of 64 x 64 voxels have values[y][x]."""
    digest = hashlib.sha256()
    for j, row in enumerate(values):
        voxels = b"".join(bytes([value]) * 64 for value in row)[:size_x]
        digest.update(voxels * min(64, size_y - 64 * j))
    return digest.digest()


class ClaimedVolume:
    """A file of few bytes a brick: bricks of 64 x 64 x 64 voxels, each of one value.

    size    voxels along x, y, z
    value   that of brick (i, j, k) of level 0; the coarser levels hold 0, so that the file is sound
            where all values are 0
    like    a sound file of 8 bits a voxel, of which kind, type and model are taken
    """

    def __init__(self, size, value, like):
        self._header = bytearray(like[:512])
        self._trailer = bytearray(like[-TRAILER_LENGTH:])
        self._build_id = like[216:224]
        self._model = first_model(like)
        self._size = size
        self._value = value
        self._pages = b""
        self._root = (b"\1\0" + varint(len(self._model)) +
                      struct.pack("<I", self._piece_crc(MODEL_LEVEL, 0, self._model)))

    def bytes(self):
        step_count = max(n - 1 for n in self._size).bit_length()
        slabs = self._model
        digests = b""
        grid = self._size
        for first in range(0, step_count + 1, 6):
            grid = [-(-n // 64) for n in grid]
            order = brick_order(grid[0], grid[1])
            before = 0
            for k in range(grid[2]):
                if first == 0:
                    of_slab = self._plane_digests(k, grid)
                    digests += of_slab
                    trailer = self._slab_trailer(k, len(order), of_slab,
                                                 self._model if k == 0 else b"")
                    slabs += trailer
                    self._root += varint(len(trailer))
                values = [self._value(i, j, k) if first == 0 else 0 for i, j in order]
                for at in range(0, len(values), PAGE_BRICKS):
                    before = self._add_page(values[at : at + PAGE_BRICKS], before,
                                            min(4, step_count + 1 - first))
        self._trailer[40:72] = hashlib.sha256(digests).digest()
        return self._assembled(step_count, slabs)

    def _piece_crc(self, level, code, data):
        return crc32c(self._build_id + struct.pack("<BQ", level, code) + data)

    def _plane_digests(self, slab, grid):
        """Those of the planes of a slab, which are all alike."""
        x, y, z = self._size
        values = tuple(tuple(self._value(i, j, slab) for i in range(grid[0]))
                       for j in range(grid[1]))
        return plane_digest(values, x, y) * min(64, z - 64 * slab)

    def _slab_trailer(self, slab, brick_count, plane_digests, before):
        data = b"8slb" + self._build_id + varint(slab) + b"\0" + bytes(brick_count)
        data += plane_digests
        data += struct.pack("<II", crc32c(before), len(data) + 12)
        return data + struct.pack("<I", crc32c(data))

    def _add_page(self, values, before, piece_count):
        page = b"\0"
        previous = 0
        for value in values:
            page += zigzag(value - previous) + b"\0"
            previous = value
        low, high = min(values), max(values)
        self._root += varint(len(page)) + struct.pack("<I", crc32c(page))
        self._root += zigzag(low - before) + varint(high - low) + varint(len(values))
        self._root += bytes(piece_count)
        self._pages += page
        return low

    def _assembled(self, step_count, slabs):
        header = self._header
        header[14] = step_count
        header[16:48] = bytes([7] * step_count + [0] * (32 - step_count))
        struct.pack_into("<3Q", header, 48, *self._size)
        at = 512 + len(slabs)
        for field, part in ((256, self._pages), (304, b""), (232, b"{}"), (280, self._root)):
            struct.pack_into("<QQI", header, field, at, len(part), crc32c(part))
            at += len(part)
        struct.pack_into("<Q", header, 224, at + TRAILER_LENGTH)
        return sealed(header, slabs + self._pages + b"{}" + self._root, self._trailer)
