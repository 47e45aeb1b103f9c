"""What ends a slab: docs/format.md, section 5."""

from dataclasses import dataclass

from .byte_cursor import ByteCursor, crc32c
from .errors import require

_MAGIC = b"8slb"


@dataclass(frozen=True)
class SlabTrailer:
    """piece_lengths in brick order; plane_digests by z; slab_crc of what stands before it."""

    build_id: int
    slab: int
    model: int
    piece_lengths: list[int]
    plane_digests: list[bytes]
    slab_crc: int


def parse_slab_trailer(data: bytes, brick_count: int, plane_count: int) -> SlabTrailer:
    """Raises OctavoError "corrupt"."""
    cursor = ByteCursor(data, "slab trailer")
    require(cursor.take(4) == _MAGIC, "a slab trailer is none")
    build_id, = cursor.unpack("Q")
    slab, model = cursor.varint(), cursor.varint()
    piece_lengths = [cursor.varint() for _ in range(brick_count)]
    plane_digests = [cursor.take(32) for _ in range(plane_count)]
    slab_crc, length, crc = cursor.unpack("3I")
    cursor.end()
    require(length == len(data), "a slab trailer states another length")
    require(crc == crc32c(data[:-4]), "the checksum of a slab trailer is wrong")
    return SlabTrailer(build_id, slab, model, piece_lengths, plane_digests, slab_crc)
