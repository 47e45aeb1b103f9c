"""Files of few bricks, made field by field as docs/format.md has them, with right checksums."""

import dataclasses
import hashlib
import struct

from file_bytes import MODEL_LEVEL, crc32c, first_model, sealed, varint, zigzag

TYPES = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f"}
BUILD_ID = 0x1122334455667788


@dataclasses.dataclass
class Crafted:
    """A file of 2 x 2 x 2 voxels of type uint8 that all are 7, unless something is said.

    like    a file whose first model it takes
    model   other bytes of the model
    coarse_model  the model of the second of two tiers, if it has one of its own
    bricks  of tier 0, all alike, along x; two where there are two tiers
    pieces  of a brick that is not uniform; none: it is, all voxels are `low`
    above   of two tiers: the one value that the next tier has
    voxels  as they are read, where they are not all `low`
    parts   (tag, flags, bytes) of each
    patches (section, place, length, bytes) of what stands elsewhere than it would: in "header",
            "slab trailer", "pages", "directory", "root" or "trailer"; what covers it is made of it
    cut     how many bytes are missing at the end
    header_crc  the checksum of the header, where it is another one
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
    model: bytes | None = None
    coarse_model: bytes | None = None
    bricks: int = 1
    pieces: tuple = ()
    above: int | None = None
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
    patches: tuple = ()
    cut: int = 0
    header_crc: bytes | None = None

    def bytes(self):
        model = bytearray(first_model(self.like) if self.model is None else self.model)
        model[0] |= self.model_flags
        slab = model + self._all_of_piece(0)
        digests = self._plane_digests()
        trailer = self._slab_trailer(slab, digests)
        pages, root = self._index(model, trailer)
        root = self._patched("root", root)
        coarse = b"".join(self._all_of_piece(number) for number in range(1, self._piece_count(0)))
        body = slab + trailer + (self.coarse_model or b"") + coarse
        parts, directory = self._parts(512 + len(body) + len(pages))
        directory = self._patched("directory", directory)
        header = bytearray(512)
        header[:8] = b"\x8f8vo\r\n\x1a\n"
        struct.pack_into("<HH4B", header, 8, self.major, self.minor, self.kind, self.type,
                         len(self.masks), self.seal)
        masks = bytes(self.masks) + self.masks_behind
        header[16 : 16 + len(masks)] = masks
        struct.pack_into("<3Q18d", header, 48, *self.size, *self.origin, *self.spacing,
                         *self.direction, self.slope, self.intercept, self.max_error)
        struct.pack_into("<Q", header, 216, BUILD_ID)
        for field, section in ((256, pages), (0, parts), (304, directory), (232, self.metadata),
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
        data = sealed(bytearray(self._patched("header", bytes(header))), body, end)
        end = self._patched("trailer", data[-96:-4])
        data = data[:-96] + end + struct.pack("<I", crc32c(end))
        if self.header_crc is not None:
            data = data[:508] + self.header_crc + data[512:]
        return data[: len(data) - self.cut]

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
        data = b"8slb" + struct.pack("<Q", BUILD_ID) + b"\0\0"
        data += varint(len(self._piece(0))) * self.bricks
        data += b"".join(digests)
        data += struct.pack("<II", crc32c(slab), len(data) + 12)
        data = self._patched("slab trailer", data)
        return data + struct.pack("<I", crc32c(data))

    def _patched(self, name, data):
        for section, at, length, changed in self.patches:
            if section == name:
                data = data[:at] + changed + data[at + length :]
        return data

    def _piece_count(self, tier):
        return min(len(self.masks) + 1 - 6 * tier, 4)

    def _piece(self, number):
        return self.pieces[number] if number < len(self.pieces) else b""

    def _all_of_piece(self, number):
        return self._piece(number) * self.bricks

    def _index(self, model, trailer):
        """All pages, and the root."""
        models = [(self.model_slab, model)]
        if self.coarse_model is not None:
            models.append((1, self.coarse_model))
        root = varint(len(models))
        for number, (step, data) in enumerate(models):
            root += varint(step) + varint(len(data))
            root += struct.pack("<I", piece_crc(MODEL_LEVEL, number, data))
        root += varint(len(trailer))
        page, entry = self._page(self.low, self.high, self.bricks, 0)
        root += entry
        if self.above is None:
            return page, root
        above, entry = self._page(self.above, self.above, 1, 1)
        return page + above, root + entry

    def _page(self, low, high, count, tier):
        """A page of bricks that are alike, and what the root says of it."""
        leaves_details_out = any(tag == 0x8002 for tag, _ in self.extensions)
        has_error = tier == 0 and (self.max_error > 0 or leaves_details_out)
        error = varint(self.error) if has_error else b""
        range_length = varint(high - low)
        page = bytes([self.page_flags])
        for brick in range(count):
            page += (zigzag(low) if brick == 0 else b"\0") + range_length + error
        totals = b""
        for number in range(self._piece_count(tier)):
            piece = b"" if tier else self._piece(number)
            if low != high:
                page += varint(len(piece)) * count
                if piece:
                    page += b"".join(struct.pack("<I", piece_crc(number, code, piece))
                                     for code in range(0, 2 * count, 2))
            totals += varint(len(piece) * count)
        page = self._patched("pages", page)
        entry = varint(len(page)) + struct.pack("<I", crc32c(page)) + zigzag(low) + range_length
        return page, entry + error + varint(count * (low == high)) + totals

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
