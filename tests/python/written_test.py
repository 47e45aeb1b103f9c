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
from written_floats import FloatFile
from written_grey import GreyFile
from written_labels import LabelFile

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


def field(size, seed):
    """Waves and noise around 0 and -0."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in size[::-1]], indexing="ij")
    noise = np.random.default_rng(seed)
    floats = np.sin(x / 3) * np.cos(y / 4 + z / 5) + noise.normal(0, 1e-3, x.shape)
    floats[x + y < 6] = 0.0
    floats[5, :, -3:] = -0.0
    floats[6, :, -3:] *= 1e-6
    floats[:, -4:, :3] = np.rint(floats[:, -4:, :3] * 4) / 4
    return np.float32(floats)


def organs(size, seed):
    """Balls of labels in each other and beside each other; the last planes across x are empty."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in size[::-1]], indexing="ij")
    random = np.random.default_rng(seed)
    labels = np.zeros(x.shape, np.int64)
    for label in (1, 2, 3, 900, 40000, 2):
        middle = [random.uniform(0.2, 0.6) * n for n in size]
        radius = random.uniform(3, 11)
        distance = (x - middle[0])**2 / 4 + (y - middle[1])**2 + (z - middle[2])**2
        labels[distance < radius**2] = label
    labels[z % 7 == 3] += (labels > 0)[z % 7 == 3]
    return labels


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
            raw = np.fromfile(path.with_suffix(".raw"), volume.DTYPE).reshape(volume.voxels.shape)
            self.assertEqual(raw.tobytes(), volume.planes().astype(volume.DTYPE).tobytes())
            with OctavoFile(str(path)) as file:
                verify(file)
                self.assertEqual(file.read_level(0).astype(volume.DTYPE).tobytes(), raw.tobytes())
        return data

    def test_two_tiers_two_slabs_and_axes_halved_at_different_levels(self):
        # z is halved one step later than x and y; level 6 is 1 x 1 x 2.
        masks = [3, 7, 7, 7, 7, 7, 4]
        for order in ("xyz", "yzx"):
            with self.subTest(order):
                voxels = scan((20, 21, 40), 1)
                data = self.both_read(GreyFile(voxels, masks, order, (0.5, 0.5, 1.25)))
                self.assertLess(len(data), voxels.nbytes)

    def test_a_single_brick_of_few_levels(self):
        self.both_read(GreyFile(scan((7, 15, 12), 2), [7, 7, 7, 7]))

    def test_two_bricks_along_x_in_one_page(self):
        self.both_read(GreyFile(scan((70, 15, 12), 3), [7, 7, 7, 7, 7, 7, 1]))

    def test_labels_of_two_tiers_some_bricks_uniform_or_stored(self):
        voxels = organs((70, 21, 18), 4)
        data = self.both_read(LabelFile(voxels, [7, 7, 7, 7, 7, 3, 1], [1, 3, 900], [1]))
        self.assertLess(len(data), voxels.nbytes)

    def test_a_brick_of_two_labels_and_one_of_many(self):
        ball = organs((21, 20, 19), 5)
        for voxels in (np.where(ball > 2, 5, 65535), ball + 7 * (ball > 1)):
            self.both_read(LabelFile(voxels, [7, 7, 3, 7, 5, 7]))

    def test_noise_of_labels_as_it_is(self):
        noise = np.random.default_rng(6).integers(0, 60000, (9, 8, 7))
        for places in ((), [0]):
            self.both_read(LabelFile(noise, [7, 7, 7, 7], stored_at=places))

    def test_floats_in_their_bins(self):
        for repeats in (False, True):
            floats = field((23, 17, 12), 7)
            self.both_read(FloatFile(floats, [7, 7, 7, 7, 3], 2**-9, 0.125, "zxy",
                                     repeats=repeats))

    def test_floats_with_few_mantissa_bits_and_absent_ones(self):
        floats = np.float32(np.rint(field((13, 11, 12), 8) * 16) / 16)
        floats[2:7, 1:6, 3:9] = np.nan
        floats[9, 2, 1:3] = np.inf, -np.inf
        floats[8, 8, 8] = np.uint32(0xffc12345).view(np.float32)
        self.both_read(FloatFile(floats, [7, 7, 7, 7], 2**-6))

    def test_plain_floats_beside_others_below_another_tier(self):
        floats = field((70, 15, 12), 9)
        floats[3, 4, 5:9] = np.nan
        self.both_read(FloatFile(floats, [7, 7, 7, 7, 7, 7, 1], 2**-9, plain_at=[0]))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    OCTAVO = sys.argv.pop(1)
    unittest.main()
