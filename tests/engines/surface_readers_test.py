#!/usr/bin/env python3
"""Has VTK read VTP files, and trimesh 3MF files and GLB files without compression.

usage: surface_readers_test.py OCTAVO [unittest arguments]

Triangles are those of the same surface as STL, each with its orientation. 3MF files have an origin
of their own.
"""

import sys
import unittest

import numpy
import trimesh
import vtk
from vtk.util.numpy_support import vtk_to_numpy

import engine_phantom


def sorted_triangles(points, triangles, decimals=4):
    """Corners of all triangles in mm, the lowest first, whatever their order."""
    no_tie = 1.23e-7  # Coordinates are binary fractions.
    rounded = numpy.round(numpy.asarray(points, float) + no_tie, decimals)
    rows = []
    for triangle in rounded[numpy.asarray(triangles)].tolist():
        first = triangle.index(min(triangle))
        rows.append(triangle[first:] + triangle[:first])
    return numpy.array(sorted(rows))


class SurfaceReaders(engine_phantom.OfPhantom):
    def polydata(self, name):
        """Points, triangles, and the whole as VTK has it."""
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(str(self.folder / name))
        reader.Update()
        self.assertEqual(reader.GetErrorCode(), 0)
        found = reader.GetOutput()
        self.assertEqual(found.GetNumberOfPolys(), found.GetNumberOfCells())
        triangles = vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
        self.assertEqual(len(triangles), found.GetNumberOfPolys())
        return vtk_to_numpy(found.GetPoints().GetData()), triangles, found

    def expected(self, decimals=4):
        mesh = trimesh.load(self.folder / "s.stl", process=False)
        self.assertGreater(len(mesh.faces), 1000)
        return sorted_triangles(mesh.vertices, mesh.faces, decimals)

    def assert_near(self, found, expected):
        self.assertEqual(found.shape, expected.shape)
        self.assertLess(numpy.abs(found - expected).max(), 2e-4)

    def test_vtk_reads_vtp(self):
        self.surface("s.stl")
        report = self.surface("s.vtp")
        points, triangles, found = self.polydata("s.vtp")
        self.assertEqual(len(triangles), report["triangles"])
        self.assert_near(sorted_triangles(points, triangles), self.expected())
        edges = vtk.vtkFeatureEdges()
        edges.SetInputData(found)
        edges.FeatureEdgesOff()
        edges.Update()
        self.assertEqual(edges.GetOutput().GetNumberOfCells(), 0)  # open ones, faulty ones
        measures = vtk.vtkMassProperties()
        measures.SetInputData(found)
        self.assertAlmostEqual(measures.GetVolume() / report["volume_mm3"], 1, places=4)
        self.assertAlmostEqual(measures.GetSurfaceArea() / report["area_mm2"], 1, places=4)
        normals = vtk_to_numpy(found.GetPointData().GetNormals())
        self.assertLess(numpy.abs(numpy.linalg.norm(normals, axis=1) - 1).max(), 1e-3)

    def test_vtk_reads_both_sides_of_interfaces(self):
        self.octavo("surface", "l.8vo", "--interfaces", "-o", "i.vtp")
        _, triangles, found = self.polydata("i.vtp")
        sides = vtk_to_numpy(found.GetCellData().GetArray("inside_outside"))
        self.assertEqual(sides.shape, (len(triangles), 2))
        self.assertEqual({tuple(pair) for pair in sides.tolist()}, {(1, 0), (2, 0), (2, 1)})

    def test_trimesh_reads_glb_without_compression(self):
        self.surface("s.stl", "--max-deviation", "0")
        self.surface("s.glb", "--max-deviation", "0", "--plain")
        mesh = trimesh.load(self.folder / "s.glb", force="mesh", process=False)
        meters = numpy.asarray(mesh.vertices, float)
        points = 1000 * numpy.stack([meters[:, 0], -meters[:, 2], meters[:, 1]], axis=1)
        self.assert_near(sorted_triangles(points, mesh.faces, 3), self.expected(3))

    def test_trimesh_reads_3mf(self):
        self.surface("s.stl")
        report = self.surface("s.3mf")
        mesh = trimesh.load(self.folder / "s.3mf", force="mesh", process=False)
        self.assertEqual(len(mesh.faces), report["triangles"])
        self.assertTrue(mesh.is_watertight)
        self.assertTrue(mesh.is_winding_consistent)
        self.assertAlmostEqual(mesh.volume / report["volume_mm3"], 1, places=5)
        self.assertAlmostEqual(mesh.area / report["area_mm2"], 1, places=5)
        same = trimesh.load(self.folder / "s.stl", process=False)
        self.assertLess(numpy.abs(numpy.ptp(mesh.vertices, axis=0) -
                                  numpy.ptp(same.vertices, axis=0)).max(), 1e-3)
        self.octavo("surface", "l.8vo", "--parts", "-o", "parts.3mf")
        scene = trimesh.load(self.folder / "parts.3mf")
        self.assertEqual(len(scene.geometry), 2)
        for part in scene.geometry.values():
            self.assertTrue(part.is_watertight)


if __name__ == "__main__":
    engine_phantom.use(sys.argv.pop(1))
    unittest.main()
