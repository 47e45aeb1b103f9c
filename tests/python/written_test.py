#!/usr/bin/env python3
"""Files of a third program, which was written from docs/format*.md alone, in both readers.

usage: written_test.py OCTAVO [unittest arguments]

Exits with 77, which means skipped, without NumPy.
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

from reader_path import ROOT  # noqa: F401  first: it finds the others
import numpy as np
from octavo_reader import OctavoFile, verify
from written_files import Volume

OCTAVO = "octavo"


def scan(size, seed):
    """Waves and noise, steps, and a constant block: every class of activity."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in size[::-1]], indexing="ij")
    noise = np.random.default_rng(seed)
    voxels = 400 * np.sin(x / 5) * np.cos(y / 7 + z / 9) + noise.normal(0, 9, x.shape)
    voxels[(x > y) & (z < 9)] -= 1500
    voxels[:4, 5:14, :7] = 31
    voxels[-3:, -2:, -2:] = noise.integers(-32000, 32000, (3, 2, 2))
    return np.rint(voxels).astype(np.int16)


class Written(unittest.TestCase):
    def both_read(self, volume):
        data = volume.bytes()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "written.8vo")
            path.write_bytes(data)
            said = subprocess.run([OCTAVO, "verify", path], capture_output=True, text=True)
            self.assertEqual(said.returncode, 0, said.stderr)
            subprocess.run([OCTAVO, "export", path, "-q", "-o", path.with_suffix(".raw")],
                           check=True)
            raw = np.fromfile(path.with_suffix(".raw"), "<i2").reshape(volume.voxels.shape)
            self.assertTrue((raw == volume.voxels).all())
            with OctavoFile(str(path)) as file:
                verify(file)
                self.assertTrue((file.read_level(0) == volume.voxels).all())
        return data

    def test_two_tiers_two_slabs_and_axes_halved_at_different_levels(self):
        # z is halved one step later than x and y; level 6 is 1 x 1 x 2.
        masks = [3, 7, 7, 7, 7, 7, 4]
        for order in ("xyz", "yzx"):
            with self.subTest(order):
                voxels = scan((20, 21, 40), 1)
                data = self.both_read(Volume(voxels, masks, order, (0.5, 0.5, 1.25)))
                self.assertLess(len(data), voxels.nbytes)

    def test_a_single_brick_of_few_levels(self):
        self.both_read(Volume(scan((7, 15, 12), 2), [7, 7, 7, 7]))

    def test_two_bricks_along_x_in_one_page(self):
        self.both_read(Volume(scan((70, 15, 12), 3), [7, 7, 7, 7, 7, 7, 1]))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    OCTAVO = sys.argv.pop(1)
    unittest.main()
