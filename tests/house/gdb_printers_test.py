"""gdb shows boxes, o-codes and masks as people write them.

usage: gdb_printers_test.py PRINTED_VALUES GDB_PRINTERS
"""

import subprocess
import sys
import unittest

PROGRAM, PRINTERS = sys.argv[1:3]


def printed(*commands):
    arguments = [part for command in commands for part in ("-ex", command)]
    return subprocess.run(["gdb", "-nx", "-q", "-batch", "-ex", f"source {PRINTERS}", *arguments,
                           PROGRAM], capture_output=True, text=True, check=True).stdout


class Printers(unittest.TestCase):
    def test_places_sizes_and_boxes(self):
        shown = printed("print place", "print size", "print box")
        self.assertEqual(shown.splitlines(),
                         ["$1 = (1, 2, 3)", "$2 = 64 x 32 x 16",
                          "$3 = 0:64,1:32,2:16 (64 x 31 x 14)"])

    def test_cubes_of_octrees_and_masks(self):
        shown = printed("print cube", "print mask_cube")
        self.assertEqual(shown.splitlines(),
                         ["$1 = level 1, code 65 (octal): side 2 at (4, 2, 6)",
                          "$2 = 2 full and 2 mixed of 64, first mixed at 7"])

    def test_a_mask(self):
        shown = printed("break printed_values.cpp:13", "run", "print tree")
        if "$1" not in shown:
            self.skipTest("programs cannot be traced here")
        self.assertRegex(shown, r"\$1 = mask of 64 x 32 x 16 voxels: \d+ mixed words, "
                                r"cubes by rank \[\d+, 1\]")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
