"""Rows of PNG files of 8 bits.

Source: W3C, Portable Network Graphics Specification, section 9 (filtering).
"""


def unfiltered(kind, line, above, channels):
    """The bytes of a row.

    kind      its filter
    line      what the file has of it
    above     the row above; before the first one zeros
    channels  bytes of a pixel
    """
    if kind == 0:
        return line
    if kind == 2:
        return bytes((a + b) & 255 for a, b in zip(line, above))
    out = bytearray(channels)  # left of the first pixel
    if kind == 1:
        for value in line:
            out.append((value + out[-channels]) & 255)
    elif kind == 3:
        for value, up in zip(line, above):
            out.append((value + (out[-channels] + up) // 2) & 255)
    else:
        for value, up, corner in zip(line, above, bytes(channels) + above):
            left = out[-channels]
            to_left, to_up = abs(up - corner), abs(left - corner)
            to_corner = abs(left + up - 2 * corner)
            if to_left <= to_up and to_left <= to_corner:
                guess = left
            else:
                guess = up if to_up <= to_corner else corner
            out.append((value + guess) & 255)
    return bytes(out[channels:])
