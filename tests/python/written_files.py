"""Writes grey files of 16 bits as docs/format.md has them, with the bricks of written_grey.py."""

import dataclasses
import hashlib
import struct

import numpy as np

from file_bytes import crc32c
from written_grey import (Model, cell_flags, flag_cells, levels_of, pack, signed, symbols_of,
                          varint)

TIER_LEVELS = 6
AXES = "xyz"


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
    """One brick that is not uniform: its place, its range, its steps and its pieces."""

    place: tuple
    smallest: int
    largest: int
    plain: bytes = b""
    levels: list = dataclasses.field(default_factory=list)  # symbols of each, finest first
    cells: bytes = b""
    root: int = 0
    pieces: list = dataclasses.field(default_factory=list)


class Volume:
    """Voxels [z][y][x] of int16, the masks of its ladder, the axis order of its model."""

    def __init__(self, voxels, masks, order="xyz", spacing=(1.0, 1.0, 1.0), metadata=b"{}"):
        self.voxels, self.masks, self.order = voxels.astype(np.int64), masks, order
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
        model = Model(order, [(min(i, 1), symbols) for bricks in self.tiers for brick in bricks
                              for i, symbols in enumerate(brick.levels)])
        self.model = model.bytes()
        for bricks in self.tiers:
            for brick in bricks:
                self._fill_pieces(brick, model)

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
        """Without its pieces."""
        low = [p * side for p, side in zip(place, sides)]
        box = tuple(slice(low[k], low[k] + sides[k]) for k in (2, 1, 0))
        own = samples[box]
        brick = Brick(place, int(own.min()), int(own.max()))
        assert brick.smallest < brick.largest, "uniform bricks are not written"
        halvings = [sum(mask >> axis & 1 for mask in self.masks[:level]) for axis in range(3)]
        each = [1 << h for h in halvings]
        last = []
        for axis in range(3):
            length, end = samples.shape[2 - axis], low[axis] + own.shape[2 - axis]
            is_last = end == length
            last.append(self.size[axis] - (length - 1) * each[axis] if is_last else each[axis])
        turn = [AXES.index(name) for name in self.order]  # of the model's axes
        turned = (own - brick.smallest - 2**15).transpose([2 - turn[k] for k in (2, 1, 0)])
        masks = [sum((mask >> turn[k] & 1) << k for k in range(3)) for mask in steps]
        by_axis = [[values[turn[k]] for k in range(3)] for values in (halvings, each, last)]
        made = levels_of(turned, masks, *by_axis)
        # A tier has the levels that the file has; the steps behind lead to the root.
        count = min(TIER_LEVELS, len(self.masks) + 1 - level)
        if count >= 3:
            brick.cells = cell_flags(flag_cells(turned, masks, made))
        high = brick.largest - brick.smallest - 2**15
        brick.levels = [symbols_of(splits, high) for splits, _ in made[:count - 1]]
        coarsest = made[count - 2][1] if count > 1 else turned
        width = (brick.largest - brick.smallest).bit_length()
        brick.plain = pack((coarsest + 2**15).flat, width)
        brick.root = int(made[-1][1].item()) + 2**15 + brick.smallest
        return brick

    @staticmethod
    def _fill_pieces(brick, model):
        count = len(brick.levels) + 1
        segments = [model.details(min(i, 1), symbols) for i, symbols in enumerate(brick.levels)]
        if count >= 3:
            segments[1] = varint(len(brick.cells)) + brick.cells + segments[1]
        segments.append(brick.plain)
        brick.pieces = segments[:3]
        if count > 3:
            lengths = b"".join(varint(len(segment)) for segment in segments[3:-1])
            brick.pieces.append(lengths + b"".join(segments[3:]))

    def piece_crc(self, level, code, data):
        return crc32c(struct.pack("<QBQ", self.build_id, level, code) + data)

    def bytes(self):
        description = self._description()
        # The bytes 16 to 215 and 12 to 14 of the header, and the metadata.
        upper = crc32c(description[16:216] + description[12:15] + self.metadata)
        planes = [hashlib.sha256(plane.astype("<i2").tobytes()).digest() for plane in self.voxels]
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
        header += struct.pack("<BBH", 1, 1, 0)
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
        return (b"\x8f8vo\r\n\x1a\n" + struct.pack("<HHBBBB", 1, 0, 1, 3, len(masks), 1)
                + masks + bytes(32 - len(masks)) + struct.pack("<3Q", *self.size)
                + struct.pack("<3d", 0, 0, 0) + struct.pack("<3d", *self.spacing)
                + struct.pack("<9d", 1, 0, 0, 0, 1, 0, 0, 0, 1) + struct.pack("<3d", 1, 0, 0))

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
        return body, lengths

    def _page(self, tier, bricks):
        page, before = b"\0", 0
        for brick in bricks:
            page += varint(signed(brick.smallest - before))
            page += varint(brick.largest - brick.smallest)
            before = brick.smallest
        for number in range(len(bricks[0].pieces)):
            page += b"".join(varint(len(brick.pieces[number])) for brick in bricks)
            for brick in bricks:
                if brick.pieces[number]:
                    page += struct.pack("<I", self.piece_crc(TIER_LEVELS * tier + number,
                                                             o_code(brick.place),
                                                             brick.pieces[number]))
        return page

    def _index(self, trailers):
        """Pages and root; a layer has one page."""
        root = varint(1) + varint(0) + varint(len(self.model))
        root += struct.pack("<I", self.piece_crc(255, 0, self.model))
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
                root += varint(signed(smallest - before)) + varint(largest - smallest) + varint(0)
                before = smallest
                for number in range(len(bricks[0].pieces)):
                    root += varint(sum(len(brick.pieces[number]) for brick in bricks))
        return pages, root
