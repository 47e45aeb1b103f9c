#!/usr/bin/env python3
"""Moves, turns, scales and resamples volumes as a user does.

usage: transform_test.py OCTAVO [unittest arguments]

Everything is generated; expected voxels are computed here, one by one.
"""

import itertools
import json
import math
import os
import random
import struct
import sys

import cli_test

SIZE = (70, 9, 66)
SPACING = (0.5, 0.75, 1.0)


def voxel_order(size):
    """Positions (x, y, z), x fastest."""
    return [(x, y, z) for z, y, x in itertools.product(*(range(n) for n in reversed(size)))]


class Transforms(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        numbers = random.Random(4)
        self.grey = [x + 3 * y - 2 * z + numbers.randrange(9) for x, y, z in voxel_order(SIZE)]
        self.mask = [1 if (x - 30) ** 2 + (4 * y - 18) ** 2 + (z - 30) ** 2 < 400 else 0
                     for x, y, z in voxel_order(SIZE)]
        self.build("v.8vo", self.grey, "int16", "h")
        self.build("m.8vo", self.mask, "uint8", "B", "--labels")

    def build(self, name, voxels, type_name, code, *options, size=SIZE, spacing=SPACING):
        (self.folder / "in.raw").write_bytes(struct.pack(f"<{len(voxels)}{code}", *voxels))
        self.expect(0, "build", "in.raw", "--raw", ",".join(map(str, size)) + "," + type_name,
                    "--spacing", ",".join(map(str, spacing)), "--preset", "fast", "-o", name, "-q",
                    "-f", *options)

    def transform(self, name, *arguments):
        made = self.expect(0, "transform", name, "-o", "o.8vo", "-f", "--json", "--progress",
                           "none", *arguments)
        self.expect(0, "verify", "o.8vo", "-q")
        return json.loads(made.stdout)

    def voxels_of(self, name="o.8vo", code="h"):
        self.expect(0, "export", name, "-o", "out.raw", "-f", "-q")
        data = (self.folder / "out.raw").read_bytes()
        return list(struct.unpack(f"<{len(data) // struct.calcsize(code)}{code}", data))

    def expect_voxels(self, source, size, where, code="h", outside=None):
        """where(x, y, z): the source position of a voxel."""
        expected = []
        for p in voxel_order(size):
            x, y, z = where(*p)
            inside = 0 <= x < SIZE[0] and 0 <= y < SIZE[1] and 0 <= z < SIZE[2]
            expected.append(source[(z * SIZE[1] + y) * SIZE[0] + x] if inside else outside)
        self.assertEqual(self.voxels_of(code=code), expected)

    def world_of(self, info, index):
        d = info["direction"]
        return [info["origin_mm"][i]
                + sum(d[3 * i + a] * info["spacing_mm"][a] * index[a] for a in range(3))
                for i in range(3)]

    def test_translations_change_the_origin_and_copy_the_bricks(self):
        made = self.transform("v.8vo", "--translate-mm", "1.5,-2,1e3")
        self.assertEqual(made["bricks"], "copied")
        self.assertEqual(made["origin_mm"], [1.5, -2, 1000])
        self.assertEqual(self.voxels_of(), self.grey)
        made = self.transform("v.8vo", "--translate", "2,-4,10")
        self.assertEqual(made["origin_mm"], [1, -3, 10])
        self.assertEqual(self.voxels_of(), self.grey)
        info = self.info("o.8vo")
        self.assertEqual(info["metadata"]["made_by"],
                         {"operation": "transform", "step": "translate", "voxels": [2, -4, 10]})
        levels = [[level["bytes"] for level in self.info(name)["levels"]]
                  for name in ["v.8vo", "o.8vo"]]
        self.assertEqual(levels[0], levels[1])

    def test_a_lossy_file_is_translated_without_another_loss(self):
        self.build("l.8vo", self.grey, "int16", "h", "--max-error", "3")
        before = self.info("l.8vo")
        self.transform("l.8vo", "--translate", "1,0,0")
        after = self.info("o.8vo")
        for name in ["max_error", "achieved_error"]:
            self.assertEqual(after[name], before[name])
        self.assertEqual(self.voxels_of(), self.voxels_of("l.8vo"))
        self.transform("l.8vo", "--mirror", "x")
        self.assertEqual(self.info("o.8vo")["metadata"]["source_max_error"],
                         before["achieved_error"])

    def test_shifts_drop_what_falls_out_and_fill_what_is_free(self):
        def moved(x, y, z):
            return x - 5, y + 3, z - 40

        self.transform("v.8vo", "--shift", "5,-3,40", "--fill", "-77")
        self.expect_voxels(self.grey, SIZE, moved, outside=-77)
        self.transform("v.8vo", "--shift", "5,-3,40")
        self.expect_voxels(self.grey, SIZE, moved, outside=min(self.grey))
        self.assertEqual(self.info("o.8vo")["origin_mm"], [0, 0, 0])
        self.transform("m.8vo", "--shift", "5,-3,40")
        self.expect_voxels(self.mask, SIZE, moved, "B", outside=0)
        self.transform("m.8vo", "--shift", "5,-3,40", "--fill", "1")
        self.expect_voxels(self.mask, SIZE, moved, "B", outside=1)
        self.transform("m.8vo", "--shift", "0,0,99999999")
        self.assertEqual(sum(self.voxels_of(code="B")), 0)

    TURNS = [
        # One quarter about z lays along y what lay along x.
        (["--rotate", "z:90"], (1, 0, 2), lambda x, y, z: (y, SIZE[1] - 1 - x, z)),
        (["--rotate", "z:270"], (1, 0, 2), lambda x, y, z: (SIZE[0] - 1 - y, x, z)),
        (["--rotate", "x:90"], (0, 2, 1), lambda x, y, z: (x, z, SIZE[2] - 1 - y)),
        (["--rotate", "y:90"], (2, 1, 0), lambda x, y, z: (SIZE[0] - 1 - z, y, x)),
        (["--rotate", "y:180"], (0, 1, 2),
         lambda x, y, z: (SIZE[0] - 1 - x, y, SIZE[2] - 1 - z)),
        (["--mirror", "z"], (0, 1, 2), lambda x, y, z: (x, y, SIZE[2] - 1 - z)),
        (["--rotate", "z:90", "--rotate", "z:90"], (0, 1, 2),
         lambda x, y, z: (SIZE[0] - 1 - x, SIZE[1] - 1 - y, z)),
    ]

    def test_turns_move_every_voxel_and_keep_its_place_in_space(self):
        before = self.info("v.8vo")
        for options, axes, where in self.TURNS:
            size = tuple(SIZE[a] for a in axes)
            with self.subTest(options):
                for name, source, code in [("v.8vo", self.grey, "h"), ("m.8vo", self.mask, "B")]:
                    made = self.transform(name, *options)
                    self.assertEqual(tuple(made["size"]), size)
                    self.expect_voxels(source, size, where, code)
                    for p in [(0, 0, 0), (3, 2, 1), tuple(n - 1 for n in size)]:
                        here = self.world_of(made, p)
                        there = self.world_of(before, where(*p))
                        for a, b in zip(here, there):
                            self.assertAlmostEqual(a, b)

    def test_what_had_no_place_in_a_body_gets_none(self):
        for options in [["--rotate", "z:90"], ["--translate", "1,2,3"], ["--scale", "2"]]:
            self.transform("v.8vo", *options)
            self.assertIs(self.info("o.8vo")["metadata"]["place_known"], False)

    def test_in_place_keeps_direction_and_center(self):
        before = self.info("v.8vo")
        center = self.world_of(before, [(n - 1) / 2 for n in SIZE])
        turned = self.transform("v.8vo", "--rotate", "z:90", "--in-place")
        self.assertEqual(turned["direction"], before["direction"])
        self.assertEqual(turned["spacing_mm"], [0.75, 0.5, 1])
        self.expect_voxels(self.grey, (SIZE[1], SIZE[0], SIZE[2]), self.TURNS[0][2])
        grown = self.transform("v.8vo", "--scale", "2", "--in-place")
        self.assertEqual(grown["spacing_mm"], before["spacing_mm"])
        for made in [turned, grown, self.transform("v.8vo", "--scale", "1/2", "--in-place")]:
            here = self.world_of(made, [(n - 1) / 2 for n in made["size"]])
            for a, b in zip(here, center):
                self.assertAlmostEqual(a, b)

    def test_four_quarter_turns_give_the_file_back(self):
        self.transform("v.8vo", "--rotate", "x:90")
        (self.folder / "o.8vo").rename(self.folder / "a.8vo")
        made = self.transform("a.8vo", "--rotate", "x:270")
        self.assertEqual(self.voxels_of(), self.grey)
        info = self.info("v.8vo")
        for name in ["origin_mm", "spacing_mm", "direction", "size"]:
            self.assertEqual(made[name], info[name])

    def test_scales_repeat_voxels_or_take_the_coarser_level(self):
        made = self.transform("m.8vo", "--scale", "2")
        self.assertEqual(made["spacing_mm"], [0.25, 0.375, 0.5])
        self.assertEqual(made["origin_mm"], [-0.125, -0.1875, -0.25])
        self.expect_voxels(self.mask, [2 * n for n in SIZE],
                           lambda x, y, z: (x // 2, y // 2, z // 2), "B")
        made = self.transform("v.8vo", "--scale", "2", "--interpolation", "nearest")
        self.expect_voxels(self.grey, [2 * n for n in SIZE],
                           lambda x, y, z: (x // 2, y // 2, z // 2))
        made = self.transform("v.8vo", "--scale", "1/4")
        level = self.info("v.8vo")["levels"][2]
        self.assertEqual((made["size"], made["spacing_mm"]), (level["size"], level["spacing_mm"]))
        self.expect(0, "extract", "v.8vo", "--level", "2", "-o", "l.raw", "-q")
        self.voxels_of()
        self.assertEqual((self.folder / "out.raw").read_bytes(),
                         (self.folder / "l.raw").read_bytes())

    def linear(self, p):
        """The grey value between voxels; None outside."""
        if any(c < -0.5 or c >= n - 0.5 for c, n in zip(p, SIZE)):
            return None
        total = 0
        for corner in itertools.product((0, 1), repeat=3):
            weight = 1
            at = []
            for c, n, k in zip(p, SIZE, corner):
                low = math.floor(c)
                weight *= c - low if k else 1 - (c - low)
                at.append(min(max(low + k, 0), n - 1))
            total += weight * self.grey[(at[2] * SIZE[1] + at[1]) * SIZE[0] + at[0]]
        return total

    def test_affine_moves_the_object_by_a_matrix_in_mm(self):
        c, s = math.cos(0.3), math.sin(0.3)
        rows = [[c, -s, 0, 4], [s, c, 0, -3], [0, 0, 1, 2.5]]
        (self.folder / "m.txt").write_text(
            "# turned about z, then moved\n"
            + "\n".join(", ".join(map(repr, row)) for row in rows) + "\n0 0 0 1\n")
        self.transform("v.8vo", "--affine", "m.txt", "--fill", "-99")
        found = self.voxels_of()
        for voxel, (x, y, z) in zip(found[::37], voxel_order(SIZE)[::37]):
            # Back from the new place to the old one.
            u, v, w = x * SPACING[0] - 4, y * SPACING[1] + 3, z * SPACING[2] - 2.5
            p = ((c * u + s * v) / SPACING[0], (-s * u + c * v) / SPACING[1], w / SPACING[2])
            value = self.linear(p)
            if value is None:
                self.assertEqual(voxel, -99)
            else:
                self.assertLessEqual(abs(voxel - value), 0.5 + 1e-9)
        # The inverse of the inverse; and the map given back with --inverse.
        moved = json.loads(self.expect(0, "info", "o.8vo", "--json").stdout)
        matrix = moved["metadata"]["made_by"]["matrix_mm"]
        self.assertEqual(matrix, rows)
        back = [[c, s, 0, -(4 * c - 3 * s)], [-s, c, 0, 4 * s + 3 * c], [0, 0, 1, -2.5]]
        (self.folder / "b.txt").write_text(" ".join(str(v) for row in back for v in row))
        self.transform("v.8vo", "--affine", "b.txt", "--inverse", "--fill", "-99")
        again = self.voxels_of()
        self.assertLessEqual(max(abs(a - b) for a, b in zip(found, again)
                                 if -99 not in (a, b)), 1)

    def test_an_angle_turns_grey_values_about_the_center_in_mm(self):
        before = self.info("v.8vo")
        for options in [[], ["--in-place"]]:
            made = self.transform("v.8vo", "--rotate", "x:20", "--rotate", "x:4.5", "--fill",
                                  "-99", *options)
            self.assertEqual(made["size"][0], SIZE[0])
            size = tuple(made["size"])
            center = [(n - 1) / 2 for n in size]
            for a, b in zip(self.world_of(made, center),
                            self.world_of(before, [(n - 1) / 2 for n in SIZE])):
                self.assertAlmostEqual(a, b)
            c, s = math.cos(math.radians(24.5)), math.sin(math.radians(24.5))
            found = self.voxels_of()
            for voxel, p in list(zip(found, voxel_order(size)))[::41]:
                _, v, w = ((i - m) * mm for i, m, mm in zip(p, center, made["spacing_mm"]))
                at = (p[0], (c * v + s * w) / SPACING[1] + (SIZE[1] - 1) / 2,
                      (-s * v + c * w) / SPACING[2] + (SIZE[2] - 1) / 2)
                value = self.linear(at)
                if value is None:
                    self.assertEqual(voxel, -99)
                else:
                    self.assertLessEqual(abs(voxel - value), 0.5 + 1e-9)
                if not options:
                    for a, b in zip(self.world_of(made, p), self.world_of(before, at)):
                        self.assertAlmostEqual(a, b)

    def test_steps_are_done_in_the_order_of_the_command_line(self):
        turned = (SIZE[1], SIZE[0], SIZE[2])
        for name, source, code in [("v.8vo", self.grey, "h"), ("m.8vo", self.mask, "B")]:
            outside = min(source)
            self.transform(name, "--rotate", "z:90", "--shift", "2,0,0")
            self.expect_voxels(source, turned, lambda x, y, z: (y, SIZE[1] - 1 - (x - 2), z),
                               code, outside)
            made = self.transform(name, "--shift", "2,0,0", "--rotate", "z:90")
            self.assertEqual(made["operation"], "shift, rotate")
            self.expect_voxels(source, turned, lambda x, y, z: (y - 2, SIZE[1] - 1 - x, z), code,
                               outside)
            self.assertEqual(self.info("o.8vo")["metadata"]["made_by"],
                             {"operation": "transform", "step": "steps",
                              "steps": ["shift 2,0,0", "rotate z:90"]})
        self.assertIn("made by      transform: steps shift 2,0,0,rotate z:90",
                      self.expect(0, "info", "o.8vo").stdout)
        made = self.transform("v.8vo", "--mirror", "x", "--translate", "1,2,3", "--mirror", "x")
        self.assertEqual(self.voxels_of(), self.grey)

    def test_a_mask_that_leaves_its_grid_is_told(self):
        corner = [int(i < 3) for i in range(math.prod(SIZE))]
        self.build("corner.8vo", corner, "uint8", "B", "--labels")
        (self.folder / "away.txt").write_text("1 0 0 -9\n0 1 0 0\n0 0 1 0\n0 0 0 1\n")
        for steps in (["--shift", "-3,0,0"], ["--affine", "away.txt"]):
            with self.subTest(steps):
                self.assertEqual(self.transform("corner.8vo", *steps)["warnings"],
                                 ["o.8vo: is empty; no labeled voxel of corner.8vo is left in "
                                  "the grid"])
                self.assertEqual(sum(self.voxels_of(code="B")), 0)
        self.assertEqual(self.transform("corner.8vo", "--shift", "-2,0,0")["warnings"], [])
        self.build("none.8vo", [0] * math.prod(SIZE), "uint8", "B", "--labels")
        self.assertEqual(self.transform("none.8vo", "--shift", "-3,0,0")["warnings"], [])

    def test_grid_of_brings_a_volume_onto_another_grid(self):
        size, spacing = (30, 25, 40), (1.0, 0.5, 1.5)
        self.build("g.8vo", [0] * (30 * 25 * 40), "uint8", "B", size=size, spacing=spacing)
        self.transform("g.8vo", "--translate-mm", "3,-1,2")
        (self.folder / "o.8vo").rename(self.folder / "grid.8vo")
        made = self.transform("m.8vo", "--grid-of", "grid.8vo")
        self.assertEqual((made["size"], made["origin_mm"]), (list(size), [3, -1, 2]))

        def where(x, y, z):
            p = [(o + i * s) / t for o, i, s, t in
                 zip((3, -1, 2), (x, y, z), spacing, SPACING)]
            return tuple(math.floor(c + 0.5 + 1e-6) for c in p)

        self.expect_voxels(self.mask, size, where, "B", outside=0)
        self.transform("g.8vo", "--translate-mm", "0,0,9999")
        (self.folder / "o.8vo").rename(self.folder / "far.8vo")
        told = self.transform("m.8vo", "--grid-of", "far.8vo")
        self.assertIn("none of it lies in the new grid", told["warnings"][0])
        self.assertEqual(sum(self.voxels_of(code="B")), 0)
        self.assertEqual(len(told["warnings"]), 1, told["warnings"])
        self.transform("m.8vo", "--grid-of", "grid.8vo")
        # The set operations bring masks onto the grid of the first in the same way.
        resampled = self.voxels_of(code="B")
        self.build("full.8vo", [1] * (30 * 25 * 40), "uint8", "B", "--labels", size=size,
                   spacing=spacing)
        self.transform("full.8vo", "--translate-mm", "3,-1,2")
        (self.folder / "o.8vo").rename(self.folder / "full.8vo")
        rejected = self.expect_error(2, ["m.8vo", "--resample"], "combine", "full.8vo", "m.8vo",
                                    "--intersect", "-o", "c.8vo")
        self.assertIn("70 x 9 x 66", rejected.stderr)
        made = self.expect(0, "combine", "full.8vo", "m.8vo", "full.8vo", "--resample",
                           "--intersect", "-o", "c.8vo", "--json", "--progress", "none")
        self.assertEqual(json.loads(made.stdout)["resampled"], ["m.8vo"])
        self.assertEqual(self.voxels_of("c.8vo", "B"), resampled)
        self.assertEqual(self.info("c.8vo")["metadata"]["made_by"]["resampled"], 1)

    def test_masks_whose_grids_do_not_meet_are_told_apart(self):
        self.transform("m.8vo", "--translate-mm", "0,0,9999")
        (self.folder / "o.8vo").rename(self.folder / "far.8vo")
        for operation, expected in [("--union", self.mask), ("--intersect", [0] * len(self.mask))]:
            made = self.expect(0, "combine", "m.8vo", "far.8vo", "--resample", operation, "-o",
                               "c.8vo", "-f", "--json", "--progress", "none")
            self.assertEqual(json.loads(made.stdout)["warnings"], [
                "far.8vo: lies wholly outside the grid of m.8vo, so that none of it is taken; it "
                "fills -0.25:34.75,-0.375:6.375,9998.5:10064.5 mm, the grid "
                "-0.25:34.75,-0.375:6.375,-0.5:65.5 mm"])
            self.assertEqual(self.voxels_of("c.8vo", "B"), expected)
        self.transform("m.8vo", "--translate-mm", "0,0,60")
        made = self.expect(0, "combine", "m.8vo", "o.8vo", "--resample", "--union", "-o", "c.8vo",
                           "-f", "--json", "--progress", "none")
        self.assertEqual(json.loads(made.stdout)["warnings"], [])

    def test_results_that_are_too_large_are_rejected_before_any_work(self):
        self.build("flat.8vo", [1] * 4000000, "uint8", "B", size=(2000, 2000, 1))
        self.build("line.8vo", [1] * 40000, "uint8", "B", size=(40000, 1, 1))
        kept = self.files()
        for words, arguments in [
            (["x.8vo: a result of 4480 x 576 x 4224 voxels would take about",
              "the limit is 600 MiB", "take a smaller scale; raise --max-memory"],
             ["v.8vo", "--scale", "64", "--max-memory", "600M"]),
            (["2560000 x 64 x 64", "between 1 and 2097152"], ["line.8vo", "--scale", "64"]),
            (["64 x finer", "between 1 and 2097152"], ["line.8vo"] + 11 * ["--scale", "64"]),
            # 128000 x 128000 x 64 voxels at once are 977 GiB.
            (["a result of 128000 x 128000 x 64 voxels", "all this machine has"],
             ["flat.8vo", "--scale", "64"]),
        ]:
            self.expect_error(6, words, "transform", *arguments, "-o", "x.8vo")
            self.assertEqual(self.files(), kept)

    def test_neither_threads_nor_memory_change_a_byte(self):
        (self.folder / "m.txt").write_text("0.9 0.1 0 3  -0.1 0.8 0.2 0  0 0.1 1.1 -5")
        for options in [["--rotate", "z:90"], ["--affine", "m.txt", "--interpolation", "cubic"],
                        ["--rotate", "1,2,3:40", "--shift", "1,2,3", "--affine", "m.txt"]]:
            self.transform("v.8vo", *options, "-j", "1")
            one = (self.folder / "o.8vo").read_bytes()
            self.transform("v.8vo", *options, "-j", "5", "--max-memory", "600M")
            self.assertEqual((self.folder / "o.8vo").read_bytes(), one)

    def test_errors_name_the_reason_and_leave_nothing(self):
        for name, text in [("eleven.txt", "1 " * 11), ("word.txt", "1 0 0 0\n0 one 0 0"),
                           ("last.txt", "1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1"),
                           ("flat.txt", "1 0 0 0 0 1 0 0 1 1 0 0"), ("long.txt", "0 " * 40000)]:
            (self.folder / name).write_text(text)
        os.mkfifo(self.folder / "pipe.txt")
        kept = self.files()
        for code, words, arguments in [
            (2, ["needs one of", "--grid-of"], []),
            (2, ["scale of 1/2", "before the steps that move"],
             ["--mirror", "x", "--scale", "1/2"]),
            (2, ["--shift", "x,y,z"], ["--shift", "1,1"]),
            (2, ["z:90"], ["--rotate", "90"]),
            (2, ["z:90"], ["--rotate", "w:90"]),
            (2, ["'45x'"], ["--rotate", "z:45x"]),
            (2, ["0,0,0 has no direction"], ["--rotate", "0,0,0:45"]),
            (2, ["1,1,0:30"], ["--rotate", "1,1:45"]),
            (2, ["undoes the step", "--in-place"], ["--rotate", "z:45", "--grid-of", "m.8vo"]),
            (2, ["--mirror", "x, y or z"], ["--mirror", "q"]),
            (2, ["power of two"], ["--scale", "3"]),
            (2, ["power of two"], ["--scale", "1/0"]),
            (2, ["power of two"], ["--scale", "-2"]),
            (2, ["--in-place", "--rotate"], ["--shift", "1,1,1", "--in-place"]),
            (2, ["--fill", "--affine"], ["--mirror", "x", "--fill", "3"]),
            (2, ["--inverse", "--affine"], ["--mirror", "x", "--inverse"]),
            (2, ["--interpolation"], ["--scale", "1/2", "--interpolation", "linear"]),
            (2, ["--max-error"], ["--translate", "1,1,1", "--max-error", "1"]),
            (2, ["fill value 0.5: is no value", "-32768 to 32767 in steps of 1"],
             ["--shift", "1,1,1", "--fill", "0.5"]),
            (2, ["fill value 40000: is no value"], ["--shift", "1,1,1", "--fill", "40000"]),
            (5, ["none.txt", "No such file"], ["--affine", "none.txt"]),
            (7, ["eleven.txt", "11 numbers", "12 or 16"], ["--affine", "eleven.txt"]),
            (7, ["word.txt", "'one' in line 2"], ["--affine", "word.txt"]),
            (7, ["last.txt", "1 0 0 1", "0 0 0 1"], ["--affine", "last.txt"]),
            (7, ["flat.txt", "inverse"], ["--affine", "flat.txt"]),
            (7, ["long.txt", "64 KiB"], ["--affine", "long.txt"]),
            (5, ["pipe.txt", "is not a regular file"], ["--affine", "pipe.txt"]),
            (5, ["none.8vo"], ["--grid-of", "none.8vo"]),
            (6, ["the limit is 10 MiB", "smaller volume"],
             ["--mirror", "x", "--max-memory", "10M"]),
        ]:
            with self.subTest(arguments):
                self.expect_error(code, words, "transform", "v.8vo", *arguments, "-o", "x.8vo")
                self.assertEqual(self.files(), kept)
        grid = (self.folder / "m.8vo").read_bytes()
        self.expect_error(2, ["m.8vo: is the input itself"], "transform", "v.8vo", "--grid-of",
                          "m.8vo", "-o", "m.8vo", "--force")
        self.assertEqual((self.folder / "m.8vo").read_bytes(), grid)
        self.expect_error(2, ["always lossless; leave out --max-error"], "transform", "m.8vo",
                          "--mirror", "x", "--max-error", "2", "-o", "x.8vo")
        self.expect_error(2, ["labels are names"], "transform", "m.8vo", "--grid-of", "v.8vo",
                          "--interpolation", "linear", "-o", "x.8vo")
        self.expect_error(5, ["exists already"], "transform", "v.8vo", "--mirror", "x", "-o",
                          "m.8vo")
        # What is wrong with the arguments comes before what stands in the way.
        for word, arguments in [("'45x'", ["--rotate", "z:45x"]),
                                ("fill value 0.5", ["--shift", "1,1,1", "--fill", "0.5"])]:
            self.expect_error(2, [word], "transform", "v.8vo", *arguments, "-o", "m.8vo")
        self.expect_error(2, ["--resample", "--complement"], "combine", "m.8vo", "--complement",
                          "--resample", "-o", "x.8vo")

    def test_codes_tells_the_neighbors_of_a_cube(self):
        # Voxels 1 in the octant at the origin of a cube of side 4, and one voxel of 5 behind it.
        voxels = [0] * 64
        for x, y, z in itertools.product((0, 1), repeat=3):
            voxels[(z * 4 + y) * 4 + x] = 1
        voxels[2] = 5
        self.build("c.8vo", voxels, "uint8", "B", "--labels", size=(4, 4, 4), spacing=(1, 1, 1))
        found = json.loads(self.expect(0, "codes", "c.8vo", "--neighbors", "20", "--json").stdout)
        kinds = {tuple(row["direction"]): row for row in found["neighbors"]}
        self.assertEqual(len(kinds), 26)
        self.assertEqual((kinds[-1, 0, 0]["code"], kinds[-1, 0, 0]["level"]), ("08", 1))
        self.assertEqual(kinds[1, 0, 0]["kind"], "background")
        self.assertEqual(kinds[0, -1, 0]["kind"], "outside")
        text = self.expect(0, "codes", "c.8vo", "--neighbors", "0", "--notation", "linear").stdout
        self.assertEqual(len(text.splitlines()), 28)
        self.assertIn("   1  0  0  smaller", text)
        self.expect_error(2, ["3 digits", "have 2"], "codes", "c.8vo", "--neighbors", "200")
        self.expect_error(2, ["'29'"], "codes", "c.8vo", "--neighbors", "29")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
