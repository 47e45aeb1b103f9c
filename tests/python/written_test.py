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
from written_masked import ValueMap

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


def masked(size, seed):
    """A ball of waves and noise in a background of one value; another one touches the border."""
    z, y, x = np.meshgrid(*[np.arange(n) for n in size[::-1]], indexing="ij")
    noise = np.random.default_rng(seed)
    voxels = np.rint(70 + 40 * np.sin(x / 4 + z / 5) + noise.normal(0, 6, x.shape))
    middle = [n / 2 for n in size]
    inner = sum(((c - m) / m)**2 for c, m in zip((x, y, z), middle)) < 0.7
    inner |= (x < 5) & (y + z > 9)
    return np.where(inner, np.clip(voxels, 2, 160), 0).astype(np.int64)


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

    def test_parts_along_each_axis_and_all(self):
        voxels = scan((35, 34, 37), 10)
        for cuts, order in ((1, "xyz"), (2, "yzx"), (6, "zxy"), (7, "xzy")):
            with self.subTest(cuts=cuts, order=order):
                self.both_read(GreyFile(voxels, [7, 7, 7, 7, 7, 7], order, cuts=cuts))
        # Two bricks; z is not halved between level 0 and 1.
        self.both_read(GreyFile(scan((71, 9, 33), 11), [3, 7, 7, 7, 7, 7, 5], cuts=7))

    def test_samples_of_17_bits_and_more(self):
        for factor in (12, 40000):
            wide = scan((21, 18, 13), 12).astype(np.int64) * factor
            wide += np.random.default_rng(13).integers(0, factor, wide.shape)
            self.both_read(GreyFile(wide, [7, 7, 7, 7, 3], "zyx"))
        self.both_read(GreyFile(scan((35, 34, 9), 14).astype(np.int64) * 9, [7, 7, 7, 7, 3, 3],
                                cuts=3, has_edges=True))

    def test_edges_of_odd_sizes_and_in_parts(self):
        for size, masks, cuts in (((23, 21, 17), [7, 7, 7, 7, 7], 0),
                                  ((37, 35, 41), [7, 7, 7, 7, 7, 7], 7),
                                  ((41, 36, 11), [3, 7, 7, 7, 7, 3], 3)):
            for order in ("xyz", "zyx"):
                with self.subTest(size=size, order=order):
                    self.both_read(GreyFile(masked(size, 15), masks, order, cuts=cuts,
                                            has_edges=True))

    def test_edges_between_two_values(self):
        voxels = (masked((19, 22, 13), 16) > 80) * 7
        self.both_read(GreyFile(voxels, [7, 7, 7, 7, 3], has_edges=True))

    def test_a_lattice_of_values_in_two_tiers(self):
        voxels = 3 * masked((70, 19, 12), 17) + 301
        self.both_read(GreyFile(voxels, [7, 7, 7, 7, 7, 7, 1], value_map=ValueMap(3, 1)))

    def test_gaps_between_values_with_and_without_a_lattice_edges_and_parts(self):
        codes = masked((43, 21, 18), 18)
        codes -= codes % 5 * (codes > 9)
        codes[5, 4, 3:9] = 77
        known = tuple(code for code in range(0, 161) if code % 5 == 0 or code in (3, 4))
        masks = [7, 7, 7, 7, 7, 1]
        for step, offset, shift in ((1, 0, 0), (2, 1, -40)):
            for has_edges, cuts in ((False, 0), (True, 0), (True, 3)):
                with self.subTest(step=step, has_edges=has_edges, cuts=cuts):
                    own = tuple(code + shift for code in known)
                    self.both_read(GreyFile((codes + shift) * step + offset, masks, "yxz",
                                            cuts=cuts, has_edges=has_edges,
                                            value_map=ValueMap(step, offset, own)))

    def test_voxels_rounded_within_a_maximum_error(self):
        for step, cuts in ((3, 0), (9, 3)):
            self.both_read(GreyFile(scan((39, 34, 13), 19), [7, 7, 7, 7, 3, 3], cuts=cuts,
                                    voxel_step=step))

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
