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
        for part, words in [("2/2", "runs from 0 to 1"), ("0/0", "1 part or more"),
                            ("0/100000", "65536 parts at most")]:
            self.expect_error(2, [words], "verify", "good.8vo", "--part", part, "-o", "x")
        self.expect_error(2, ["-o FILE"], "verify", "good.8vo", "--part", "0/2")
        self.expect_error(2, ["-o goes with --part"], "verify", "good.8vo", "-o", "x")
        self.expect_error(2, ["--against"], "verify", "good.8vo", "--part", "0/2", "-o", "x",
                          "--spacing", "1")
        self.expect_error(2, ["--against"], "verify", "flip.8vo", *found, "--untilt")
        self.expect_error(4, ["no result of a part"], "verify", "good.8vo", "--join", "good.8vo")
        self.assertNotIn("x", self.files())

    def test_what_a_part_found_never_replaces_a_file_that_it_is_of(self):
        self.expect(0, "threshold", "good.8vo", "--range", "1:", "-o", "mask.8vo", "-q")
        part = ["--part", "0/2", "-f", "-o"]
        for output, words in [("good.8vo", ["verify", "good.8vo", *part]),
                              ("mask.8vo", ["components", "mask.8vo", *part]),
                              ("mask.8vo", ["measure", "mask.8vo", *part]),
                              ("good.8vo", ["measure", "mask.8vo", "--of", "good.8vo", *part])]:
            before = (self.folder / output).read_bytes()
            self.expect_error(2, [f"{output}: is the input itself"], *words, output)
            self.assertEqual((self.folder / output).read_bytes(), before)
        names = self.find_parts(2)
        self.expect_error(2, ["found-0: is the input itself"], "components", "mask.8vo", "--join",
                          *names, "-f", "-o", "found-0")

    def test_a_part_of_a_measurement_prints_no_table(self):
        self.expect_error(2, ["--csv", "--join"], "measure", "good.8vo", "--part", "0/2", "-o",
                          "x", "--csv")
        self.assertEqual(self.files(), ["good.8vo"])

    def find_parts(self, count, *options):
        """The names of what so many parts found."""
        names = [f"found-{i}" for i in range(count)]
        for i, name in enumerate(names):
            self.expect(0, "components", "mask.8vo", "--part", f"{i}/{count}", "-o", name, "-fq",
                        *options)
        return names

    def noise(self):
        self.random_raw("noise.raw", (40, 30, 200))
        self.expect(0, "build", "noise.raw", "--raw", "40,30,200,int16", "--spacing", "1", "-o",
                    "noise.8vo", "-q")
        self.expect(0, "threshold", "noise.8vo", "--range", "700:", "-o", "mask.8vo", "-q")

    def test_components_of_parts_are_those_of_one_run(self):
        self.noise()
        for options in ([], ["--connectivity", "18"]):
            found = self.find_parts(3, *options)
            for kept in ([], ["--keep-largest", "30"], ["--min-mm3", "4"]):
                asked = ["components", "mask.8vo", *options, *kept]
                whole = [self.expect(0, *asked, *how).stdout for how in ([], ["--json"])]
                join = [*asked, "--join", *reversed(found)]
                self.assertEqual([self.expect(0, *join, *how).stdout for how in ([], ["--json"])],
                                 whole)
                self.expect(0, *join, "-o", "all.numbers", "-fq")
                self.expect(0, *asked, "-o", "once.8vo", "-fq")
                said = json.loads(self.expect(0, "components", "mask.8vo", "--numbers",
                                              "all.numbers", "-fo", "labels.8vo", "--json").stdout)
                self.assertEqual((self.folder / "labels.8vo").read_bytes(),
                                 (self.folder / "once.8vo").read_bytes())
                self.assertEqual(said["kept"], json.loads(whole[1])["kept"])

    def test_parts_of_components_that_do_not_fit_are_rejected(self):
        self.noise()
        found = self.find_parts(2)
        self.expect(0, "components", "mask.8vo", "--join", *found, "-o", "all.numbers", "-q")
        files = self.files()
        for code, words, arguments in [
            (2, ["these are missing: 1"], ["--join", "found-0"]),
            (2, ["connectivity"], ["--join", *found, "--connectivity", "26"]),
            (2, ["name of a volume"], ["--join", *found, "-o", "x.8vo"]),
            (2, ["expected I/N"], ["--part", "3", "-o", "x"]),
            (2, ["-o FILE"], ["--part", "0/2"]),
            (2, ["--rows", "--part"], ["--part", "0/2", "-o", "x", "--rows", "3"]),
            (2, ["-o FILE"], ["--numbers", "all.numbers"]),
            (2, ["--numbers"], ["--numbers", "all.numbers", "-o", "x.8vo", "--min-mm3", "1"]),
            (4, ["another verb"], ["--numbers", "found-0", "-o", "x.8vo"]),
            (4, ["no result of a part"], ["--join", "mask.8vo"]),
        ]:
            with self.subTest(arguments):
                self.expect_error(code, words, "components", "mask.8vo", *arguments)
        self.expect(0, "threshold", "noise.8vo", "--range", "701:", "-o", "other.8vo", "-q")
        self.expect_error(2, ["another mask"], "components", "other.8vo", "--numbers",
                          "all.numbers", "-o", "x.8vo")
        (self.folder / "other.8vo").unlink()
        self.assertEqual(self.files(), files)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
