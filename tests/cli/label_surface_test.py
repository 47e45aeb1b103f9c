#!/usr/bin/env python3
"""Makes surfaces of labels as a user does, and reads the files back.

usage: label_surface_test.py OCTAVO [unittest arguments]

Everything is generated: four organs side by side, one of which touches itself at an edge, and a
grain that has no name.
"""

import collections
import json
import struct
import sys

import cli_test

SIZE = (20, 16, 12)
SPACING = (0.5, 0.75, 2.0)
ALL = ["--max-deviation", "0"]  # triangles
NAMES = "1 Liver\n2 left/kidney\n3 left kidney\n4 Liver\n"


def label_at(x, y, z):
    if (x, y, z) == (18, 14, 10):
        return 9
    if not (2 <= x < 16 and 2 <= y < 14 and 1 <= z < 9):
        return 0
    if (x < 5) == (y < 6) and x < 8 and y < 10:
        return 3
    return 1 if x < 8 else 2 if 3 * y < 2 * z + 2 * x else 4


def sides_of(triangles):
    return collections.Counter((t[k], t[(k + 1) % 3]) for t in triangles for k in range(3))


def volume_of(triangles):
    return sum((a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6 for a, b, c in triangles)


def read_stl(path):
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    records = (struct.unpack_from("<12f", data, 84 + 50 * i) for i in range(count))
    return [(r[3:6], r[6:9], r[9:12]) for r in records]


def read_obj(path):
    """Points, and of each group its triangles."""
    points, groups, group = [], {}, None
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append(tuple(map(float, words[1:])))
        elif words[:1] in (["g"], ["o"]):
            group = " ".join(words[1:])
        elif words[:1] == ["f"]:
            corners = tuple(int(word.split("/")[0]) - 1 for word in words[1:])
            groups.setdefault(group, []).append(corners)
    return points, groups


class LabelSurfaces(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.voxels = bytes(label_at(x, y, z) for z in range(SIZE[2]) for y in range(SIZE[1])
                            for x in range(SIZE[0]))
        (self.folder / "v.raw").write_bytes(self.voxels)
        (self.folder / "names.txt").write_text(NAMES)
        self.expect(0, "build", "v.raw", "--raw", ",".join(map(str, SIZE)) + ",uint8", "--spacing",
                    ",".join(map(str, SPACING)), "--labels", "--label-names", "names.txt", "-o",
                    "l.8vo", "-q")

    def json(self, *arguments):
        return json.loads(self.expect(0, *arguments, "--json", "--progress", "none").stdout)

    def volume_in_voxels(self, label):
        return self.voxels.count(label) * SPACING[0] * SPACING[1] * SPACING[2]

    def test_a_folder_holds_a_part_for_each_label(self):
        report = self.json("surface", "l.8vo", "--parts", *ALL, "-o", "organs")
        names = {1: "Liver_1", 2: "left_kidney_2", 3: "left_kidney_3", 4: "Liver_4", 9: "label_9"}
        self.assertEqual({row["label"]: row["output"] for row in report["labels"]},
                         {label: f"organs/{name}.stl" for label, name in names.items()})
        self.assertEqual(sorted(path.name for path in (self.folder / "organs").iterdir()),
                         sorted(f"{name}.stl" for name in names.values()))
        inner, outer = collections.Counter(), 0
        for row in report["labels"]:
            triangles = read_stl(self.folder / row["output"])
            self.assertEqual(len(triangles), row["triangles"])
            sides = sides_of(triangles)
            self.assertEqual(set(sides.values()), {1})
            self.assertTrue(all(s[::-1] in sides for s in sides))
            self.assertTrue(row["closed"] and row["manifold"])
            self.assertAlmostEqual(volume_of(triangles), row["volume_mm3"], delta=0.001)
            self.assertAlmostEqual(volume_of(triangles) / self.volume_in_voxels(row["label"]),
                                   1 + row["volume_change"], delta=0.001)
            self.assertLessEqual(abs(row["volume_change"]), 0.01)
            inner.update(frozenset(t) for t in triangles)
        # Neighbors have the same triangles.
        self.assertEqual(set(inner.values()), {1, 2})
        self.assertGreater(sum(1 for count in inner.values() if count == 2), 100)
        self.assertGreater(max(row["longest_move_mm"] for row in report["labels"]), 0.1)

    def test_as_few_triangles_between_labels_as_asked(self):
        full = self.json("surface", "l.8vo", "--parts", "--max-deviation", "0", "-o",
                         "full.ply")
        report = self.json("surface", "l.8vo", "--parts", "--triangles", "60%", "-o", "few.ply")
        self.assertEqual(report["full_interface_triangles"], full["interface_triangles"])
        self.assertLessEqual(report["interface_triangles"], 0.6 * full["interface_triangles"])
        self.assertGreater(report["max_deviation_mm"], 0)
        self.assertTrue(report["closed_manifold"])
        told = self.expect(2, "surface", "l.8vo", "--parts", "--triangles", "20", "-o", "none.ply")
        self.assertIn("the fewest that were reached", told.stderr)
        self.assertFalse((self.folder / "none.ply").exists())

    def test_a_label_that_touches_itself_is_manifold_by_its_places(self):
        report = self.json("surface", "l.8vo", "--parts", "--label", "3", "--smooth", "off", *ALL,
                           "-o", "one.obj")
        (row,) = report["labels"]
        self.assertGreater(row["touching_points"], 0)
        self.assertEqual(row["coincident_points"], 0)
        self.assertEqual(row["components"], 2)
        self.assertEqual(row["longest_move_mm"], 0)
        # Points that are moved apart take less than a hundredth of a voxel with them.
        self.assertAlmostEqual(row["volume_mm3"], self.volume_in_voxels(3),
                               delta=0.01 * row["touching_points"])
        _, groups = read_obj(self.folder / "one.obj")
        ((_, triangles),) = groups.items()
        sides = sides_of(triangles)
        self.assertEqual(set(sides.values()), {1})
        self.assertTrue(all(s[::-1] in sides for s in sides))
        text = self.expect(0, "surface", "l.8vo", "--parts", "-o", "p.ply", "--progress",
                           "none").stdout
        self.assertIn("2 of 5 labels touch themselves", text)
        self.assertIn("left/kidney", text)

    def test_one_file_holds_what_lies_between_labels(self):
        report = self.json("surface", "l.8vo", "--interfaces", "-o", "all.obj", "--space", "ras")
        points, groups = read_obj(self.folder / "all.obj")
        self.assertEqual(sum(map(len, groups.values())), report["triangles"])
        self.assertEqual(len(groups), report["pairs"])
        self.assertEqual(len(points), report["points"])
        # Each triangle once, so that sides of three are there where three labels meet.
        triangles = [t for group in groups.values() for t in group]
        self.assertEqual(len({frozenset(t) for t in triangles}), len(triangles))
        sides = collections.Counter(frozenset(s) for s in sides_of(triangles).elements())
        self.assertLessEqual({2, 3}, set(sides.values()))
        some = self.json("surface", "l.8vo", "--interfaces", "--label", "2", "-o", "some.ply")
        self.assertLess(some["triangles"], report["triangles"])
        header = (self.folder / "some.ply").read_bytes().split(b"end_header\n")[0].decode()
        self.assertIn("element face %d\n" % some["triangles"], header)

    def test_fewer_triangles_fit_as_well(self):
        full = self.json("surface", "l.8vo", "--parts", *ALL, "-o", "full")
        light = self.json("surface", "l.8vo", "--parts", "-o", "light")
        self.assertEqual(light["full_interface_triangles"], full["interface_triangles"])
        self.assertLess(light["interface_triangles"], 0.9 * full["interface_triangles"])
        self.assertEqual((light["max_deviation_mm"], light["self_intersections"]), (0.25, 0))
        corners = collections.Counter()
        for row in light["labels"]:
            self.assertTrue(row["closed"] and row["manifold"])
            corners.update(frozenset(t) for t in read_stl(self.folder / row["output"]))
        self.assertEqual(set(corners.values()), {1, 2})

    def test_parts_go_into_one_file_as_objects(self):
        for name in ("a.3mf", "a.glb", "a.vtp", "a.ply"):
            report = self.json("surface", "l.8vo", "--parts", "-o", name)
            self.assertEqual(report["file_bytes"], (self.folder / name).stat().st_size)
        self.assertEqual(len(report["labels"]), 5)
        report = self.json("surface", "l.8vo", "--parts", "-o", "a.obj")
        _, groups = read_obj(self.folder / "a.obj")
        self.assertEqual({name: len(faces) for name, faces in groups.items()},
                         {name: row["triangles"] for name, row in
                          zip(("Liver_1", "left/kidney", "left_kidney", "Liver_4", "9"),
                              report["labels"])})

    def test_what_is_there_is_replaced_only_when_forced(self):
        self.expect(0, "surface", "l.8vo", "--parts", "-o", "organs", "-q")
        before = (self.folder / "organs/Liver_1.stl").read_bytes()
        failure = self.expect(5, "surface", "l.8vo", "--parts", "--smooth", "off", "-o", "organs")
        self.assertIn("exists already", failure.stderr)
        self.assertEqual((self.folder / "organs/Liver_1.stl").read_bytes(), before)
        self.expect(0, "surface", "l.8vo", "--parts", "--smooth", "off", "-o", "organs", "-q", "-f")
        self.assertNotEqual((self.folder / "organs/Liver_1.stl").read_bytes(), before)

    def test_parts_whose_points_cannot_be_told_apart_are_not_written(self):
        # Two cubes of one label touch at an edge, far from 0.
        size = (8, 8, 6)
        inside = {(x, y, z) for z in range(2, 4) for y in range(1, 4) for x in range(1, 4)}
        inside |= {(x + 3, y + 3, z) for x, y, z in inside}
        (self.folder / "edge.raw").write_bytes(bytes(
            (x, y, z) in inside for z in range(size[2]) for y in range(size[1])
            for x in range(size[0])))
        (self.folder / "edge.mhd").write_text(
            "ObjectType = Image\nNDims = 3\nDimSize = 8 8 6\nElementType = MET_UCHAR\n"
            "ElementSpacing = 0.01 0.01 0.01\nOffset = 1000 1000 1000\n"
            "ElementDataFile = edge.raw\n")
        self.expect(0, "build", "edge.mhd", "--labels", "-o", "edge.8vo", "-q")
        failure = self.expect(1, "surface", "edge.8vo", "--parts", "-o", "edges", "--smooth", "off",
                              *ALL)
        self.assertRegex(failure.stdout + failure.stderr, r"[1-9]\d* points at one place")
        self.assertFalse((self.folder / "edges").exists())

    def test_no_part_replaces_the_volume_that_it_is_of(self):
        (self.folder / "organs").mkdir()
        held = (self.folder / "l.8vo").read_bytes()
        for name, labels in (("organs/Liver_1.stl", []), ("organs/Liver.stl", ["--label", "1"])):
            (self.folder / name).write_bytes(held)
            failure = self.expect(2, "surface", name, "--parts", "-o", "organs", "-f", *labels)
            self.assertIn("is the input itself", failure.stderr)
            self.assertEqual((self.folder / name).read_bytes(), held)

    def test_bad_input_is_one_sentence_and_no_file(self):
        self.expect(0, "build", "v.raw", "--raw", ",".join(map(str, SIZE)) + ",uint8", "--spacing",
                    "1", "--grey", "-o", "grey.8vo", "-q")
        before = sorted(path.name for path in self.folder.iterdir())
        for code, words, expected in [
                (2, ["grey.8vo", "--parts", "-o", "organs"], "octavo threshold"),
                (2, ["l.8vo", "--parts", "-o", "a.stl"], "name a folder"),
                (2, ["l.8vo", "--interfaces", "-o", "a.stl"], ".ply, .obj or .vtp"),
                (2, ["l.8vo", "--interfaces", "-o", "organs"], ".ply, .obj or .vtp"),
                (2, ["l.8vo", "--parts", "--label", "7", "-o", "organs"], "no voxel"),
                (2, ["l.8vo", "--parts", "--label", "spleen", "-o", "organs"], "spleen"),
                (2, ["l.8vo", "--parts", "--smooth", "-1", "-o", "organs"], "--smooth"),
                (2, ["l.8vo", "--parts", "--smooth", "much", "-o", "organs"], "--smooth"),
                (2, ["l.8vo", "--smooth", "4", "-o", "a.stl"], "give --parts"),
                (2, ["l.8vo", "--part-format", "ply", "-o", "a.stl"], "give --parts"),
                (2, ["l.8vo", "--parts", "--part-format", "ply", "-o", "a.obj"], "folder"),
                (2, ["l.8vo", "--parts", "--seed", "1,1,1", "-o", "organs"], "--seed"),
                (2, ["l.8vo", "--parts", "--isovalue", "1", "-o", "organs"], "--isovalue"),
                (2, ["l.8vo", "--parts", "--level", "30", "-o", "organs"], "level 30"),
                (5, ["l.8vo", "--parts", "-o", "names.txt"], "not a folder"),
                (5, ["l.8vo", "--parts", "-o", "missing/deep/organs"],
                 "its folder does not exist; make it first")]:
            with self.subTest(words=words):
                failure = self.expect(code, "surface", *words)
                self.assertIn(expected, failure.stderr)
                self.assertEqual(len(failure.stderr.strip().splitlines()), 1)
                self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
