#!/usr/bin/env python3
"""Kills the making of meshes, takes their disk away: what stands under a name is whole.

usage: mesh_faults.py OCTAVO [unittest arguments]

As program_faults.py does with other files. Everything is generated.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import unittest

import program_faults
from program_faults import MOMENTS, InFolder, mounts
import processor_time  # pylint: disable=wrong-import-order

ALL_TRIANGLES = ["--max-deviation", "0"]  # without what takes time and is not written
PAGE = os.sysconf("SC_PAGE_SIZE")


class MeshKills(InFolder):
    check_moments = program_faults.Kills.check_moments

    def test_a_killed_mesh_leaves_the_old_file_or_a_whole_one(self):
        self.expect(0, "phantom", "--size", "70", "--noise", "400", "-o", "p.8vo")
        self.expect(0, "threshold", "p.8vo", "--range", "0:", "-o", "mask.8vo")
        for target, command in [
                ("out.glb", ["surface", "p.8vo", "--isovalue", "0", *ALL_TRIANGLES]),
                ("out.3mf", ["surface", "p.8vo", "--isovalue", "0", *ALL_TRIANGLES]),
                ("out.inp", ["hexahedra", "mask.8vo", "--conforming"])]:
            (self.folder / target).write_bytes(b"old")
            self.check_moments([*command, "-o", target, "--force"], target, max(4, MOMENTS // 4))

    def parts_in(self, folder):
        return {path.name: path.read_bytes() for path in (self.folder / folder).glob("[!.]*")}

    def test_killed_parts_are_all_there_or_none(self):
        numbers = random.Random(9)
        labels = bytes(numbers.randrange(1, 9) for _ in range(18 ** 3))
        large = bytes(labels[z // 4 * 324 + y // 4 * 18 + x // 4]
                      for z in range(72) for y in range(72) for x in range(72))
        (self.folder / "l.raw").write_bytes(large)
        self.expect(0, "build", "l.raw", "--raw", "72,72,72,uint8", "--labels", "--spacing", "1",
                    "-o", "l.8vo")
        command = ["surface", "l.8vo", "--parts", *ALL_TRIANGLES, "-o", "organs", "--progress",
                   "none"]
        began = processor_time.of_children()
        self.expect(0, *command)
        seconds = processor_time.of_children() - began
        whole = self.parts_in("organs")
        self.assertEqual(len(whole), 8)
        own = self.names()
        kept = 0
        for moment in range(max(8, MOMENTS // 2)):
            shutil.rmtree(self.folder / "organs")
            process = self.start(*command)
            processor_time.let_run(process, numbers.uniform(0, 1.05 * seconds))
            how = [signal.SIGKILL, signal.SIGTERM][moment % 2]
            process.send_signal(how)
            _, said = process.communicate()
            self.assertIn(process.returncode, (0, -how, 128 + how), said)
            if (self.folder / "organs").exists():
                self.assertEqual(self.parts_in("organs"), whole)
                kept += 1
            left = [name for name in self.names() if name not in own]
            self.assertTrue(all(name.startswith(".organs.tmp-") for name in left), left)
            if process.returncode == 128 + how:
                self.assertNotIn(f".organs.tmp-{process.pid}", left)
            (self.folder / "organs").mkdir(exist_ok=True)
        shutil.rmtree(self.folder / "organs")
        self.expect(0, *command)
        self.assertEqual(self.names(), own)
        self.assertEqual(self.parts_in("organs"), whole)
        print(f"surface --parts: {kept} of {max(8, MOMENTS // 2)} ends came too late", flush=True)


class MeshDisks(program_faults.Disks):
    SIZE = (32, 32, 20)

    def setUp(self):
        super().setUp()
        self.expect(0, "threshold", "good.8vo", "--range", "0:", "-o", "mask.8vo")

    def commands(self, folder):
        for name in ["x.stl", "x.ply", "x.obj", "x.vtp", "x.glb", "x.3mf"]:
            yield (["surface", "good.8vo", "--isovalue", "0", *ALL_TRIANGLES, "-o",
                    f"{folder}/{name}"],
                   f"{folder}/{name}")
        yield (["surface", "mask.8vo", "--parts", "--smooth", "off", *ALL_TRIANGLES, "-o",
                f"{folder}/parts"],
               f"{folder}/parts")
        for name in ["x.vtu", "x.inp", "x.msh", "x.mesh"]:
            yield ["hexahedra", "mask.8vo", "-o", f"{folder}/{name}"], f"{folder}/{name}"

    def expect_error(self, code, words, *arguments, **options):
        # Parts that are not connected are told of as well.
        quiet = ["-q"] if arguments[0] == "hexahedra" else []
        return super().expect_error(code, words, *arguments, *quiet, **options)

    def expect_full_after(self, pages, command, old):
        """Runs out of a disk of so many free pages; what stood there stays, and nothing else."""
        out = self.folder / "out"
        self.assertTrue(mounts(out, "-t", "tmpfs", "-o", f"size={(pages + len(old)) * PAGE}",
                               "none"))
        try:
            for name in old:
                (out / name).write_text(f"old {name}")  # one page
            said = self.expect(5, *command, "--force", "--progress", "none", "-q").stderr
            self.assertIn("no space left", said)
            self.assertEqual(sorted(os.listdir(out)), sorted(old))
            for name in old:
                self.assertEqual((out / name).read_text(), f"old {name}")
        finally:
            subprocess.run(["umount", out], check=True)

    def test_a_disk_that_fills_in_the_middle_leaves_what_stood_there(self):
        out = self.folder / "out"
        if not mounts(out, "-t", "tmpfs", "-o", "size=4k", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        subprocess.run(["umount", out], check=True)
        for command, path in self.commands("out"):
            if path.endswith("parts"):
                continue
            with self.subTest(path):
                self.expect(0, *command, "-q")
                size = (self.folder / path).stat().st_size
                (self.folder / path).unlink()
                pages = -(-size // PAGE)
                self.assertGreater(pages, 8)
                name = os.path.basename(path)
                self.expect_full_after(pages // 2, command, [])
                self.expect_full_after(pages - 1, command, [name])

    def test_a_disk_too_small_for_the_report_leaves_no_surface_either(self):
        out = self.folder / "out"
        if not mounts(out, "-t", "tmpfs", "-o", "size=4k", "none"):
            self.skipTest("needs the right to mount a tmpfs")
        subprocess.run(["umount", out], check=True)
        command = ["surface", "good.8vo", "--isovalue", "0", *ALL_TRIANGLES, "-o", "out/x.stl",
                   "--report", "out/x.json"]
        self.expect(0, *command)
        pages = -(-(out / "x.stl").stat().st_size // PAGE)
        for name in ["x.stl", "x.json"]:
            (out / name).unlink()
        self.expect_full_after(pages, command, [])
        self.expect_full_after(pages, command, ["x.json", "x.stl"])


if __name__ == "__main__":
    program_faults.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
