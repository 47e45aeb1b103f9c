#!/usr/bin/env python3
"""Files whose metadata are no metadata: every verb reads their voxels all the same.

usage: metadata_test.py OCTAVO [unittest arguments]

Everything is generated; files are given other metadata with fitting checksums.
"""

import json
import struct
import sys

import cli_test

SIZE = (16, 16, 16)


def crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return table


TABLE = crc_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = TABLE[(crc ^ byte) & 255] ^ (crc >> 8)
    return crc ^ 0xFFFFFFFF


def with_metadata(data, text):
    """The file with other metadata: docs/format.md, sections 2, 7 and 8."""
    header, trailer = bytearray(data[:512]), bytearray(data[-64:])
    begin, length = struct.unpack_from("<QQ", header, 232)
    root, = struct.unpack_from("<Q", header, 280)
    growth = len(text) - length
    struct.pack_into("<QQI", header, 232, begin, len(text), crc32c(text))
    struct.pack_into("<Q", header, 280, root + growth)
    struct.pack_into("<Q", header, 224, len(data) + growth)
    struct.pack_into("<I", header, 508, crc32c(header[:508]))
    between = data[512:begin] + text + data[begin + length:-64]
    trailer[8:24] = header[216:232]
    struct.pack_into("<II", trailer, 24, crc32c(header), crc32c(between))
    trailer[24:28] = header[508:512]
    struct.pack_into("<I", trailer, 60, crc32c(trailer[:60]))
    return bytes(header) + between + bytes(trailer)


SIZE_OF_TEXT = 100_000
# Every verb is given these.
DEEP = {
    "nested lists": b"[" * (SIZE_OF_TEXT // 2) + b"]" * (SIZE_OF_TEXT // 2),
    "a nested member": b'{"x":' + b"[" * (SIZE_OF_TEXT // 2) + b"]" * (SIZE_OF_TEXT // 2) + b"}",
}
# And some verbs these as well.
OTHERS = {
    "nested objects": b'{"a":' * (SIZE_OF_TEXT // 6) + b"1" + b"}" * (SIZE_OF_TEXT // 6),
    "open brackets": b"[" * SIZE_OF_TEXT,
    "many values": b'{"labels":[' + b"1," * SIZE_OF_TEXT + b"1]}",
    "a long string": b'{"unit":"' + b"a" * SIZE_OF_TEXT + b'"}',
    "no UTF-8": b'{"unit":"\xff\xfe"}',
    "no object": b"null",
    "nothing": b"",
}

# What every verb is given; "out" is new each time.
OF_GREY = [
    ["info"], ["info", "--metadata"], ["info", "--json"], ["verify"], ["probe", "--at", "1,1,1"],
    ["threshold", "--range", "20:", "-o", "out.8vo"], ["condense", "-o", "out.8vo", "--flat", "1"],
    ["transform", "--rotate", "z:90", "-o", "out.8vo"], ["build", "-o", "out.8vo"],
    ["build", "--isotropic", "--max-error", "1", "-o", "out.8vo"],
    ["export", "-o", "out.nrrd"], ["export", "-o", "out.nii.gz"], ["export", "-o", "out.mha"],
    ["export", "-o", "out.tif"], ["export", "-o", "out.raw"],
    ["extract", "--box", "0:4,0:4,0:4", "-o", "out.nrrd"],
    ["slice", "--axis", "z", "-o", "out.png"], ["codes", "--range", "20:"],
]
OF_LABELS = [
    ["info"], ["info", "--metadata"], ["info", "--json"], ["measure"], ["measure", "--csv"],
    ["measure", "--json"], ["touch"], ["codes", "--counts"], ["codes", "--list", "--json"],
    ["probe", "--at", "5,5,5"], ["components", "-o", "out.8vo"], ["shell", "-o", "out.8vo"],
    ["dilate", "--voxels", "1", "-o", "out.8vo"], ["fill-holes", "-o", "out.8vo"],
    ["transform", "--rotate", "z:90", "-o", "out.8vo"], ["build", "-o", "out.8vo"],
    ["export", "-o", "out.nii.gz"], ["slice", "--axis", "z", "-o", "out.png"],
    ["render", "--size", "32x32", "-o", "out.png"],
    ["combine", "l.8vo", "--union", "-o", "out.8vo"], ["compare", "l.8vo", "--labels"],
    ["measure", "--of", "v.8vo"], ["touch", "l.8vo"],
]


class Metadata(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = bytearray(x + y + z for z in range(16) for y in range(16) for x in range(16))
        (self.folder / "v.raw").write_bytes(voxels)
        (self.folder / "l.raw").write_bytes(bytes(voxel // 20 for voxel in voxels))
        layout = ",".join(map(str, SIZE)) + ",uint8"
        for name, options in [("v", ["--grey"]), ("l", ["--labels"])]:
            self.expect(0, "build", f"{name}.raw", "--raw", layout, "--spacing", "1,1,2", *options,
                        "-o", f"{name}.8vo", "-q")

    def give(self, name, text):
        """bad.8vo: the file `name` with other metadata."""
        whole = (self.folder / name).read_bytes()
        (self.folder / "bad.8vo").write_bytes(with_metadata(whole, text))

    def expect_read(self, what, arguments):
        verb, *options = arguments
        result = self.octavo(verb, "bad.8vo", *options, "-f", "--progress", "none")
        with self.subTest(metadata=what, verb=verb, options=options):
            self.assertEqual(result.returncode, 0, result.stderr[:200])
        if result.returncode == 0 and "out.8vo" in options:
            self.expect(0, "info", "out.8vo")
        for out in self.folder.glob("out.*"):
            out.unlink()

    def test_other_metadata_make_a_sound_file(self):
        text = b'{"unit":"HU","labels":{"1":{"name":"a"}}}'
        self.give("v.8vo", text)
        self.expect(0, "verify", "bad.8vo")
        self.assertEqual(self.info("bad.8vo")["metadata"], json.loads(text))

    def test_nested_brackets_stop_no_verb_that_reads_grey_values(self):
        for what, text in DEEP.items():
            self.give("v.8vo", text)
            for arguments in OF_GREY:
                self.expect_read(what, arguments)

    def test_nested_brackets_stop_no_verb_that_reads_labels(self):
        for what, text in DEEP.items():
            self.give("l.8vo", text)
            for arguments in OF_LABELS:
                self.expect_read(what, arguments)

    def test_no_other_text_stops_a_verb(self):
        for what, text in OTHERS.items():
            self.give("v.8vo", text)
            for arguments in OF_GREY[:3] + [["threshold", "--range", "20:", "-o", "out.8vo"],
                                            ["build", "--max-error", "1", "-o", "out.8vo"]]:
                self.expect_read(what, arguments)

    def test_what_is_no_metadata_takes_no_names(self):
        (self.folder / "names.txt").write_text("1 a\n")
        self.give("l.8vo", DEEP["nested lists"])
        self.expect_error(4, ["metadata cannot be read", "no names"], "build", "bad.8vo",
                          "--labels", "--label-names", "names.txt", "-o", "out.8vo")
        self.assertFalse((self.folder / "out.8vo").exists())


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
