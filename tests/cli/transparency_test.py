#!/usr/bin/env python3
"""Draws transparency pictures and condenses grey volumes as a user does.

usage: transparency_test.py OCTAVO [unittest arguments]
"""

import json
import struct
import sys

import cli_test
from render_test import read_png


class Transparency(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "40,36,33", "-o", "p.8vo", "-q")

    def render(self, *arguments):
        result = self.expect(0, "render", "p.8vo", "--mode", "transparency", *arguments, "-o",
                             "p.png", "-f", "--json", "--progress", "none")
        return json.loads(result.stdout), result.stderr

    def picture(self):
        return (self.folder / "p.png").read_bytes()

    def test_a_picture_has_the_size_asked_for_and_is_the_same_for_all_threads(self):
        told, _ = self.render("--size", "200x150", "-j", "1")
        first = self.picture()
        self.assertEqual(struct.unpack(">II", first[16:24]), (200, 150))
        self.assertEqual(told["size"], [200, 150])
        self.assertGreater(told["leaves"], 0)
        self.render("--size", "200x150", "-j", "2")
        self.assertEqual(self.picture(), first)
        self.render("--size", "200x150", "--direction", "front")
        self.assertNotEqual(self.picture(), first)

    def test_a_grey_volume_is_summed_along_a_ramp(self):
        told, _ = self.render("--size", "64")
        self.assertEqual(told["ramp"], [-1000, 900])
        self.assertEqual(told["ranges"], [])
        self.assertFalse(told["average"])
        first = self.picture()
        window = told["window"]
        self.render("--size", "64", "--window", f"{window['center']!r},{window['width']!r}")
        self.assertEqual(self.picture(), first)
        self.render("--size", "64", "--window", f"{window['center']!r},{window['width'] / 3!r}")
        self.assertNotEqual(self.picture(), first)

    def cube(self, name, ground, value):
        """20 x 20 x 20 voxels of `ground`, of 0.5 x 2 x 0.5 mm, with a cube of 10 of `value`."""
        within = range(5, 15)
        voxels = [value if x in within and y in within and z in within else ground
                  for z in range(20) for y in range(20) for x in range(20)]
        (self.folder / "c.raw").write_bytes(struct.pack("<8000h", *voxels))
        self.expect(0, "build", "c.raw", "--raw", "20,20,20,int16", "--spacing", "0.5,2,0.5", "-o",
                    name, "-q", "-f")

    def sums(self, name, *options):
        """What is reported, and grey values in the cube, beside it and beside the volume."""
        told = json.loads(self.expect(
            0, "render", name, "--mode", "transparency", "--direction", "front", "--size",
            "100", "-o", "c.png", "-f", "--no-scale-bar", "--no-sides", "--no-legend", "--json",
            "--progress", "none", *options).stdout)
        rows = read_png(self.folder / "c.png")
        return told, [rows[50][x][0] for x in (50, 10, 1)]

    def test_sums_are_of_what_values_have_above_the_one_reported(self):
        for ground in (100, 0, -300):
            self.cube("c.8vo", ground, ground + 200)
            told, greys = self.sums("c.8vo", "--window", "4000,8000")
            self.assertEqual(told["ramp"], [ground, ground + 200])
            self.assertEqual(greys, [round(255 * 200 * 10 * 2 / 8000), 0, 0])
            said = self.expect(0, "render", "c.8vo", "--mode", "transparency", "-o", "c.png", "-f")
            self.assertIn(f"of sums above {ground};", said.stdout)

    def test_sums_that_are_all_one_are_white(self):
        self.cube("c.8vo", 0, 300)
        told, greys = self.sums("c.8vo")
        self.assertEqual((greys, told["warnings"]), ([255, 0, 0], []))
        self.assertEqual(told["window"], {"center": 3000, "width": 6000})

    def test_sums_are_seen_on_a_white_ground(self):
        self.cube("c.8vo", 0, 300)
        told, greys = self.sums("c.8vo", "--background", "white")
        self.assertEqual((greys, told["warnings"]), ([255, 0, 255], []))
        told, greys = self.sums("c.8vo", "--background", "white", "--cut", "x<8", "--window",
                                "3000,6000")
        self.assertEqual(greys[-1], 255)
        told, greys = self.sums("c.8vo", "--window", "1e6,10", "--background", "white")
        self.assertEqual(greys, [0, 0, 255])
        self.assertEqual(told["warnings"],
                         ["c.8vo: all sums are below the window; they are black"])

    def test_ranges_have_colors_and_opacities(self):
        told, _ = self.render("--range", "250:350=red:0.2", "--range=:-900=#0102ff",
                              "--range", "800:")
        self.assertEqual([r["low"] for r in told["ranges"]], [250, None, 800])
        self.assertEqual([r["high"] for r in told["ranges"]], [350, -900, None])
        self.assertEqual(told["ranges"][0]["opacity"], 0.2)
        self.assertEqual(told["ranges"][1]["color"], [1, 2, 255])
        self.assertIsNone(told["ramp"])

    def test_bricks_of_one_range_are_not_decoded(self):
        self.assertEqual(self.render("--range", "5000:")[0]["decoded_bricks"], 0)
        self.assertEqual(self.render("--range", "800:")[0]["decoded_bricks"], 1)

    def test_an_average_has_no_window_and_differs_by_side(self):
        told, _ = self.render("--average", "--direction", "1,0,0", "--no-sides")
        self.assertIsNone(told["window"])
        self.assertTrue(told["average"])

    def test_a_view_between_lines_takes_the_nearest_and_says_so(self):
        told, said = self.render("--azimuth", "20", "--elevation", "0", "--size", "64")
        self.assertIn("degrees from what was asked for", said)
        self.assertEqual([round(c) for c in told["toward"]], [0, -1, 0])
        _, said = self.render("--direction", "1,0,1", "--size", "64")
        self.assertEqual(said, "")

    def test_cuts_and_levels_are_drawn(self):
        whole = self.render("--size", "64")[0]["leaves"]
        first = self.picture()
        self.render("--size", "64", "--cut", "x<20")
        self.assertNotEqual(self.picture(), first)
        self.assertLess(self.render("--size", "64", "--level", "1")[0]["leaves"], whole)

    def test_a_turntable_is_equally_bright(self):
        told = json.loads(self.expect(
            0, "render", "p.8vo", "--mode", "transparency", "--direction", "front", "--size", "48",
            "--turntable", "4", "-o", "t.png", "--json", "--progress", "none").stdout)
        self.assertEqual(told["outputs"], [f"t-00{i}.png" for i in range(4)])

    def test_what_makes_no_sense_is_rejected(self):
        for words, options in [
            (["--range", "COLOR"], ["--range", "1:2=purplish"]),
            (["--range", "OPACITY"], ["--range", "1:2=red:7"]),
            (["--range", "OPACITY"], ["--range", "1:2=red:0.1:3"]),
            (["--range", "LOW:HIGH"], ["--range", "12"]),
            (["--tissue", "knee"], ["--tissue", "knee"]),
            (["--window"], ["--window", "5"]),
            (["--window"], ["--window", "5,0"]),
            (["--turntable", "8"], ["--turntable", "36"]),
        ]:
            self.expect_error(2, words, "render", "p.8vo", "--mode", "transparency", *options,
                              "-o", "q.png")
        self.expect_error(2, ["--average", "transparency"], "render", "p.8vo", "--range", "800:",
                          "--average", "-o", "q.png")
        self.expect(0, "threshold", "p.8vo", "--range", "800:", "-o", "m.8vo", "-q")
        self.expect_error(2, ["m.8vo", "surface"], "render", "m.8vo", "--mode", "transparency",
                          "-o", "q.png")
        self.assertEqual(self.files(), ["m.8vo", "p.8vo"])


class Condense(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "40", "--noise", "3", "-o", "p.8vo", "-q")

    def voxels(self, name):
        self.expect(0, "export", name, "-o", "v.raw", "-f", "-q")
        raw = (self.folder / "v.raw").read_bytes()
        return struct.unpack(f"<{len(raw) // 2}h", raw)

    def leaves(self, name):
        told = self.expect(0, "render", name, "--mode", "transparency", "--size", "64", "-o",
                           "p.png", "-f", "--json", "--progress", "none")
        return json.loads(told.stdout)["leaves"]

    def test_no_voxel_moves_by_more_than_flat_and_cubes_are_fewer(self):
        source = self.voxels("p.8vo")
        counts = [self.leaves("p.8vo")]
        for flat in [0, 10, 30]:
            self.expect(0, "condense", "p.8vo", "--flat", flat, "-o", "c.8vo", "-f", "-q")
            moved = [abs(a - b) for a, b in zip(source, self.voxels("c.8vo"))]
            self.assertLessEqual(max(moved), flat)
            self.assertEqual(max(moved) > 0, flat > 0)
            counts.append(self.leaves("c.8vo"))
        self.assertEqual(counts[0], counts[1])
        self.assertGreater(counts[1], counts[2])
        self.assertGreater(counts[2], 1.5 * counts[3])
        self.assertEqual(self.info("c.8vo")["metadata"]["made_by"],
                         {"operation": "condense", "flat": 30})

    def test_cubes_have_codes(self):
        self.expect_error(2, ["p.8vo", "octavo condense"], "codes", "p.8vo")
        self.expect(0, "condense", "p.8vo", "--flat", "30", "-o", "c.8vo", "-q")
        told = json.loads(self.expect(0, "codes", "c.8vo", "--list", "--json", "--notation",
                                      "linear", "--progress", "none").stdout)
        self.assertEqual(told["voxels"], 40 ** 3)
        self.assertLess(told["leaves"], 40 ** 3 / 1.5)
        voxels = self.voxels("c.8vo")
        total = sum(cube["value"] * 8 ** cube["level"] for cube in told["codes"])
        self.assertEqual(total, sum(voxels))

    def test_what_has_no_mean_is_rejected(self):
        self.expect(0, "threshold", "p.8vo", "--range", "800:", "-o", "m.8vo", "-q")
        self.expect_error(2, ["m.8vo", "labels"], "condense", "m.8vo", "--flat", "1", "-o",
                          "c.8vo")
        self.expect(2, "condense", "p.8vo", "--flat=-1", "-o", "c.8vo")
        self.assertEqual(self.files(), ["m.8vo", "p.8vo"])


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
