#!/usr/bin/env python3
"""Asks of masks what touches, fills their holes and grows and shrinks them, as a user does.

usage: morph_test.py OCTAVO [unittest arguments]

Everything is generated; what is expected comes from a walk over every voxel.
"""

import itertools
import json
import sys

import cli_test

SIZE = (70, 40, 66)
SPACING = (0.5, 0.75, 2.0)


def indices():
    return itertools.product(range(SIZE[2]), range(SIZE[1]), range(SIZE[0]))


class Boxes(dict):
    """Labels by (z, y, x); what is not in it is 0."""

    def fill(self, x, y, z, label=1):
        for p in itertools.product(range(*z), range(*y), range(*x)):
            self[p] = label
        return self

    def raw(self):
        return bytes(self.get(p, 0) for p in indices())


class Masks(cli_test.InFolder):
    def build(self, name, boxes, *arguments):
        size = ",".join(map(str, SIZE))
        spacing = ",".join(map(str, SPACING))
        (self.folder / "v.raw").write_bytes(boxes.raw())
        self.expect(0, "build", "v.raw", "--raw", f"{size},uint8", "--spacing", spacing, "--labels",
                    "-o", name, "-q", "-f", *arguments)

    def json(self, *arguments):
        return json.loads(self.expect(0, *arguments, "--json", "--progress", "none").stdout)

    def voxels_of(self, name):
        self.expect(0, "export", name, "-o", "out.raw", "-f", "-q")
        return (self.folder / "out.raw").read_bytes()


class Touch(Masks):
    def test_objects_overlap_touch_or_lie_apart(self):
        self.build("a.8vo", Boxes().fill((4, 24), (4, 24), (4, 24)))
        self.build("b.8vo", Boxes().fill((24, 60), (8, 12), (8, 10)))
        self.build("c.8vo", Boxes().fill((20, 60), (8, 12), (8, 10)))
        self.build("d.8vo", Boxes().fill((24, 30), (24, 30), (8, 9)))
        touching = self.json("touch", "a.8vo", "b.8vo")
        self.assertEqual(touching["relation"], "touch")
        self.assertEqual(touching["overlap"],
                         {"voxels": 0, "mm3": 0, "box": None, "box_mm": None})
        self.assertEqual(touching["faces"], 8)
        self.assertAlmostEqual(touching["area_mm2"], 8 * 0.75 * 2)
        self.assertEqual(touching["contact_a"]["box"], [[23, 24], [8, 12], [8, 10]])
        self.assertEqual(touching["contact_b"]["box"], [[24, 25], [8, 12], [8, 10]])
        in_mm = [[11.75, 12.25], [5.625, 8.625], [15, 19]]
        self.assertEqual(touching["contact_b"]["box_mm"], in_mm)
        overlapping = self.json("touch", "a.8vo", "c.8vo")
        self.assertEqual(overlapping["relation"], "overlap")
        self.assertEqual(overlapping["overlap"]["voxels"], 4 * 4 * 2)
        self.assertEqual(overlapping["overlap"]["mm3"], 4 * 4 * 2 * 0.75)
        self.assertEqual(overlapping["overlap"]["box"], [[20, 24], [8, 12], [8, 10]])
        self.assertEqual(overlapping["contact_a"]["voxels"], 0)
        self.assertEqual(self.json("touch", "a.8vo", "d.8vo")["relation"], "apart")
        by_edges = self.json("touch", "a.8vo", "d.8vo", "--connectivity", "18")
        self.assertEqual((by_edges["relation"], by_edges["faces"]), ("touch", 0))
        self.assertEqual(by_edges["contact_b"]["box"], [[24, 25], [24, 25], [8, 9]])
        self.assertIn("do not touch", self.expect(0, "touch", "a.8vo", "d.8vo").stdout)
        text = self.expect(0, "touch", "a.8vo", "b.8vo").stdout
        self.assertIn("8 faces, 12 mm2", text)
        self.assertIn("box 23:24,8:12,8:10", text)

    def test_labels_that_touch_are_listed_in_pairs(self):
        labels = Boxes().fill((4, 24), (4, 24), (4, 24), 3).fill((24, 60), (8, 12), (8, 10), 7)
        labels.fill((60, 66), (12, 14), (8, 10), 200)
        self.build("l.8vo", labels)
        pairs = self.json("touch", "l.8vo")["pairs"]
        self.assertEqual(pairs, [{"labels": [3, 7], "names": [None, None], "faces": 8,
                                  "area_mm2": 12, "voxel_pairs": 8}])
        pairs = self.json("touch", "l.8vo", "--connectivity", "18")["pairs"]
        self.assertEqual([p["labels"] for p in pairs], [[3, 7], [7, 200]])
        self.assertEqual((pairs[1]["faces"], pairs[1]["voxel_pairs"]), (0, 2))
        text = self.expect(0, "touch", "l.8vo", "--connectivity", "26").stdout
        self.assertEqual(len(text.splitlines()), 4)
        self.assertIn("2 pairs of labels touch", text)

    def test_errors_name_the_reason(self):
        self.build("a.8vo", Boxes().fill((4, 24), (4, 24), (4, 24)))
        (self.folder / "s.raw").write_bytes(bytes(8))
        for kind in ["--labels", "--grey"]:
            self.expect(0, "build", "s.raw", "--raw", "2,2,2,uint8", "--spacing", "1", kind, "-o",
                        f"s{kind[2]}.8vo", "-q")
        for words, arguments in [
            (["sg.8vo", "octavo threshold"], ["touch", "sg.8vo"]),
            (["sg.8vo", "octavo threshold"], ["touch", "a.8vo", "sg.8vo"]),
            (["sl.8vo", "2 x 2 x 2", "70 x 40 x 66"], ["touch", "a.8vo", "sl.8vo"]),
            (["--connectivity"], ["touch", "a.8vo", "--connectivity", "7"]),
        ]:
            self.expect_error(2, words, *arguments)


class FillHoles(Masks):
    def setUp(self):
        super().setUp()
        # A hollow box with a slit along an edge of its wall, a solid one with two closed pores.
        self.boxes = Boxes().fill((2, 12), (2, 12), (2, 12)).fill((30, 60), (10, 30), (10, 30))
        self.boxes.fill((3, 11), (3, 11), (3, 11), 0).fill((2, 3), (2, 3), (3, 11), 0)
        self.boxes.fill((40, 42), (20, 21), (15, 17), 0).fill((50, 51), (20, 21), (15, 16), 0)
        self.build("m.8vo", self.boxes)

    def filled(self, *boxes):
        voxels = Boxes(self.boxes)
        for box in boxes:
            voxels.fill(*box)
        return voxels.raw()

    def test_what_does_not_reach_the_border_is_filled(self):
        hollow = ((3, 11), (3, 11), (3, 11))
        large, small = ((40, 42), (20, 21), (15, 17)), ((50, 51), (20, 21), (15, 16))
        for arguments, holes, boxes in [
            ([], 3, [hollow, large, small]),
            (["--connectivity", "18"], 3, [hollow, large, small]),
            (["--connectivity", "6"], 2, [large, small]),
            (["--max-mm3", "0.75"], 1, [small]),
            (["--max-mm3", "3"], 2, [large, small]),
            (["--max-mm3", "0.7"], 0, []),
        ]:
            made = self.json("fill-holes", "m.8vo", *arguments, "-o", "f.8vo", "-f")
            expected = self.filled(*boxes)
            self.assertEqual(made["holes"], holes, arguments)
            self.assertEqual(made["voxels"], sum(expected))
            self.assertEqual(made["hole_voxels"], sum(expected) - sum(self.boxes.raw()))
            self.assertEqual(self.voxels_of("f.8vo"), expected, arguments)
        made_by = self.info("f.8vo")["metadata"]["made_by"]
        self.assertEqual(made_by, {"operation": "fill-holes", "connectivity": 26, "max_mm3": 0.7})
        text = self.expect(0, "fill-holes", "m.8vo", "--max-mm3", "3", "-o", "t.8vo").stdout
        self.assertIn("2 holes filled (5 voxels, 3.75 mm3); 1 larger left", text)

    def test_errors_name_the_reason(self):
        for words, arguments in [(["octavo threshold"], ["g.8vo", "-o", "x.8vo"]),
                                 (["--output"], ["m.8vo"]),
                                 (["--max-mm3"], ["m.8vo", "-o", "x.8vo", "--max-mm3", "-1"]),
                                 (["--max-mm3"], ["m.8vo", "-o", "x.8vo", "--max-mm3", "nan"])]:
            if "g.8vo" in arguments:
                (self.folder / "s.raw").write_bytes(bytes(8))
                self.expect(0, "build", "s.raw", "--raw", "2,2,2,uint8", "--grey", "-o", "g.8vo",
                            "--spacing", "1", "-q")
            self.expect_error(2, words, "fill-holes", *arguments)
            self.assertFalse((self.folder / "x.8vo").exists())


class Morphology(Masks):
    def setUp(self):
        super().setUp()
        # Across the borders of cubes of 64^3, and cut off by the border of the volume.
        self.boxes = Boxes().fill((56, 70), (0, 9), (58, 66)).fill((20, 40), (20, 24), (10, 11))
        self.boxes.fill((30, 31), (24, 30), (10, 11)).fill((5, 6), (5, 6), (63, 64))
        self.build("m.8vo", self.boxes)

    def grown(self, voxels, steps):
        """The voxels of the volume that are a step away from one of `voxels`."""
        sums = ((z + dz, y + dy, x + dx) for (z, y, x) in voxels for dz, dy, dx in steps)
        ends = tuple(reversed(SIZE))
        return {p for p in sums if all(0 <= at < end for at, end in zip(p, ends))}

    def shrunk(self, voxels, steps):
        """Those that the background is no step away from; its voxels beside them are enough."""
        faces = [(0, 0, 1), (0, 0, -1), (0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0)]
        return voxels - self.grown(self.grown(voxels, faces) - voxels, steps)

    def expect_morphology(self, arguments, steps):
        before = {p for p, label in self.boxes.items() if label}
        grown = self.grown(before, steps)
        shrunk = self.shrunk(before, steps)
        for verb, expected in [("dilate", grown), ("erode", shrunk),
                               ("open", self.grown(shrunk, steps)),
                               ("close", self.shrunk(grown, steps))]:
            made = self.json(verb, "m.8vo", *arguments, "-o", "r.8vo", "-f")
            self.assertEqual(made["voxels"], len(expected), (verb, arguments))
            self.assertEqual(made["voxels_before"], len(before))
            voxels = self.voxels_of("r.8vo")
            self.assertEqual({p for p, v in zip(indices(), voxels) if v}, expected, verb)
            self.assertEqual(self.info("r.8vo")["metadata"]["made_by"]["operation"], verb)

    def test_balls_are_measured_in_mm(self):
        span = range(-3, 4)
        steps = [s for s in itertools.product(span, span, span)
                 if sum((n * mm) ** 2 for n, mm in zip(s, reversed(SPACING))) <= 1.5**2]
        self.expect_morphology(["--mm", "1.5"], steps)

    def test_steps_go_from_voxel_to_neighbor(self):
        span = range(-2, 3)
        cube = list(itertools.product(span, span, span))
        diamond = [s for s in cube if sum(map(abs, s)) <= 2]
        self.expect_morphology(["--voxels", "2"], diamond)
        self.expect_morphology(["--voxels", "2", "--connectivity", "26"], cube)

    def test_errors_name_the_reason(self):
        for words, arguments in [
            (["--mm", "--voxels"], []),
            (["--mm", "--voxels"], ["--mm", "1", "--voxels", "2"]),
            (["--connectivity"], ["--mm", "1", "--connectivity", "26"]),
            (["--mm"], ["--mm", "-1"]),
            (["--mm"], ["--mm", "nan"]),
            (["--mm"], ["--mm", "inf"]),
            (["--mm", "two"], ["--mm", "two"]),
            (["--mm", "is empty"], ["--mm", ""]),
            (["--voxels"], ["--voxels", "-1"]),
            (["--voxels"], ["--voxels", "1.5"]),
        ]:
            for verb in ["dilate", "erode", "open", "close"]:
                self.expect_error(2, words, verb, "m.8vo", "-o", "x.8vo", *arguments)
                self.assertFalse((self.folder / "x.8vo").exists())


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
