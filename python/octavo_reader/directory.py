"""Parts and the directory that lists them: docs/format.md, section 7."""

from dataclasses import dataclass

from .byte_cursor import ByteCursor
from .errors import require, require_known
from .header import Header, Section

THUMBNAIL = "thmb"
_REQUIRED = 1
_KNOWN_FLAGS = 7
_THUMBNAIL_FLAGS = 2
_ENTRY = "4sIQQII"
_ENTRY_LENGTH = 32
_THUMBNAIL_LIMIT = 256 << 10


@dataclass(frozen=True)
class Part:
    """A run of bytes with a tag.

    flags  bit 0: required; bit 1: it follows from the voxels, bit 2: from something else
    """

    tag: str
    flags: int
    section: Section


def parse_directory(data: bytes, header: Header) -> list[Part]:
    """The parts of a file, in their order.

    Raises  OctavoError "corrupt"; "unsupported_version" for what this reader would need to know
    """
    require(len(data) % _ENTRY_LENGTH == 0, "the directory ends inside an entry")
    cursor = ByteCursor(data, "directory")
    entries = [cursor.unpack(_ENTRY) for _ in range(len(data) // _ENTRY_LENGTH)]
    for name, flags, _, _, _, zero in entries:
        require_known(flags & ~_KNOWN_FLAGS == 0 and zero == 0, f"a flag of part {name}")
        require_known(flags & _REQUIRED == 0 or name == THUMBNAIL.encode(), f"part {name}")
    parts = []
    at = header.pages.offset + header.pages.length
    for name, flags, offset, length, crc, _ in entries:
        require(name.isalnum() and name.isascii(), "a tag is no four letters")
        tag = name.decode()
        require(offset == at and length <= header.directory.offset - at,
                "the parts do not follow each other")
        at += length
        if tag == THUMBNAIL:
            require(all(part.tag != THUMBNAIL for part in parts), "there are two thumbnails")
            require(length <= _THUMBNAIL_LIMIT, "the thumbnail is too long")
            require(flags == _THUMBNAIL_FLAGS, "the thumbnail has other flags")
        parts.append(Part(tag, flags, Section(offset, length, crc)))
    require(at == header.directory.offset, "the parts do not reach the directory")
    return parts
