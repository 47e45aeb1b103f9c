#!/usr/bin/env python3
"""Has printers' programs read surfaces: trimesh, lib3mf, ADMesh and PrusaSlicer.

usage: printing_test.py OCTAVO [unittest arguments]

Each must find what the report says: closed, manifold, as many triangles, the same volume.
"""

import re
import subprocess
import sys
import unittest

import lib3mf
import trimesh

import engine_phantom


class Printing(engine_phantom.OfPhantom):
    def run_here(self, *command):
        return subprocess.run(command, cwd=self.folder, check=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True).stdout

    def test_trimesh_finds_them_closed(self):
        for ending in ("stl", "ply", "obj"):
            with self.subTest(ending):
                report = self.surface(f"s.{ending}")
                mesh = trimesh.load(self.folder / f"s.{ending}")
                self.assertEqual(len(mesh.faces), report["triangles"])
                self.assertTrue(mesh.is_watertight)
                self.assertTrue(mesh.is_winding_consistent)
                self.assertAlmostEqual(mesh.volume / report["volume_mm3"], 1, places=5)

    def test_lib3mf_finds_objects_manifold_in_millimeters(self):
        self.surface("s.3mf")
        self.octavo("surface", "l.8vo", "--parts", "-o", "parts.3mf")
        for name, count in (("s.3mf", 1), ("parts.3mf", 2)):
            with self.subTest(name):
                model = lib3mf.get_wrapper().CreateModel()
                reader = model.QueryReader("3mf")
                reader.SetStrictModeActive(True)
                reader.ReadFromFile(str(self.folder / name))
                self.assertEqual(reader.GetWarningCount(), 0)
                self.assertEqual(model.GetUnit(), lib3mf.ModelUnit.MilliMeter)
                meshes = model.GetMeshObjects()
                self.assertEqual(meshes.Count(), count)
                while meshes.MoveNext():
                    mesh = meshes.GetCurrentMeshObject()
                    self.assertTrue(mesh.IsManifoldAndOriented(), mesh.GetName())
                    self.assertGreater(mesh.GetTriangleCount(), 100)

    def test_admesh_has_nothing_to_repair(self):
        report = self.surface("s.stl")
        told = self.run_here("admesh", "s.stl")
        counts = {name.strip(): [float(value) for value in values.split()]
                  for name, values in re.findall(r"^([A-Z][\w ]+?) *: +([\d. ]+?)(?: {5,}|$)",
                                                 told, re.MULTILINE)}
        facets = re.search(r"Number of facets +: +(\d+) +(\d+)", told)
        self.assertEqual(facets.groups(), 2 * (str(report["triangles"]),), told)
        for repair in ("Degenerate facets", "Edges fixed", "Facets removed", "Facets added",
                       "Facets reversed", "Backwards edges", "Normals fixed"):
            self.assertEqual(counts[repair], [0], told)
        self.assertRegex(told, r"Total disconnected facets +: +0 +0")

    def test_prusa_slicer_slices_them(self):
        for name in ("s.stl", "s.3mf"):
            with self.subTest(name):
                self.surface(name)
                told = self.run_here("prusa-slicer", "--export-gcode", "--output", "s.gcode", name)
                self.assertNotRegex(told, "(?i)repair|manifold|open edge")
                moves = [line for line in (self.folder / "s.gcode").read_text().splitlines()
                         if line.startswith("G1 ")]
                self.assertGreater(len(moves), 1000)
                (self.folder / "s.gcode").unlink()


if __name__ == "__main__":
    engine_phantom.use(sys.argv.pop(1))
    unittest.main()
