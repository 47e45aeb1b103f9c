#!/usr/bin/env python3
"""Gives the program odd targets: what stands under a name is whole, or was left alone.

usage: target_faults.py OCTAVO [unittest arguments]
"""

import os
import sys
import unittest

import program_faults
from program_faults import InFolder


class Targets(InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "20", "-o", "good.8vo")
        self.before = self.names()

    def commands(self, stem):
        yield ["phantom", "--size", "9", "-o", f"{stem}.8vo"], f"{stem}.8vo"
        for ending in ["nrrd", "nii.gz", "mhd", "tif"]:
            yield ["export", "good.8vo", "-o", f"{stem}.{ending}"], f"{stem}.{ending}"
        yield ["slice", "good.8vo", "-o", f"{stem}.png"], f"{stem}.png"

    def expect_rejected(self, stem, code, words, make=None, force=True):
        for command, name in self.commands(stem):
            with self.subTest(name):
                if make:
                    make(self.folder / name)
                names = self.names()
                self.expect_error(code, words, *command, *(["--force"] if force else []))
                self.assertEqual(self.names(), names)

    def test_a_missing_folder_is_exit_5(self):
        self.expect_rejected("nowhere/x", 5, ["nowhere/x", "folder does not exist"])
        self.assertEqual(self.names(), self.before)

    def test_a_file_taken_for_a_folder_is_exit_5(self):
        self.expect_rejected("good.8vo/x", 5, ["good.8vo/x", "Not a directory"])
        self.assertEqual(self.names(), self.before)

    def test_a_folder_is_never_replaced_by_a_file(self):
        for command, name in self.commands("folder"):
            if command[0] == "export":
                continue  # There a folder asks for a stack.
            (self.folder / name).mkdir()
            with self.subTest(name):
                self.expect_error(5, [name], *command, "--force")
                self.assertEqual(os.listdir(self.folder / name), [])

    def test_a_pipe_is_rejected_and_not_waited_for(self):
        self.expect_rejected("pipe", 5, ["pipe", "not a"], make=os.mkfifo)

    def test_a_device_is_rejected(self):
        self.expect_rejected("device", 5, ["device", "not a"],
                             make=lambda path: os.symlink("/dev/full", path))

    def test_a_link_to_nowhere_is_rejected(self):
        self.expect_rejected("link", 5, ["link", "not a"],
                             make=lambda path: os.symlink("gone", path))
        self.assertNotIn("gone", self.names())

    def test_what_a_link_points_to_is_left_alone(self):
        (self.folder / "behind").write_text("kept")
        for command, name in self.commands("link"):
            with self.subTest(name):
                os.symlink("behind", self.folder / name)
                self.expect_error(5, [name, "exists already"], *command)
                self.expect(0, *command, "--force")
                self.assertEqual((self.folder / "behind").read_text(), "kept")

    def test_a_line_end_in_a_name_is_written_and_escaped(self):
        self.expect_rejected("no\nfolder/x", 5, [r"no\x0afolder/x"])
        for command, name in self.commands("two\nlines"):
            with self.subTest(name):
                self.expect(0, *command)
                self.assertIn(name, self.names())
                self.expect_error(5, [r"two\x0alines", "exists already"], *command)

    def test_the_longest_name_is_written_and_a_longer_one_rejected(self):
        for ending_length, code in [(255, 0), (256, 5)]:
            for command, name in self.commands("x"):
                stem = "x" * (ending_length - len(name) + 1)
                command = [name.replace("x", stem, 1) if part == name else part for part in command]
                with self.subTest(command[-1][-8:]):
                    result = self.expect(code, *command)
                    if code:
                        self.assertIn("octavo: xxxx", result.stderr)
                        self.assertIn("longer than 255 bytes", result.stderr)
        self.assertEqual([n for n in self.names() if n.startswith(".")], [])


if __name__ == "__main__":
    program_faults.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
