"""A scan in three parts for the tests of engines, what `octavo build` makes of it, and a folder."""

import atexit
import os
import pathlib
import random
import shutil
import subprocess
import tempfile
import unittest

PATH_WITH_OCTAVO = ""
OPTIONS = ("scan.raw", "--raw", "512,512,140,uint16", "--spacing", "1", "--preset", "fast")
PLAN_OPTIONS = (*OPTIONS, "--parts", "3")
VOXEL_COUNT = 512 * 512 * 140  # groups of 64, 64 and 12 planes


def use(octavo):
    """Lets programs find `octavo`, and no number of a scheduler that runs these tests."""
    folder = pathlib.Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder)
    (folder / "octavo").symlink_to(pathlib.Path(octavo).absolute())
    os.environ["PATH"] = f"{folder}:{os.environ['PATH']}"
    for name in list(os.environ):
        if name.startswith(("SLURM_", "PBS_", "OMPI_", "PMI")):
            del os.environ[name]


class OfScan(unittest.TestCase):
    """Each test works in a fresh folder with scan.raw; whole.8vo is what one machine makes."""

    @classmethod
    def setUpClass(cls):
        cls.shared = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.shared)
        # Noise, one byte a voxel: runs of two parts are longer than what a store copies at least.
        voxels = bytearray(2 * VOXEL_COUNT)
        voxels[::2] = random.Random(9).randbytes(VOXEL_COUNT)
        (cls.shared / "scan.raw").write_bytes(voxels)
        subprocess.run(["octavo", "build", *OPTIONS, "-q", "-o", "whole.8vo"], cwd=cls.shared,
                       check=True)
        cls.whole = (cls.shared / "whole.8vo").read_bytes()

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        os.link(self.shared / "scan.raw", self.folder / "scan.raw")

    def octavo(self, *arguments):
        subprocess.run(["octavo", *map(str, arguments), "-q"], cwd=self.folder, check=True)

    def stand_in(self, text):
        """A folder with a program `octavo` in it, which ends with the real one."""
        folder = self.folder / "bin"
        folder.mkdir()
        program = folder / "octavo"
        program.write_text(f'#!/bin/sh\n{text}\nexec {shutil.which("octavo")} "$@"\n')
        program.chmod(0o755)
        return folder

    def check_joined(self):
        self.assertTrue((self.folder / "scan.8vo").read_bytes() == self.whole, "other bytes")

    def files(self):
        return sorted(path.name for path in self.folder.iterdir())
