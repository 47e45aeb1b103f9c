#!/usr/bin/env python3
"""Builds cubes from thick slices, as a user does.

usage: isotropic_test.py OCTAVO [unittest arguments]

The volumes are generated; nothing but the standard library is needed.
"""

import array
import json
import os
import sys
import unittest

import cli_test

X, Y, SLICES = 6, 5, 4


class Isotropic(cli_test.InFolder):
    """A ramp of 30 per slice of 3 mm, 0.5 mm pixels: six planes a slice."""

    RAW = ("--raw", f"{X},{Y},{SLICES},int16")
    THICK = (*RAW, "--spacing", "0.5,0.5,3")

    def setUp(self):
        super().setUp()
        voxels = (30 * z + 4 * y + x for z in range(SLICES) for y in range(Y) for x in range(X))
        (self.folder / "thick.raw").write_bytes(array.array("h", voxels).tobytes())

    def build(self, *options, output="a.8vo", source="thick.raw"):
        return self.expect(0, "build", source, "-o", output, "--progress", "none", *options)

    def voxels(self, name):
        self.expect(0, "export", name, "-o", name + ".raw", "--progress", "none", "--force")
        voxels = array.array("h")
        voxels.frombytes((self.folder / (name + ".raw")).read_bytes())
        return voxels.tolist()

    def test_thick_slices_become_cubes_told_recorded_and_proven(self):
        expected = [5 * z + 4 * y + x for z in range(19) for y in range(Y) for x in range(X)]
        for method in [[], ["linear"], ["cubic"]]:
            with self.subTest(method):
                told = self.build(*self.THICK, "--isotropic", *method, "--force")
                self.assertIn("4 slices 3 mm apart become 19 planes 0.5 mm apart", told.stderr)
                info = self.info("a.8vo")
                self.assertEqual(info["spacing_mm"], [0.5, 0.5, 0.5])
                self.assertEqual(info["size"], [X, Y, 19])
                self.assertEqual(info["metadata"]["prepared"]["isotropic"],
                                 {"made_plane_count": 15, "method": (method or ["linear"])[0],
                                  "slice_mm": 3.0, "slices": 4, "step_mm": 0.5})
                self.assertEqual(self.voxels("a.8vo"), expected)
                self.expect(0, "verify", "a.8vo", "--against", "thick.raw", *self.THICK)
        shown = self.expect(0, "info", "a.8vo").stdout
        self.assertIn("15 planes made between thick slices (cubic)", shown)
        self.assertIn("lossless from its prepared planes", shown)

    def test_a_source_may_stand_behind_the_option(self):
        self.expect(0, "build", "--isotropic", "thick.raw", "-o", "b.8vo", *self.THICK)
        self.assertEqual(self.info("b.8vo")["size"], [X, Y, 19])

    def test_verify_finds_what_differs_from_the_prepared_source(self):
        self.build(*self.THICK, "--isotropic")
        voxels = bytearray((self.folder / "thick.raw").read_bytes())
        voxels[100] ^= 64
        (self.folder / "other.raw").write_bytes(voxels)
        self.expect(1, "verify", "a.8vo", "--against", "other.raw", *self.THICK)
        told = self.expect(2, "verify", "a.8vo", "--against", "thick.raw", *self.RAW)
        self.assertIn("thick.raw: isotropic voxels are made by their distances", told.stderr)

    def test_an_octavo_file_is_a_source_as_well(self):
        self.build(*self.THICK, output="thick.8vo")
        self.build("--isotropic", output="cubes.8vo", source="thick.8vo")
        self.build(*self.THICK, "--isotropic", output="direct.8vo")
        self.expect(0, "compare", "cubes.8vo", "direct.8vo")
        self.expect(0, "verify", "cubes.8vo", "--against", "thick.8vo")
        again = self.build("--isotropic", output="again.8vo", source="cubes.8vo")
        self.assertIn("cubes already", again.stderr)
        self.expect(0, "verify", "again.8vo", "--against", "cubes.8vo")

    def test_options_of_scans_are_rejected_for_an_octavo_file(self):
        self.build(*self.THICK, output="thick.8vo")
        for option in ["--raw 1,1,1,u8", "--spacing 1", "--channel 0", "--time 0", "--series 1.2",
                       "--segment 1", "--on-gap fill", "--drop-duplicates", "--untilt"]:
            name, *value = option.split()
            words = ["thick.8vo", name, "leave it out"]
            self.expect_error(2, words, "build", "thick.8vo", "-o", "x.8vo", name, *value)
            self.expect_error(2, words, "compare", "thick.8vo", "thick.8vo", name, *value)
            self.expect_error(2, words, "verify", "thick.8vo", "--against", "thick.8vo", name,
                              *value)
        self.expect(0, "compare", "thick.8vo", "thick.raw", *self.THICK)
        self.expect(0, "compare", "thick.raw", "thick.8vo", *self.THICK)
        self.assertNotIn("x.8vo", self.files())

    def test_labels_are_interpolated_by_shape_and_none_is_made_up(self):
        side = 20
        labels = array.array("h", (
            (7 if (x - 9) ** 2 + (y - 9) ** 2 <= (4 + 4 * z) ** 2 else 300)
            for z in range(2) for y in range(side) for x in range(side)))
        (self.folder / "labels.raw").write_bytes(labels.tobytes())
        layout = ("--raw", f"{side},{side},2,int16", "--spacing", "1,1,4")
        self.build(*layout, "--labels", "--isotropic", source="labels.raw")
        self.assertEqual(self.info("a.8vo")["metadata"]["prepared"]["isotropic"]["method"], "shape")
        planes = self.voxels("a.8vo")
        self.assertEqual(set(planes), {7, 300})
        counts = [planes[z * side * side:(z + 1) * side * side].count(7) for z in range(5)]
        self.assertEqual(counts, sorted(counts))
        for z in range(1, 4):
            self.assertAlmostEqual(counts[z], 3.14159 * (4 + z) ** 2, delta=0.1 * counts[z])
        self.expect(0, "verify", "a.8vo", "--against", "labels.raw", *layout)
        self.expect_error(2, ["by their shapes", "--grey"], "build", "labels.raw", "-o", "c.8vo",
                          *layout, "--labels", "--isotropic", "cubic")

    def test_what_cannot_be_done_is_said_and_leaves_nothing(self):
        before = self.files()
        table = [
            (2, ["isotropic voxels are made by their distances", "give --spacing"], []),
            (7, ["0.5 x 2 x 9 mm", "not square"], ["--spacing", "0.5,2,9"]),
            (7, ["300 pixels apart"], ["--spacing", "0.01,0.01,3"]),
        ]
        for code, words, options in table:
            with self.subTest(words):
                self.expect(code, "build", "thick.raw", "-o", "c.8vo", *self.RAW, "--isotropic",
                            "-q", *options)
                result = self.octavo("build", "thick.raw", "-o", "c.8vo", *self.RAW,
                                     "--isotropic", *options)
                for word in words:
                    self.assertIn(word, result.stderr)
        self.expect_error(2, ["nearest"], "build", "thick.raw", "-o", "c.8vo", *self.THICK,
                          "--isotropic=nearest")
        self.assertEqual(self.files(), before)

    def test_cubes_stay_as_they_are_with_a_notice(self):
        told = self.build(*self.RAW, "--spacing", "2", "--isotropic", output="b.8vo")
        self.assertIn("cubes already", told.stderr)
        self.build(*self.RAW, "--spacing", "2", output="a.8vo")
        self.assertEqual((self.folder / "a.8vo").read_bytes(),
                         (self.folder / "b.8vo").read_bytes())
        self.assertNotIn("prepared", json.dumps(self.info("b.8vo")["metadata"]))


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
