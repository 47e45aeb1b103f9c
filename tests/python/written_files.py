"""Writes files as docs/format.md has them; written_grey.py, _labels and _floats have the bricks.

Written from that text alone and sharing nothing with the two readers, so that the tests tell what
the text leaves open.
"""

import dataclasses
import hashlib
import struct

import numpy as np

from file_bytes import crc32c

TIER_LEVELS = 6


def varint(value):
    out = bytearray()
    while value >= 128:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out + bytes([value]))


def signed(value):
    """0, -1, 1, -2, .. as 0, 1, 2, 3, .."""
    return 2 * value if value >= 0 else -2 * value - 1


def pack(values, width):
    """Numbers of so many bits, packed lowest bit first."""
    bits = sum(int(value) << width * i for i, value in enumerate(values))
    return bits.to_bytes((width * len(values) + 7) // 8, "little")


def o_code(place):
    code = 0
    for bit in range(21):
        z, x, y = (place[k] >> bit & 1 for k in (2, 0, 1))
        code |= (4 * z + 2 * x + y) << 3 * bit
    return code


def halved(size, mask):
    return [(n + 1) // 2 if mask >> k & 1 else n for k, n in enumerate(size)]


@dataclasses.dataclass
class Brick:
    """One brick: its place, its range, its root, its segments and its pieces."""

    place: tuple
    smallest: int
    largest: int
    root: int = 0
    segments: list = dataclasses.field(default_factory=list)  # finest first
    pieces: list = dataclasses.field(default_factory=list)

    def is_uniform(self):
        return self.smallest == self.largest


class File:
    """Voxels [z][y][x], the masks of their ladder; who knows a kind of bricks codes them."""

    KIND, TYPE, DTYPE = 1, 3, "<i2"
    max_error = 0
    coarse_model = b""  # of the other tiers, where they have one of their own

    def __init__(self, voxels, masks, spacing=(1.0, 1.0, 1.0), metadata=b"{}"):
        self.voxels, self.masks = voxels.astype(np.int64), masks
        self.spacing, self.metadata = spacing, metadata
        self.size = list(voxels.shape[::-1])
        self.tiers = []
        samples, level = self.voxels, 0
        while True:
            bricks = self._bricks(samples, level)
            self.tiers.append(bricks)
            if level + TIER_LEVELS > len(masks):
                break
            above = np.zeros([max(b.place[k] for b in bricks) + 1 for k in (2, 1, 0)], np.int64)
            for brick in bricks:
                above[brick.place[::-1]] = brick.root
            samples, level = above, level + TIER_LEVELS
        self.model = self.code_all([brick for bricks in self.tiers for brick in bricks])
        for tier, bricks in enumerate(self.tiers):
            for brick in bricks:
                self._fill_pieces(brick, self._level_count(tier))

    def planes(self):
        """Those of level 0 as they are read."""
        return self.voxels

    def extensions(self):
        """Those of the header."""
        return []

    def analyze(self, brick, samples, steps, weights, count):
        """Finds the root of a brick of `count` levels that is not uniform.

        steps: masks of its steps, the last one to its root; weights: of each axis the halvings up
        to its first level, what a sample stands for, and what the last one stands for.
        """
        raise NotImplementedError

    def code_all(self, bricks):
        """Gives the bricks that are not uniform their segments. Returns the bytes of the model."""
        raise NotImplementedError

    def _level_count(self, tier):
        """A tier has the levels that the file has; the steps behind lead to the root."""
        return min(TIER_LEVELS, len(self.masks) + 1 - TIER_LEVELS * tier)

    def _steps(self, level):
        """The masks of the steps of a tier, the last to the next tier."""
        return [self.masks[k] if k < len(self.masks) else 7
                for k in range(level, level + TIER_LEVELS)]

    def _bricks(self, samples, level):
        steps = self._steps(level)
        sides = [1 << sum(mask >> axis & 1 for mask in steps) for axis in range(3)]
        size = samples.shape[::-1]
        counts = [-(-n // side) for n, side in zip(size, sides)]
        places = [(x, y, z) for z in range(counts[2]) for y in range(counts[1])
                  for x in range(counts[0])]
        places.sort(key=lambda place: (place[2], o_code(place)))
        return [self._brick(samples, level, steps, sides, place) for place in places]

    def _brick(self, samples, level, steps, sides, place):
        """Without its segments."""
        low = [p * side for p, side in zip(place, sides)]
        box = tuple(slice(low[k], low[k] + sides[k]) for k in (2, 1, 0))
        own = samples[box]
        brick = Brick(place, int(own.min()), int(own.max()))
        brick.root = brick.smallest
        if brick.is_uniform():
            return brick
        halvings = [sum(mask >> axis & 1 for mask in self.masks[:level]) for axis in range(3)]
        each = [1 << h for h in halvings]
        last = []
        for axis in range(3):
            length, end = samples.shape[2 - axis], low[axis] + own.shape[2 - axis]
            is_last = end == length
            last.append(self.size[axis] - (length - 1) * each[axis] if is_last else each[axis])
        self.analyze(brick, own, steps, (halvings, each, last),
                     self._level_count(level // TIER_LEVELS))
        return brick

    @staticmethod
    def _fill_pieces(brick, count):
        segments = brick.segments or [b""] * count
        brick.pieces = segments[:3]
        if count > 3:
            lengths = b"".join(varint(len(segment)) for segment in segments[3:-1])
            brick.pieces.append(lengths + b"".join(segments[3:]) if segments[-1] else b"")

    def piece_crc(self, level, code, data):
        return crc32c(struct.pack("<QBQ", self.build_id, level, code) + data)

    def bytes(self):
        description = self._description()
        # The bytes 16 to 215 and 12 to 14 of the header, and the metadata.
        upper = crc32c(description[16:216] + description[12:15] + self.metadata)
        planes = [hashlib.sha256(plane.astype(self.DTYPE).tobytes()).digest()
                  for plane in self.planes()]
        self.build_id = upper << 32 | int.from_bytes(planes[0][:4], "little")
        body, trailers = self._slabs(planes)
        for tier, bricks in enumerate(self.tiers):
            for number in range(tier == 0, len(bricks[0].pieces)):
                body += b"".join(brick.pieces[number] for brick in bricks)
        pages, root = self._index(trailers)
        sections, place = {}, 512 + len(body)
        for name, data in (("pages", pages), ("directory", b""), ("metadata", self.metadata),
                           ("root", root)):
            sections[name] = struct.pack("<QQII", place, len(data), crc32c(data), 0)
            place += len(data)
        header = description[:216] + struct.pack("<QQ", self.build_id, place + 96)
        header += b"".join(sections[name] for name in ("metadata", "pages", "root", "directory"))
        extensions = self.extensions()
        header += struct.pack("<BBH", 1, 1, len(extensions)) + b"".join(extensions)
        header += bytes(508 - len(header))
        header_crc = crc32c(header)
        header += struct.pack("<I", header_crc)
        between = body + pages + self.metadata + root
        digest = hashlib.sha256(b"".join(planes)).digest()
        trailer = b"\x8f8voend\n" + struct.pack("<QQIIQ", self.build_id, place + 96, header_crc,
                                                crc32c(between), 0) + digest + bytes(20)
        return header + between + trailer + struct.pack("<I", crc32c(trailer))

    def _description(self):
        """The first 216 bytes of the header."""
        masks = bytes(self.masks)
        return (b"\x8f8vo\r\n\x1a\n" + struct.pack("<HHBBBB", 1, 0, self.KIND, self.TYPE,
                                                           len(masks), 1)
                + masks + bytes(32 - len(masks)) + struct.pack("<3Q", *self.size)
                + struct.pack("<3d", 0, 0, 0) + struct.pack("<3d", *self.spacing)
                + struct.pack("<9d", 1, 0, 0, 0, 1, 0, 0, 0, 1)
                + struct.pack("<3d", 1, 0, self.max_error))

    def _layers(self, tier):
        bricks = self.tiers[tier]
        return [[brick for brick in bricks if brick.place[2] == layer]
                for layer in range(bricks[-1].place[2] + 1)]

    def _slabs(self, planes):
        body, lengths = b"", []
        depth = 1 << sum(mask >> 2 & 1 for mask in self._steps(0))
        for number, bricks in enumerate(self._layers(0)):
            slab = (self.model if number == 0 else b"") + b"".join(b.pieces[0] for b in bricks)
            trailer = b"8slb" + struct.pack("<Q", self.build_id) + varint(number) + varint(0)
            trailer += b"".join(varint(len(brick.pieces[0])) for brick in bricks)
            trailer += b"".join(planes[number * depth:(number + 1) * depth])
            trailer += struct.pack("<I", crc32c(slab))
            trailer += struct.pack("<I", len(trailer) + 8)
            trailer += struct.pack("<I", crc32c(trailer))
            body += slab + trailer
            lengths.append(len(trailer))
        return body + self.coarse_model, lengths

    def _page(self, tier, bricks):
        page, before = b"\0", 0
        for brick in bricks:
            page += varint(signed(brick.smallest - before))
            page += varint(brick.largest - brick.smallest)
            page += self._error(tier)
            before = brick.smallest
        for number in range(len(bricks[0].pieces)):
            coded = [brick for brick in bricks if not brick.is_uniform()]
            page += b"".join(varint(len(brick.pieces[number])) for brick in coded)
            for brick in coded:
                if brick.pieces[number]:
                    page += struct.pack("<I", self.piece_crc(TIER_LEVELS * tier + number,
                                                             o_code(brick.place),
                                                             brick.pieces[number]))
        return page

    def _error(self, tier):
        """What is claimed of a brick of tier 0, or a page."""
        return varint(self.max_error) if self.max_error > 0 and tier == 0 else b""

    def _index(self, trailers):
        """Pages and root; a layer has one page."""
        models = [model for model in (self.model, self.coarse_model) if model]
        root = varint(len(models))
        for number, model in enumerate(models):
            root += varint(number * len(trailers)) + varint(len(model))
            root += struct.pack("<I", self.piece_crc(255, number, model))
        pages = b""
        for tier in range(len(self.tiers)):
            before = 0
            for layer, bricks in enumerate(self._layers(tier)):
                page = self._page(tier, bricks)
                pages += page
                smallest = min(brick.smallest for brick in bricks)
                largest = max(brick.largest for brick in bricks)
                root += varint(trailers[layer]) if tier == 0 else b""
                root += varint(len(page)) + struct.pack("<I", crc32c(page))
                root += varint(signed(smallest - before)) + varint(largest - smallest)
                root += self._error(tier)
                root += varint(sum(brick.is_uniform() for brick in bricks))
                before = smallest
                for number in range(len(bricks[0].pieces)):
                    root += varint(sum(len(brick.pieces[number]) for brick in bricks))
        return pages, root
