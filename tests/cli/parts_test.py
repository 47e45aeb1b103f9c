#!/usr/bin/env python3
"""Builds scans in parts, as job arrays do, and joins them.

usage: parts_test.py OCTAVO [unittest arguments]

The volume has three groups of planes; everything is generated.
"""

import array
import json
import os
import random
import shlex
import shutil
import signal
import subprocess
import sys

import cli_test
from shared_folder import folder_of

SIZE = (512, 512, 140)  # of uint16: groups of 64, 64 and 12 planes
PLANE = SIZE[0] * SIZE[1]

SCHEDULERS = ["SLURM_ARRAY_TASK_ID", "PBS_ARRAY_INDEX", "LSB_JOBINDEX", "SGE_TASK_ID",
              "AWS_BATCH_JOB_ARRAY_INDEX", "JOB_COMPLETION_INDEX", "OMPI_COMM_WORLD_RANK",
              "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"]


def voxels():
    """Planes that differ in a block of 64 x 32 voxels; all else is 0, which is encoded fast."""
    numbers = random.Random(5)
    planes = []
    for z in range(SIZE[2]):
        plane = bytearray(2 * PLANE)
        for y in range(32):
            noise = numbers.choices(range(9), k=64)
            row = array.array("H", (x * y % 700 + noise[x] for x in range(64)))
            begin = 2 * (SIZE[0] * (y + z) + 192)
            plane[begin:begin + 128] = row.tobytes()
        planes.append(bytes(plane))
    return b"".join(planes)


VOXELS = voxels()


def without_schedulers(**variables):
    kept = {name: value for name, value in os.environ.items()
            if not name.startswith(("SLURM_", "PBS_", "OMPI_", "PMI"))
            and name not in SCHEDULERS}
    return {**kept, **variables}


class InParts(cli_test.InFolder):
    @classmethod
    def setUpClass(cls):
        cls.scan = folder_of(cls) / "scan.raw"
        cls.scan.write_bytes(VOXELS)

    def setUp(self):
        """The scan is shared: a test that changes it writes its own."""
        super().setUp()
        os.link(self.scan, self.folder / "scan.raw")

    def begin_with(self, make):
        """What `make` puts beside the scan, made once for all tests of the class."""
        made = self.scan.parent / "made"
        if made.exists():
            shutil.copytree(made, self.folder, dirs_exist_ok=True)
        else:
            make()
            shutil.copytree(self.folder, made, ignore=shutil.ignore_patterns("scan.raw"))

    def write_scan(self, voxels_of_it):
        (self.folder / "scan.raw").unlink()
        (self.folder / "scan.raw").write_bytes(voxels_of_it)

    raw = ("scan.raw", "--raw", "512,512,140,uint16", "--spacing", "1", "--preset", "fast", "-q")

    def plan(self, *options):
        self.expect(0, "plan", *self.raw, *options, "-o", "scan.plan")

    def part(self, code, *arguments, **variables):
        return self.expect(code, "part", "scan.plan", *arguments, "--progress", "none",
                           env=without_schedulers(**variables))

    def built(self):
        self.expect(0, "build", *self.raw, "-o", "whole.8vo")
        return (self.folder / "whole.8vo").read_bytes()

    def bytes_of(self, name):
        return (self.folder / name).read_bytes()


class Joined(InParts):
    def test_a_file_joined_from_parts_is_that_of_a_build(self):
        whole = self.built()
        self.plan("--parts", "2")
        self.part(0, "--part", "1", "-o", "parts")
        self.part(0, "--part", "0", "-o", "parts")
        self.expect(0, "join", "scan.plan", "parts", "-o", "scan.8vo")
        self.assertEqual(self.bytes_of("scan.8vo"), whole)
        self.expect(0, "build", *self.raw, "--parts", "3", "-o", "parted.8vo")
        self.assertEqual(self.bytes_of("parted.8vo"), whole)
        self.assertEqual(self.files(), [
            "parted.8vo", "parts", "scan.8vo", "scan.part-0000-of-0002",
            "scan.part-0001-of-0002", "scan.plan", "scan.raw", "whole.8vo"])

    def test_an_export_that_comes_back_with_other_voxels_is_told_of_in_parts_as_well(self):
        self.expect(0, "phantom", "--size", "32", "-o", "a.8vo", "-q")
        self.expect(0, "export", "a.8vo", "-o", "a.zarr", "-q")
        for is_whole in (True, False):
            if not is_whole:
                (self.folder / "a.zarr" / "0" / "c" / "0" / "0" / "0").unlink()
            for how in ([], ["--parts", "1"]):
                done = self.expect(0, "build", "a.zarr", *how, "-o", "b.8vo", "--force", "-q")
                self.assertEqual(done.stderr.count("are not those that were exported"),
                                 0 if is_whole else 1, how)

    def test_a_part_made_twice_has_the_same_bytes(self):
        self.plan("--parts", "3")
        self.part(0, "--part", "1")
        first = self.bytes_of("scan.part-0001-of-0003")
        again = self.part(0, "--part", "1")
        self.assertIn("part 1 of 3 is there already", again.stdout)
        made = json.loads(self.part(0, "--part", "1", "--force", "--json").stdout)
        self.assertFalse(made["parts"][0]["was_there"])
        self.assertEqual(self.bytes_of("scan.part-0001-of-0003"), first)

    def test_more_parts_than_groups_are_as_many_as_groups_and_that_is_told(self):
        for option, asked, made, words in (
                ("--parts", 50, {"parts": 3}, "3 parts in place of 50"),
                ("--bands", 900, {"bands": 64, "parts": 192},
                 "64 parts share each group in place of 900"),
                ("--parts", 3, {"parts": 3}, None), ("--part-size", "40M", {"parts": 3}, None)):
            with self.subTest(option=option, asked=asked):
                done = self.expect(0, "plan", *self.raw[:-1], option, asked, "-fo", "scan.plan",
                                   "--json", "--progress", "none")
                told = json.loads(done.stdout)
                self.assertEqual(told, told | made)
                self.assertEqual(told["asked_parts"], asked if option == "--parts" else None)
                self.assertEqual(told["asked_bands"], asked if option == "--bands" else None)
                self.assertIn(words or "", done.stderr)
                self.assertEqual("in place of" in done.stderr, words is not None)
        self.part(0, "--parts", "0-2")
        self.assertIn("scan.part-0002-of-0003", self.files())

    def test_a_plan_says_what_a_part_needs_and_what_comes_next(self):
        raw = self.raw[:-1]
        said = self.expect(0, "plan", *raw, "--part-size", "40M", "-o", "scan.plan").stdout
        self.assertIn("512 x 512 x 140 voxels of uint16, 73.4 MB; 3 groups of 64 planes", said)
        self.assertIn("3 of 1 group; each needs", said)
        self.assertIn("octavo join scan.plan parts/ -o scan.8vo", said)
        said = self.expect(0, "plan", *raw, "-o", "bob's \"own\".plan").stdout
        line = next(line for line in said.splitlines() if "--wrap" in line)
        self.assertEqual(shlex.split(shlex.split(line)[-1])[2], "bob's \"own\".plan")
        told = json.loads(self.expect(0, "plan", *raw, "-fo", "scan.plan", "--json").stdout)
        self.assertEqual((told["groups"], told["parts"]), (3, 1))
        self.assertGreater(told["part_memory_bytes"], 2 * told["group_bytes"])
        self.assertFalse(told["reads_from_start"])


class Computed(InParts):
    """Volumes that verbs compute, planned and joined: what the verb itself writes."""

    def setUp(self):
        super().setUp()
        self.begin_with(lambda: self.expect(0, "build", *self.raw, "-o", "grey.8vo"))

    def check(self, *work, parts=2, once=()):
        """once: other words for the same volume."""
        self.expect(0, *(once or work), "-o", "once.8vo", "-q", "-f")
        self.expect(0, "plan", "--parts", parts, "-o", "work.plan", "-f", "-q", "--", *work)
        for part in reversed(range(parts)):
            self.expect(0, "part", "work.plan", "--part", part, "-f", "-q")
        self.expect(0, "join", "work.plan", "-o", "joined.8vo", "-f", "-q")
        self.assertEqual((self.folder / "joined.8vo").read_bytes(),
                         (self.folder / "once.8vo").read_bytes(), work)

    def test_what_verbs_compute_is_the_same_in_parts(self):
        self.check("threshold", "grey.8vo", "--range", "300:")
        self.check("threshold", "grey.8vo", "--class", "1=300:600", "--class", "7=:0")
        self.check("condense", "grey.8vo", "--flat", "40")
        self.check("transform", "grey.8vo", "--mirror", "z", "--preset", "fast")
        self.check("transform", "grey.8vo", "--rotate", "z:10", "--preset", "fast")
        self.expect(0, "threshold", "grey.8vo", "--range", "300:", "-o", "a.8vo", "-q")
        self.expect(0, "threshold", "grey.8vo", "--range", ":600", "-o", "b.8vo", "-q")
        for operation in ("--union", "--intersect", "--subtract", "--xor"):
            self.check("combine", "a.8vo", "b.8vo", operation)
        self.check("combine", "a.8vo", "--complement")
        for count in (1, 3):
            found = [f"found-{i}" for i in range(count)]
            for i, name in enumerate(found):
                self.expect(0, "components", "a.8vo", "--part", f"{i}/{count}", "-fqo", name)
            self.expect(0, "components", "a.8vo", "--join", *found, "-fqo", "all.numbers")
            self.check("components", "a.8vo", "--numbers", "all.numbers",
                       once=("components", "a.8vo"))

    def test_numbers_of_components_are_an_input_of_their_plan(self):
        self.expect(0, "threshold", "grey.8vo", "--range", "300:", "-o", "a.8vo", "-q")
        self.expect(0, "components", "a.8vo", "--part", "0/1", "-qo", "found")
        self.expect(0, "components", "a.8vo", "--join", "found", "-qo", "all.numbers")
        self.expect(0, "plan", "--parts", "2", "-o", "work.plan", "-q", "--", "components",
                    "a.8vo", "--numbers", "all.numbers")
        self.expect(0, "components", "a.8vo", "--join", "found", "--keep-largest", "3", "-fqo",
                    "all.numbers")
        self.expect_error(7, ["all.numbers", "was changed"], "part", "work.plan", "--part", "0")

    def test_options_of_every_verb_stand_before_plan_as_well(self):
        for options in (["-j", "2"], ["--max-memory", "2G", "-q"], ["--quiet"]):
            self.expect(0, *options, "plan", "-f", "-o", "work.plan", "--", "threshold",
                        "grey.8vo", "--range", "300:")

    def test_a_plan_never_replaces_a_file_of_its_source(self):
        (self.folder / "scan.nhdr").write_text(
            "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 512 512 140\nendian: little\n"
            "spacings: 1 1 1\nencoding: raw\ndata file: scan.raw\n")
        before = {name: self.bytes_of(name) for name in self.files()}
        for output in ("scan.nhdr", "scan.raw"):
            said = self.expect(2, "plan", "-f", "-o", output, "scan.nhdr").stderr
            self.assertIn(f"{output}: is the input itself", said)
        self.assertEqual({name: self.bytes_of(name) for name in self.files()}, before)

    def test_what_cannot_be_planned_is_said(self):
        for words, arguments in [
            (["copied as they are"], ["--", "transform", "grey.8vo", "--translate", "1,0,0"]),
            (["octrees"], ["--", "combine", "grey.8vo", "grey.8vo", "--union", "--resample"]),
            (["threshold, condense"], ["--", "measure", "grey.8vo"]),
            (["components --join"], ["--", "components", "grey.8vo"]),
            (["octavo join"], ["--", "threshold", "grey.8vo", "--range", "1:", "-o", "a.8vo"]),
            (["before --"], ["--", "threshold", "grey.8vo", "--range", "1:", "-j", "2"]),
            (["octavo threshold --help"], ["--", "threshold", "grey.8vo", "--rang", "1:"]),
            (["behind --"], ["--preset", "fast", "--", "threshold", "grey.8vo", "--range", "1:"]),
            (["a source is required"], []),
        ]:
            with self.subTest(arguments):
                said = self.expect(2, "plan", "-o", "work.plan", *arguments).stderr
                self.assertEqual(said.count("\n"), 1, said)
                for word in words:
                    self.assertIn(word, said)
        self.assertEqual(self.files(), ["grey.8vo", "scan.raw"])


class Rejected(InParts):
    def setUp(self):
        super().setUp()
        self.begin_with(self.make_two_of_three_parts)

    def make_two_of_three_parts(self):
        self.plan("--parts", "3")
        self.part(0, "--parts", "0,2", "-q")

    def test_missing_parts_are_listed_for_a_job_array(self):
        listed = self.expect(1, "join", "scan.plan", "--missing", "--progress", "none")
        self.assertEqual(listed.stdout, "1\n")
        self.expect_error(5, ["1 of 3 parts is missing: 1", "octavo part scan.plan --part 1"],
                          "join", "scan.plan", "-o", "scan.8vo")
        (self.folder / "scan.plan").rename(self.folder / "a $b.plan")
        self.expect_error(5, ["octavo part \"a \\$b.plan\" --part 0 makes one"],
                          "join", "a $b.plan", "-o", "scan.8vo")
        (self.folder / "a $b.plan").rename(self.folder / "scan.plan")
        self.part(0, "--parts", "1", "-q")
        self.assertEqual(self.expect(0, "join", "scan.plan", "--missing").stdout, "")

    def test_a_damaged_part_is_named_and_made_anew(self):
        name = "scan.part-0002-of-0003"
        good = self.bytes_of(name)
        bad = bytearray(good)
        bad[len(bad) // 2] ^= 4
        (self.folder / name).write_bytes(bad)
        self.part(0, "--part", "1", "-q")
        self.expect_error(4, [name], "join", "scan.plan", "-o", "scan.8vo")
        self.assertNotIn("scan.8vo", self.files())
        self.assertEqual(self.expect(1, "join", "scan.plan", "--missing").stdout, "2\n")
        again = self.part(0, "--part", "2")
        self.assertIn("made anew", again.stderr)
        self.assertEqual(self.bytes_of(name), good)
        (self.folder / name).write_bytes(good[:-9])
        self.expect_error(4, [name], "join", "scan.plan", "-o", "scan.8vo")

    def test_a_part_whose_head_is_lost_is_made_anew(self):
        name = "scan.part-0002-of-0003"
        good = self.bytes_of(name)
        for bad in b"", good[:1], good[:300], b"\0" + good[1:], good[:7] + b"\xff" + good[8:]:
            with self.subTest(len(bad)):
                (self.folder / name).write_bytes(bad)
                self.expect_error(4, [name], "join", "scan.plan", name, "-o", "scan.8vo")
                self.assertIn("made anew", self.part(0, "--part", "2").stderr)
                self.assertEqual(self.bytes_of(name), good)

    def test_of_two_files_of_one_part_the_one_with_the_wrong_name_is_named(self):
        self.part(0, "--part", "1", "-q")
        shutil.copy(self.folder / "scan.part-0001-of-0003", self.folder / "scan.part-0000-of-0003")
        for way in [], ["--consume"], ["--step", "layout"]:
            self.expect_error(2, ["scan.part-0000-of-0003: is part 1, not part 0"],
                              "join", "scan.plan", *way, "-o", "scan.8vo")
        self.assertEqual(len([name for name in self.files() if ".part-" in name]), 3)

    def test_a_plan_whose_parts_could_have_no_names_is_rejected(self):
        for length, code in [(238, 2), (237, 0)]:
            said = self.expect(code, "plan", *self.raw, "-o", "n" * length + ".plan")
            self.assertEqual("too long a name for a plan" in said.stderr, code == 2, said.stderr)
        self.expect(0, "part", "n" * 237 + ".plan", "-q", "--progress", "none")

    def test_a_volume_of_more_voxels_than_allowed_is_rejected(self):
        (self.folder / "slices").mkdir()
        for z in range(SIZE[2]):
            plane = VOXELS[2 * PLANE * z:2 * PLANE * (z + 1)]
            (self.folder / "slices" / f"s{z:04}").write_bytes(plane)
        self.expect(0, "plan", "slices", *self.raw[1:], "--parts", "3", "-o", "slices.plan")
        self.expect_error(6, ["--max-voxels"], "part", "slices.plan", "--part", "1",
                          "--max-voxels", "20000000")
        self.expect(0, "part", "slices.plan", "--part", "1", "--max-voxels", "40000000")

    def test_a_part_of_another_plan_is_rejected_and_kept(self):
        other = bytearray(VOXELS)
        other[5] ^= 1
        self.write_scan(other)
        self.expect(0, "plan", *self.raw, "-f", "--parts", "3", "-o", "scan.plan")
        before = self.bytes_of("scan.part-0000-of-0003")
        said = self.part(2, "--part", "0")
        self.assertIn("another plan", said.stderr)
        self.assertIn("--force", said.stderr)
        self.assertEqual(self.bytes_of("scan.part-0000-of-0003"), before)
        self.part(0, "--part", "0", "-f")
        self.part(0, "--part", "1")
        self.expect_error(2, ["scan.part-0002-of-0003", "another plan"],
                          "join", "scan.plan", "-o", "scan.8vo")

    def test_a_file_that_is_no_part_is_rejected_and_kept(self):
        name = "scan.part-0001-of-0003"
        notes = b"notes of mine, and long enough to be a head " * 40
        (self.folder / name).write_bytes(notes)
        said = self.part(2, "--part", "1")
        self.assertIn(name + ": is no part of a build", said.stderr)
        self.assertIn("--force", said.stderr)
        self.assertEqual(self.bytes_of(name), notes)
        self.part(0, "--part", "1", "-f")

    def test_a_source_changed_behind_the_first_group_is_rejected(self):
        self.write_scan(VOXELS[:2 * PLANE * 100] + b"\1\2\3\4" + VOXELS[2 * PLANE * 100 + 4:])
        said = self.part(7, "--part", "1")
        self.assertIn("scan.raw: was changed after the build was planned", said.stderr)
        self.assertNotIn("scan.part-0001-of-0003", self.files())

    def test_copies_that_lost_their_times_are_taken_by_their_bytes(self):
        slices = self.folder / "slices"
        slices.mkdir()
        for z in range(4):
            (slices / f"s{z}.raw").write_bytes(bytes(range(z, z + 64)))
        stack = ("slices", "--raw", "8,8,4,uint8", "--spacing", "1", "-q")
        self.expect(0, "build", *stack, "-o", "b.8vo")
        for check in ("times", "content"):
            self.expect(0, "plan", *stack, "--check", check, "-o", f"{check}.plan")
        for path in slices.iterdir():
            os.utime(path, (5, 5))
        said = self.expect(7, "part", "times.plan", "-o", "stack", "--part", "0")
        self.assertIn("octavo plan --check content", said.stderr)
        self.expect(0, "part", "content.plan", "-o", "stack", "--part", "0")
        self.expect(0, "join", "content.plan", "stack", "-o", "c.8vo")
        self.assertEqual(self.bytes_of("c.8vo"), self.bytes_of("b.8vo"))
        (slices / "s2.raw").write_bytes(bytes(64))
        said = self.expect(7, "part", "content.plan", "-o", "stack", "--part", "0", "-f")
        self.assertIn("s2.raw: was changed after the build was planned (64 bytes", said.stderr)
        for source in (self.raw, ("--", "threshold", "b.8vo", "--range", "3:")):
            said = self.expect(2, "plan", "--check", "content", "-o", "other.plan", *source)
            self.assertIn("every part would read all; leave out --check", said.stderr)
        self.assertNotIn("other.plan", self.files())

    def test_a_source_that_is_gone_is_not_the_planned_one(self):
        (self.folder / "scan.raw").unlink()
        said = self.part(7, "--part", "1")
        self.assertIn("scan.raw: is missing", said.stderr)

    def test_parts_given_one_by_one_may_have_any_name_but_come_once(self):
        self.part(0, "--part", "1", "-q")
        for part in range(3):
            (self.folder / f"scan.part-000{part}-of-0003").rename(self.folder / f"p{part}")
        self.expect_error(2, ["p0", "give each part once"],
                          "join", "scan.plan", "p0", "p1", "p2", "p0", "-o", "scan.8vo")
        self.expect_error(5, ["octavo: scan.plan: 1 of 3 parts is missing: 1"],
                          "join", "scan.plan", "p0", "p2", "-o", "scan.8vo")
        self.expect(0, "join", "scan.plan", "p2", "p0", "p1", "-o", "scan.8vo", "-q")
        self.assertEqual(self.bytes_of("scan.8vo"), self.built())

    def test_what_is_no_plan_no_part_or_no_number_is_rejected(self):
        (self.folder / "text").write_text("text, and long enough to be a head " * 40)
        for code, words, arguments in [
            (3, ["no plan"], ["part", "text"]),
            (5, ["none.plan"], ["part", "none.plan"]),
            (2, ["no part 3", "parts 0 to 2"], ["part", "scan.plan", "--part", "3"]),
            (2, ["list of parts"], ["part", "scan.plan", "--parts", "2-"]),
            (3, ["text"], ["join", "scan.plan", "text", "-o", "scan.8vo"]),
            (2, ["--output is required"], ["join", "scan.plan"]),
            (2, [".8vo"], ["join", "scan.plan", "-o", "scan"]),
            (2, [".plan"], ["plan", *self.raw, "-o", "plan.8vo"]),
            (2, ["URL"], ["plan", "https://example.org/a.8vo", "-o", "url.plan"]),
            (2, ["--resume"], ["build", *self.raw, "--parts", "2", "--resume", "-o", "x.8vo"]),
        ]:
            with self.subTest(arguments):
                self.expect_error(code, words, *arguments)
        changed = self.bytes_of("scan.plan").replace(b"16", b"17", 1)
        (self.folder / "changed.plan").write_bytes(changed)
        self.expect_error(4, ["changed.plan"], "part", "changed.plan", "--part", "0")


class Elsewhere(InParts):
    def test_a_plan_holds_in_every_folder_and_moves_with_its_source(self):
        self.plan("--parts", "3")
        away = self.folder / "away"
        away.mkdir()
        result = cli_test.run("part", "../scan.plan", "--part", "0", cwd=away)
        self.assertEqual(result.returncode, 0, result.stderr)
        (self.folder / "scan.raw").rename(away / "scan.raw")
        (self.folder / "scan.plan").rename(away / "scan.plan")
        for part in (1, 2):
            result = cli_test.run("part", "away/scan.plan", "--part", part, "-o", ".",
                                  cwd=self.folder)
            self.assertEqual(result.returncode, 0, result.stderr)
        self.expect(0, "join", "away/scan.plan", ".", "-o", "scan.8vo", "-q")

    def test_a_source_may_have_another_root(self):
        self.expect(0, "plan", *self.raw, "--source-root", ".", "-o", "scan.plan")
        self.check_moved("mounted")

    def test_paths_that_are_no_utf_8_are_planned_as_they_are(self):
        odd = self.folder / "D\udce9"
        odd.mkdir()
        for z in (1, 2):
            (odd / f"Sch\udce4del_{z}.raw").write_bytes(bytes(range(z, z + 64)))
        stack = (odd, "--raw", "8,8,2,uint8", "--spacing", "1", "-q")
        self.expect(0, "build", *stack, "-o", "r\udce9f.8vo")
        self.expect(0, "plan", *stack, "--source-root", odd, "-o", "scan.plan")
        self.part(0, "-q")
        self.expect(0, "join", "scan.plan", "-o", "scan.8vo", "-q")
        self.assertEqual(self.bytes_of("scan.8vo"), self.bytes_of("r\udce9f.8vo"))
        self.expect(0, "plan", "-fqo", "scan.plan", "--", "threshold", "r\udce9f.8vo", "--range",
                    "3:")
        self.part(0, "-fq")

    def test_a_source_root_is_a_folder(self):
        for root in ("none", "scan.raw"):
            self.expect_error(2, [f"{root}: is no folder"], "plan", *self.raw, "--source-root",
                              root, "-o", "scan.plan")
        self.assertNotIn("scan.plan", self.files())

    def test_slashes_behind_the_folder_of_the_plan_are_one(self):
        self.expect(0, "plan", f"{self.folder}//scan.raw", *self.raw[1:], "-o", "scan.plan")
        self.part(0, "-q")

    def test_the_next_commands_name_a_plan_that_begins_as_an_option_does(self):
        told = self.expect(0, "plan", *self.raw[:-1], "--output=-a.plan").stdout
        self.assertIn("octavo part ./-a.plan ", told)
        self.assertIn("octavo join ./-a.plan parts/ -o ./-a.8vo", told)

    def test_a_part_whose_name_a_loose_link_has_says_what_to_do(self):
        self.plan("--parts", "1")
        name = "scan.part-0000-of-0001"
        (self.folder / name).symlink_to("gone")
        said = self.part(5)
        self.assertIn(f"{name}: is a link to a file that is not there; remove it", said.stderr)
        (self.folder / name).unlink()
        self.part(0, "-q")

    def test_a_plan_of_absolute_paths_follows_the_folder_of_its_files(self):
        (self.folder / "plans").mkdir()
        self.expect(0, "plan", *self.raw, "-o", "plans/scan.plan")
        (self.folder / "plans/scan.plan").rename(self.folder / "scan.plan")
        self.check_moved("elsewhere")

    def check_moved(self, name):
        (self.folder / name).mkdir()
        (self.folder / "scan.raw").rename(self.folder / name / "scan.raw")
        self.part(7)
        self.part(0, "--source-root", name, "-q")
        self.assertIn("scan.part-0000-of-0001", self.files())


class Stopped(InParts):
    def test_a_part_that_is_ended_leaves_nothing_and_says_143(self):
        # Noise takes a part far longer than a signal.
        self.write_scan(os.urandom(len(VOXELS)))
        self.plan("--parts", "1", "--max-error", "2")
        command = [cli_test.OCTAVO, "part", "scan.plan", "--progress", "json", "-j", "1"]
        with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE, text=True,
                              env=without_schedulers()) as running:
            running.stderr.readline()
            running.send_signal(signal.SIGTERM)
            running.stderr.read()
            self.assertEqual(running.wait(), 143)
        self.assertEqual(self.files(), ["scan.plan", "scan.raw"])

    def test_parts_of_a_build_are_gone_after_a_failure_and_after_a_kill(self):
        command = [cli_test.OCTAVO, "build", *self.raw[:-1], "--parts", "3", "-j", "2",
                   "--progress", "json", "-o", "scan.8vo"]
        for number, code in [(signal.SIGTERM, 143), (signal.SIGKILL, -9)]:
            with subprocess.Popen(command, cwd=self.folder, stderr=subprocess.PIPE,
                                  text=True) as running:
                for line in running.stderr:
                    if '"parts"' in line:
                        break
                running.send_signal(number)
                running.stderr.read()
                self.assertEqual(running.wait(), code)
            if number == signal.SIGTERM:
                self.assertEqual(self.files(), ["scan.raw"])
        self.expect(0, "build", *self.raw, "--parts", "2", "-f", "-o", "scan.8vo")
        self.assertEqual(self.files(), ["scan.8vo", "scan.raw"])


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
