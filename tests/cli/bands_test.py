#!/usr/bin/env python3
"""Builds scans in parts that share groups of planes, and joins them.

usage: bands_test.py OCTAVO [unittest arguments]
"""

import array
import json
import os
import random
import re
import signal
import subprocess
import sys

import cli_test
import parts_test


class SharedGroups(parts_test.InParts):
    """Two parts share each of the three groups."""

    def setUp(self):
        super().setUp()
        self.begin_with(self.make_parts)

    def make_parts(self):
        self.plan("--bands", "2")
        self.part(0, "--parts", "4,1,5,0,2,3", "-o", "parts", "-q")

    def join(self, code, *arguments, **variables):
        return self.expect(code, "join", "scan.plan", "parts", *arguments, "-o", "scan.8vo",
                           "--progress", "none", env=parts_test.without_schedulers(**variables))

    def name(self, part):
        return f"parts/scan.part-000{part}-of-0006"

    def missing(self, code):
        return self.expect(code, "join", "scan.plan", "parts", "--missing", "--progress",
                           "none").stdout

    def test_every_way_to_join_makes_the_file_of_a_build(self):
        whole = self.built()
        self.join(0)
        self.assertEqual(self.bytes_of("scan.8vo"), whole)
        (self.folder / "scan.8vo").unlink()
        told = json.loads(self.join(0, "--runs", "--json").stdout)
        joined = b""
        for run in told["runs"]:
            with open(run["path"], "rb") as file:
                file.seek(run["offset"])
                joined += file.read(run["length"])
        self.assertEqual(joined, whole)
        told = json.loads(self.join(0, "--step", "copy", "--json", PBS_ARRAY_INDEX="2").stdout)
        self.assertEqual(told["copied"], [2])
        self.assertNotIn(2, told["uncopied"])
        self.join(0, "--step", "copy")
        self.join(0, "--step", "seal")
        self.assertEqual(self.bytes_of("scan.8vo"), whole)
        (self.folder / "scan.8vo").unlink()
        self.join(0, "--consume")
        self.assertEqual(self.bytes_of("scan.8vo"), whole)
        mark, *others = self.files()
        self.assertTrue(mark.startswith(".scan.8vo.join-done-"), mark)
        self.assertEqual(others, ["parts", "scan.8vo", "scan.plan", "scan.raw", "whole.8vo"])
        self.expect(0, "build", *self.raw, "--bands", "3", "-j", "2", "-o", "parted.8vo")
        self.assertEqual(self.bytes_of("parted.8vo"), whole)
        self.assertEqual(self.files(), [mark, "parted.8vo", *others])

    def test_a_part_made_twice_or_in_less_memory_has_the_same_bytes(self):
        first = self.bytes_of(self.name(3))
        self.assertIn("is there already", self.part(0, "--part", "3", "-o", "parts").stdout)
        self.part(0, "--part", "3", "-o", "parts", "--force", "--max-memory", "256M", "-j", "1")
        self.assertEqual(self.bytes_of(self.name(3)), first)
        within = ("--part", "3", "-o", "parts", "--force", "-j", "1", "--max-memory")
        told = self.part(6, *within, "200M").stderr
        needed = int(re.search(r"needs about (\d+) MiB", told).group(1))
        self.part(6, *within, f"{needed - 1}M")
        self.part(0, *within, f"{needed}M")
        self.assertEqual(self.bytes_of(self.name(3)), first)

    def test_missing_and_damaged_parts_are_named_alone_and_made_anew(self):
        good = self.bytes_of(self.name(2))
        for at in [20, 100, 520, len(good) // 2, len(good) - 5]:
            bad = bytearray(good)
            bad[at] ^= 4
            (self.folder / self.name(2)).write_bytes(bad)
            (self.folder / self.name(5)).unlink(missing_ok=True)
            self.assertEqual(self.missing(1), "2,5\n")
            self.assertIn("1 of 6 parts is missing: 5", self.join(5).stderr)
            self.part(0, "--part", "5", "-o", "parts", "-q")
            self.assertIn(self.name(2), self.join(4).stderr)
            self.assertNotIn("scan.8vo", self.files())
            self.part(0, "--part", "2", "-o", "parts", "-q")
            self.assertEqual(self.bytes_of(self.name(2)), good)
        self.assertEqual(self.missing(0), "")

    def test_a_band_of_another_plan_is_rejected(self):
        self.expect(0, "plan", *self.raw, "--bands", "2", "--access", "boxes", "-fo", "scan.plan")
        self.assertIn("is a part of another plan", self.join(2).stderr)
        self.assertIn("is a part of another plan",
                      self.part(2, "--part", "2", "-o", "parts").stderr)

    def test_a_source_changed_between_bands_is_rejected(self):
        (self.folder / self.name(5)).unlink()
        self.write_scan(parts_test.VOXELS[:-2] + b"\1\2")
        self.part(7, "--part", "5", "-o", "parts")
        self.assertEqual(self.missing(1), "5\n")

    def test_bands_of_other_voxels_are_missing_until_they_are_made_anew(self):
        times = os.stat(self.folder / "scan.raw")
        self.write_scan(parts_test.VOXELS[:-2] + b"\1\2")
        os.utime(self.folder / "scan.raw", ns=(times.st_atime_ns, times.st_mtime_ns))
        self.part(0, "--part", "5", "-o", "parts", "--force")
        self.assertIn("was made of other voxels of group 2", self.join(7).stderr)
        said = self.expect(1, "join", "scan.plan", "parts", "--missing", "--progress", "none")
        self.assertEqual(said.stdout, "4-5\n")
        self.assertIn("octavo part --force", said.stderr)
        self.part(0, "--parts", "4-5", "-o", "parts", "--force")
        self.assertEqual(self.missing(0), "")
        self.join(0)

    def test_a_limit_that_a_plan_takes_its_parts_take(self):
        wide = ("scan.raw", "--raw", "512,512,70,uint32", *self.raw[3:])

        def plan(code, limit):
            return self.expect(code, "plan", *wide, "--bands", "2", "-j", "1", "--max-memory",
                               f"{limit}M", "-fo", "low.plan")
        needed = int(re.search(r"needs about (\d+) MiB", plan(6, 1).stderr).group(1))
        plan(6, needed - 2)
        plan(0, needed)
        for part in "0", "3":
            self.expect(0, "part", "low.plan", "--part", part, "-j", "1", "--max-memory",
                        f"{needed}M", "-o", "low", "-q", "--progress", "none")

    def test_a_killed_band_leaves_nothing_under_its_name(self):
        command = [cli_test.OCTAVO, "part", "scan.plan", "--part", "2", "-o", "killed",
                   "--progress", "json", "-j", "1"]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True,
                              env=parts_test.without_schedulers()) as running:
            running.stderr.readline()
            running.send_signal(signal.SIGKILL)
            running.stderr.read()
            running.wait()
        self.assertNotIn("killed/scan.part-0002-of-0006", self.files())
        self.part(0, "--part", "2", "-o", "killed", "-q")
        self.assertEqual(self.bytes_of("killed/scan.part-0002-of-0006"),
                         self.bytes_of(self.name(2)))

    def test_floats_that_only_level_0_holds_are_told_once_of_each_file(self):
        numbers = random.Random(1)
        row = array.array("f", (numbers.gauss(0, 1) for _ in range(512))).tobytes()
        far = array.array("f", [1e30] * 3).tobytes() + row[12:]
        plane = row * 256
        (self.folder / "far.raw").write_bytes(
            (plane * 40 + far + row * 255 + plane * 23) * 2)  # in both groups
        words = ("far.raw", "--raw", "512,256,128,float32", "--spacing", "1", "--preset", "fast")
        whole = self.expect(0, "build", *words, "-o", "far.8vo", "--progress", "none").stderr
        parted = self.expect(0, "build", *words, "--bands", "4", "-o", "parted.8vo", "--progress",
                             "none").stderr
        told = re.compile(r"(\d+) voxels lie beyond what coarse levels hold")
        self.assertEqual(len(told.findall(whole)), 1, whole)
        self.assertEqual(told.findall(parted), told.findall(whole), parted)
        self.assertIn(": warning: parted.8vo: 6 voxels lie", parted)
        self.assertEqual(self.bytes_of("parted.8vo"), self.bytes_of("far.8vo"))
        # Each part says what it holds, each join what the file holds.
        self.expect(0, "plan", *words, "--parts", "2", "-o", "far.plan", "-q")
        said = self.expect(0, "part", "far.plan", "--parts", "0-1", "-o", "far", "-q").stderr
        self.assertEqual(told.findall(said), ["3", "3"], said)
        self.expect(7, "join", "far.plan", "far", "-o", "strict.8vo", "--strict", "-q")
        self.assertNotIn("strict.8vo", self.files())
        for how in ((), ("--consume",)):
            said = self.expect(0, "join", "far.plan", "far", "-o", "joined.8vo", "-fq", *how).stderr
            self.assertIn("joined.8vo: 6 voxels lie", said)

    def test_parts_in_two_folders_are_not_called_missing(self):
        (self.folder / "more").mkdir()
        told = self.expect(2, "join", "scan.plan", "parts", "more", "--missing")
        self.assertIn("give one folder that has all parts", told.stderr)
        self.assertEqual(told.stdout, "")

    def test_a_plan_says_how_many_share_a_group(self):
        said = self.expect(0, "plan", *self.raw[:-1], "--bands", "4", "-fo", "scan.plan").stdout
        self.assertIn("12, of which 4 share each group; each needs", said)
        told = json.loads(self.expect(0, "plan", *self.raw, "--bands", "1000", "-fo", "scan.plan",
                                      "--json").stdout)
        self.assertEqual((told["parts"], told["bands"]), (3 * 64, 64))
        whole = json.loads(self.expect(0, "plan", *self.raw, "--parts", "3", "-fo", "scan.plan",
                                       "--json").stdout)
        self.assertLess(told["part_memory_bytes"], whole["part_memory_bytes"])

    def test_what_has_no_bands_is_rejected_and_left_alone(self):
        self.expect_error(2, ["parts share no group whose voxels change"], "plan", *self.raw,
                          "--bands", "2", "--max-error", "2", "-o", "other.plan")
        self.expect_error(2, ["parts share no group whose voxels change"], "build", *self.raw,
                          "--bands", "2", "--keep-details", "1", "-o", "other.8vo")
        narrow = ("scan.raw", "--raw", "128,512,560,uint16", "--spacing", "1", "-q")
        self.expect_error(2, ["several layers of bricks"], "plan", *narrow, "--bands", "2", "-o",
                          "other.plan")
        self.expect(2, "plan", *self.raw, "--bands", "2", "--parts", "3", "-o", "other.plan")
        self.expect(2, "plan", *self.raw, "--bands", "0", "-o", "other.plan")
        self.expect(0, "plan", *narrow, "--bands", "1", "-o", "other.plan")
        self.assertNotIn("other.8vo", self.files())


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
