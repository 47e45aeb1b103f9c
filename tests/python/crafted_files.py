"""Files of one brick, made field by field as docs/format.md has them, with right checksums."""

import dataclasses
import hashlib
import struct

from file_bytes import MODEL_LEVEL, crc32c, first_model, sealed, varint, zigzag

TYPES = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f"}
BUILD_ID = 0x1122334455667788


@dataclasses.dataclass
class Crafted:
    """A file of 2 x 2 x 2 voxels of type uint8 that all are 7, unless something is said.

    stored   piece 0 of a brick that holds its voxels as they are; none: they all are `low`
    voxels   as they are read, where they are not all `low`
    parts    (tag, flags, bytes) of each
    before   changes header and bytes behind it before checksums are made
    """

    like: bytes
    major: int = 1
    minor: int = 0
    kind: int = 1
    type: int = 2
    seal: int = 1
    masks: tuple = (7,)
    size: tuple = (2, 2, 2)
    origin: tuple = (0.0, 0.0, 0.0)
    spacing: tuple = (1.0, 1.0, 1.0)
    direction: tuple = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    slope: float = 1.0
    intercept: float = 0.0
    max_error: float = 0.0
    channels: int = 1
    times: int = 1
    extensions: tuple = ()
    behind_extensions: bytes = b""
    extension_count: int | None = None
    section_zeros: int = 0
    low: int = 7
    high: int = 7
    error: int = 0
    stored: bytes = b""
    voxels: tuple = ()
    model_flags: int = 0
    masks_behind: bytes = b""
    page_flags: int = 0
    parts: tuple = ()
    part_length: int | None = None
    directory: bytes | None = None
    metadata: bytes = b"{}"
    digest: bytes | None = None
    plane_digest: bytes | None = None
    trailer_zeros: bytes = bytes(20)
    previous: int = 0
    model_slab: int = 0

    def bytes(self):
        model = bytearray(first_model(self.like))
        model[0] |= self.model_flags
        slab = model + self.stored
        digests = self._plane_digests()
        trailer = self._slab_trailer(slab, digests)
        page, root = self._index(model, trailer)
        parts, directory = self._parts(512 + len(slab) + len(trailer) + len(page))
        header = bytearray(512)
        header[:8] = b"\x8f8vo\r\n\x1a\n"
        struct.pack_into("<HH4B", header, 8, self.major, self.minor, self.kind, self.type,
                         len(self.masks), self.seal)
        masks = bytes(self.masks) + self.masks_behind
        header[16 : 16 + len(masks)] = masks
        struct.pack_into("<3Q18d", header, 48, *self.size, *self.origin, *self.spacing,
                         *self.direction, self.slope, self.intercept, self.max_error)
        struct.pack_into("<Q", header, 216, BUILD_ID)
        body = slab + trailer
        for field, section in ((256, page), (0, parts), (304, directory), (232, self.metadata),
                               (280, root)):
            if field:
                struct.pack_into("<QQII", header, field, 512 + len(body), len(section),
                                 crc32c(section), self.section_zeros)
            body += section
        struct.pack_into("<Q", header, 224, 512 + len(body) + 96)
        extensions = b"".join(struct.pack("<HH", tag, len(data)) + data
                              for tag, data in self.extensions)
        count = len(self.extensions) if self.extension_count is None else self.extension_count
        struct.pack_into("<BBH", header, 328, self.channels, self.times, count)
        extensions += self.behind_extensions
        header[332 : 332 + len(extensions)] = extensions
        end = bytearray(b"\x8f8voend\n" + bytes(88))
        struct.pack_into("<Q", end, 32, self.previous)
        end[40:72] = self.digest or hashlib.sha256(b"".join(digests)).digest()
        end[72:92] = self.trailer_zeros
        return sealed(header, body, end)

    def _plane_digests(self):
        x, y, z = self.size
        if self.plane_digest:
            return [self.plane_digest] * z
        letter = "<%d" + TYPES.get(self.type, "B")
        voxels = self.voxels or (self.low,) * (x * y * z)
        planes = [voxels[k * x * y : (k + 1) * x * y] for k in range(z)]
        return [hashlib.sha256(struct.pack(letter % len(plane), *plane)).digest()
                for plane in planes]

    def _slab_trailer(self, slab, digests):
        data = b"8slb" + struct.pack("<Q", BUILD_ID) + b"\0\0" + varint(len(self.stored))
        data += b"".join(digests)
        data += struct.pack("<II", crc32c(slab), len(data) + 12)
        return data + struct.pack("<I", crc32c(data))

    def _index(self, model, trailer):
        ends = zigzag(self.low) + varint(self.high - self.low)
        leaves_details_out = any(tag == 0x8002 for tag, _ in self.extensions)
        error = varint(self.error) if self.max_error > 0 or leaves_details_out else b""
        page = bytes([self.page_flags]) + ends + error
        piece_count = min(len(self.masks) + 1, 4)
        if self.low != self.high:
            crc = struct.pack("<I", piece_crc(0, 0, self.stored))
            page += varint(len(self.stored)) + crc + bytes(piece_count - 1)
        root = b"\1" + varint(self.model_slab) + varint(len(model))
        root += struct.pack("<I", piece_crc(MODEL_LEVEL, 0, model)) + varint(len(trailer))
        root += varint(len(page)) + struct.pack("<I", crc32c(page)) + ends + error
        root += varint(self.low == self.high) + varint(len(self.stored)) + bytes(piece_count - 1)
        return page, root

    def _parts(self, begin):
        data = directory = b""
        for tag, flags, part in self.parts:
            length = len(part) if self.part_length is None else self.part_length
            directory += struct.pack("<4sIQQII", tag, flags, begin + len(data), length,
                                     crc32c(part), 0)
            data += part
        return data, directory if self.directory is None else self.directory


def piece_crc(level, code, data):
    return crc32c(struct.pack("<QBQ", BUILD_ID, level, code) + data)
