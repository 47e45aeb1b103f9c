#!/usr/bin/env python3
"""Makes surfaces as a user does, and reads the files back.

usage: surface_test.py OCTAVO [unittest arguments]

Everything is generated.
"""

import collections
import json
import resource
import struct
import sys
import zipfile
from xml.etree import ElementTree

import cli_test

SIZE = (24, 20, 16)
SPACING = (0.5, 0.75, 2.0)
BODY = ((4, 12), (5, 15), (6, 10))
ALL = ["--max-deviation", "0"]  # triangles


def voxels(value):
    x, y, z = (range(*side) for side in BODY)
    return bytes(value if i in x and j in y and k in z else 0
                 for k in range(SIZE[2]) for j in range(SIZE[1]) for i in range(SIZE[0]))


def read_stl(path):
    """Corners of the triangles, and the header."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    records = (struct.unpack_from("<12f", data, 84 + 50 * i) for i in range(count))
    return [(r[3:6], r[6:9], r[9:12]) for r in records], data[:80].decode()


def read_obj(path):
    lines = [line.split() for line in path.read_text().splitlines()]
    points = [tuple(map(float, words[1:])) for words in lines if words[0] == "v"]
    return [tuple(points[int(n.split("/")[0]) - 1] for n in words[1:])
            for words in lines if words[0] == "f"]


def volume_of(triangles):
    return sum((a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6 for a, b, c in triangles)


def open_sides(triangles):
    sides = collections.Counter((t[k], t[(k + 1) % 3]) for t in triangles for k in range(3))
    return [side for side in sides if sides[side] != 1 or sides[side[::-1]] != 1]


class Surfaces(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.build("grey.8vo", 100, "--grey")
        self.build("mask.8vo", 1, "--labels")

    def build(self, name, value, *arguments):
        (self.folder / "v.raw").write_bytes(voxels(value))
        self.expect(0, "build", "v.raw", "--raw", ",".join(map(str, SIZE)) + ",uint8", "--spacing",
                    ",".join(map(str, SPACING)), "-o", name, "-q", "-f", *arguments)

    def json(self, *arguments):
        return json.loads(self.expect(0, *arguments, "--json", "--progress", "none").stdout)

    def test_cells_merge_within_what_is_proven(self):
        full = self.json("surface", "grey.8vo", "--isovalue", "50", "--max-deviation", "0", "-o",
                         "full.stl")
        report = self.json("surface", "grey.8vo", "--isovalue", "50", "--method", "octree", "-o",
                           "cells.stl")
        self.assertLess(3 * report["triangles"], full["triangles"])
        self.assertEqual(report["full_triangles"], full["triangles"])
        self.assertEqual((report["closed"], report["manifold"], report["self_intersections"]),
                         (True, True, 0))
        self.assertEqual(report["max_deviation_mm"], 0.25)
        self.assertEqual(open_sides(read_stl(self.folder / "cells.stl")[0]), [])
        for others in (("--triangles", "30"), ("--parts",), ("--max-deviation", "0")):
            self.expect(2, "surface", "mask.8vo", "--method", "octree", *others, "-o", "none.ply")
        self.assertFalse((self.folder / "none.ply").exists())
        # The usual method may be named where there is nothing to collapse.
        named = self.json("surface", "grey.8vo", "--isovalue", "50", "--max-deviation", "0",
                          "--method", "collapse", "-o", "named.stl")
        self.assertEqual(named["triangles"], full["triangles"])

    def test_as_few_triangles_as_asked_within_what_is_proven(self):
        for asked, most in (("30", 30), ("5%", None)):
            report = self.json("surface", "grey.8vo", "--isovalue", "50", "--triangles", asked,
                               "-f", "-o", "few.stl")
            most = most or report["full_triangles"] // 20
            self.assertLessEqual(report["triangles"], most)
            self.assertEqual(len(read_stl(self.folder / "few.stl")[0]), report["triangles"])
            self.assertEqual((report["closed"], report["manifold"], report["self_intersections"]),
                             (True, True, 0))
            self.assertGreater(report["max_deviation_mm"], 0)
        one = bytearray(5 * 6 * 7)
        one[107] = 1
        (self.folder / "one.raw").write_bytes(one)
        self.expect(0, "build", "one.raw", "--raw", "5,6,7,uint8", "--spacing", "1", "-o",
                    "one.8vo", "-qf")
        for asked in ("8", "1000"):
            report = self.json("surface", "one.8vo", "--isovalue", "0.5", "--triangles", asked,
                               "-f", "-o", "few.stl")
            self.assertEqual((report["triangles"], report["full_triangles"]), (8, 8))
            self.assertEqual(report["max_deviation_mm"], 0)
        (self.folder / "few.stl").unlink()
        for asked, words in (("3", "has 4 triangles or more; the limit is 3"), ("0", "1 or more"),
                             ("101%", "up to 100"), ("many", "--triangles")):
            told = self.expect(2, "surface", "grey.8vo", "--isovalue", "50", "--triangles", asked,
                               "-o", "few.stl").stderr
            self.assertIn(words, told)
        self.expect(2, "surface", "grey.8vo", "--isovalue", "50", "--triangles", "30",
                    "--max-deviation", "1", "-o", "few.stl")
        self.assertFalse((self.folder / "few.stl").exists())

    def test_files_hold_one_closed_body_outward(self):
        report = self.json("surface", "grey.8vo", "--isovalue", "50", *ALL, "-o", "m.stl")
        triangles, header = read_stl(self.folder / "m.stl")
        self.assertIn("SPACE=LPS", header)
        self.assertEqual(report["triangles"], len(triangles))
        self.assertEqual((report["closed"], report["manifold"], report["components"]),
                         (True, True, 1))
        self.assertEqual(open_sides(triangles), [])
        self.assertAlmostEqual(volume_of(triangles), report["volume_mm3"], delta=0.01)
        body = 8 * 10 * 4 * 0.5 * 0.75 * 2
        self.assertAlmostEqual(report["volume_mm3"], body, delta=0.1 * body)
        self.expect(0, "surface", "mask.8vo", *ALL, "-o", "m.obj", "-q")
        self.assertEqual(open_sides(read_obj(self.folder / "m.obj")), [])

    def test_a_seed_takes_its_piece_and_says_what_was_decoded(self):
        whole = self.json("surface", "mask.8vo", *ALL, "-o", "whole.stl")
        self.assertNotIn("decoded_bricks", whole)
        triangles, _ = read_stl(self.folder / "whole.stl")
        index = [place / spacing for place, spacing in zip(triangles[0][0], SPACING)]
        seed = ",".join(map(str, index))
        piece = self.json("surface", "mask.8vo", "--seed", seed, *ALL, "-o", "m.stl")
        self.assertEqual((piece["triangles"], piece["decoded_bricks"]), (len(triangles), 1))
        self.assertEqual(read_stl(self.folder / "m.stl")[0], triangles)
        text = self.expect(0, "surface", "mask.8vo", "--seed", seed, "-o", "n.stl").stdout
        self.assertIn("out of 1 brick\n", text)

    def test_fewer_triangles_within_a_deviation(self):
        self.expect(0, "surface", "mask.8vo", *ALL, "-o", "full.stl", "-q")
        light = self.json("surface", "mask.8vo", "-o", "m.stl")
        triangles, _ = read_stl(self.folder / "m.stl")
        self.assertEqual(open_sides(triangles), [])
        self.assertEqual(light["full_triangles"], len(read_stl(self.folder / "full.stl")[0]))
        self.assertLess(3 * light["triangles"], light["full_triangles"])
        self.assertEqual((light["max_deviation_mm"], light["self_intersections"]), (0.25, 0))
        self.expect(0, "surface", "mask.8vo", "--max-deviation", "0.5voxel", "-o", "h.stl", "-q")
        self.assertEqual(read_stl(self.folder / "h.stl")[0], triangles)
        text = self.expect(0, "surface", "mask.8vo", "--max-deviation", "0.1", "-o", "n.stl").stdout
        self.assertIn("proven within 0.1 mm", text)

    def test_ras_turns_x_and_y_round(self):
        self.expect(0, "surface", "mask.8vo", "-o", "l.stl", "-q")
        self.expect(0, "surface", "mask.8vo", "-o", "r.stl", "--space", "ras", "-q")
        lps, _ = read_stl(self.folder / "l.stl")
        ras, header = read_stl(self.folder / "r.stl")
        self.assertIn("SPACE=RAS", header)
        self.assertEqual([tuple((-x, -y, z) for x, y, z in t) for t in lps], ras)

    def test_ply_says_what_it_was_made_of(self):
        report = self.json("surface", "grey.8vo", "--isovalue", "50", "-o", "m.ply")
        header = (self.folder / "m.ply").read_bytes().split(b"end_header\n")[0].decode()
        self.assertIn(report["voxel_digest"], header)
        self.assertIn("element face %d\n" % report["triangles"], header)
        self.assertIn("property float nx\n", header)

    def test_the_report_stands_beside_the_surface_and_in_it(self):
        for ending in ("stl", "ply", "obj", "glb", "vtp", "3mf"):
            printed = self.json("surface", "grey.8vo", "--isovalue", "50", *ALL, "-o",
                                f"m.{ending}", "--report", "m.json", "-f")
            report = json.loads((self.folder / "m.json").read_text())
            self.assertEqual({key: printed[key] for key in report}, report)
            self.assertEqual(set(printed) - set(report),
                             {"output", "is_written", "file_bytes", "warnings"})
            self.assertEqual((report["isovalue"], report["level"], report["space"],
                              report["max_deviation_mm"], report["self_intersections"]),
                             (50, 0, "lps", 0, None))
            for axis in range(3):
                low, high = (report["bounds_mm"][end][axis] for end in (0, 1))
                for place, voxel in ((low, BODY[axis][0]), (high, BODY[axis][1])):
                    self.assertAlmostEqual(place, (voxel - 0.5) * SPACING[axis], delta=0.02)
            if ending != "stl":
                self.assertEqual(self.report_in(self.folder / f"m.{ending}"), report)

    def report_in(self, path):
        """The report that a mesh carries."""
        data = path.read_bytes()
        if path.suffix == ".glb":
            (size,) = struct.unpack_from("<I", data, 12)
            return json.loads(data[20:20 + size])["asset"]["extras"]["report"]
        if path.suffix == ".vtp":
            codes = data.split(b'Name="report"')[1].split(b">")[1].split(b"<")[0].split()
            return json.loads(bytes(int(code) for code in codes[:-1]))
        if path.suffix == ".3mf":
            root = ElementTree.fromstring(zipfile.ZipFile(path).read("3D/3dmodel.model"))
            texts = [element.text for element in root if element.get("name") == "Description"]
            return json.loads(texts[0].split("report ")[1])
        parts = data.split(b"report ")[1:]
        return json.loads(b"".join(part.split(b"\n")[0] for part in parts))

    def test_points_of_glb_have_16_bits_within_the_deviation(self):
        for words, number, extensions in [
                (ALL, 5126, ["KHR_mesh_quantization", "EXT_meshopt_compression"]),
                (["--max-deviation", "0.1"], 5123,
                 ["KHR_mesh_quantization", "EXT_meshopt_compression"]),
                (["--max-deviation", "1e-6"], 5126,
                 ["KHR_mesh_quantization", "EXT_meshopt_compression"]),
                (["--max-deviation", "0.1", "--plain"], 5126, None)]:
            report = self.json("surface", "mask.8vo", "-o", "m.glb", "-f", *words)
            self.assertEqual(report["max_deviation_mm"], float(words[1]))
            data = (self.folder / "m.glb").read_bytes()
            (size,) = struct.unpack_from("<I", data, 12)
            file = json.loads(data[20:20 + size])
            (primitive,) = file["meshes"][0]["primitives"]
            positions = file["accessors"][primitive["attributes"]["POSITION"]]
            self.assertEqual(positions["componentType"], number)
            self.assertEqual(positions["count"], report["points"])
            self.assertEqual(file["accessors"][primitive["indices"]]["count"],
                             3 * report["triangles"])
            self.assertEqual(file.get("extensionsRequired"), extensions)

    def test_the_object_has_the_name_and_the_color_of_its_label(self):
        name = "left 'lung' <&\u00e4>"
        (self.folder / "names.txt").write_text(f"7 {name}\n", encoding="utf-8")
        self.build("named.8vo", 7, "--labels", "--label-names", "names.txt")
        for ending in ("glb", "3mf", "obj", "ply", "vtp"):
            self.expect(0, "surface", "named.8vo", "--label", name, "-o", f"m.{ending}", "-q")
        data = (self.folder / "m.glb").read_bytes()
        (size,) = struct.unpack_from("<I", data, 12)
        node = json.loads(data[20:20 + size])["nodes"][1]
        self.assertEqual((node["name"], node["extras"]["label"]), (name, 7))
        root = ElementTree.fromstring(
            zipfile.ZipFile(self.folder / "m.3mf").read("3D/3dmodel.model"))
        (printed,) = [element for element in root.iter() if element.tag.endswith("}object")]
        self.assertEqual(printed.get("name"), name)
        self.assertIn("\ng " + name.replace(" ", "_") + "\n",
                      (self.folder / "m.obj").read_text(encoding="utf-8"))
        self.assertIn(f"\ncomment label 7 {name}\n".encode(),
                      (self.folder / "m.ply").read_bytes())
        codes = " ".join(map(str, name.encode())) + " 0"
        self.assertIn(codes.encode(), (self.folder / "m.vtp").read_bytes())

    def test_mirrored_grids_have_triangles_outward(self):
        (self.folder / "v.raw").write_bytes(voxels(1))
        for last, space in ((1, "lps"), (-1, "lps"), (-1, "ras")):
            (self.folder / "v.mhd").write_text(
                "ObjectType = Image\nNDims = 3\nDimSize = %d %d %d\n" % SIZE
                + "ElementType = MET_UCHAR\nElementSpacing = %g %g %g\n" % SPACING
                + f"TransformMatrix = 1 0 0 0 1 0 0 0 {last}\nOffset = 30 20 10\n"
                + "ElementDataFile = v.raw\n")
            self.expect(0, "build", "v.mhd", "--labels", "-o", "v.8vo", "-qf")
            report = self.json("surface", "v.8vo", *ALL, "-o", "m.stl", "--space", space, "-f")
            triangles, _ = read_stl(self.folder / "m.stl")
            self.assertGreater(report["volume_mm3"], 200)
            self.assertAlmostEqual(volume_of(triangles), report["volume_mm3"], delta=0.1)

    def test_what_floats_cannot_tell_apart_is_not_written(self):
        (self.folder / "v.raw").write_bytes(voxels(1))
        (self.folder / "v.mhd").write_text(
            "ObjectType = Image\nNDims = 3\nDimSize = %d %d %d\n" % SIZE
            + "ElementType = MET_UCHAR\nElementSpacing = 1 1 1\nOffset = 1e11 0 0\n"
            + "ElementDataFile = v.raw\n")
        self.expect(0, "build", "v.mhd", "--labels", "-o", "v.8vo", "-qf")
        before = sorted(path.name for path in self.folder.iterdir())
        for ending in ("stl", "ply", "obj", "glb", "vtp", "3mf"):
            output = self.expect(1, "surface", "v.8vo", "-o", f"m.{ending}", "--report",
                                 "m.json").stdout
            self.assertRegex(output, "not written, the surface has .* [1-9][0-9]* points at one")
            self.assertIn("a volume whose origin is nearer to 0 helps\n", output)
            self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)
            self.expect(0, "surface", "v.8vo", "-o", f"n.{ending}", "--allow-open", "-q")
            (self.folder / f"n.{ending}").unlink()

    def test_a_disk_that_is_full_in_the_middle_leaves_what_was_there(self):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))

        for ending in ("stl", "ply", "obj", "glb", "vtp", "3mf"):
            words = ["surface", "mask.8vo", *ALL, "-o", f"m.{ending}", "--report", "m.json"]
            before = sorted(path.name for path in self.folder.iterdir())
            failure = self.expect(5, *words, preexec_fn=limit)
            self.assertIn("File too large", failure.stderr)
            self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)
            self.expect(0, *words, "-q")
            kept = {path.name: path.read_bytes() for path in self.folder.iterdir()}
            self.assertGreater(len(kept[f"m.{ending}"]), 3000)
            self.expect(5, *words, "-f", preexec_fn=limit)
            self.assertEqual({path.name: path.read_bytes() for path in self.folder.iterdir()},
                             kept)
            (self.folder / "m.json").unlink()

    def test_a_report_is_written_with_its_surface_or_not_at_all(self):
        self.expect(0, "surface", "mask.8vo", "-o", "m.stl", "--report", "m.json", "-q")
        before = {path.name: path.read_bytes() for path in self.folder.iterdir()}
        for code, words, expected in [
                (5, ["--report", "m.json"], "exists"),
                (2, ["--report", "./n.stl"], "is the surface itself"),
                (2, ["--report", "mask.8vo", "-f"], "is the input"),
                (5, ["--report", "missing/n.json"], "missing")]:
            failure = self.expect(code, "surface", "mask.8vo", "-o", "n.stl", *words)
            self.assertIn(expected, failure.stderr)
            self.assertEqual({path.name: path.read_bytes() for path in self.folder.iterdir()},
                             before)
        self.expect(0, "surface", "mask.8vo", "--space", "ras", "-o", "m.stl", "--report", "m.json",
                    "-qf")
        self.assertEqual(json.loads((self.folder / "m.json").read_text())["space"], "ras")

    def test_bad_input_is_one_sentence_and_no_file(self):
        before = sorted(path.name for path in self.folder.iterdir())
        for code, words, expected in [
                (2, ["grey.8vo", "-o", "m.stl"], "give --isovalue VALUE"),
                (2, ["grey.8vo", "--isovalue", "500", "-o", "m.stl"], "no voxel has 500 or more"),
                (2, ["grey.8vo", "--isovalue", "nan", "-o", "m.stl"], "isovalue"),
                (2, ["mask.8vo", "--isovalue", "1", "-o", "m.stl"], "leave out --isovalue"),
                (2, ["mask.8vo", "--stored", "-o", "m.stl"], "leave out --stored"),
                (2, ["grey.8vo", "--label", "1", "-o", "m.stl"], "octavo threshold"),
                (2, ["mask.8vo", "--label", "9", "-o", "m.stl"], "has no surface"),
                (2, ["mask.8vo", "--label", "1", "--label", "9", "-o", "m.stl"],
                 "no voxel of level 0 has label 9"),
                (2, ["mask.8vo", "--seed", "20,2,2", "-o", "m.stl"], "give another --seed"),
                (2, ["mask.8vo", "--seed", "90,2,2", "-o", "m.stl"], "outside"),
                (2, ["mask.8vo", "--level", "30", "-o", "m.stl"], "level 30"),
                (2, ["mask.8vo", "--max-deviation", "wide", "-o", "m.stl"], "--max-deviation"),
                (2, ["mask.8vo", "--max-deviation", "-1", "-o", "m.stl"], "0 or more"),
                (2, ["mask.8vo", "-o", "m.off"], ".stl, .ply, .obj, .glb, .vtp or .3mf"),
                (2, ["mask.8vo", "-o", "m.glb", "--space", "ras"], "leave out --space"),
                (2, ["mask.8vo", "-o", "m.stl", "--plain"], "leave out --plain"),
                (5, ["mask.8vo", "-o", "missing/m.stl"], "missing"),
                (5, ["gone.8vo", "-o", "m.stl"], "gone.8vo")]:
            with self.subTest(words=words):
                failure = self.expect(code, "surface", *words)
                self.assertIn(expected, failure.stderr)
                self.assertEqual(len(failure.stderr.strip().splitlines()), 1)
                self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
