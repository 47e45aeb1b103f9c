#!/usr/bin/env python3
"""build --keep-details: what it prints, what the file says of itself, what other verbs make of it.

usage: kept_details_test.py OCTAVO
"""

import array
import hashlib
import json
import math
import os
import sys
import unittest

import cli_test

SIZE = (100, 70, 66)


class KeptDetails(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", ",".join(map(str, SIZE)), "--noise", "9", "-q",
                    "-o", "scan.mhd")
        self.expect(0, "build", "scan.mhd", "-o", "whole.8vo", "-q")

    def build(self, level, *options):
        return self.expect(0, "build", "scan.mhd", "--keep-details", level, "-o", "kept.8vo", "-f",
                           *options).stdout

    def voxels(self, name, *options):
        self.expect(0, "export", name, "--stored", "-o", "voxels.raw", "-f", "-q", *options)
        return array.array("h", (self.folder / "voxels.raw").read_bytes())

    def test_the_error_is_that_of_the_voxels_and_told_by_build_and_info(self):
        said = json.loads(self.build(1, "--json"))["detail_errors"]
        pairs = list(zip(self.voxels("whole.8vo"), self.voxels("kept.8vo")))
        differences = [a - b for a, b in pairs]
        span = max(a for a, _ in pairs) - min(a for a, _ in pairs)
        rms = math.sqrt(sum(d * d for d in differences) / len(differences))
        self.assertEqual(said["max"], max(map(abs, differences)))
        self.assertAlmostEqual(said["rms"], rms, places=6)
        self.assertAlmostEqual(said["psnr_db"], 20 * math.log10(span / rms), delta=0.006)
        info = self.info("kept.8vo")
        self.assertEqual(info["detail_errors"], said)
        self.assertEqual(info["detail_level"], 1)
        self.assertEqual(info["max_error"], said["max"])
        self.assertFalse(info["lossless"])
        self.assertEqual(info["metadata"]["coding"], {"keep_details": 1, "detail_errors": said})
        words = f"largest error {said['max']:g}, RMS {rms:.4g}, PSNR {said['psnr_db']:.2f} dB"
        self.assertIn(", " + words + ", ", self.build(1))
        shown = self.expect(0, "info", "kept.8vo").stdout
        self.assertIn(f"details      from level 1 on; {words}\n", shown)
        self.assertIn("grey, interpolated where fine\n", shown)

    def test_levels_without_details_take_no_bytes_and_the_others_are_unchanged(self):
        for level in (1, 2, 5):
            self.build(level, "-q")
            stored = [one["bytes"] for one in self.info("kept.8vo")["levels"]]
            separate = min(level, 3)  # the others share a piece
            # Bricks too small to be coded have their samples in front.
            self.assertLess(sum(stored[:separate]), 200)
            for one in range(level, len(stored)):
                self.assertEqual(self.voxels("kept.8vo", "--level", one),
                                 self.voxels("whole.8vo", "--level", one), f"level {one}")

    def test_the_digest_is_that_of_the_voxels_as_they_are_read(self):
        self.build(2, "-q")
        voxels = self.voxels("kept.8vo").tobytes()
        plane = 2 * SIZE[0] * SIZE[1]
        digests = [hashlib.sha256(voxels[at : at + plane]).digest()
                   for at in range(0, len(voxels), plane)]
        self.assertEqual(self.info("kept.8vo")["voxels_sha256"],
                         hashlib.sha256(b"".join(digests)).hexdigest())
        self.expect(0, "verify", "kept.8vo", "-q")

    def test_other_verbs_take_the_interpolated_voxels(self):
        self.build(1, "-q")
        largest = self.info("kept.8vo")["max_error"]
        self.expect(1, "compare", "kept.8vo", "scan.mhd", "-q")
        self.expect(0, "compare", "kept.8vo", "scan.mhd", "--max-error", largest, "-q")
        self.expect(0, "export", "kept.8vo", "-o", "kept.mhd", "-q")
        self.expect(0, "compare", "kept.8vo", "kept.mhd", "-q")
        self.expect(0, "slice", "kept.8vo", "--axis", "z", "--index", "64", "-o", "kept.png", "-q")
        # Bricks that their ranges decide are not decoded: as many voxels as in a file of the same.
        self.expect(0, "build", "kept.mhd", "-o", "again.8vo", "-q")
        digests = []
        for name in ("kept", "again"):
            self.expect(0, "threshold", f"{name}.8vo", "--range", "200:", "-o", f"{name}-m.8vo",
                        "-q")
            self.expect(0, "measure", f"{name}-m.8vo", "--of", f"{name}.8vo", "-q")
            digests.append(self.info(f"{name}-m.8vo")["voxels_sha256"])
        self.assertEqual(*digests)
        voxel = json.loads(self.expect(0, "probe", "kept.8vo", "--at", "63,31,64",
                                       "--json").stdout)
        at = (64 * SIZE[1] + 31) * SIZE[0] + 63
        self.assertEqual(json.dumps(voxel).count(f'"stored": {self.voxels("kept.8vo")[at]}'), 1,
                         voxel)

    def test_what_is_built_of_such_a_file_says_how_far_its_source_was(self):
        self.build(1, "-q")
        largest = self.info("kept.8vo")["max_error"]
        self.expect(0, "build", "kept.8vo", "-o", "again.8vo", "-q")
        info = self.info("again.8vo")
        self.assertTrue(info["lossless"] and info["source_lossy"])
        self.assertEqual(info["metadata"]["source_max_error"], largest)
        self.assertEqual(info["detail_level"], 0)

    def test_what_cannot_be_left_out_is_a_usage_error(self):
        for level in ("0", "6", "-1", "1.5", "all"):
            self.expect_error(2, ["--keep-details"], "build", "scan.mhd", "-o", "b.8vo",
                              "--keep-details", level)
        layout = self.random_raw("tiny.raw", (3, 2, 2))
        table = [
            (["details cannot be kept from level 3 on; give --keep-details 1 to 2"],
             ["tiny.raw", "--raw", layout, "--spacing", "1", "--keep-details", "3"]),
            (["without details no max error is kept", "leave out --keep-details"],
             ["scan.mhd", "--keep-details", "1", "--max-error", "2"]),
            (["no bytes to be cut into parts", "leave out --keep-details"],
             ["scan.mhd", "--keep-details", "1", "--access", "boxes"]),
            (["label maps are always lossless", "leave out --keep-details"],
             ["tiny.raw", "--raw", layout, "--spacing", "1", "--labels", "--keep-details", "1"]),
        ]
        for words, arguments in table:
            with self.subTest(arguments):
                self.expect_error(2, words, "build", *arguments, "-o", "b.8vo")
                self.assertNotIn("b.8vo", self.files())


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
