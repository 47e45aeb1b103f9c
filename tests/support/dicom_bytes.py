"""DICOM slices whose pictures are compressed by hand, as far as pictures can be."""

import struct

PLAIN = "1.2.840.10008.1.2.1"  # little-endian, with kinds of values
RUN_LENGTHS = "1.2.840.10008.1.2.5"
JPEG = "1.2.840.10008.1.2.4.50"
JPEG_LOSSLESS = "1.2.840.10008.1.2.4.70"
JPEG_LS = "1.2.840.10008.1.2.4.80"
JPEG_2000 = "1.2.840.10008.1.2.4.90"
CT_IMAGE = b"1.2.840.10008.5.1.4.1.1.2"

# How many samples a bit stands for in a run of JPEG-LS, by powers of two (ITU-T T.87, A.2.1).
RUN_POWERS = ([0] * 4 + [1] * 4 + [2] * 4 + [3] * 4 + [4, 4, 5, 5, 6, 6, 7, 7] +
              list(range(8, 16)))


def element(tag, kind, value):
    value += b"\0" * (len(value) & 1) if kind in ("UI", "OB") else b" " * (len(value) & 1)
    head = struct.pack("<HH", tag >> 16, tag & 0xffff) + kind.encode()
    return head + struct.pack("<xxI" if kind == "OB" else "<H", len(value)) + value


def compressed_slice(syntax, side, bits, picture):
    """A square slice of `bits` bits with one fragment."""
    return compressed_frames(syntax, side, bits, 1, [picture])


def compressed_frames(syntax, side, bits, frames, fragments):
    """Square frames of `bits` bits; more than one have no positions."""
    meta = element(0x00020010, "UI", syntax.encode())
    data = b"".join([
        element(0x00080016, "UI", CT_IMAGE), element(0x00080018, "UI", b"1.2.3"),
        element(0x00180050, "DS", b"1"), element(0x0020000d, "UI", b"1.2.4"),
        element(0x0020000e, "UI", b"1.2.5"), element(0x00200032, "DS", b"0\\0\\0"),
        element(0x00200037, "DS", b"1\\0\\0\\0\\1\\0")])
    for tag, value in ((0x00280002, 1), (0x00280004, None), (0x00280008, frames),
                       (0x00280010, side), (0x00280011, side), (0x00280030, None),
                       (0x00280100, bits), (0x00280101, bits), (0x00280102, bits - 1),
                       (0x00280103, 0)):
        if tag == 0x00280004:
            data += element(tag, "CS", b"MONOCHROME2")
        elif tag == 0x00280008:
            data += element(tag, "IS", str(value).encode())
        elif tag == 0x00280030:
            data += element(tag, "DS", b"1\\1")
        else:
            data += element(tag, "US", struct.pack("<H", value))
    items = b"".join(struct.pack("<HHI", 0xfffe, 0xe000, len(one) + (len(one) & 1)) + one +
                     bytes(len(one) & 1) for one in fragments)
    return (bytes(128) + b"DICM" + element(0x00020000, "UL", struct.pack("<I", len(meta))) + meta +
            data + struct.pack("<HH2sHI", 0x7fe0, 0x0010, b"OB", 0, 0xffffffff) +
            struct.pack("<HHI", 0xfffe, 0xe000, 0) + items +
            struct.pack("<HHI", 0xfffe, 0xe0dd, 0))


def run_lengths(voxels):
    """Voxels of 16 bits, all 0, in runs of 128."""
    segment = b"\x81\0" * (voxels // 128)
    return struct.pack("<16I", 2, 64, 64 + len(segment), *[0] * 13) + 2 * segment


def jpeg_frame(mark, side, bits):
    return mark + struct.pack(">HBHHBBBB", 11, bits, side, side, 1, 1, 0x11, 0)


def jpeg(side, blocks):
    """Blocks of 64 voxels of 8 bits, all alike: two codes of a bit each."""
    codes = b"".join(b"\xff\xc4" + struct.pack(">HB", 20, table) + bytes([1] + [0] * 16)
                     for table in (0x00, 0x10))
    return (b"\xff\xd8\xff\xdb" + struct.pack(">HB", 67, 0) + b"\1" * 64 +
            jpeg_frame(b"\xff\xc0", side, 8) + codes +
            b"\xff\xda" + struct.pack(">HBBBBBB", 8, 1, 1, 0, 0, 63, 0) +
            bytes((blocks + 3) // 4) + b"\xff\xd9")


def jpeg_ls(side, rows):
    """The first rows of voxels of 16 bits, all 0: runs alone, each of them a bit that is set."""
    bits, power = 0, 0
    for _ in range(rows):
        left = side
        while left > 0:
            bits += 1
            if left >= 1 << RUN_POWERS[power]:
                left -= 1 << RUN_POWERS[power]
                power = min(power + 1, 31)
            else:
                left = 0
    # Seven bits stand in the byte behind one of eight that are set.
    pairs, rest = divmod(bits, 15)
    last = bytes([0xff, 0x3f80 >> rest - 8 & 0x7f] if rest >= 8 else
                 [0xff00 >> rest & 0xff] if rest > 0 else [])
    return (b"\xff\xd8" + jpeg_frame(b"\xff\xf7", side, 16) +
            b"\xff\xda" + struct.pack(">HBBBBBB", 8, 1, 1, 0, 0, 0, 0) +
            b"\xff\x7f" * pairs + last + b"\xff\xd9")


def jpeg_2000(side, packets):
    """Voxels of 16 bits without a single coded block: a byte that is 0 for each packet."""
    size = struct.pack(">HIIIIIIIIHBBB", 0, side, side, 0, 0, side, side, 0, 0, 1, 15, 1, 1)
    coding = struct.pack(">BBHBBBBBB", 0, 0, 1, 0, 5, 4, 4, 0, 1)
    steps = b"\x40" + b"\x80" * 16
    head = b"".join(mark + struct.pack(">H", len(value) + 2) + value for mark, value in
                    ((b"\xff\x51", size), (b"\xff\x52", coding), (b"\xff\x5c", steps)))
    return (b"\xff\x4f" + head + b"\xff\x90" + struct.pack(">HHIBB", 10, 0, 14 + packets, 0, 1) +
            b"\xff\x93" + bytes(packets) + b"\xff\xd9")
