#!/usr/bin/env python3
"""Kills the program, takes its disk away: what stands under a name is whole.

usage: program_faults.py OCTAVO [unittest arguments]

Builds are ended at 16 random moments, under tools/nightly at its share of 1000. What needs the
right to mount is skipped without it. Everything is generated.
"""

import array
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
import processor_time  # pylint: disable=wrong-import-position
from shared_folder import folder_of  # pylint: disable=wrong-import-position

OCTAVO = "octavo"
MOMENTS = max(16, int(1000 * float(os.environ.get("OCTAVO_NIGHTLY_SHARE", "0"))))
SECONDS_TO_STOP = 2  # of processor time
# What starts a record of a journal, and the type of one that ends a group: journal.h.
RECORD = struct.Struct("<IIQI")
GROUP_RECORD = 3


def mounts(folder, *options):
    """True when `folder` could be mounted over; the caller unmounts."""
    return subprocess.run(["mount", *options, folder], capture_output=True, check=False
                          ).returncode == 0


class InFolder(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def start(self, *arguments, **options):
        return subprocess.Popen([OCTAVO, *map(str, arguments)], cwd=self.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, **options)

    def octavo(self, *arguments, **options):
        return subprocess.run([OCTAVO, *map(str, arguments)], cwd=self.folder,
                              capture_output=True, text=True, check=False, **options)

    def expect(self, code, *arguments, **options):
        result = self.octavo(*arguments, **options)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stderr}")
        return result

    def expect_error(self, code, words, *arguments, **options):
        """One line on standard error with `words` in it, and nothing on standard output."""
        result = self.expect(code, *arguments, "--progress", "none", **options)
        self.assertEqual(result.stdout, "")
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("octavo: "), result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)

    def names(self):
        return sorted(p.name for p in self.folder.iterdir())

    def noisy_raw(self, name, x, y, z):
        numbers = random.Random(5)
        voxels = array.array("h", numbers.choices(range(-200, 200), k=x * y * z))
        (self.folder / name).write_bytes(voxels.tobytes())
        return [name, "--raw", f"{x},{y},{z},int16", "--spacing", "1"]


class Kills(InFolder):
    def check_moments(self, command, target, count):
        """Ends `command` at `count` random moments; `target` holds its old or its new content."""
        numbers = random.Random(6)
        path = self.folder / target
        old = path.read_bytes()
        began = processor_time.of_children()
        self.expect(0, *command)
        seconds = processor_time.of_children() - began
        new = path.read_bytes()
        self.assertNotEqual(old, new)
        own = self.names()
        kept = finished = 0
        for moment in range(count):
            path.write_bytes(old)
            began = processor_time.of_children()
            process = self.start(*command, "--progress", "none")
            processor_time.let_run(process, numbers.uniform(0, 1.05 * seconds))
            how = [signal.SIGKILL, signal.SIGTERM, signal.SIGKILL, signal.SIGINT][moment % 4]
            asked = processor_time.of_process(process)
            process.send_signal(how)
            _, said = process.communicate()
            if asked is not None:
                used = processor_time.of_children() - began
                self.assertLess(used - asked, SECONDS_TO_STOP, how)
            # Before the program took its signals over, they end it as they end any other.
            self.assertIn(process.returncode, (0, -how, 128 + how), said)
            now = path.read_bytes()
            self.assertIn(now, (old, new), f"moment {moment}, {how}")
            kept += now == old
            finished += now == new
            left = [name for name in self.names() if name not in own]
            self.assertLessEqual(len(left), 1, left)
            for name in left:
                self.assertTrue(name.startswith(f".{target}.tmp-"), name)
            if how != signal.SIGKILL and process.returncode > 0:
                self.assertNotIn(f".{target}.tmp-{process.pid}", left)
        self.expect(0, *command)
        self.assertEqual(self.names(), own)
        self.assertEqual(path.read_bytes(), new)
        print(f"goal D1: {count} of {count} ends of a running {command[0]}, old file kept {kept} "
              f"times, replaced {finished} times", flush=True)
        self.assertGreater(kept, 0)

    def test_a_killed_build_leaves_the_old_file_or_a_whole_one(self):
        source = self.noisy_raw("v.raw", 100, 90, 80)
        self.expect(0, "phantom", "--size", "30", "-o", "out.8vo")
        self.check_moments(["build", *source, "-o", "out.8vo", "--force"], "out.8vo", MOMENTS)
        self.expect(0, "verify", "out.8vo", "--against", *source)

    def test_a_killed_export_leaves_the_old_file_or_a_whole_one(self):
        self.expect(0, "phantom", "--size", "100", "--noise", "20", "-o", "p.8vo")
        for target in ["out.nrrd", "out.nii.gz"]:
            (self.folder / target).write_bytes(b"old")
            self.check_moments(["export", "p.8vo", "-o", target, "--force"], target, MOMENTS // 4)
            self.expect(0, "compare", "p.8vo", target)


class Resume(InFolder):
    # Three groups; noise in one column of bricks, so that a build takes seconds, not minutes.
    SIZE = (512, 512, 150)

    @classmethod
    def setUpClass(cls):
        """The scan and its file, which each test begins with, and how long the file takes."""
        super().setUpClass()
        cls.made = folder_of(cls)
        x, y, z = cls.SIZE
        numbers = random.Random(7)
        with open(cls.made / "v.raw", "wb") as raw:
            for _ in range(z):
                rows = (numbers.randbytes(128) + bytes(2 * x - 128) for _ in range(60))
                raw.write(b"".join(rows) + bytes(2 * x * (y - 60)))
        cls.build = ["build", "v.raw", "--raw", f"{x},{y},{z},int16", "--spacing", "1"]
        began = processor_time.of_children()
        subprocess.run([OCTAVO, *cls.build, "-q", "-o", "reference.8vo"], cwd=cls.made, check=True)
        cls.seconds = processor_time.of_children() - began

    def setUp(self):
        super().setUp()
        shutil.copytree(self.made, self.folder, dirs_exist_ok=True)
        self.own = self.names() + ["out.8vo"]

    def left(self):
        return [name for name in self.names() if name not in self.own]

    def end(self, command, how, seconds):
        """Ends `command` after `seconds` of processor time; its exit code and what it said."""
        process = self.start(*command, "--progress", "none")
        processor_time.let_run(process, seconds)
        return self.stop(process, how)

    def stop(self, process, how):
        process.send_signal(how)
        _, said = process.communicate()
        return process.returncode, said.decode()

    def whole_groups(self):
        """Groups that a journal beside the output has noted."""
        count = 0
        for path in self.folder.glob(".*.journal"):
            content = path.read_bytes()
            at = 0
            while at + RECORD.size <= len(content):
                kind, _, length, _ = RECORD.unpack_from(content, at)
                at += RECORD.size + length
                count += kind == GROUP_RECORD and at <= len(content)
        return count

    def check_left(self):
        """At most one growing file, with its journal."""
        left = self.left()
        for name in left:
            self.assertTrue(name.startswith(".out.8vo.tmp-"), left)
        self.assertLessEqual(sum(not name.endswith(".journal") for name in left), 1, left)
        self.assertLessEqual(len(left), 2, left)
        return left

    def test_a_build_killed_again_and_again_ends_in_the_same_bytes(self):
        numbers = random.Random(8)
        command = [*self.build, "-o", "out.8vo", "--resume"]
        ends = spared = 0
        for moment in range(max(4, MOMENTS // 4)):
            how = [signal.SIGKILL, signal.SIGINT, signal.SIGKILL, signal.SIGTERM][moment % 4]
            code, said = self.end(command, how, numbers.uniform(0.2, 1.0) * self.seconds)
            self.assertIn(code, (0, -how, 128 + how), said)
            spared += "continued behind plane" in said
            left = self.check_left()
            # A signal may also come between the last step of a program and its end.
            if code == 0 or (self.folder / "out.8vo").exists():
                self.assertEqual(left, [])
                self.assertEqual((self.folder / "out.8vo").read_bytes(),
                                 (self.folder / "reference.8vo").read_bytes())
                os.unlink(self.folder / "out.8vo")
                ends += 1
                continue
            if code == 128 + how:
                self.assertEqual("--resume" in said, len(left) == 2, said)
        said = self.expect(0, *command).stderr
        self.assertEqual(self.left(), [])
        self.assertEqual((self.folder / "out.8vo").read_bytes(),
                         (self.folder / "reference.8vo").read_bytes())
        print(f"build --resume: ended {ends} times in between, {spared} continued builds ended")

    def interrupt(self, command, how):
        """Ends `command` as soon as it leaves something to continue; what the next build says."""
        process = self.start(*command, "--progress", "none")
        processor_time.wait_until(lambda: process.poll() is not None or self.whole_groups() > 0)
        code, said = self.stop(process, how)
        self.assertIn(code, (-how, 128 + how), said)
        resumable = self.expect(5, *self.build, "-o", "out.8vo", "--progress", "none")
        return code, said, resumable.stderr

    def test_an_interrupted_build_is_told_and_kept_and_others_are_rejected(self):
        command = [*self.build, "-o", "out.8vo", "--resume"]
        code, said, error = self.interrupt(command, signal.SIGINT)
        self.assertEqual(code, 130)
        self.assertEqual(said.count("\n"), 1, said)
        for word in ["octavo: out.8vo: stopped while ", "planes 0 to ",
                     " of 150 are kept for out.8vo", "--resume"]:
            self.assertIn(word, said)
        for word in ["out.8vo: an interrupted build", "--resume", "--force"]:
            self.assertIn(word, error)
        anew = "leave out --resume and use --force to start anew"
        for words, options in [
                (["another preset: small there, fast now", "it was begun with --preset small"],
                 ["--preset", "fast"]),
                (["another max error: 0 there, 2 now", "it was begun with --max-error 0"],
                 ["--max-error", "2"]),
                (["another thumbnail: not given there, given now",
                  "it was begun without --thumbnail"], ["--thumbnail"]),
                (["another kind: grey there, labels now; the interrupted build is kept; leave"],
                 ["--labels"])]:
            self.expect_error(2, [*words, "the interrupted build is kept", anew],
                              *command, *options)
        voxels = bytearray((self.folder / "v.raw").read_bytes())
        voxels[1000] ^= 1
        (self.folder / "v.raw").write_bytes(voxels)
        self.expect_error(7, ["the first planes hold other voxels", anew], *command)
        voxels[1000] ^= 1
        (self.folder / "v.raw").write_bytes(voxels)
        self.assertEqual(len(self.check_left()), 2)
        result = self.expect(0, *command, "--json", "--progress", "none")
        self.assertGreaterEqual(json.loads(result.stdout)["resumed_planes"], 64)
        self.assertEqual((self.folder / "out.8vo").read_bytes(),
                         (self.folder / "reference.8vo").read_bytes())

    def test_a_killed_build_that_did_not_ask_can_be_continued_or_started_anew(self):
        command = [*self.build, "-o", "out.8vo"]
        self.interrupt(command, signal.SIGKILL)
        self.assertEqual(len(self.check_left()), 2)
        self.assertIn("continued behind", self.expect(0, *command, "--resume").stderr)
        self.assertEqual((self.folder / "out.8vo").read_bytes(),
                         (self.folder / "reference.8vo").read_bytes())
        os.unlink(self.folder / "out.8vo")
        self.interrupt(command, signal.SIGKILL)
        self.assertNotIn("continued", self.expect(0, *command, "--force").stderr)
        self.assertEqual(self.left(), [])

    def test_repair_seals_the_whole_planes_and_says_which_are_missing(self):
        self.interrupt([*self.build, "-o", "out.8vo"], signal.SIGKILL)
        left = {name: (self.folder / name).read_bytes() for name in self.check_left()}
        growing = min(left)
        self.expect_error(4, [growing, "not sealed", "--resume", "repair"], "info", growing)
        said = self.expect(0, "repair", "out.8vo", "-o", "rescued.8vo").stdout
        result = json.loads(self.expect(0, "repair", growing, "-o", "rescued.8vo", "--force",
                                        "--json").stdout)
        first, last = result["missing_planes"]
        self.assertEqual((result["planes"], last), (150, 149))
        missing = f"planes {first} to 149 are missing"
        self.assertIn(f"planes 0 to {first - 1} of 150 are whole; {missing}", said)
        self.assertIn(missing, self.expect(0, "verify", "rescued.8vo").stdout)
        self.assertIn(missing, self.expect(0, "info", "rescued.8vo").stdout)
        self.expect(0, "export", "rescued.8vo", "-o", "rescued.raw")
        voxels = (self.folder / "rescued.raw").read_bytes()
        original = (self.folder / "v.raw").read_bytes()
        whole = first * 2 * self.SIZE[0] * self.SIZE[1]
        self.assertEqual(voxels[:whole], original[:whole])
        low = min(array.array("h", original[:whole]))
        self.assertEqual(set(array.array("h", voxels[whole:])), {low})
        for name, content in left.items():
            self.assertEqual((self.folder / name).read_bytes(), content)
        self.expect_error(5, ["nothing.8vo: no such file, and no interrupted build"], "repair",
                          "nothing.8vo", "-o", "x.8vo")
        (self.folder / ".early.8vo.tmp-1").write_bytes(left[growing][:512])
        self.expect_error(5, ["early.8vo: no such file, and .early.8vo.tmp-1 beside it",
                              "start it anew"], "repair", "early.8vo", "-o", "x.8vo")
        os.unlink(self.folder / ".early.8vo.tmp-1")
        # No other verb loses what is left, nor does a file that happens to be called a journal.
        self.expect(0, "phantom", "--size", "9", "-o", "p.8vo")
        (self.folder / "p.8vo.journal").write_text("something else")
        self.expect_error(2, ["p.8vo: is sound"], "repair", "p.8vo", "-o", "x.8vo")
        for command in [("phantom", "--size", "9"), ("threshold", "p.8vo", "--range=-5000:5000")]:
            self.expect_error(5, ["out.8vo: an interrupted build", "--force"], *command, "-o",
                              "out.8vo")
        # Without its journal nobody knows what is whole.
        (self.folder / "copy.8vo").write_bytes(left[growing])
        self.expect_error(4, ["copy.8vo: not sealed", "build it again"], "repair",
                          "copy.8vo", "-o", "x.8vo")
        self.assertIn("continued behind",
                      self.expect(0, *self.build, "-o", "out.8vo", "--resume").stderr)

    def test_a_full_disk_keeps_what_is_whole(self):
        out = self.folder / "out"
        out.mkdir()
        size = (self.folder / "reference.8vo").stat().st_size
        kib = size * 3 // 4 // 1024
        if not mounts(out, "-t", "tmpfs", "-o", f"size={kib}k", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        try:
            command = [*self.build, "-o", "out/x.8vo", "--resume"]
            self.expect_error(5, ["no space left", "are kept for x.8vo", "--resume"], *command)
            self.assertEqual(len(os.listdir(out)), 2)
            subprocess.run(["mount", "-o", f"remount,size={8 * kib}k", out], check=True)
            self.assertIn("continued behind", self.expect(0, *command).stderr)
            self.assertEqual(os.listdir(out), ["x.8vo"])
            self.assertEqual((out / "x.8vo").read_bytes(),
                             (self.folder / "reference.8vo").read_bytes())
        finally:
            subprocess.run(["umount", out], check=True)


class NothingToResume(InFolder):
    def test_it_is_told_and_built(self):
        source = self.noisy_raw("v.raw", 9, 8, 7)
        said = self.expect(0, "build", *source, "-o", "a.8vo", "--resume").stderr
        self.assertIn("a.8vo: no interrupted build of it to continue", said)
        self.expect(0, "verify", "a.8vo", "--against", *source)


class Salvage(InFolder):
    # Three bricks of the same size, which fill most of the file.
    SIZE = (192, 64, 20)
    COUNT = 192 * 64 * 20

    def setUp(self):
        super().setUp()
        self.source = self.noisy_raw("v.raw", *self.SIZE)
        self.expect(0, "build", *self.source, "-o", "good.8vo")

    def damage(self, *fractions):
        """bad.8vo: good.8vo with a flipped bit at each fraction of its length."""
        damaged = bytearray((self.folder / "good.8vo").read_bytes())
        places = [int(len(damaged) * fraction) for fraction in fractions]
        for place in places:
            damaged[place] ^= 4
        (self.folder / "bad.8vo").write_bytes(damaged)
        return places

    def report(self):
        return json.loads(self.expect(4, "verify", "bad.8vo", "--json").stdout)

    def voxels(self, name):
        return array.array("h", (self.folder / name).read_bytes())

    def outside(self, voxels, bricks):
        """The voxels that lie in none of `bricks`, which stand side by side along x."""
        damaged = [brick[0] for brick in bricks]
        return [v for i, v in enumerate(voxels) if i % self.SIZE[0] // 64 not in damaged]

    def test_verify_names_the_brick_and_the_flipped_bit(self):
        place, = self.damage(0.2)
        self.expect_error(4, ["bad.8vo: brick o-code 0x", " level 0 at byte ", "checksum ",
                              f"(one flipped bit, byte {place})", "bricks damaged; repair "],
                          "verify", "bad.8vo")
        report = self.report()
        self.assertFalse(report["sound"])
        self.assertEqual(report["damaged_bricks"], 1)
        damage, = report["damages"]
        self.assertEqual(damage["what"], "brick")
        self.assertEqual((damage["flipped_byte"], damage["flipped_bit"]), (place, 2))

    def test_verify_names_every_damaged_place(self):
        places = self.damage(0.15, 0.45, 0.75)
        result = self.expect(4, "verify", "bad.8vo", "--progress", "none")
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 4, result.stderr)
        for place in places:
            self.assertTrue(any(f"byte {place})" in line for line in lines[:3]), result.stderr)
        self.assertIn("bad.8vo: 3 damaged places", lines[3])
        quiet = self.expect(4, "verify", "bad.8vo", "-q", "--progress", "none")
        self.assertEqual(quiet.stderr, lines[3] + "\n")

    def test_damage_is_rejected_unless_asked_otherwise(self):
        self.damage(0.2)
        for command in [("export", "bad.8vo", "-o", "x.raw"),
                        ("extract", "bad.8vo", "--box", ":,:,0:9", "-o", "x.raw"),
                        ("slice", "bad.8vo", "--axis", "all", "-o", "x.png")]:
            self.expect_error(4, ["bad.8vo: brick o-code", "--salvage"], *command)
            self.expect_error(4, ["bad.8vo: brick o-code", "--strict"], *command, "--salvage",
                              "--strict")
        self.assertEqual([n for n in self.names() if n.startswith(("x", "."))], [])

    def test_everything_outside_damaged_bricks_is_the_original(self):
        self.damage(0.15, 0.75)
        bricks = [damage["brick"] for damage in self.report()["damages"]]
        original = self.outside(self.voxels("v.raw"), bricks)
        self.assertTrue(0 < len(original) < self.COUNT)
        for fill in [["--salvage"], ["--salvage", "coarse"], ["--salvage=-777"]]:
            with self.subTest(fill):
                result = self.expect(0, "export", "bad.8vo", "-o", "x.raw", "--force", *fill)
                warnings = [line for line in result.stderr.splitlines() if "warning" in line]
                self.assertEqual(len(warnings), 2, result.stderr)
                for warning in warnings:
                    self.assertIn("octavo: warning: bad.8vo: brick o-code 0x", warning)
                    self.assertIn("filled ", warning)
                found = self.voxels("x.raw")
                self.assertEqual(self.outside(found, bricks), original)
                if fill == ["--salvage=-777"]:
                    self.assertEqual(found.count(-777), self.COUNT - len(original))
                if fill[-1] == "coarse":
                    self.assertIn("from level 1", result.stderr)
                    inside = self.voxels("v.raw")
                    worst = max(abs(a - b) for a, b in zip(found, inside))
                    self.assertLess(worst, 400)
        result = self.expect(0, "slice", "bad.8vo", "-o", "x.png", "--salvage", "--json")
        self.assertLessEqual(json.loads(result.stdout)["salvaged"]["bricks"], 2)

    def test_warnings_end_after_ten(self):
        self.expect(0, "phantom", "--size", "320,320,10", "--noise", "20", "-o", "good.8vo",
                    "--force")
        self.damage(*(0.02 + 0.025 * i for i in range(30)))
        damaged = self.report()["damaged_bricks"]
        self.assertGreater(damaged, 11)
        result = self.expect(0, "export", "bad.8vo", "-o", "x.raw", "--salvage", "--json",
                             "--progress", "none")
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 11, result.stderr)
        self.assertIn("more damaged places", lines[-1])
        salvaged = json.loads(result.stdout)["salvaged"]
        self.assertEqual(salvaged["bricks"], damaged)

    def test_a_fill_that_is_no_voxel_is_exit_2(self):
        self.damage(0.2)
        for words, fill in [(["-32768 to 32767"], "40000"), (["neither"], "high"),
                            (["neither"], "nan")]:
            self.expect_error(2, words, "export", "bad.8vo", "-o", "x.raw", "--salvage", fill)
        self.expect_error(2, ["name the file before"], "export", "--salvage", "bad.8vo", "-o",
                          "x.raw")
        self.assertNotIn("x.raw", self.names())


class SmallFolder(InFolder):
    SIZE = (64, 64, 40)

    def setUp(self):
        super().setUp()
        self.source = self.noisy_raw("v.raw", *self.SIZE)
        self.expect(0, "build", *self.source, "-o", "good.8vo")
        (self.folder / "out").mkdir()

    def commands(self, folder):
        """Every way to write a file, with the name of what it writes."""
        for name in ["x.nrrd", "x.raw", "x.nii", "x.nii.gz", "x.mha", "x.mhd", "x.tif", "stack/"]:
            # The voxels of an .mhd stand in a .raw beside it, which is written first.
            first = {"x.mhd": "x.raw"}.get(name, name.rstrip("/"))
            yield ["export", "good.8vo", "-o", f"{folder}/{name}"], f"{folder}/{first}"
        yield ["slice", "good.8vo", "-o", f"{folder}/x.png"], f"{folder}/x.png"
        yield ["build", *self.source, "-o", f"{folder}/x.8vo"], f"{folder}/x.8vo"


class Disks(SmallFolder):
    def expect_clean_failures(self, words, **options):
        for command, path in self.commands("out"):
            with self.subTest(path):
                self.expect_error(5, [f"octavo: {path}", *words], *command, **options)
                self.assertEqual(os.listdir(self.folder / "out"), [])

    def test_a_full_disk_is_exit_5_and_leaves_nothing(self):
        out = self.folder / "out"
        if not mounts(out, "-t", "tmpfs", "-o", "size=4k", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        try:
            self.expect_clean_failures(["no space left"])
        finally:
            subprocess.run(["umount", out], check=True)

    def test_a_limit_of_file_size_is_exit_5_and_leaves_nothing(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

        self.expect_clean_failures(["File too large"], preexec_fn=limit)

    def test_a_read_only_disk_is_exit_5_and_leaves_nothing(self):
        out = self.folder / "out"
        if not mounts(out, "-t", "tmpfs", "-o", "ro", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        try:
            self.expect_clean_failures(["Read-only file system"])
        finally:
            subprocess.run(["umount", out], check=True)

    def test_an_old_file_outlives_a_full_disk(self):
        out = self.folder / "out"
        if not mounts(out, "-t", "tmpfs", "-o", "size=64k", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        try:
            for command, path in self.commands("out"):
                if path.endswith(("stack", "parts", ".png")):
                    continue
                (self.folder / path).write_bytes(b"old")
                self.expect(5, *command, "--force")
                self.assertEqual((self.folder / path).read_bytes(), b"old")
                os.unlink(self.folder / path)
                self.assertEqual(os.listdir(out), [])
        finally:
            subprocess.run(["umount", out], check=True)


if __name__ == "__main__":
    OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
