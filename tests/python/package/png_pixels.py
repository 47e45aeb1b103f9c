"""Reads the PNG pictures of the program, with nothing but NumPy."""

import pathlib
import struct
import sys
import zlib

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from png_rows import unfiltered  # noqa: E402  pylint: disable=wrong-import-position


def pixels_of(path):
    """The picture of a PNG file, as `pixels_of_png`."""
    return pixels_of_png(path.read_bytes())


def pixels_of_png(held):
    """A PNG picture of 8 bits, grey or in colors, as an array [y, x, 3]."""
    at, data = 8, b""
    while at < len(held):
        length, kind = struct.unpack(">I4s", held[at:at + 8])
        body = held[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, _, color = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            data += body
        at += 12 + length
    channels = {0: 1, 2: 3}[color]
    rows = np.frombuffer(zlib.decompress(data), np.uint8).reshape(height, 1 + width * channels)
    pixels = np.zeros((height, width, channels), np.uint8)
    for y, row in enumerate(rows):
        given = row[1:].reshape(width, channels)
        above = pixels[y - 1] if y else np.zeros((width, channels), np.uint8)
        if row[0] == 0:
            pixels[y] = given
        elif row[0] == 1:
            pixels[y] = np.add.accumulate(given, 0, dtype=np.uint8)
        elif row[0] == 2:
            pixels[y] = given + above
        else:
            line = unfiltered(row[0], row[1:].tobytes(), above.tobytes(), channels)
            pixels[y] = np.frombuffer(line, np.uint8).reshape(width, channels)
    return np.broadcast_to(pixels, (height, width, 3)) if channels == 1 else pixels
