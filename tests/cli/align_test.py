#!/usr/bin/env python3
"""Lays masks onto each other, as a user does.

usage: align_test.py OCTAVO [unittest arguments]
"""

import itertools
import json
import math
import sys
import unittest

import cli_test

SIZE = (48, 40, 36)
KEYS = ["moving", "fixed", "found", "why_none", "matrix_mm", "scale", "agreement",
        "agreement_around", "sharpness", "parting", "doubtful", "overlap", "mean_mm", "p95_mm",
        "max_mm", "iterations", "condition", "points", "has_lines", "level", "warnings"]


def is_in_bars(x, y, z):
    """Three bars of three lengths from a corner: nothing turns them onto themselves."""
    return ((4 <= x < 44 and 4 <= y < 12 and 4 <= z < 9)
            or (4 <= x < 10 and 4 <= y < 34 and 4 <= z < 14)
            or (4 <= x < 13 and 4 <= y < 11 and 4 <= z < 26))


class Align(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.build("bars.8vo", is_in_bars)

    def build(self, name, inside):
        places = itertools.product(*map(range, reversed(SIZE)))
        (self.folder / "v.raw").write_bytes(bytes(int(inside(x, y, z)) for z, y, x in places))
        self.expect(0, "build", "v.raw", "--raw", ",".join(map(str, SIZE)) + ",uint8",
                    "--spacing", "0.5", "--labels", "-o", name, "-q", "-f")

    def matrix(self):
        return [[float(number) for number in line.split()]
                for line in (self.folder / "pose.txt").read_text().splitlines()]

    def test_a_turned_mask_is_found_and_laid_back(self):
        # x, y, z of what moves are y, z, x of what stays, and 3 voxels up.
        self.build("turned.8vo", lambda x, y, z: is_in_bars(z, x, y - 3))
        made = json.loads(self.expect(0, "align", "turned.8vo", "bars.8vo", "-o", "pose.txt",
                                      "--json", "--progress", "none").stdout)
        self.assertEqual(list(made), KEYS)
        self.assertTrue(made["found"])
        self.assertIsNone(made["why_none"])
        self.assertGreater(made["agreement"], 0.6)
        matrix = self.matrix()
        self.assertEqual(matrix[3], [0, 0, 0, 1])
        for row, said in zip(matrix, made["matrix_mm"]):
            for number, other in zip(row, said):
                self.assertAlmostEqual(number, other, places=12)
        for row, expected in zip(matrix, ([0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, -1.5])):
            for number, asked in zip(row, expected):
                self.assertAlmostEqual(number, asked, delta=0.15)
        # The matrix is what transform takes.
        self.expect(0, "transform", "turned.8vo", "--affine", "pose.txt", "--grid-of", "bars.8vo",
                    "-o", "back.8vo", "-q")
        self.expect(0, "export", "back.8vo", "-o", "back.raw", "-q")
        self.expect(0, "export", "bars.8vo", "-o", "bars.raw", "-q")
        back, bars = ((self.folder / name).read_bytes() for name in ("back.raw", "bars.raw"))
        self.assertEqual(len(back), math.prod(SIZE))
        both = sum(a != 0 and b != 0 for a, b in zip(back, bars))
        self.assertGreater(both, 0.75 * sum(value != 0 for value in bars))

    def test_a_foreign_shape_has_no_pose(self):
        self.build("walls.8vo",
                   lambda x, y, z: x % 8 < 4 or (y % 10 < 4 and z % 9 < 4))
        self.build("ball.8vo",
                   lambda x, y, z: (x - 20) ** 2 + (y - 18) ** 2 + (z - 17) ** 2 <= 100)
        shown = self.expect(1, "align", "ball.8vo", "walls.8vo", "-o", "pose.txt")
        self.assertIn("no pose; ", shown.stdout)
        self.assertRegex(shown.stdout, r" is \d+\.\d %, not \d+ % or more")
        self.assertFalse((self.folder / "pose.txt").exists())
        made = json.loads(self.expect(1, "align", "ball.8vo", "walls.8vo", "-o", "pose.txt",
                                      "--json", "--progress", "none").stdout)
        self.assertFalse(made["found"])
        self.assertIsNone(made["matrix_mm"])
        self.assertIn("no pose; " + made["why_none"], shown.stdout)
        self.assertFalse((self.folder / "pose.txt").exists())

    def test_bad_masks_and_outputs_are_a_sentence(self):
        self.build("empty.8vo", lambda x, y, z: False)
        failed = self.expect(2, "align", "empty.8vo", "bars.8vo", "-o", "pose.txt")
        self.assertIn("no surface", failed.stderr)
        failed = self.expect(2, "align", "bars.8vo")
        self.assertIn("fixed", failed.stderr)
        (self.folder / "pose.txt").write_text("kept")
        self.expect(5, "align", "bars.8vo", "bars.8vo", "-o", "pose.txt")
        self.assertEqual((self.folder / "pose.txt").read_text(), "kept")


    def test_meshes_and_points_are_laid_as_well(self):
        self.expect(0, "surface", "bars.8vo", "-o", "bars.stl", "-q")
        made = json.loads(self.expect(0, "align", "bars.stl", "bars.8vo", "-o", "pose.txt",
                                      "--picture", "pose.png", "--json", "--progress",
                                      "none").stdout)
        self.assertTrue(made["found"])
        for number, asked in zip(itertools.chain(*self.matrix()),
                                 (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)):
            self.assertAlmostEqual(number, asked, delta=0.15)
        self.assertEqual((self.folder / "pose.png").read_bytes()[:4], b"\x89PNG")
        # Middles of faces, 40 mm up, with a row of names.
        steps = [(i, j, k) for i, j, k in itertools.product((-1, 0, 1), repeat=3)
                 if abs(i) + abs(j) + abs(k) == 1]
        rows = [f"{x / 2 + i / 4},{y / 2 + j / 4},{z / 2 + k / 4 + 40}"
                for x, y, z in itertools.product(*map(range, SIZE)) if is_in_bars(x, y, z)
                for i, j, k in steps if not is_in_bars(x + i, y + j, z + k)]
        (self.folder / "places.csv").write_text("\n".join(["x,y,z", *rows]) + "\n")
        self.expect(0, "align", "places.csv", "bars.8vo", "-o", "points.txt", "-q")
        words = (self.folder / "points.txt").read_text().split()
        for number, asked in zip(map(float, words), (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -40)):
            self.assertAlmostEqual(number, asked, delta=0.3)

    def test_rows_that_are_none_leave_nothing_behind(self):
        (self.folder / "bad.csv").write_text("1,2,3\n4,5\n")
        self.expect_error(7, ["bad.csv", "line 2"], "align", "bad.csv", "bars.8vo", "-o", "a.txt",
                          "--picture", "a.png")
        (self.folder / "few.csv").write_text("".join(f"{i},{i * i},3\n" for i in range(29)))
        self.expect_error(2, ["few.csv", "30"], "align", "few.csv", "bars.8vo")
        self.expect_error(2, [".csv"], "align", "bars.docx", "bars.8vo")
        self.expect_error(2, [".png"], "align", "bars.8vo", "bars.8vo", "--picture", "a.jpg")
        self.assertEqual([path.name for path in self.folder.glob("a.*")], [])


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
