#!/usr/bin/env python3
"""Replaces files and folders and is stopped at it; looks who may read them, and what is cleaned up.

usage: replace_faults.py OCTAVO [unittest arguments]

What needs strace, or the right to make process namespaces, is skipped without it. Everything is
generated.
"""

import fcntl
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import unittest

import program_faults
from program_faults import InFolder, SmallFolder

# Beyond any number that a process can have.
NOBODY = 2147483647


def has_strace():
    """True when system calls can be made to fail from outside."""
    return shutil.which("strace") is not None and subprocess.run(
        ["strace", "-o", "/dev/null", "true"], capture_output=True, check=False).returncode == 0


def no_bytes():
    """Lets the program write nothing into any file."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (16, 16))


class Traced(InFolder):
    def setUp(self):
        super().setUp()
        if not has_strace():
            self.skipTest("needs strace")

    def trace(self, rules, *arguments):
        """Runs the program with system calls injected by `rules`; returns it and what it called."""
        log = self.folder.parent / (self.folder.name + ".trace")
        self.addCleanup(log.unlink, missing_ok=True)
        chosen = [part for rule in rules for part in ("-e", rule)]
        result = subprocess.run(
            ["strace", "-f", "-o", log, *chosen, program_faults.OCTAVO, *map(str, arguments)],
            cwd=self.folder, capture_output=True, text=True, check=False)
        return result, log.read_text()


class Pairs(Traced):
    def setUp(self):
        super().setUp()
        for name, spacing in [("old", "1"), ("new", "2")]:
            self.expect(0, "phantom", "--size", "12", "-o", f"{name}.8vo")
            self.expect(0, "export", f"{name}.8vo", "-o", f"{name}.raw")
            self.expect(0, "build", f"{name}.raw", "--raw", "12,12,12,int16", "--spacing", spacing,
                        "-o", f"{name}.8vo", "--force")
        # As many voxels, others.
        raw = bytes(b ^ 1 for b in (self.folder / "new.raw").read_bytes())
        (self.folder / "new.raw").write_bytes(raw)
        self.expect(0, "build", "new.raw", "--raw", "12,12,12,int16", "--spacing", "2", "-o",
                    "new.8vo", "--force")

    def pair(self):
        paths = [self.folder / "s.mhd", self.folder / "s.raw"]
        return tuple(path.read_bytes() if path.exists() else None for path in paths)

    def check_stops(self, rule, code):
        """Stops the replacing at each call in turn; the header says what its voxels are."""
        self.expect(0, "export", "new.8vo", "-o", "s.mhd", "--force")
        new = self.pair()
        stops = 0
        for number in range(1, 10):
            self.expect(0, "export", "old.8vo", "-o", "s.mhd", "--force")
            old = self.pair()
            self.assertNotEqual(old[0], new[0])
            self.assertEqual(len(old[1]), len(new[1]))
            result, _ = self.trace([f"inject={rule}:when={number}"], "export", "new.8vo", "-o",
                                   "s.mhd", "--force", "-j1", "--progress", "none")
            found = self.pair()
            self.assertIn(found, (old, new, (None, old[1]), (None, None), (None, new[1])),
                          number)
            if result.returncode == 0:
                break
            self.assertEqual(result.returncode, code, result.stderr)
            stops += 1
            if found[0] is None:
                self.assertNotEqual(self.octavo("build", "s.mhd", "-o", "x.8vo").returncode, 0)
            if code == 5:
                self.assertRegex(result.stderr, r"octavo: s\.(mhd|raw): ")
                self.assertTrue(found in (old, new), result.stderr)
            # An export that fails makes nothing worse, and brings the earlier pair back.
            self.expect(5, "export", "new.8vo", "-o", "s.mhd", "--force", preexec_fn=no_bytes)
            self.assertTrue(self.pair() in (old, new), number)
            self.assertEqual([name for name in self.names() if name.startswith(".")], [])
        self.assertGreaterEqual(stops, 2)

    def test_a_killed_export_leaves_no_old_header_beside_new_voxels(self):
        self.check_stops("rename,renameat2:signal=KILL", -signal.SIGKILL)

    def test_a_failed_sync_leaves_no_old_header_beside_new_voxels(self):
        self.check_stops("fsync:error=EIO", 5)

    def test_a_failed_rename_leaves_no_old_header_beside_new_voxels(self):
        self.check_stops("rename,renameat2:error=EACCES", 5)


class ParallelPairs(InFolder):
    ROUNDS = 20

    def test_exports_at_the_same_time_leave_a_header_with_its_own_voxels(self):
        self.expect(0, "phantom", "--size", "24", "-o", "p.8vo")
        own = ["p.8vo", "s.mhd", "s.raw"]
        for _ in range(self.ROUNDS):
            running = [self.start("export", "p.8vo", "--level", level, "-o", "s.mhd", "--force",
                                  "-j1") for level in [0, 1, 2, 0, 1, 2]]
            for process in running:
                _, said = process.communicate()
                self.assertEqual(process.returncode, 0, said)
            header = (self.folder / "s.mhd").read_text()
            size = next(line for line in header.splitlines() if line.startswith("DimSize"))
            x, y, z = map(int, size.split("=")[1].split())
            self.assertEqual((self.folder / "s.raw").stat().st_size, 2 * x * y * z, header)
            self.assertEqual(self.names(), own)


class Stacks(Traced):
    WITHOUT_EXCHANGE = "inject=renameat2:error=EINVAL"

    def setUp(self):
        super().setUp()
        for name, size in [("old", "9,9,7"), ("new", "9,9,5")]:
            self.expect(0, "phantom", "--size", size, "-o", f"{name}.8vo")
        self.expect(0, "export", "old.8vo", "-o", "st/")
        self.own = self.names()

    def planes(self):
        return len(os.listdir(self.folder / "st"))

    def test_the_earlier_stack_goes_after_the_new_name_is_on_disk(self):
        _, calls = self.trace(["trace=renameat2,fsync,unlink,unlinkat"], "export", "new.8vo", "-o",
                              "st/", "--force")
        lines = [line.split(maxsplit=1)[1] for line in calls.splitlines()]
        exchange = next(i for i, line in enumerate(lines) if "RENAME_EXCHANGE" in line)
        self.assertTrue(lines[exchange + 1].startswith("fsync"), lines[exchange:])
        self.assertTrue(any(line.startswith("unlink") for line in lines[exchange + 2:]))
        self.assertEqual((self.planes(), self.names()), (5, self.own))

    def test_a_swap_in_two_steps_that_was_killed_is_settled_by_the_next_export(self):
        for calls in range(1, 4):
            result, _ = self.trace(
                [self.WITHOUT_EXCHANGE, f"inject=rename,unlinkat,rmdir:signal=KILL:when={calls}"],
                "export", "new.8vo", "-o", "st/", "--force", "-j1")
            self.assertEqual(result.returncode, -signal.SIGKILL, calls)
            # Whatever the moment, one whole stack is there, under a name that is settled.
            self.expect_error(5, ["st: the folder is not empty", "--force"], "export", "old.8vo",
                              "-o", "st/")
            self.assertIn(self.planes(), (5, 7))
            self.expect(0, "export", "old.8vo", "-o", "st/", "--force")
            self.assertEqual((self.planes(), self.names()), (7, self.own), calls)

    def test_a_folder_that_a_person_called_earlier_is_left_alone(self):
        shutil.copytree(self.folder / "st", self.folder / "st.earlier")
        for rules in [["trace=none"], [self.WITHOUT_EXCHANGE]]:
            result, _ = self.trace(rules, "export", "new.8vo", "-o", "st/", "--force")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(len(os.listdir(self.folder / "st.earlier")), 7)

    def test_a_link_leads_to_the_stack_that_is_replaced(self):
        (self.folder / "deep").mkdir()
        (self.folder / "st").rename(self.folder / "deep/st")
        (self.folder / "st").symlink_to("deep/st")
        for target in ["st/", "st"]:
            for source, planes in [("new", 5), ("old", 7)]:
                self.expect(0, "export", f"{source}.8vo", "-o", target, "--force")
                self.assertTrue((self.folder / "st").is_symlink())
                self.assertEqual(self.planes(), planes)
                self.assertEqual(os.listdir(self.folder / "deep"), ["st"])
        self.expect_error(5, ["st: the folder is not empty"], "export", "new.8vo", "-o", "st/")
        (self.folder / "nowhere").symlink_to("gone")
        (self.folder / "file.tif").write_text("kept")
        (self.folder / "to_file").symlink_to("file.tif")
        for target, words in [("nowhere/", "nowhere: is a link that cannot be followed"),
                              ("to_file/", "is a file; a TIFF stack needs a folder")]:
            self.expect_error(5, [words], "export", "new.8vo", "-o", target, "--force")
        self.assertEqual((self.folder / "file.tif").read_text(), "kept")

    def test_no_link_is_followed_where_a_stack_is_removed(self):
        (self.folder / "st").rename(self.folder / "real")
        (self.folder / ".st.tmp-earlier").symlink_to("real")
        (self.folder / f".st.tmp-{NOBODY}").symlink_to("real")
        self.expect(0, "export", "old.8vo", "-o", "other/")
        (self.folder / "other").rename(self.folder / "st")
        self.expect_error(5, ["st: the earlier stack of this name, .st.tmp-earlier, cannot be "
                              "removed"], "export", "new.8vo", "-o", "st/", "--force")
        (self.folder / ".st.tmp-earlier").unlink()
        self.expect(0, "export", "new.8vo", "-o", "st/", "--force")
        self.assertEqual(len(os.listdir(self.folder / "real")), 7)

    def test_what_is_called_a_plane_and_is_no_file_is_rejected_before_any_work(self):
        before = self.names()
        plane = self.folder / "st/plane_0099.tif"
        for make, remove in [(lambda: plane.symlink_to("plane_0000.tif"), plane.unlink),
                             (plane.mkdir, plane.rmdir),
                             (lambda: os.mkfifo(plane), plane.unlink)]:
            make()
            self.expect_error(5, ["st: the folder holds plane_0099.tif, which is no plane"],
                              "export", "new.8vo", "-o", "st/", "--force")
            self.assertEqual((self.planes(), self.names()), (8, before))
            remove()

    def test_an_earlier_stack_that_cannot_be_removed_is_told_by_each_export(self):
        told = "st: the earlier stack of this name, .st.tmp-earlier, cannot be removed: "
        result, _ = self.trace(["inject=unlinkat:error=EACCES:when=1"], "export", "new.8vo", "-o",
                               "st/", "--force", "-j1", "--progress", "none")
        self.assertEqual(result.returncode, 5, result.stderr)
        self.assertIn(told + "Permission denied", result.stderr)
        self.assertEqual(self.planes(), 5)
        foreign = self.folder / ".st.tmp-earlier/notes.txt"
        foreign.write_text("kept")
        for _ in range(2):
            self.expect_error(5, [told], "export", "old.8vo", "-o", "st/", "--force")
        self.assertEqual((foreign.read_text(), self.planes()), ("kept", 5))
        foreign.unlink()
        self.expect(0, "export", "old.8vo", "-o", "st/", "--force")
        self.assertEqual((self.planes(), self.names()), (7, self.own))


class Signals(Traced):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "20", "-o", "p.8vo")

    def test_a_signal_while_a_slice_is_written_leaves_nothing_unfinished(self):
        for axis in ["z", "all"]:
            for call in ["pwrite64", "fsync"]:
                result, _ = self.trace([f"inject={call}:signal=TERM:when=1"], "slice", "p.8vo",
                                       "--axis", axis, "-o", "s.png", "--force")
                self.assertEqual(result.returncode, 0 if axis == "z" else 143, result.stderr)
                self.assertEqual([name for name in self.names() if name.startswith(".")], [])

    def test_a_name_that_may_not_last_is_told_by_its_file(self):
        (self.folder / "s.nrrd").write_text("old")
        (self.folder / "st").mkdir()
        (self.folder / "st/plane_0000.tif").write_text("old")
        for target, count in [("s.nrrd", 2), ("st/", 22)]:
            result, _ = self.trace([f"inject=fsync:error=EIO:when={count}"], "export", "p.8vo",
                                   "-o", target, "--force", "-j1", "--progress", "none")
            self.assertEqual(result.returncode, 5, result.stderr)
            self.assertIn(f"octavo: {target.rstrip('/')}: cannot make the new name durable: ",
                          result.stderr)
            self.assertIn("what is new stands there, whole", result.stderr)
        self.assertNotEqual((self.folder / "s.nrrd").read_bytes(), b"old")
        self.assertEqual(len(os.listdir(self.folder / "st")), 20)


class FullDisk(SmallFolder):
    def large_results(self, folder):
        """More ways to write a file, of what fills a small disk."""
        self.expect(0, "plan", *self.source, "--parts", "1", "-o", "v.plan")
        self.expect(0, "part", "v.plan", "--part", "0", "-o", "parts")
        self.expect(0, "threshold", "good.8vo", "--range", "0:", "-o", "mask.8vo")
        yield ["join", "v.plan", "parts", "-o", f"{folder}/x.8vo"], f"{folder}/x.8vo"
        yield ["build", *self.source, "--parts", "1", "-o", f"{folder}/x.8vo"], f"{folder}/x.8vo"
        yield (["slice", "good.8vo", "--montage", "8x5", "--every", "1", "-o",
                f"{folder}/x.png"], f"{folder}/x.png")
        yield ["surface", "mask.8vo", "-o", f"{folder}/x.stl"], f"{folder}/x.stl"
        yield (["hexahedra", "mask.8vo", "--uniform", "-o", f"{folder}/x.vtu"],
               f"{folder}/x.vtu")

    def test_what_is_not_replaced_is_said_to_be_unchanged(self):
        out = self.folder / "out"
        if not program_faults.mounts(out, "-t", "tmpfs", "-o", "size=64k", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        try:
            for command, path in [*self.commands("out"), *self.large_results("out")]:
                if path.endswith("stack") or command[0] == "slice" and "--montage" not in command:
                    continue
                (self.folder / path).write_bytes(b"old")
                said = self.expect(5, *command, "--force").stderr
                self.assertIn(f"; existing {os.path.basename(path)} unchanged", said)
                self.assertEqual(said.count("unchanged"), 1, said)
                self.assertEqual((self.folder / path).read_bytes(), b"old")
                os.unlink(self.folder / path)
        finally:
            subprocess.run(["umount", out], check=True)


class Permissions(InFolder):
    def setUp(self):
        super().setUp()
        before = os.umask(0o022)
        self.addCleanup(os.umask, before)
        self.expect(0, "phantom", "--size", "9", "-o", "good.8vo")

    def mode(self, name):
        return (self.folder / name).stat().st_mode & 0o7777

    def test_what_replaces_a_private_file_is_private(self):
        commands = {"p.8vo": ["phantom", "--size", "9"], "s.png": ["slice", "good.8vo"],
                    "s.nrrd": ["export", "good.8vo"], "s.mhd": ["export", "good.8vo"],
                    "s.tif": ["export", "good.8vo"], "r.png": ["render", "good.8vo", "--mode",
                                                               "transparency"]}
        for name, command in commands.items():
            with self.subTest(name):
                written = [name] + (["s.raw"] if name == "s.mhd" else [])
                self.expect(0, *command, "-o", name)
                for one in written:
                    self.assertEqual(self.mode(one), 0o644)
                    (self.folder / one).chmod(0o600)
                self.expect(0, *command, "-o", name, "--force")
                for one in written:
                    self.assertEqual(self.mode(one), 0o600, one)

    def test_a_private_stack_stays_private_as_do_its_planes(self):
        self.expect(0, "export", "good.8vo", "-o", "st/")
        (self.folder / "st").chmod(0o700)
        for plane in (self.folder / "st").iterdir():
            plane.chmod(0o640)
        self.expect(0, "export", "good.8vo", "-o", "st/", "--force")
        self.assertEqual(self.mode("st"), 0o700)
        self.assertEqual({self.mode(f"st/{name}") for name in os.listdir(self.folder / "st")},
                         {0o640})
        (self.folder / "empty").mkdir(mode=0o700)
        self.expect(0, "export", "good.8vo", "-o", "empty/")
        self.assertEqual(self.mode("empty"), 0o700)


class Leftovers(InFolder):
    COMMAND = ["phantom", "--size", "9", "-o", "x.8vo", "--force"]

    def test_what_the_program_did_not_make_is_never_removed(self):
        for name in [f".x.8vo.tmp-{NOBODY}.bak", f".x.8vo.tmp-{NOBODY}-saved/notes.txt",
                     ".x.8vo.tmp-77/notes.txt", f".x.8vo.tmp-9.8vo.tmp-{NOBODY}",
                     f".x.8vo.tmp-9.8vo.tmp-{NOBODY}.journal", ".x.8vo.tmp-.journal",
                     f".x.8vo.tmp-{NOBODY}.bak.journal"]:
            path = self.folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_text("kept")
        before = self.names()
        self.expect(0, *self.COMMAND)
        self.assertEqual(self.names(), sorted(before + ["x.8vo"]))
        self.assertTrue((self.folder / f".x.8vo.tmp-{NOBODY}-saved/notes.txt").exists())

    def changed(self, path):
        """When `path` changed last; None where there is none."""
        try:
            return path.stat().st_ctime_ns
        except FileNotFoundError:
            return None

    def wait_for_lock(self, path):
        """Waits until nobody has `path` locked: its program has ended."""
        with open(path, "r+b") as file:
            fcntl.flock(file, fcntl.LOCK_EX)

    def test_killed_builds_leave_one_file_whatever_their_number(self):
        enter = ["unshare", "-pf", "--kill-child"]
        if subprocess.run([*enter, "true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("needs the right to make process namespaces")
        source = self.noisy_raw("v.raw", 200, 200, 120)
        growing = self.folder / ".x.8vo.tmp-1"
        changed = None
        kills = 0
        while kills < 3:
            with subprocess.Popen([*enter, program_faults.OCTAVO, "build", *source, "-o", "x.8vo",
                                   "--progress", "none"], cwd=self.folder) as process:
                while self.changed(growing) in (None, changed):
                    self.assertIsNone(process.poll(), "it ended before it was killed")
                process.kill()
            try:
                self.wait_for_lock(growing)
            except FileNotFoundError:
                # Killed between the removal of the file before and the making of its own.
                changed = None
                continue
            kills += 1
            changed = self.changed(growing)
            left = [n for n in self.names() if n.startswith(".") and not n.endswith(".journal")]
            self.assertEqual(left, [growing.name])
        self.expect(0, *self.COMMAND)
        self.assertEqual(self.names(), ["v.raw", "x.8vo"])


class TwoBuilds(InFolder):
    def test_a_name_that_another_program_builds_is_rejected_without_force(self):
        growing = self.folder / f".x.8vo.tmp-{NOBODY}"
        growing.write_bytes(b"")
        journal = pathlib.Path(str(growing) + ".journal")
        journal.write_bytes(b"")
        command = ["phantom", "--size", "9", "-o", "x.8vo"]
        with open(journal, "r+b") as held:
            fcntl.flock(held, fcntl.LOCK_EX)
            self.expect_error(5, ["x.8vo: is being built by another program", growing.name,
                                  "--force"], *command)
            self.assertNotIn("x.8vo", self.names())
            self.expect(0, *command, "--force")
            self.assertTrue(growing.exists())
        self.assertEqual(json.loads(self.expect(0, *command, "--force", "--json").stdout)["output"],
                         "x.8vo")
        self.assertEqual(self.names(), ["x.8vo"])


if __name__ == "__main__":
    program_faults.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
