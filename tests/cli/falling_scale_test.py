#!/usr/bin/env python3
"""A scale that falls, the larger a stored value, the smaller the real one; and one of small steps.

usage: falling_scale_test.py OCTAVO

Volumes of the same real values, stored as they are, as 200 less them, and fourfold: whatever the
program shows or computes of real values must be the same.
"""

import json
import os
import random
import struct
import sys
import unittest

import cli_test

SIZE = (24, 20, 16)


def ball_values():
    """A bright ball with noise in a dim surrounding, x fastest."""
    noise = random.Random(5)
    values = []
    for z in range(SIZE[2]):
        for y in range(SIZE[1]):
            for x in range(SIZE[0]):
                square = (x - 11) ** 2 + (y - 9) ** 2 + (z - 8) ** 2
                values.append((160 if square < 40 else 20) + noise.randrange(30))
    return values


def nifti(stored, slope, intercept):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 4, 16)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, slope, intercept)
    header[123] = 2
    struct.pack_into("<h", header, 254, 1)
    struct.pack_into("<12f", header, 280, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
    header[344:348] = b"n+1\0"
    return bytes(header) + struct.pack(f"<{len(stored)}h", *stored)


class FallingScale(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        values = ball_values()
        for name, data in [("rising", nifti(values, 1, 0)),
                           ("fine", nifti([4 * v for v in values], 0.25, 0)),
                           ("falling", nifti([200 - v for v in values], -1, 200))]:
            (self.folder / f"{name}.nii").write_bytes(data)
            self.expect(0, "build", f"{name}.nii", "-o", f"{name}.8vo", "-q")
        self.expect(0, "threshold", "rising.8vo", "--range", "100:", "-o", "mask.8vo", "-q")

    def of_both(self, make):
        return [make(name) for name in ("rising", "falling")]

    def picture(self, name, *arguments):
        self.expect(0, "render", f"{name}.8vo", "--size", "90", *arguments, "-o", f"{name}.png",
                    "-f", "-q")
        return (self.folder / f"{name}.png").read_bytes()

    def test_pictures_are_the_same(self):
        for arguments in [["--mode", "transparency"],
                          ["--mode", "transparency", "--window", "500,900"],
                          ["--mode", "transparency", "--average"],
                          ["--mode", "surface", "--range", "100:"]]:
            with self.subTest(arguments):
                rising, falling = self.of_both(lambda name: self.picture(name, *arguments))
                self.assertEqual(rising, falling)

    def test_sums_are_those_of_real_values(self):
        for arguments in [[], ["--window", "500,900"]]:
            told = [json.loads(self.expect(0, "render", f"{name}.8vo", "--mode", "transparency",
                                           "--size", "90", *arguments, "-o", f"{name}.png", "-f",
                                           "--json").stdout)
                    for name in ("rising", "fine", "falling")]
            self.assertEqual(told[0]["window"], told[1]["window"])
            self.assertEqual(told[0]["window"], told[2]["window"])
        pictures = [(self.folder / f"{name}.png").read_bytes()
                    for name in ("rising", "fine", "falling")]
        self.assertEqual(pictures[0], pictures[1])
        self.assertEqual(pictures[0], pictures[2])

    def test_what_comes_from_outside_is_the_minimum_value(self):
        def moved(name):
            self.expect(0, "transform", f"{name}.8vo", "--shift", "3,0,0", "-o", f"{name}-m.8vo")
            rows = self.expect(0, "probe", f"{name}-m.8vo", "--at", "1,1,1", "--at", "9,9,9",
                               "--json").stdout
            return [point["real"] for point in json.loads(rows)["points"]]
        rising, falling = self.of_both(moved)
        self.assertEqual(rising, falling)
        self.assertEqual(rising[0], 20)

    def test_percentiles_count_from_the_minimum_real_value(self):
        shares = [word for share in "0 5 25 50 75 95 100".split()
                  for word in ("--percentile", share)]

        def percentiles(name):
            told = self.expect(0, "measure", "mask.8vo", "--of", f"{name}.8vo", "--json",
                               *shares).stdout
            return [one["percentiles"] for one in json.loads(told)["objects"]]
        rising, falling = self.of_both(percentiles)
        self.assertEqual(rising, falling)
        self.assertEqual(rising[0]["0"], 160)

    def test_the_minimum_is_named_first(self):
        self.assertIn("values       20 to 189", self.expect(0, "info", "rising.8vo").stdout)
        self.assertIn("values       20 to 189", self.expect(0, "info", "falling.8vo").stdout)

    def test_salvage_fills_with_the_minimum(self):
        whole = (self.folder / "falling.8vo").read_bytes()
        coded = json.loads(self.expect(0, "info", "falling.8vo", "--json").stdout)
        self.assertGreater(len(whole), 2000, coded)
        damaged = bytearray(whole)
        damaged[len(whole) // 2] ^= 0x55
        (self.folder / "falling.8vo").write_bytes(damaged)
        told = self.expect(0, "export", "falling.8vo", "--salvage", "-o", "x.nii").stderr
        self.assertIn("filled with its lowest value, 20", told)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
