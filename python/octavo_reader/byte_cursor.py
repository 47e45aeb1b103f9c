"""Numbers and checksums of docs/format.md, section 1."""

import struct

import numpy as np

from .errors import OctavoError, require


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


_CRC_TABLE = _crc_table()


def crc32c(data: bytes, before: bytes = b"") -> int:
    """CRC-32C of `before` followed by `data`."""
    crc = 0xFFFFFFFF
    for part in (before, data):
        for byte in part:
            crc = _CRC_TABLE[(crc ^ byte) & 255] ^ (crc >> 8)
    return crc ^ 0xFFFFFFFF


class ByteCursor:
    """Reads numbers from bytes, first to last.

    Every read raises OctavoError "corrupt" when it would pass the end; `name` says of what.
    """

    def __init__(self, data: bytes, name: str) -> None:
        self._data = data
        self._name = name
        self.at = 0

    def take(self, count: int) -> bytes:
        """The next `count` bytes."""
        require(0 <= count <= len(self._data) - self.at, f"{self._name} ends too early")
        self.at += count
        return self._data[self.at - count : self.at]

    def unpack(self, layout: str) -> tuple:
        """Numbers of fixed size; `layout` as in struct, little-endian."""
        return struct.unpack("<" + layout, self.take(struct.calcsize("<" + layout)))

    def u8(self) -> int:
        return self.take(1)[0]

    def u32(self) -> int:
        return self.unpack("I")[0]

    def varint(self) -> int:
        """An unsigned number of at most 64 bits in the fewest bytes."""
        value = 0
        for shift in range(0, 70, 7):
            byte = self.u8()
            value |= (byte & 127) << shift
            if byte < 128:
                require(value < 1 << 64, f"{self._name}: a number has more than 64 bits")
                require(byte > 0 or shift == 0, f"{self._name}: a number has a needless byte")
                return value
        raise OctavoError("corrupt", f"{self._name}: a number has more than 64 bits")

    def zigzag(self) -> int:
        """A signed number."""
        value = self.varint()
        return value >> 1 if value & 1 == 0 else -(value >> 1) - 1

    def rest(self) -> bytes:
        """All bytes that are left."""
        return self.take(len(self._data) - self.at)

    def end(self) -> None:
        """Raises OctavoError "corrupt" unless every byte was taken."""
        require(self.at == len(self._data), f"{self._name} has bytes behind its end")


def unpack_bits(data: bytes, width: int, count: int, name: str) -> np.ndarray:
    """`count` fields of `width` bits (at most 32), lowest bit first, as int64 of shape (count,).

    Raises OctavoError "corrupt" when `data` has another length than these take.
    """
    require(len(data) == (count * width + 7) // 8, f"{name} has a wrong length")
    bits = np.unpackbits(np.frombuffer(data, np.uint8), bitorder="little").astype(np.int64)
    fields = bits[: count * width].reshape(count, width)
    return (fields << np.arange(width, dtype=np.int64)).sum(axis=1, dtype=np.int64)
