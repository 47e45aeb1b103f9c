#!/usr/bin/env python3
"""Runs builds whose sources are read by another process, and ends either process.

usage: isolation_test.py OCTAVO [unittest arguments]
"""

import os
import pathlib
import random
import signal
import struct
import subprocess
import sys
import unittest

import cli_test
import processor_time
from cli_test import InFolder


def write_tiff(path, width, height, voxels):
    """An uncompressed grey TIFF of 8 bits in one strip."""
    fields = [(256, 4, width), (257, 4, height), (258, 3, 8), (259, 3, 1), (262, 3, 1),
              (273, 4, 8), (277, 3, 1), (278, 4, height), (279, 4, len(voxels))]
    head = struct.pack("<2sHI", b"II", 42, 8 + len(voxels) + len(voxels) % 2)
    table = struct.pack("<H", len(fields))
    for tag, kind, value in fields:
        table += struct.pack("<HHII", tag, kind, 1, value)
    path.write_bytes(head + voxels + bytes(len(voxels) % 2) + table + struct.pack("<I", 0))


def children_of(process):
    """The processes that `process` started and that have not ended."""
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = stat.read_text().rsplit(")", 1)[1].split()[:2]
        except OSError:
            continue
        if int(parent) == process and state not in "ZX":
            found.append(int(stat.parent.name))
    return found


def state_of(process):
    """The letter that ps shows; X for one that is no more."""
    try:
        text = pathlib.Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return "X"
    return text.rsplit(")", 1)[1].split()[0]


def is_running(process):
    return state_of(process) not in "ZX"


class Isolation(InFolder):
    def write_stack(self, name, side, count):
        (self.folder / name).mkdir()
        numbers = random.Random(5)
        for z in range(count):
            write_tiff(self.folder / name / f"{z}.tif", side, side, numbers.randbytes(side * side))

    def start_build(self):
        """A build of the folder `stack`, and the process that reads for it."""
        process = subprocess.Popen(
            [cli_test.OCTAVO, "build", "stack", "-o", "x.8vo", "--spacing", "1", "--progress",
             "none"], cwd=self.folder, stderr=subprocess.PIPE, text=True)
        workers = []
        while not workers and process.poll() is None:
            workers = children_of(process.pid)
        self.assertEqual(len(workers), 1)
        return process, workers[0]

    def test_isolation_changes_no_byte_and_no_word(self):
        self.write_stack("stack", 40, 5)
        for option, output in [([], "a.8vo"), (["--no-isolation"], "b.8vo")]:
            self.expect(0, "build", "stack", "-o", output, "--spacing", "1", *option)
        self.assertEqual((self.folder / "a.8vo").read_bytes(),
                         (self.folder / "b.8vo").read_bytes())
        bad = self.folder / "stack" / "3.tif"
        bad.write_bytes(bad.read_bytes()[:-60])
        told = [self.expect_error(7, ["3.tif"], "build", "stack", "-o", "c.8vo", *option).stderr
                for option in ([], ["--no-isolation"])]
        self.assertEqual(told[0], told[1])
        self.assertNotIn("c.8vo", self.files())

    def test_the_worker_is_no_verb(self):
        self.expect_error(2, ["import-worker"], "import-worker")
        self.assertNotIn("import-worker", self.expect(0, "--help").stdout)

    def test_the_worker_ends_with_the_program(self):
        self.write_stack("stack", 400, 400)
        for number in [signal.SIGKILL, signal.SIGTERM, signal.SIGINT]:
            with self.subTest(number):
                process, worker = self.start_build()
                # Stopped, the program takes no planes: the worker cannot come to its end.
                process.send_signal(signal.SIGSTOP)
                processor_time.wait_until(lambda: state_of(process.pid) == "T")
                # It sleeps once the pipe is full.
                processor_time.wait_until(lambda: state_of(worker) in "SZX")
                self.assertTrue(is_running(worker))
                process.send_signal(number)
                process.send_signal(signal.SIGCONT)
                _, errors = process.communicate()
                code = -number if number == signal.SIGKILL else 128 + number
                self.assertEqual(process.returncode, code, errors)
                processor_time.wait_until(lambda: not is_running(worker))

    def test_a_worker_that_is_killed_is_exit_7_and_leaves_no_file(self):
        self.write_stack("stack", 400, 400)
        process, worker = self.start_build()
        os.kill(worker, signal.SIGKILL)
        _, errors = process.communicate()
        self.assertEqual(process.returncode, 7, errors)
        self.assertEqual(errors.count("\n"), 1, errors)
        self.assertIn("stopped by signal 9", errors)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["stack"])


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
