#!/usr/bin/env python3
"""Measures structures of known answers, as a user does.

usage: morphometry_test.py OCTAVO [unittest arguments]
"""

import array
import csv
import itertools
import json
import math
import sys
import unittest

import cli_test

SIDE = 40
MM = 0.5


class Morphometry(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.build("plate.8vo", lambda x, y, z: 15 <= z < 25)

    def build(self, name, inside):
        places = itertools.product(range(SIDE), repeat=3)
        (self.folder / "v.raw").write_bytes(bytes(int(inside(x, y, z)) for z, y, x in places))
        self.expect(0, "build", "v.raw", "--raw", f"{SIDE},{SIDE},{SIDE},uint8", "--spacing",
                    str(MM), "--labels", "-o", name, "-q", "-f")

    def measures(self, *arguments):
        return json.loads(self.expect(0, "morphometry", *arguments, "--json", "--progress",
                                      "none").stdout)

    def test_a_plate_is_what_it_is(self):
        made = self.measures("plate.8vo", "--thickness-map", "th.8vo")
        expected = {"bv_mm3": 2000, "tv_mm3": 8000, "bv_tv": 0.25, "porosity": 0.75,
                    "bs_mm2": 800, "bs_bv_per_mm": 0.4, "bs_tv_per_mm": 0.1, "cut_mm2": 400,
                    "smi": 0, "tb_th_mm": 5, "tb_th_sd_mm": 0, "tb_th_max_mm": 5,
                    "tb_n_per_mm": 0.05, "euler_number": 1, "euler_number_by_faces": 1,
                    "euler_number_error": 0, "degree_of_anisotropy": 1,
                    "surface_fractal_dimension": 2}
        for key, value in expected.items():
            self.assertAlmostEqual(made[key], value, places=6, msg=key)
        self.assertEqual(made["touches_border"], [True] * 4 + [False] * 2)
        self.assertEqual(made["thickness"]["voxels"], 10 * SIDE * SIDE)
        self.assertEqual(sum(made["thickness"]["bins"]), 10 * SIDE * SIDE)
        self.assertTrue((self.folder / "th.8vo").is_file())

    def test_a_ball_is_what_it_is(self):
        radius = 14
        middle = SIDE // 2
        self.build("ball.8vo", lambda x, y, z: (x - middle) ** 2 + (y - middle) ** 2
                   + (z - middle) ** 2 <= radius ** 2)
        made = self.measures("ball.8vo")
        mm = radius * MM
        self.assertAlmostEqual(made["bv_mm3"] / (4 / 3 * math.pi * mm ** 3), 1, delta=0.02)
        self.assertAlmostEqual(made["bs_mm2"] / (4 * math.pi * mm ** 2), 1, delta=0.02)
        self.assertAlmostEqual(made["smi"], 4, delta=0.08)
        self.assertAlmostEqual(made["tb_th_mm"], 2 * mm, delta=MM)
        self.assertEqual(made["euler_number"], 1)
        self.assertEqual(made["touches_border"], [False] * 6)
        self.assertEqual(made["warnings"], [])

    def test_tables_say_what_json_says(self):
        made = self.measures("plate.8vo")
        rows = list(csv.DictReader(self.expect(0, "morphometry", "plate.8vo", "--csv", "--progress",
                                               "none").stdout.splitlines()))
        self.assertEqual(rows[0]["name"], "bv_mm3")
        for row in rows:
            if row["value"]:
                self.assertAlmostEqual(float(row["value"]), made[row["name"]], places=6)
            else:
                self.assertIsNone(made[row["name"]])
        slices = list(csv.DictReader(self.expect(0, "morphometry", "plate.8vo", "--slices",
                                                 "--progress", "none").stdout.splitlines()))
        self.assertEqual(len(slices), SIDE)
        for z, row in enumerate(slices):
            self.assertEqual(float(row["area_mm2"]), 400 if 15 <= z < 25 else 0)
            self.assertEqual(float(row["thickness_mm"]), 5 if 15 <= z < 25 else 0)

    def test_ways_and_forms_and_their_picture(self):
        # Plates that are shorter than the volume: ways go along them, or around their ends.
        self.build("walls.8vo", lambda x, y, z: z % 10 < 3 and 4 < x < 36)
        made = self.measures("walls.8vo", "--tortuosity", "--histogram", "h.png")
        self.assertAlmostEqual(made["tortuosity_y"], 1, places=6)
        self.assertGreater(made["tortuosity_x"], 1)  # behind the ends of plates
        self.assertLess(made["tortuosity_x"], 1.02)
        self.assertGreater(made["tortuosity_z"], 1.02)
        self.assertLess(made["ellipsoid_factor"], 0)
        self.assertAlmostEqual(sum(made["ellipsoids"]["shares"]), 1, places=6)
        self.assertEqual((self.folder / "h.png").read_bytes()[:4], b"\x89PNG")
        self.build("tight.8vo", lambda x, y, z: z == 20)
        self.assertIsNone(self.measures("tight.8vo", "--tortuosity")["tortuosity_z"])
        self.assertNotIn("tortuosity_z", self.measures("tight.8vo"))
        slow = self.measures("walls.8vo", "--diffusion", "--no-thickness")
        self.assertAlmostEqual(slow["diffusive_tortuosity_y"], 1, places=4)
        self.assertGreater(slow["diffusive_tortuosity_z"], made["tortuosity_z"])
        self.assertAlmostEqual(slow["effective_diffusivity_z"] * slow["diffusive_tortuosity_z"],
                               slow["porosity"], places=6)
        self.assertNotIn("tortuosity_z", slow)
        tight = self.measures("tight.8vo", "--diffusion", "--no-thickness")
        self.assertEqual(tight["effective_diffusivity_z"], 0)
        self.expect_error(2, ["--no-thickness"], "morphometry", "tight.8vo", "--no-thickness",
                          "--histogram", "i.png")
        self.expect_error(2, [".png"], "morphometry", "tight.8vo", "--histogram", "i.svg")
        self.assertEqual([path.name for path in self.folder.glob("i.*")], [])

    def test_what_is_not_finite_has_no_density(self):
        def scan(name, values):
            (self.folder / "s.raw").write_bytes(array.array("f", values).tobytes())
            self.expect(0, "build", "s.raw", "--raw", f"{SIDE},{SIDE},{SIDE},float32", "--spacing",
                        str(MM), "-o", name, "-q", "-f")
        count = SIDE ** 3
        scan("part.8vo", [math.nan] * 100 + [8.0] * (count - 100))
        made = self.measures("plate.8vo", "--no-thickness", "--of", "part.8vo")
        self.assertEqual((made["tmd"], made["bmd"], made["bmd_sd"]), (8, 8, 0))
        self.assertIn(f"100 of {count} voxels are not finite", " ".join(made["warnings"]))
        scan("none.8vo", [math.nan] * count)
        made = self.measures("plate.8vo", "--no-thickness", "--of", "none.8vo")
        for key in ("tmd", "tmd_sd", "bmd", "bmd_sd"):
            self.assertIsNone(made[key])

    def test_every_way_says_how_far_it_is(self):
        self.build("posts.8vo", lambda x, y, z: x % 8 < 3 and y % 8 < 3)
        shown = self.expect(0, "morphometry", "posts.8vo", "--tortuosity", "--diffusion",
                            "--progress", "json").stderr
        last = {}
        for line in shown.splitlines():
            if not line.startswith("{"):
                continue  # that the mask touches the border
            event = json.loads(line)["progress"]
            last[event["what"]] = (event["done"], event["total"])
        for axis in "xyz":
            for what in ("ways", "diffusion"):
                done, total = last[f"{what} along {axis}"]
                self.assertEqual(done, total)
                self.assertGreater(total, 100)

    def test_empty_and_full_masks_are_said(self):
        self.build("empty.8vo", lambda x, y, z: False)
        failed = self.expect(2, "morphometry", "empty.8vo")
        self.assertIn("the mask is empty", failed.stderr)
        failed = self.expect(2, "morphometry", "plate.8vo", "--region", "empty.8vo")
        self.assertIn("no voxel of the mask lies in the region", failed.stderr)
        self.build("full.8vo", lambda x, y, z: True)
        full = self.expect(0, "morphometry", "full.8vo", "--progress", "none")
        self.assertIn("there is no surface in it", full.stderr)
        self.assertRegex(full.stdout, r"Tb\.Th +- mm +not measured: there is no surface")
        told = json.loads(self.expect(0, "morphometry", "full.8vo", "--json").stdout)
        for key in ("tb_th_mm", "tb_n_per_mm", "tb_sp_mm", "pore_d50_mm"):
            self.assertIsNone(told[key], key)
        self.expect_error(2, ["full.8vo", "fills the volume"], "morphometry", "full.8vo",
                          "--thickness-map", "map.8vo")
        self.assertFalse((self.folder / "map.8vo").exists())

    def test_bad_arguments_are_a_sentence(self):
        for words, arguments in (
                ("--calibration", ("--calibration", "1,2")),
                ("labels, not grey values", ("--of", "plate.8vo")),
                ("--no-thickness", ("--no-thickness", "--slices")),
                ("input itself", ("--thickness-map", "plate.8vo", "-f"))):
            failed = self.expect(2, "morphometry", "plate.8vo", *arguments)
            self.assertIn(words, failed.stderr)
        self.expect(2, "morphometry")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
