#!/usr/bin/env python3
"""Solves meshes of hexahedra with CalculiX, and reads them with meshio.

usage: calculix_test.py OCTAVO [unittest arguments]

A block of one material, pressed along x, moves linearly and has one stress everywhere, however it
is divided into elements: with hanging nodes, and with pyramids and tetrahedra as well.
"""

import collections
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import meshio
import numpy

OCTAVO = ""
SIDE = 16
SPACING = (0.5, 0.75, 1.25)
MODULUS = 1000.0
STRAIN = -0.01
STEP = """*INCLUDE, INPUT=mesh.inp
*BOUNDARY
X_MIN, 1, 1, 0
Y_MIN, 2, 2, 0
Z_MIN, 3, 3, 0
X_MAX, 1, 1, {move}
*STEP
*STATIC
*NODE PRINT, NSET=X_MIN, TOTALS=ONLY
RF
*EL PRINT, ELSET=ALL_ELEMENTS, TOTALS=ONLY
EVOL
*NODE FILE
U
*EL FILE
S
*END STEP
"""


def read_results(path):
    """By name of a result its numbers of each node."""
    results, lines = collections.defaultdict(dict), None
    for line in path.read_text().splitlines():
        if line.startswith(" -4"):
            lines = results[line.split()[1]]
        elif line.startswith(" -3"):
            lines = None
        elif line.startswith(" -1") and lines is not None:
            numbers = line[13:]
            lines[int(line[3:13])] = [float(numbers[i:i + 12]) for i in range(0, len(numbers), 12)]
    return results


class CalculiX(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        labels = bytearray(b"\1" * SIDE ** 3)
        for x, y, z in ((7, 8, 9), (8, 6, 5)):
            labels[(z * SIDE + y) * SIDE + x] = 2
        size = ",".join([str(SIDE)] * 3)
        spacing = ",".join(map(str, SPACING))
        for name, data, kind in (("labels", bytes(labels), "--labels"),
                                 ("grey", bytes([100]) * SIDE ** 3, "--grey")):
            (self.folder / "v.raw").write_bytes(data)
            self.octavo("build", "v.raw", "--raw", size + ",uint8", "--spacing", spacing, "-o",
                        name + ".8vo", kind)

    def octavo(self, *arguments):
        subprocess.run([OCTAVO, *arguments, "-q"], cwd=self.folder, check=True)

    def solve(self, method):
        self.octavo("hexahedra", "labels.8vo", method, "--of", "grey.8vo", "--density", "0,1",
                    "--modulus", f"{MODULUS},1", "-o", "mesh.inp", "-f")
        move = STRAIN * SIDE * SPACING[0]
        (self.folder / "press.inp").write_text(STEP.format(move=move))
        output = subprocess.run(["ccx", "press"], cwd=self.folder, capture_output=True, text=True,
                                check=True).stdout
        self.assertNotIn("*ERROR", output)
        return read_results(self.folder / "press.frd")

    def test_a_block_under_pressure_moves_linearly_and_has_one_stress(self):
        for method in ("--uniform", "--octree", "--conforming"):
            with self.subTest(method):
                results = self.solve(method)
                points = meshio.read(self.folder / "mesh.inp").points
                lowest = points.min(axis=0)
                moved = numpy.array([results["DISP"][i + 1] for i in range(len(points))])
                expected = (points - lowest) * [STRAIN, -0.3 * STRAIN, -0.3 * STRAIN]
                numpy.testing.assert_allclose(moved, expected, atol=1e-6)
                stress = numpy.array(list(results["STRESS"].values()))
                numpy.testing.assert_allclose(stress[:, 0], MODULUS * STRAIN, rtol=1e-3)
                numpy.testing.assert_allclose(stress[:, 1:], 0, atol=1e-2)
                volume = float((self.folder / "press.dat").read_text().split()[-1])
                self.assertAlmostEqual(volume, (SIDE ** 3) * numpy.prod(SPACING), delta=1e-2)

    def test_meshio_reads_every_format_alike(self):
        for method in ("--uniform", "--octree", "--conforming"):
            counts = {}
            for ending in ("vtu", "inp", "msh"):
                if (method, ending) == ("--octree", "msh"):
                    continue
                self.octavo("hexahedra", "labels.8vo", method, "-o", f"m.{ending}", "-f")
                mesh = meshio.read(self.folder / f"m.{ending}")
                elements = collections.Counter()
                for block in mesh.cells:
                    elements[block.data.shape[1]] += len(block.data)
                if ending == "inp":  # a pyramid has the corners of a cube there
                    elements[8] -= sum(int((block.data[:, 4] == block.data[:, 5]).sum())
                                       for block in mesh.cells if block.data.shape[1] == 8)
                counts[ending] = (len(mesh.points), elements[8], elements[4])
            self.assertEqual(len(set(counts.values())), 1, counts)


if __name__ == "__main__":
    OCTAVO = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
