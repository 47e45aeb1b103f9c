#!/usr/bin/env python3
"""Asks how far voxels are from a mask, as a user does.

usage: distance_test.py OCTAVO [unittest arguments]

What is expected comes from a search through every voxel, or from scipy where that is installed.
"""

import array
import itertools
import json
import math
import random
import sys
import unittest

import cli_test

try:
    import numpy
    import scipy.ndimage
except ImportError:
    scipy = None

SIZE = (11, 9, 8)
SPACING = (0.5, 0.75, 2.0)


def searched(inside, to_faces):
    """Distances of voxels, x fastest, by looking at all of the other class."""
    places = [(x, y, z) for z in range(SIZE[2]) for y in range(SIZE[1]) for x in range(SIZE[0])]
    distances = []
    for p, is_inside in zip(places, inside):
        nearest = math.inf
        for q, is_other in zip(places, inside):
            if is_inside == is_other:
                continue
            steps = [abs(a - b) for a, b in zip(p, q)]
            if to_faces:
                steps = [max(0, step - 0.5) for step in steps]
            nearest = min(nearest, sum((s * mm) ** 2 for s, mm in zip(steps, SPACING)))
        distances.append(math.sqrt(nearest) * (-1 if is_inside else 1))
    return distances


class Distance(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        numbers = random.Random(25)
        self.inside = [int(numbers.random() < 0.1) for _ in itertools.product(*map(range, SIZE))]
        self.build("mask.8vo", bytes(self.inside), SIZE, SPACING)

    def build(self, name, voxels, size, spacing):
        (self.folder / "v.raw").write_bytes(voxels)
        self.expect(0, "build", "v.raw", "--raw", ",".join(map(str, size)) + ",uint8", "--spacing",
                    ",".join(map(str, spacing)), "--labels", "-o", name, "-q", "-f")

    def distances(self, mask, *arguments):
        self.expect(0, "distance", mask, "-o", "d.8vo", "-f", "-q", *arguments)
        self.expect(0, "export", "d.8vo", "--real", "-o", "d.raw", "-f", "-q")
        return array.array("f", (self.folder / "d.raw").read_bytes())

    def test_distances_are_those_of_a_search(self):
        for to in ("faces", "centers"):
            expected = searched(self.inside, to == "faces")
            for made, asked in zip(self.distances("mask.8vo", "--to", to), expected):
                self.assertAlmostEqual(made, asked, delta=1e-6 * abs(asked))
            for made, asked in zip(self.distances("mask.8vo", "--to", to, "--step", "0.01"),
                                   expected):
                self.assertAlmostEqual(made, asked, delta=0.005001)
            for made, asked in zip(self.distances("mask.8vo", "--to", to, "--max-mm", "1"),
                                   expected):
                self.assertAlmostEqual(made, max(-1, min(1, asked)), delta=1e-6)

    def test_json_says_what_was_written(self):
        result = json.loads(self.expect(0, "distance", "mask.8vo", "-o", "j.8vo", "--steps",
                                        "--json", "--progress", "none").stdout)
        expected = searched(self.inside, True)
        self.assertAlmostEqual(result["smallest_mm"], min(expected), places=5)
        self.assertAlmostEqual(result["largest_mm"], max(expected), places=5)
        self.assertEqual(math.log2(result["step_mm"]) % 1, 0)
        self.assertEqual(result["file_bytes"], (self.folder / "j.8vo").stat().st_size)

    def test_distances_within_a_bound_are_within_it_and_smaller(self):
        size = (64, 64, 40)
        self.build("ball.8vo", bytes(int((x - 30) ** 2 + (y - 33) ** 2 + (z - 20) ** 2 < 14 ** 2)
                                     for z in range(size[2]) for y in range(size[1])
                                     for x in range(size[0])), size, (0.5, 0.5, 0.5))
        exact = self.distances("ball.8vo")
        for bound, arguments in ((0.1, ()), (0.02, ()), (0.1, ("--step", "0.01"))):
            made = self.distances("ball.8vo", "--within", str(bound), *arguments)
            off = [abs(a - b) for a, b in zip(made, exact)]
            self.assertLessEqual(max(off), bound * (1 + 1e-5))
            self.assertGreater(max(off), 0)
        result = {}
        for name, arguments in (("all", ()), ("some", ("--within", "0.1"))):
            result[name] = json.loads(self.expect(0, "distance", "ball.8vo", "-o", "s.8vo", "-f",
                                                  *arguments, "--json", "--progress",
                                                  "none").stdout)
        self.assertLess(result["some"]["file_bytes"], 0.2 * result["all"]["file_bytes"])
        self.assertEqual(result["all"]["max_error_mm"], 0)
        self.assertLessEqual(result["some"]["max_error_mm"], 0.1)
        failed = self.expect(2, "distance", "ball.8vo", "-o", "no.8vo", "--within", "0.01",
                             "--step", "0.1")
        self.assertIn("--within", failed.stderr)
        self.assertFalse((self.folder / "no.8vo").exists())

    def test_masks_without_a_surface_are_rejected(self):
        count = math.prod(SIZE)
        for name, value in (("empty.8vo", b"\0"), ("full.8vo", b"\1")):
            self.build(name, value * count, SIZE, SPACING)
            failed = self.expect(2, "distance", name, "-o", "none.8vo")
            self.assertIn("no surface", failed.stderr)
            self.assertFalse((self.folder / "none.8vo").exists())
        failed = self.expect(2, "distance", "mask.8vo", "-o", "none.8vo", "--step", "1e-9")
        self.assertIn("--step", failed.stderr)
        self.expect(2, "distance", "mask.8vo", "-o", "none.8vo", "--max-mm", "0")

    @unittest.skipIf(scipy is None, "scipy is not installed")
    def test_distances_are_those_of_scipy(self):
        size, spacing = (40, 33, 27), (0.31, 0.47, 1.1)
        noise = numpy.random.default_rng(5).normal(size=size[::-1])
        mask = scipy.ndimage.gaussian_filter(noise, 2) > 0.02
        self.build("noise.8vo", mask.astype(numpy.uint8).tobytes(), size, spacing)
        made = numpy.array(self.distances("noise.8vo", "--to", "centers")).reshape(mask.shape)
        edt = scipy.ndimage.distance_transform_edt
        outside, inside = (edt(part, sampling=spacing[::-1]) for part in (~mask, mask))
        self.assertLess(abs(made - (outside - inside)).max(), 2e-6)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
