#!/usr/bin/env python3
"""Proves that numbers of 64 bits, NumPy's default, are read where they fit, and else rejected.

usage: wide_numbers_test.py OCTAVO [unittest arguments]

Everything is generated: raw voxels of int64, uint64 and float64.
"""

import json
import struct
import sys

import cli_test

SIZE = (9, 8, 7)
COUNT = SIZE[0] * SIZE[1] * SIZE[2]
LETTERS = {"int64": "q", "uint64": "Q", "float64": "d", "int32": "i", "uint32": "I", "float32": "f"}


class WideNumbers(cli_test.InFolder):
    def build(self, code, stored, numbers, *options):
        """Builds v.8vo of `numbers`, x fastest; returns what the program did."""
        (self.folder / "v.raw").write_bytes(struct.pack(f"<{COUNT}{LETTERS[stored]}", *numbers))
        self.raw = ["--raw", ",".join(map(str, SIZE)) + "," + stored, "--spacing", "1"]
        return self.expect(code, "build", "v.raw", *self.raw, "-o", "v.8vo", "--force",
                           "--preset", "fast", "--progress", "none", *options)

    def expect_voxels(self, voxel, numbers):
        """v.8vo is lossless, of that type, and so says verify with the source beside it."""
        info = json.loads(self.expect(0, "info", "v.8vo", "--json").stdout)
        self.assertEqual(info["type"], voxel)
        self.expect(0, "export", "v.8vo", "-o", "back.raw", "--force", "--progress", "none")
        self.assertEqual((self.folder / "back.raw").read_bytes(),
                         struct.pack(f"<{COUNT}{LETTERS[voxel]}", *numbers))
        self.expect(0, "verify", "v.8vo", "--against", "v.raw", *self.raw, "--progress", "none")

    def test_values_that_fit_are_kept(self):
        whole = [i % 37 - 9 for i in range(COUNT)]
        ids = [4294967295 - i for i in range(COUNT)]
        for stored, voxel, numbers in [
                ("int64", "int32", whole), ("int64", "uint32", ids), ("uint64", "uint32", ids),
                ("float64", "int32", whole), ("float64", "float32", [i / 4 for i in whole])]:
            said = self.build(0, stored, numbers)
            self.assertNotIn("warning", said.stderr)
            self.expect_voxels(voxel, numbers)

    def test_whole_numbers_of_float64_may_be_labels(self):
        self.build(0, "float64", [i % 5 for i in range(COUNT)], "--labels")
        self.assertEqual(json.loads(self.expect(0, "info", "v.8vo", "--json").stdout)["kind"],
                         "labels")

    def test_what_float32_rounds_brings_a_warning_that_strict_makes_an_error(self):
        tenths = [i % 37 * 0.1 for i in range(COUNT)]
        said = self.build(0, "float64", tenths)
        self.assertIn("rounded to float32", said.stderr)
        self.expect_voxels("float32", tenths)
        self.assertIn("--strict", self.build(7, "float64", tenths, "--strict").stderr)

    def test_the_first_value_that_does_not_fit_is_named(self):
        at = (4 * SIZE[1] + 3) * SIZE[0] + 2
        for stored, value in [("int64", 2**31), ("int64", -2**40), ("uint64", 2**32),
                              ("float64", 1e39)]:
            numbers = [-1 if stored == "int64" else 0.1 if stored == "float64" else 0] * COUNT
            numbers[at] = value
            said = self.build(7, stored, numbers)
            self.assertIn(f"{value:g}" if stored == "float64" else str(value), said.stderr)
            self.assertIn("x,y,z = 2,3,4", said.stderr)
            self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["v.raw"])

    def test_ranges_find_the_numbers_that_are_read(self):
        self.build(0, "float32", [i % 37 * 0.1 for i in range(COUNT)])
        for ends in ["0.7:", ":0.3", "0.1:0.1", "0.6:2.3"]:
            low, high = ends.split(":")
            expected = sum(round(float(low or 0) * 10) <= i % 37 <= round(float(high or 4) * 10)
                           for i in range(COUNT))
            self.expect(0, "threshold", "v.8vo", "--range", ends, "-o", "m.8vo", "--force")
            told = json.loads(self.expect(0, "measure", "m.8vo", "--json").stdout)
            self.assertEqual(told["objects"][0]["voxels"], expected, ends)
            codes = self.expect(0, "codes", "v.8vo", "--range", ends, "--json").stdout
            self.assertEqual(json.loads(codes)["voxels"], expected, ends)

    def test_what_probe_prints_is_found_by_a_range(self):
        numbers = [(-1) ** i / (i + 3) ** 1.5 for i in range(COUNT)]
        self.build(0, "float32", numbers)
        for x in range(3):
            told = self.expect(0, "probe", "v.8vo", "--at", f"{x},0,0").stdout
            value = told.split("value")[1].split()[0]
            self.expect(0, "threshold", "v.8vo", f"--range={value}:{value}", "-o", "m.8vo",
                        "--force")
            found = json.loads(self.expect(0, "measure", "m.8vo", "--json").stdout)["objects"]
            self.assertEqual([o["voxels"] for o in found], [1], value)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
