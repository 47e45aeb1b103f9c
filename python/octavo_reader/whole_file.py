"""What only a whole file shows: docs/format.md, section 11, "verify"."""

import hashlib

import numpy as np

from .byte_cursor import crc32c
from .directory import THUMBNAIL
from .errors import require
from .file import OctavoFile
from .header import HEADER_LENGTH, TRAILER_LENGTH, Section
from .index import brick_order
from .thumbnail import thumbnail_of


def verify(file: OctavoFile) -> None:
    """Proves every rule that a reader proves, of every byte of a file.

    Raises  OctavoError, naming the first rule that does not hold
    Memory  that of all voxels
    """
    header = file.header
    body = file.read_bytes(HEADER_LENGTH, header.file_length - TRAILER_LENGTH - HEADER_LENGTH)
    require(crc32c(body) == file.body_crc, "the checksum of all bytes is wrong")
    require(crc32c(_section(body, header.pages)) == header.pages.crc,
            "the checksum of the index pages is wrong")
    require(isinstance(file.metadata, dict), "the metadata is no JSON object")
    for part in file.parts:
        file.part(part)
    for number in range(file.model_count):
        model = file.model(number)
        require(header.kind == "labels" or model.axis_order == file.model(0).axis_order,
                f"model {number} has another axis order than model 0")
    _verify_slabs(file, body)
    levels = [file.read_level(level) for level in range(header.level_count)]
    _verify_ranges(file, levels)
    _verify_tiers(file, levels)
    digests = [hashlib.sha256(plane.astype(plane.dtype.newbyteorder("<")).tobytes()).digest()
               for plane in levels[0]]
    stored = [digest for slab in range(header.bricks(0)[2])
              for digest in file.slab_trailer(slab).plane_digests]
    for z, (found, expected) in enumerate(zip(digests, stored, strict=True)):
        require(found == expected, f"plane {z} has another digest than its slab trailer says")
    require(hashlib.sha256(b"".join(digests)).digest() == file.voxel_digest,
            "the voxels have another digest than the trailer says")
    for part in file.parts:
        if part.tag == THUMBNAIL:
            require(file.part(part) == thumbnail_of(header, levels.__getitem__),
                    "the thumbnail is not that of these voxels")


def _section(body: bytes, section: Section) -> bytes:
    begin = section.offset - HEADER_LENGTH
    return body[begin : begin + section.length]


def _verify_slabs(file: OctavoFile, body: bytes) -> None:
    """Slab trailers against the index and the bytes of their slabs."""
    bricks_x, bricks_y, _ = file.header.bricks(0)
    layer_bricks = bricks_x * bricks_y
    lengths = [brick.pieces[0][1] for brick in file.bricks(0)]
    begin = 0
    for slab, (offset, length) in enumerate(file.root.slab_trailers):
        trailer = file.slab_trailer(slab)
        of_slab = lengths[slab * layer_bricks : (slab + 1) * layer_bricks]
        require(trailer.piece_lengths == of_slab, "a slab trailer contradicts the index")
        end = offset - HEADER_LENGTH
        require(crc32c(body[begin:end]) == trailer.slab_crc, "the checksum of a slab is wrong")
        begin = end + length


def _verify_tiers(file: OctavoFile, levels: list[np.ndarray]) -> None:
    """The samples that the bricks of a tier determine are those of the next tier."""
    for tier in range(1, file.header.tier_count):
        level = file.header.tier_levels(tier).start
        require(file.parents(tier - 1).tobytes() == levels[level].tobytes(),
                f"level {level} is not made of the bricks below")


def _verify_ranges(file: OctavoFile, levels: list[np.ndarray]) -> None:
    """The range of every brick is that of its voxels; in lossy files, and of exact floats, bounds
    of them."""
    header = file.header
    for tier in range(header.tier_count):
        samples = levels[header.tier_levels(tier).start]
        sides = [1 << shift for shift in header.brick_shifts(tier)]
        bricks_x, bricks_y, layers = header.bricks(tier)
        places = [(i, j, k) for k in range(layers) for i, j in brick_order(bricks_x, bricks_y)]
        for (i, j, k), brick in zip(places, file.bricks(tier), strict=True):
            x, y, z = (n * side for n, side in zip((i, j, k), sides))
            box = samples[z : z + sides[2], y : y + sides[1], x : x + sides[0]]
            low, high = (file.voxels_of(np.array(end)) for end in (brick.smallest, brick.largest))
            box = box[np.isfinite(box)]
            if header.is_exact or header.has_errors(tier):
                require(((low <= box) & (box <= high)).all(), "a voxel is out of its range")
            else:
                require(low == box.min() and box.max() == high,
                        "the range of a brick is not that of its voxels")
