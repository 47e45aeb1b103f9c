#!/usr/bin/env python3
"""Builds from DICOM series that are no even stack, as a user does.

usage: dicom_series_test.py OCTAVO [unittest arguments]

The series are generated: 8 x 6 voxels of int16, no package is needed.
"""

import math
import os
import struct
import sys
import unittest

import cli_test

COLUMNS, ROWS = 8, 6


def element(group, number, vr, value):
    if isinstance(value, str):
        value = value.encode()
    value += (b"\0" if vr == "UI" else b" ") * (len(value) % 2)
    head = struct.pack("<HH", group, number) + vr.encode()
    length = "<xxI" if vr == "OW" else "<H"
    return head + struct.pack(length, len(value)) + value


def dicom(position_mm, voxel, series="1.2.3"):
    """A slice whose voxels all are `voxel`."""
    numbers = {0x02: 1, 0x10: ROWS, 0x11: COLUMNS, 0x100: 16, 0x101: 16, 0x102: 15, 0x103: 1}
    texts = [(8, 0x60, "CS", "CT"), (8, 0x103E, "LO", "Head " + series), (0x20, 0xE, "UI", series),
             (0x20, 0x32, "DS", "\\".join(f"{mm:.6f}" for mm in position_mm)),
             (0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0"), (0x28, 0x04, "CS", "MONOCHROME2"),
             (0x28, 0x30, "DS", "0.5\\0.5")]
    data_set = b"".join(element(*text) for text in texts)
    for number, value in numbers.items():
        data_set += element(0x28, number, "US", struct.pack("<H", value))
    data_set += element(0x7FE0, 0x10, "OW", struct.pack("<h", voxel) * (COLUMNS * ROWS))
    meta = element(2, 0x10, "UI", "1.2.840.10008.1.2.1")
    group = element(2, 0, "UL", struct.pack("<I", len(meta)))
    return b"\0" * 128 + b"DICM" + group + meta + data_set


class DicomSeries(cli_test.InFolder):
    def write(self, name, z_mm, y_mm=0.0, voxel=None, series="1.2.3"):
        folder = self.folder / "scan"
        folder.mkdir(exist_ok=True)
        value = round(10 * z_mm) if voxel is None else voxel
        (folder / name).write_bytes(dicom((0, y_mm, z_mm), value, series))

    def build(self, *options, output="a.8vo"):
        return self.expect(0, "build", "scan", "-o", output, "--progress", "none", *options)

    def refuse(self, words, *options, code=7):
        before = self.files()
        self.expect_error(code, words, "build", "scan", "-o", "rejected.8vo", *options)
        self.assertEqual(self.files(), before)

    def value_of(self, name, z):
        result = self.expect(0, "probe", name, "--at", f"4,3,{z}", "--json")
        return cli_test.json.loads(result.stdout)["points"][0]["stored"]

    def test_a_missing_slice_is_rejected_or_filled_and_recorded(self):
        for z in [0, 2, 6, 8]:
            self.write(f"s{z}.dcm", z)
        self.refuse(["s2.dcm", "s6.dcm", "4 mm", "2 mm", "1 slice is missing", "--on-gap fill"])
        told = self.build("--on-gap", "fill")
        self.assertIn("warning: 1 missing plane interpolated", told.stderr)
        self.assertEqual([self.value_of("a.8vo", z) for z in range(5)], [0, 20, 40, 60, 80])
        info = self.info("a.8vo")
        self.assertEqual(info["metadata"]["prepared"]["gaps"]["made_planes"], [[2, 2]])
        self.assertEqual(info["spacing_mm"][2], 2)
        shown = self.expect(0, "info", "a.8vo", "--metadata").stdout
        self.assertIn("1 plane interpolated between slices", shown)
        self.assertIn("lossless from its prepared planes", shown)
        self.assertIn('"prepared"', shown)
        self.expect(0, "verify", "a.8vo", "--against", "scan", "--on-gap", "fill")
        self.expect(7, "verify", "a.8vo", "--against", "scan")

    def test_uneven_slices_are_resampled_only_when_asked(self):
        for z in [0, 2, 4, 5, 8]:
            self.write(f"s{z}.dcm", z)
        self.write("s11.dcm", 11.4)
        self.refuse(["uneven", "--on-gap resample"])
        self.refuse(["no even grid", "--on-gap resample"], "--on-gap", "fill")
        self.refuse(["--on-gap"], "--on-gap", "guess", code=2)
        told = self.build("--on-gap", "resample")
        self.assertIn("resampled to a step of 2 mm", told.stderr)
        self.assertEqual([self.value_of("a.8vo", z) for z in range(6)], [0, 20, 40, 60, 80, 100])

    def test_copies_are_left_out_only_when_asked_and_equal(self):
        for name, z in [("a", 0), ("b", 2), ("c", 2), ("d", 4)]:
            self.write(name, z)
        self.refuse(["b and c", "same position", "--drop-duplicates"])
        told = self.build("--drop-duplicates")
        self.assertIn("1 copy of a slice left out", told.stderr)
        self.assertEqual(self.info("a.8vo")["size"], [COLUMNS, ROWS, 3])
        self.assertIn("lossless\n", self.expect(0, "info", "a.8vo").stdout)
        self.write("c", 2, voxel=7)
        self.refuse(["b and c", "voxels differ"], "--drop-duplicates")

    def test_a_tilt_is_rejected_with_its_angle_or_removed(self):
        for z in [0, 2, 4]:
            self.write(f"s{z}.dcm", z, y_mm=z * math.tan(math.radians(18.5)))
        self.refuse(["18.5 degrees", "s0.dcm", "s4.dcm", "--untilt"])
        told = self.build("--untilt")
        self.assertIn("gantry tilt of 18.5 degrees removed", told.stderr)
        info = self.info("a.8vo")
        self.assertEqual(info["size"], [COLUMNS, ROWS + 3, 3])
        self.assertAlmostEqual(info["metadata"]["prepared"]["tilt"]["angle_degrees"], 18.5, 3)
        self.assertEqual(self.value_of("a.8vo", 2), 40)
        self.assertIn("gantry tilt of 18.5 degrees removed",
                      self.expect(0, "info", "a.8vo").stdout)

    def test_several_series_are_listed_with_number_size_and_description(self):
        for z in [0, 2, 4]:
            self.write(f"s{z}", z)
        self.write("other", 0, series="4.5.6")
        self.refuse(["2 series", "--series", "1.2.3: 3 slices of 8 x 6, CT, Head 1.2.3",
                     "4.5.6: 1 slice of 8 x 6, CT, Head 4.5.6"])
        self.build("--series", "1.2.3")
        self.assertEqual(self.info("a.8vo")["size"][2], 3)

    def test_a_lost_slice_is_named_wherever_it_stood(self):
        for z in range(4):
            self.write(f"IM{z}", 2 * z)
        lost = self.folder / "scan" / "IM3"
        whole = lost.read_bytes()
        lost.write_bytes(whole[:whole.rindex(b"\xe0\x7f\x10\0")])
        self.refuse(["IM3", "a picture without pixel data", "copy it again"])
        lost.write_bytes(whole[:whole.index(b"\x08\0\x60\0")])
        self.refuse(["IM3", "nothing stands behind", "copy it again"])
        lost.write_bytes(b"")
        self.refuse(["IM3", "the file is empty", "copy it again"])
        lost.write_bytes(bytes(700))
        told = self.build()
        self.assertIn("warning: 1 file that is not DICOM left out: IM3", told.stderr)
        lost.rename(lost.with_name("notes.txt"))
        self.assertNotIn("warning", self.build("-f").stderr)

    def test_the_options_are_rejected_for_other_sources(self):
        layout = self.random_raw("v.raw", (10, 9, 8))
        for options in [("--untilt",), ("--drop-duplicates",), ("--on-gap", "fill")]:
            with self.subTest(options):
                self.expect_error(2, ["v.raw", "DICOM series alone; leave out " + options[0]],
                                  "build", "v.raw",
                                  "--raw", layout, "--spacing", "1", "-o", "x.8vo", *options)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
