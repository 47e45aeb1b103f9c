#!/usr/bin/env python3
"""Reads GLB files by the validator of Khronos and by glTF Transform with meshoptimizer's decoder.

usage: glb_test.py OCTAVO MODULES [unittest arguments]

Triangles are those of the same surface as STL, read by meshio, each with its orientation; where
points were moved to a grid of 16 bits, area and volume are those that the report says.
"""

import json
import pathlib
import subprocess
import sys
import unittest

import meshio
import numpy

import engine_phantom

MODULES = ""
READER = pathlib.Path(__file__).resolve().parent / "read_glb.mjs"
# Extensions that the validator does not know, and what it therefore takes for unused.
KNOWN_ISSUES = {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"}


def in_patient(points):
    """Meters with y up as mm in LPS."""
    points = 1000 * numpy.array(points)
    return numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)


def sorted_triangles(points, triangles):
    """Places of the corners of all triangles, in nanometers, whatever their order."""
    no_tie = 0.123  # Coordinates are binary fractions.
    corners = numpy.rint(1e6 * points + no_tie).astype(int)[triangles]
    rows = []
    for triangle in corners.tolist():
        first = triangle.index(min(triangle))
        rows.append(triangle[first:] + triangle[:first])
    return sorted(rows)


def area_and_volume(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = numpy.cross(b - a, c - a)
    return (numpy.linalg.norm(normals, axis=1).sum() / 2,
            numpy.einsum("ij,ij->", a, numpy.cross(b, c)) / 6)


class Glb(engine_phantom.OfPhantom):
    def read(self, name):
        """The parts of a file without errors, points in mm."""
        found = json.loads(subprocess.run(["node", READER, MODULES, self.folder / name], check=True,
                                          capture_output=True, text=True).stdout)
        issues = found["issues"]
        self.assertEqual((issues["numErrors"], issues["numWarnings"]), (0, 0), issues["messages"])
        self.assertLessEqual({issue["code"] for issue in issues["messages"]}, KNOWN_ISSUES)
        for part in found["parts"]:
            part["points"] = in_patient(part["points"])
            part["numbers"] = numpy.array(part["numbers"]).reshape(-1, 3)
        self.assertEqual(found["triangles"], sum(len(p["numbers"]) for p in found["parts"]))
        return found["parts"]

    def triangles_of_stl(self, *names):
        found = []
        for name in names:
            mesh = meshio.read(self.folder / name)
            found += sorted_triangles(mesh.points.astype(float), mesh.cells_dict["triangle"])
        self.assertGreater(len(found), 1000)
        return sorted(found)

    def check(self, expected, *surface):
        self.octavo("surface", *surface, "-o", "m.glb", "-f")
        found = []
        for part in self.read("m.glb"):
            found += sorted_triangles(part["points"], part["numbers"])
            lengths = numpy.linalg.norm(part["normals"], axis=1)
            self.assertLess(numpy.abs(lengths - 1).max(), 0.02)
        self.assertTrue(sorted(found) == expected, surface)

    def test_all_triangles_are_those_of_stl(self):
        surface = ["p.8vo", "--isovalue", "300", "--max-deviation", "0"]
        self.octavo("surface", *surface, "-o", "m.stl")
        expected = self.triangles_of_stl("m.stl")
        self.check(expected, *surface)
        self.check(expected, *surface, "--plain")

    def test_parts_are_those_of_stl(self):
        surface = ["l.8vo", "--parts", "--max-deviation", "0"]
        self.octavo("surface", *surface, "-o", "parts")
        expected = self.triangles_of_stl("parts/label_1.stl", "parts/label_2.stl")
        self.check(expected, *surface)

    def test_points_of_16_bits_enclose_what_the_report_says(self):
        report = self.surface("q.glb", "--max-deviation", "0.5voxel")
        [part] = self.read("q.glb")
        self.assertEqual(len(part["numbers"]), report["triangles"])
        area, volume = area_and_volume(part["points"], part["numbers"])
        self.assertAlmostEqual(area / report["area_mm2"], 1, 4)
        self.assertAlmostEqual(volume / report["volume_mm3"], 1, 4)


if __name__ == "__main__":
    engine_phantom.use(sys.argv.pop(1))
    MODULES = sys.argv.pop(1)
    unittest.main()
