#!/usr/bin/env python3
"""Joins the parts of a scan in steps, by consuming them, and from listed runs.

usage: joins_test.py OCTAVO [unittest arguments]
"""

import json
import os
import sys

import cli_test
import parts_test
from parts_test import PLANE, VOXELS, without_schedulers


class JoinedInOtherWays(parts_test.InParts):
    """All tests begin with copies of the same parts."""

    def setUp(self):
        super().setUp()
        self.begin_with(self.make_parts)
        self.whole = self.bytes_of("whole.8vo")

    def make_parts(self):
        self.built()
        self.plan("--parts", "3")
        self.part(0, "--parts", "0-2", "-o", "parts", "-q")

    def step(self, code, *arguments, **variables):
        return self.expect(code, "join", "scan.plan", "parts", *arguments, "-o", "scan.8vo",
                           "--progress", "none", env=without_schedulers(**variables))

    def test_a_join_in_steps_makes_the_same_file(self):
        self.assertEqual(self.step(5, "--step", "copy").stdout, "")
        self.step(0, "--step", "layout")
        self.step(0, "--step", "layout")
        self.step(0, "--step", "copy", "--part", "1")
        told = json.loads(self.step(0, "--step", "copy", "--json", PBS_ARRAY_INDEX="2").stdout)
        self.assertEqual((told["copied"], told["uncopied"]), ([2], [0]))
        self.assertIn("1 of 3 parts was not copied: 0", self.step(5, "--step", "seal").stderr)
        self.assertNotIn("scan.8vo", self.files())
        self.step(0, "--step", "copy")
        self.step(0, "--step", "seal")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)
        self.step(0, "--step", "seal")
        self.assertIn("is joined already", self.step(0, "--step", "copy", "--part", "1").stdout)
        for part in (self.folder / "parts").iterdir():
            part.rename(self.folder / part.name)
        self.assertEqual(self.step(0, "--missing").stdout, "")
        for part in self.folder.glob("scan.part-*"):
            part.rename(self.folder / "parts" / part.name)
        (mark,) = [name for name in self.files() if name.startswith(".")]
        self.assertTrue(mark.startswith(".scan.8vo.join-done-"), mark)
        self.step(0, "--force")
        self.assertEqual([name for name in self.files() if name.startswith(".")], [])

    def test_a_join_in_one_leaves_nothing_of_one_in_steps(self):
        self.step(0, "--step", "layout")
        self.step(0, "--step", "copy", "--part", "1")
        self.step(0)
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)
        self.assertEqual([name for name in self.files() if name.startswith(".")], [])

    def test_only_the_file_that_steps_have_sealed_is_taken_for_sealed(self):
        self.expect(0, "join", "scan.plan", "parts", "-o", "scan.8vo", "-q")
        self.assertIn("nothing is laid out", self.step(5, "--step", "seal").stderr)
        (self.folder / "scan.8vo").unlink()
        for step in ("layout", "copy", "seal", "seal"):
            self.step(0, "--step", step)
        self.write_scan(VOXELS[:2 * PLANE * 100] + b"\1\2\3\4" + VOXELS[2 * PLANE * 100 + 4:])
        self.expect(0, "plan", *self.raw, "-f", "--parts", "3", "-o", "scan.plan")
        self.assertIn("nothing is laid out", self.step(5, "--step", "seal").stderr)

    def test_a_join_that_consumes_its_parts_makes_the_same_file(self):
        self.step(0, "--consume")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)
        (mark, *files) = self.files()
        self.assertTrue(mark.startswith(".scan.8vo.join-done-"), mark)
        self.assertEqual(files, ["parts", "scan.8vo", "scan.plan", "scan.raw", "whole.8vo"])

    def test_a_join_that_has_consumed_its_parts_ends_well_when_it_is_given_again(self):
        self.step(0, "--consume")
        for force in [], ["-f"]:
            said = self.step(0, "--consume", *force)
            self.assertIn("scan.8vo: is joined already", said.stderr)
            self.assertEqual(self.bytes_of("scan.8vo"), self.whole)
        self.part(0, "--part", "1", "-o", "parts", "-q")
        self.assertIn("is joined already", self.step(0, "--consume").stderr)
        self.assertEqual(len([name for name in self.files() if ".part-" in name]), 1)
        self.expect_error(5, ["2 of 3 parts are missing"], "join", "scan.plan", "parts",
                          "--consume", "-f", "-o", "scan.8vo")
        (self.folder / "scan.8vo").write_bytes(self.whole[:-1])
        self.expect_error(5, ["exists already"], "join", "scan.plan", "parts", "--consume", "-o",
                          "scan.8vo")

    def test_a_part_that_is_copied_already_is_consumed_as_well(self):
        self.step(0, "--step", "layout")
        self.step(0, "--step", "copy", "--part", "1")
        self.assertEqual(len([n for n in self.files() if ".part-" in n]), 3)
        arguments = ("--step", "copy", "--consume", "--json")
        told = json.loads(self.step(0, *arguments, "--part", "1").stdout)
        self.assertEqual((told["copied"], told["uncopied"]), ([], [0, 2]))
        self.assertEqual(len([n for n in self.files() if ".part-" in n]), 2)
        self.step(0, "--step", "copy", "--part", "2")
        told = json.loads(self.step(0, *arguments).stdout)
        self.assertEqual((told["copied"], told["uncopied"]), ([0], []))
        self.assertEqual([n for n in self.files() if ".part-" in n], [])
        self.step(0, *arguments)
        self.step(0, "--step", "seal")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)

    def test_parts_that_a_join_holds_are_not_missing(self):
        self.step(0, "--step", "layout")
        self.step(0, "--step", "copy", "--part", "1", "--consume")
        (self.folder / "parts/scan.part-0002-of-0003").unlink()
        for output in [], ["-o", "scan.8vo"]:
            said = self.expect(1, "join", "scan.plan", "parts", "--missing", *output, "--progress",
                               "none")
            self.assertEqual(said.stdout, "2\n")
            self.assertIn("scan.8vo: a join that has begun here holds 1 part", said.stderr)
        self.assertEqual(self.expect(1, "join", "scan.plan", "parts", "--missing", "-o",
                                     "other.8vo").stdout, "1-2\n")
        self.part(0, "--part", "2", "-o", "parts", "-q")
        self.assertEqual(self.expect(0, "join", "scan.plan", "parts", "--missing").stdout, "")
        said = self.step(5)
        self.assertIn("1 of 3 parts is missing: 1; a join that has begun here holds 1 of them; "
                      "--consume goes on with it", said.stderr)
        self.step(0, "--consume")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)

    def test_nothing_is_consumed_where_a_part_is_damaged(self):
        name = "parts/scan.part-0002-of-0003"
        bad = bytearray(self.bytes_of(name))
        bad[len(bad) // 2] ^= 4
        (self.folder / name).write_bytes(bad)
        self.step(4, "--consume")
        self.assertEqual(len([n for n in self.files() if ".part-" in n]), 3)
        self.assertNotIn("scan.8vo", self.files())

    def begin(self):
        """Parts 0 and 1 are copied and gone. Returns where the growing file holds what."""
        told = json.loads(self.step(0, "--runs", "--json").stdout)
        self.step(0, "--step", "copy", "--parts", "0-1", "--consume")
        places, at = {}, 0
        for run in told["runs"]:
            places.setdefault(os.path.basename(run["path"]), at + run["length"] // 2)
            at += run["length"]
        return places

    def flip(self, at):
        growing = bytearray(self.bytes_of(".scan.8vo.join"))
        growing[at] ^= 4
        (self.folder / ".scan.8vo.join").write_bytes(growing)

    def count_parts(self):
        return len([name for name in self.files() if ".part-" in name])

    def test_a_file_is_sealed_when_all_that_was_copied_is_whole(self):
        self.flip(self.begin()["scan.part-0000-of-0003"])
        self.step(0, "--step", "copy")
        said = self.step(4, "--step", "seal").stderr
        self.assertIn("changed since they were copied: part 0; --step copy copies", said)
        self.assertNotIn("scan.8vo", self.files())
        self.assertEqual(self.step(1, "--missing").stdout, "0\n")
        self.part(0, "--part", "0", "-o", "parts", "-q")
        self.step(0, "--step", "copy")
        self.step(0, "--step", "seal")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)

    def test_a_consuming_join_that_goes_on_proves_what_was_copied(self):
        self.flip(self.begin()["scan.part-0001-of-0003"])
        self.assertEqual(self.step(1, "--missing").stdout, "1\n")
        said = self.step(4, "--consume").stderr
        self.assertIn("part 1; no part is removed; octavo part scan.plan --part 1 makes one", said)
        self.assertEqual(self.count_parts(), 1)
        self.part(0, "--part", "1", "-o", "parts", "-q")
        self.step(0, "--consume")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)

    def test_a_growing_file_that_is_damaged_elsewhere_takes_no_part(self):
        self.flip(self.begin()[".scan.8vo.join"])
        self.assertEqual(self.step(1, "--missing").stdout, "0-1\n")
        self.assertIn("remove .scan.8vo.join*", self.step(4, "--consume").stderr)
        self.assertEqual(self.count_parts(), 1)
        self.step(0, "--step", "copy")
        self.assertIn("remove .scan.8vo.join*", self.step(4, "--step", "seal").stderr)
        self.assertNotIn("scan.8vo", self.files())

    def test_nothing_more_is_consumed_where_a_part_is_missing(self):
        self.step(0, "--step", "layout")
        self.step(0, "--step", "copy", "--part", "0", "--consume")
        (self.folder / "parts/scan.part-0001-of-0003").unlink()
        said = self.step(5, "--consume").stderr
        self.assertIn("1 of 3 parts is missing: 1; octavo part scan.plan --part 1 makes one", said)
        self.assertEqual(self.count_parts(), 1)

    def test_what_stands_in_the_place_of_a_part_that_is_held_is_left(self):
        damaged = bytearray(self.bytes_of("parts/scan.part-0001-of-0003"))
        damaged[500] ^= 1
        self.begin()
        (self.folder / "parts/scan.part-0000-of-0003").write_text("my notes")
        (self.folder / "parts/scan.part-0001-of-0003").write_bytes(damaged)
        self.assertEqual(self.step(0, "--missing").stdout, "")
        self.step(0, "--consume")
        self.assertEqual(self.bytes_of("scan.8vo"), self.whole)
        self.assertEqual(self.bytes_of("parts/scan.part-0000-of-0003"), b"my notes")

    def test_a_part_is_not_the_output(self):
        (self.folder / "scan.8vo").symlink_to("parts/scan.part-0001-of-0003")
        for way in ("-f",), ("-f", "--consume"), ("-f", "--step", "layout"):
            self.assertIn("scan.8vo: is the input itself", self.step(2, *way).stderr)
        self.assertEqual(self.count_parts(), 3)

    def test_what_killed_joins_were_writing_goes(self):
        for way in (), ("-f", "--consume"):
            for name in "..scan.8vo.join.tmp-7", "..scan.8vo.join-copied-1-3-4.tmp-9":
                (self.folder / name).write_text("begun")
            (self.folder / "..other.8vo.join.tmp-7").write_text("begun")
            self.step(0, *way)
            hidden = [name for name in self.files() if name.startswith("..")]
            self.assertEqual(hidden, ["..other.8vo.join.tmp-7"])

    def test_a_join_keeps_to_limits(self):
        for limit in ("--max-voxels", "1000"), ("--max-memory", "1M"):
            for way in (), ("--consume",), ("--step", "layout"), ("--runs",):
                with self.subTest(limit + way):
                    self.assertIn("the limit is", self.step(6, *limit, *way).stderr)
        self.assertEqual([name for name in self.files() if "join" in name], [])
        self.assertEqual(self.count_parts(), 3)

    def test_the_listed_runs_are_the_file(self):
        told = json.loads(self.step(0, "--runs", "--json").stdout)
        joined = b""
        for run in told["runs"]:
            self.assertTrue(os.path.isabs(run["path"]))
            with open(run["path"], "rb") as file:
                file.seek(run["offset"])
                joined += file.read(run["length"])
        self.assertEqual(len(joined), told["file_bytes"])
        self.assertEqual(joined, self.whole)
        of_parts = sum(run["length"] for run in told["runs"] if ".part-" in run["path"])
        self.assertGreater(of_parts, 0.9 * len(joined))
        lines = self.step(0, "--runs").stdout.splitlines()
        self.assertEqual(len(lines), len(told["runs"]))

    def test_options_of_steps_that_do_not_fit_are_rejected(self):
        for arguments in [("--part", "1"), ("--step", "seal", "--parts", "0-1"),
                          ("--step", "layout", "--missing"), ("--runs", "--consume"),
                          ("--step", "layout", "--consume"), ("--step", "seal", "--consume")]:
            with self.subTest(arguments):
                self.step(2, *arguments)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
