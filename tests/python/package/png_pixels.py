"""Reads the PNG pictures of the program, with nothing but NumPy."""

import struct
import zlib

import numpy as np


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
            pixels[y] = _predicted(row[0], given, above)
    return np.broadcast_to(pixels, (height, width, 3)) if channels == 1 else pixels


def _predicted(kind, given, above):
    """A row of which each byte is given as what it adds to its neighbors left and above."""
    channels = given.shape[1]
    out = [0] * channels  # left of the first pixel
    aboves = above.ravel().tolist()
    for value, b, d in zip(given.ravel().tolist(), aboves, [0] * channels + aboves):
        a = out[-channels]
        if kind == 3:
            guess = (a + b) // 2
        else:
            to_a, to_b, to_d = abs(b - d), abs(a - d), abs(a + b - 2 * d)
            if to_a <= to_b and to_a <= to_d:
                guess = a
            else:
                guess = b if to_b <= to_d else d
        out.append((value + guess) & 255)
    return np.array(out[channels:], np.uint8).reshape(given.shape)
