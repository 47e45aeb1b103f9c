#!/usr/bin/env python3
"""Work on a large file in parts: what they find together is what one run finds.

usage: work_parts_test.py OCTAVO [unittest arguments]
"""

import json
import sys

import cli_test


class WorkInParts(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "20", "-o", "good.8vo", "-q")

    def test_parts_of_a_verification_join_to_what_one_says(self):
        flipped = bytearray((self.folder / "good.8vo").read_bytes())
        flipped[600] ^= 8
        (self.folder / "flip.8vo").write_bytes(flipped)
        for name, code in [("good.8vo", 0), ("flip.8vo", 4)]:
            for i in range(2):
                said = self.expect(0, "verify", name, "--part", f"{i}/2", "-o", f"found-{i}", "-f",
                                   "--json")
                self.assertNotIn("sound", json.loads(said.stdout))
            found = ["--join", "found-1", "found-0"]
            whole = self.expect(code, "verify", name, "--json")
            self.assertEqual(self.expect(code, "verify", name, "--json", *found).stdout,
                             whole.stdout)
        self.expect_error(2, ["of 2 these are missing: 1"], "verify", "flip.8vo", "--join",
                          "found-0")
        self.expect(0, "phantom", "--size", "21", "-o", "other.8vo", "-q")
        self.expect_error(2, ["is of another file"], "verify", "other.8vo", *found)
        self.expect_error(2, ["expected I/N"], "verify", "good.8vo", "--part", "3", "-o", "x")
        self.expect_error(2, ["numbered from 0"], "verify", "good.8vo", "--part", "2/2", "-o", "x")
        self.expect_error(2, ["-o FILE"], "verify", "good.8vo", "--part", "0/2")
        self.expect_error(2, ["-o goes with --part"], "verify", "good.8vo", "-o", "x")
        self.expect_error(2, ["--against"], "verify", "good.8vo", "--part", "0/2", "-o", "x",
                          "--spacing", "1")
        self.expect_error(2, ["--against"], "verify", "flip.8vo", *found, "--untilt")
        self.expect_error(4, ["no result of a part"], "verify", "good.8vo", "--join", "good.8vo")
        self.assertNotIn("x", self.files())

    def test_a_part_of_a_measurement_prints_no_table(self):
        self.expect_error(2, ["--csv", "--join"], "measure", "good.8vo", "--part", "0/2", "-o",
                          "x", "--csv")
        self.assertEqual(self.files(), ["good.8vo"])


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
