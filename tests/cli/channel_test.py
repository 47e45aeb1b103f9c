#!/usr/bin/env python3
"""Builds from colors, series in time and numbered files that skip, as a user does.

usage: channel_test.py OCTAVO [unittest arguments]

The sources are generated: PNG pictures (read by the worker process) and NIfTI files.
"""

import os
import struct
import sys
import unittest
import zlib

import cli_test

COLUMNS, ROWS = 6, 5


def png(colors, before=(), behind=()):
    """A picture whose pixels all have these values; 1 grey, 2 with alpha, 3 RGB, 4 with alpha.

    before, behind: (name, bytes) of chunks on either side of the picture's.
    """
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[len(colors)]
    row = b"\0" + bytes(colors) * COLUMNS
    parts = [(b"IHDR", struct.pack(">IIBBBBB", COLUMNS, ROWS, 8, kind, 0, 0, 0)),
             *before, (b"IDAT", zlib.compress(row * ROWS)), *behind, (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts)


def nifti(times):
    """4 x 3 x 2 bytes at each time, all of the value 10 + time."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<5h", header, 40, 4, 4, 3, 2, times)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<4f", header, 76, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 2
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
    header[344:348] = b"n+1\0"
    return bytes(header) + b"".join(bytes([10 + t]) * 24 for t in range(times))


class Components(cli_test.InFolder):
    def build(self, source, *options):
        return self.expect(0, "build", source, "-o", "a.8vo", "-f", "--progress", "none", *options)

    def refuse(self, code, words, source, *options):
        before = self.files()
        self.expect_error(code, words, "build", source, "-o", "rejected.8vo", *options)
        self.assertEqual(self.files(), before)

    def value(self):
        result = self.expect(0, "probe", "a.8vo", "--at", "1,1,1", "--json")
        return cli_test.json.loads(result.stdout)["points"][0]["stored"]

    def test_a_color_is_taken_by_name_or_number_and_told(self):
        (self.folder / "rgb").mkdir()
        for z in range(3):
            (self.folder / "rgb" / f"{z}.png").write_bytes(png([10 + z, 20 + z, 30 + z]))
        self.refuse(7, ["rgb", "3 channels (red, green, blue)", "--channel"], "rgb")
        for name, number, value in [("red", "0", 11), ("green", "1", 21), ("Blue", "2", 31)]:
            for channel in (name, number):
                self.build("rgb", "--channel", channel)
                self.assertEqual(self.value(), value)
                chosen = self.info("a.8vo")["metadata"]["chosen"]["channel"]
                self.assertEqual(chosen,
                                 {"index": int(number), "count": 3, "name": name.lower()})
            self.assertIn(f"channel {name.lower()} of 3", self.expect(0, "info", "a.8vo").stdout)
        self.expect(0, "verify", "a.8vo", "--against", "rgb", "--channel", "blue")
        self.expect(1, "verify", "a.8vo", "--against", "rgb", "--channel", "red")
        self.refuse(2, ["channel 3 is not there", "give --channel", "0 to 2"],
                    "rgb", "--channel", "3")
        self.refuse(2, ["channel pink", "red, green, blue", "give --channel"],
                    "rgb", "--channel", "pink")

    def test_a_time_is_taken_by_number_and_told(self):
        (self.folder / "series.nii").write_bytes(nifti(3))
        self.refuse(7, ["series.nii", "3 points in time", "--time"], "series.nii")
        for time in range(3):
            self.build("series.nii", "--time", time)
            self.assertEqual(self.value(), 10 + time)
            self.assertEqual(self.info("a.8vo")["metadata"]["chosen"]["time"],
                             {"index": time, "count": 3})
            self.assertIn(f"time {time} of 3", self.expect(0, "info", "a.8vo").stdout)
        self.refuse(2, ["time 3 is not there", "give --time with 0 to 2"],
                    "series.nii", "--time", "3")
        self.refuse(2, ["--time"], "series.nii", "--time", "first")

    def test_options_without_a_choice_are_rejected(self):
        (self.folder / "one.nii").write_bytes(nifti(1))
        self.build("one.nii")
        self.assertNotIn("chosen", self.info("a.8vo")["metadata"])
        self.build("one.nii", "--channel", "0", "--time", "0", "--spacing", "2")
        self.assertIn("2 x 2 x 2 mm (given by --spacing)", self.expect(0, "info", "a.8vo").stdout)
        self.refuse(2, ["channel 1 is not there", "1 channel", "leave out --channel"],
                    "one.nii", "--channel", "1")
        self.refuse(2, ["one of several segments is chosen in DICOM series alone",
                        "leave out --segment"],
                    "one.nii", "--segment", "1")
        self.refuse(2, ["stacks of numbered files", "TIFF, PNG, raw", "leave out --on-gap"],
                    "one.nii", "--on-gap", "ignore")

    def test_numbers_that_skip_are_rejected_or_ignored_and_told(self):
        (self.folder / "stack").mkdir()
        for z in [1, 2, 4, 5]:
            (self.folder / "stack" / f"slice {z}.png").write_bytes(png([z]))
        self.refuse(7, ["slice 2.png", "slice 4.png", "1 file is missing", "--on-gap ignore"],
                    "stack")
        self.refuse(2, ["missing planes are made from their neighbors in DICOM series alone; "
                         "leave out --on-gap"],
                    "stack", "--on-gap", "fill")
        told = self.build("stack", "--on-gap", "ignore")
        self.assertIn("warning: slice 2.png is followed by slice 4.png", told.stderr)
        self.assertEqual(self.info("a.8vo")["size"], [COLUMNS, ROWS, 4])
        self.assertIn("1 gap in the numbers of its files passed over",
                      self.expect(0, "info", "a.8vo").stdout)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
