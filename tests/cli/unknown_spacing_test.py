#!/usr/bin/env python3
"""Proves that nothing is said in mm where no spacing is known, and of sides where no place is.

usage: unknown_spacing_test.py OCTAVO [unittest arguments]

Everything is generated: a grey block in the same volume with and without a spacing.
"""

import csv
import io
import json
import struct
import sys

import cli_test

SIZE = (20, 18, 12)


class UnknownSpacing(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = [40 if 4 <= x < 12 and 4 <= y < 12 and 4 <= z < 8 else 10
                  for z in range(SIZE[2]) for y in range(SIZE[1]) for x in range(SIZE[0])]
        (self.folder / "v.raw").write_bytes(struct.pack(f"<{len(voxels)}h", *voxels))
        self.build("known.8vo", "--spacing", "0.5")
        self.build("v.8vo")
        self.said("threshold", "v.8vo", "--range", "30:", "-o", "m.8vo")
        self.said("threshold", "known.8vo", "--range", "30:", "-o", "known-m.8vo")

    def build(self, name, *options):
        layout = ",".join(map(str, SIZE)) + ",int16"
        self.expect(0, "build", "v.raw", "--raw", layout, "--preset", "fast", "-o", name, "-q",
                    *options)

    def said(self, *arguments):
        return self.expect(0, *arguments, "--progress", "none")

    def rows(self, *arguments):
        return list(csv.DictReader(io.StringIO(self.said(*arguments).stdout)))

    def test_a_table_keeps_its_columns_and_leaves_cells_in_mm_empty(self):
        for of, known_of in [([], []), (["--of", "v.8vo"], ["--of", "known.8vo"])]:
            known, = self.rows("measure", "known-m.8vo", "--csv", *known_of)
            row, = self.rows("measure", "m.8vo", "--csv", *of)
            self.assertEqual(list(row), list(known))
            for name, cell in row.items():
                in_mm = "mm" in name or name.startswith("principal_axis")
                self.assertEqual(cell, "" if in_mm else known[name], name)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
