#!/usr/bin/env python3
"""Works with masks as a user does: threshold, combine, components, measure.

usage: octree_test.py OCTAVO [unittest arguments]

Everything is generated: a block of 40, a bar of 90 and a grain of 200 in a surrounding of 10.
"""

import json
import struct
import sys

import cli_test

SIZE = (70, 66, 68)
SPACING = (0.5, 0.5, 2.0)


def scene():
    """Voxels [z][y][x]."""
    voxels = [10] * (SIZE[0] * SIZE[1] * SIZE[2])

    def fill(box, value):
        (x0, x1), (y0, y1), (z0, z1) = box
        for z in range(z0, z1):
            for y in range(y0, y1):
                for x in range(x0, x1):
                    voxels[(z * SIZE[1] + y) * SIZE[0] + x] = value

    fill(((4, 24), (4, 24), (4, 24)), 40)
    fill(((24, 60), (8, 12), (8, 12)), 90)  # touches the block by a face
    fill(((60, 61), (12, 13), (12, 13)), 200)  # touches the bar by a corner
    fill(((30, 40), (40, 50), (60, 68)), 90)
    return voxels


class Masks(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = scene()
        (self.folder / "v.raw").write_bytes(struct.pack(f"<{len(voxels)}h", *voxels))
        size = ",".join(map(str, SIZE))
        self.expect(0, "build", "v.raw", "--raw", f"{size},int16", "--spacing", "0.5,0.5,2", "-o",
                    "v.8vo", "--preset", "fast", "-q")

    def json(self, *arguments):
        return json.loads(self.expect(0, *arguments, "--json", "--progress", "none").stdout)

    def voxels_of(self, name):
        self.expect(0, "export", name, "-o", "out.raw", "-f", "-q")
        return list((self.folder / "out.raw").read_bytes())

    def threshold(self, name, *ranges):
        arguments = [word for text in ranges for word in ("--range", text)]
        return self.json("threshold", "v.8vo", *arguments, "-o", name)

    def test_threshold_takes_the_voxels_of_the_ranges(self):
        for ranges, takes in [
            (["40:"], lambda v: v >= 40),
            ([":10", "200:200"], lambda v: v <= 10 or v == 200),
            (["10.5:89.5"], lambda v: v == 40),
        ]:
            made = self.threshold("m.8vo", *ranges)
            expected = [1 if takes(v) else 0 for v in scene()]
            self.assertEqual(made["objects"][0]["voxels"], sum(expected))
            self.assertEqual(made["objects"][0]["mm3"], sum(expected) * 0.5)
            self.assertEqual(self.voxels_of("m.8vo"), expected)
            (self.folder / "m.8vo").unlink()
        info = self.info("v.8vo")
        self.threshold("m.8vo", "40:")
        mask = self.info("m.8vo")
        self.assertEqual(mask["kind"], "labels")
        self.assertEqual(mask["spacing_mm"], info["spacing_mm"])
        self.assertEqual(mask["metadata"]["made_by"]["operation"], "threshold")

    def test_classes_are_made_in_one_pass_and_the_first_counts(self):
        self.json("threshold", "v.8vo", "--class", "3=30:50", "--class", "7=:95", "--class",
                  "1=-5:500", "-o", "c.8vo")
        expected = [3 if v == 40 else 7 if v <= 95 else 1 for v in scene()]
        self.assertEqual(self.voxels_of("c.8vo"), expected)

    def test_ranges_are_real_values_and_stored_ones_on_request(self):
        # NIfTI with slope 2 and intercept -1000: 40 stored is -920.
        header = struct.pack("<i36x8h", 348, 3, *SIZE, 1, 1, 1, 1) + bytes(14)
        header += struct.pack("<hhh8ffff", 4, 16, 0, 1, 1, 1, 1, 0, 0, 0, 0, 352, 2, -1000)
        header = header.ljust(344, b"\0") + b"n+1\0" + bytes(4)
        voxels = (self.folder / "v.raw").read_bytes()
        (self.folder / "n.nii").write_bytes(header + voxels)
        self.expect(0, "build", "n.nii", "-o", "n.8vo", "-q", "--preset", "fast")
        for ranges, expected in [(["--range=-920:-920"], 8000), (["--range=-921.9:-920.1"], 0),
                                 (["--range=-920:1e300"], 8000 + 800 + 576 + 1),
                                 (["--range=-1e18:-920"], None), (["--range=1e17:"], 0),
                                 (["--range", "40:40", "--stored"], 8000)]:
            made = self.json("threshold", "n.8vo", *ranges, "-o", "a.8vo", "-f")
            if expected is None:
                expected = SIZE[0] * SIZE[1] * SIZE[2] - 800 - 576 - 1
            self.assertEqual(made["objects"][0]["voxels"], expected)

    def test_nothing_is_said_in_mm_where_the_spacing_is_unknown(self):
        header = struct.pack("<i36x8h", 348, 3, *SIZE, 1, 1, 1, 1) + bytes(14)
        header += struct.pack("<hhh8ffff", 4, 16, 0, 1, 0, 0, 0, 0, 0, 0, 0, 352, 1, 0)
        header = header.ljust(344, b"\0") + b"n+1\0" + bytes(4)
        (self.folder / "n.nii").write_bytes(header + (self.folder / "v.raw").read_bytes())
        self.expect(0, "build", "n.nii", "-o", "n.8vo", "-q", "--preset", "fast")
        made = self.json("threshold", "n.8vo", "--range", "40:", "-o", "a.8vo")
        self.assertIsNone(made["objects"][0]["mm3"])
        found = self.json("components", "a.8vo")
        self.assertIsNone(found["objects"][0]["mm3"])
        self.assertIsNone(found["objects"][0]["centroid_mm"])
        told = self.expect(0, "measure", "a.8vo", "--json")
        self.assertIn("spacing is not known", told.stderr)
        region = json.loads(told.stdout)["objects"][0]
        self.assertIsNone(region["principal_moments_mm2"])
        self.assertIsNone(region["centroid_mm"])
        place = ", ".join(f"{c:.1f}" for c in region["centroid_voxel"])
        self.assertRegex(self.expect(0, "measure", "a.8vo").stdout,
                         rf"centroid voxels[^\n]*\n[^\n]* {place} ")
        self.expect_error(2, ["a volume in mm3", "--spacing"],
                          "components", "a.8vo", "--min-mm3", "1")

    def test_set_operations_are_those_on_every_voxel(self):
        self.threshold("a.8vo", "40:90")
        self.threshold("b.8vo", "90:")
        self.threshold("c.8vo", "200:")
        a, b, c = (self.voxels_of(name) for name in ["a.8vo", "b.8vo", "c.8vo"])
        cases = {
            "--union": lambda p, q, r: p | q | r,
            "--intersect": lambda p, q, r: p & q & r,
            "--subtract": lambda p, q, r: p & ~q & ~r & 1,
            "--xor": lambda p, q, r: p ^ q ^ r,
        }
        for option, expected in cases.items():
            made = self.json("combine", "a.8vo", "b.8vo", "c.8vo", option, "-o", "r.8vo", "-f")
            wanted = [expected(*voxels) for voxels in zip(a, b, c)]
            self.assertEqual(self.voxels_of("r.8vo"), wanted, option)
            self.assertEqual(made["voxels"], sum(wanted))
        self.json("combine", "a.8vo", "--complement", "-o", "r.8vo", "-f")
        self.assertEqual(self.voxels_of("r.8vo"), [1 - v for v in a])

    def test_components_are_numbered_by_size(self):
        self.threshold("m.8vo", "40:")
        found = self.json("components", "m.8vo", "-o", "l.8vo")
        self.assertEqual(found["components"], 3)
        sizes = [8000 + 36 * 16, 800, 1]
        self.assertEqual([o["voxels"] for o in found["objects"]], sizes)
        self.assertEqual([o["label"] for o in found["objects"]], [1, 2, 3])
        self.assertEqual(found["objects"][1]["box"], [[30, 40], [40, 50], [60, 68]])
        center = [34.5 * 0.5, 44.5 * 0.5, 63.5 * 2]
        self.assertEqual(found["objects"][1]["centroid_mm"], center)
        labels = self.voxels_of("l.8vo")
        self.assertEqual([labels.count(k) for k in (1, 2, 3)], sizes)
        self.assertEqual(self.json("components", "m.8vo", "--connectivity", "26")["components"], 2)
        kept = self.json("components", "m.8vo", "--keep-largest", "1", "-o", "k.8vo")
        self.assertEqual(kept["kept"], 1)
        self.assertEqual(sum(self.voxels_of("k.8vo")), sizes[0])
        large = self.json("components", "m.8vo", "--min-mm3", "1")
        self.assertEqual(large["kept"], 2)

    def test_parts_of_a_measurement_join_to_every_digit(self):
        self.threshold("m.8vo", "40:")
        self.json("components", "m.8vo", "-o", "l.8vo")
        question = ["measure", "l.8vo", "--of", "v.8vo"]
        for i in range(2):
            self.expect(0, *question, "--part", f"{i}/2", "-o", f"sums-{i}")
        for form in ["--json", "--csv"]:
            self.assertEqual(self.expect(0, *question, form, "--join", "sums-1", "sums-0").stdout,
                             self.expect(0, *question, form).stdout)
        none = self.json(*question, "--no-percentiles")["objects"][0]
        self.assertNotIn("percentiles", none)
        for words, command in [
                ("another measurement", [*question, "--no-percentiles", "--join", "sums-0"]),
                ("missing: 1", [*question, "--join", "sums-0"]),
                ("verb", ["verify", "l.8vo", "--join", "sums-0"])]:
            self.assertIn(words, self.octavo(*command).stderr)

    def test_measure_gives_what_lies_beneath_labels(self):
        self.threshold("m.8vo", "40:")
        self.json("components", "m.8vo", "-o", "l.8vo")
        objects = self.json("measure", "l.8vo", "--of", "v.8vo", "--percentile", "50")["objects"]
        self.assertEqual([o["label"] for o in objects], [1, 2, 3])
        second = objects[1]
        self.assertEqual(second["voxels"], 800)
        self.assertEqual(second["mm3"], 400)
        self.assertEqual((second["mean"], second["sd"]), (90, 0))
        self.assertEqual(second["integrated_mm3"], 90 * 400)
        self.assertEqual(second["surface_voxels"], 800 - 8 * 8 * 6)
        first = objects[0]
        self.assertAlmostEqual(first["mean"], (8000 * 40 + 576 * 90) / 8576)
        self.assertEqual((first["min"], first["max"]), (40, 90))
        self.assertEqual(first["percentiles"], {"50": 40})
        asked = self.expect(0, "measure", "l.8vo", "--of", "v.8vo", "--percentile", "99",
                            "--percentile", "2.5").stdout.splitlines()
        self.assertEqual(asked[0].split()[-2:], ["p2.5", "p99"])
        self.assertEqual([line.split()[-2:] for line in asked[1:]],
                         [["40", "90"], ["90", "90"], ["200", "200"]])
        usual = self.expect(0, "measure", "l.8vo", "--of", "v.8vo").stdout.splitlines()
        self.assertEqual(usual[0].split()[-1], "max")
        table = self.expect(0, "measure", "l.8vo", "--of", "v.8vo", "--csv").stdout.splitlines()
        self.assertEqual(len(table), 4)
        self.assertEqual(len({line.count(",") for line in table}), 1)
        row = dict(zip(table[0].split(","), table[2].split(",")))
        wanted = {"label": "2", "voxels": "800", "centroid_z_mm": "127.0", "box_z_hi": "68",
                  "mean": "90.0", "p50": "90.0"}
        self.assertEqual({name: row[name] for name in wanted}, wanted)
        self.assertIn("principal_axis_3_z", row)
        self.assertIn("principal_moment_1_mm2", row)

    def test_an_input_is_never_the_output(self):
        self.threshold("a.8vo", "40:")
        before = {name: (self.folder / name).read_bytes() for name in ("a.8vo", "v.8vo")}
        for arguments in [
            ("threshold", "v.8vo", "--range", "40:", "-o", "./v.8vo"),
            ("condense", "v.8vo", "--flat", "5", "-o", "v.8vo"),
            ("transform", "v.8vo", "--mirror", "x", "-o", "v.8vo"),
            ("combine", "a.8vo", "a.8vo", "--union", "-o", "a.8vo"),
            ("components", "a.8vo", "-o", "a.8vo"),
            ("fill-holes", "a.8vo", "-o", "a.8vo"),
            ("dilate", "a.8vo", "--mm", "1", "-o", "a.8vo"),
            ("shell", "a.8vo", "-o", "a.8vo"),
        ]:
            told = self.expect(2, *arguments, "--force")
            self.assertIn("is the input itself", told.stderr)
        for name, whole in before.items():
            self.assertEqual((self.folder / name).read_bytes(), whole)

    def test_results_are_octavo_files(self):
        told = self.expect(2, "threshold", "v.8vo", "--range", "40:", "-o", "mask.nrrd")
        self.assertIn("octavo export", told.stderr)
        self.assertFalse((self.folder / "mask.nrrd").exists())

    def test_numbers_that_are_none_are_rejected(self):
        self.threshold("a.8vo", "40:")
        for arguments in [("components", "a.8vo", "--min-mm3", "nan"),
                          ("measure", "a.8vo", "--of", "v.8vo", "--percentile", "nan"),
                          ("condense", "v.8vo", "--flat", "nan", "-o", "c.8vo"),
                          ("condense", "v.8vo", "--flat=-1", "-o", "c.8vo"),
                          ("condense", "v.8vo", "--flat", "1", "--up-to-mean", "-o", "c.8vo"),
                          ("condense", "v.8vo", "--self-similar=-1"),
                          ("condense", "v.8vo", "--self-similar", "1", "-o", "c.8vo"),
                          ("condense", "v.8vo", "--self-similar", "x"),
                          ("condense", "v.8vo")]:
            self.expect(2, *arguments)

    def test_errors_name_the_reason(self):
        self.threshold("m.8vo", "40:")
        voxels = bytes(8)
        (self.folder / "s.raw").write_bytes(voxels)
        self.expect(0, "build", "s.raw", "--raw", "2,2,2,uint8", "--spacing", "1", "--labels", "-o",
                    "s.8vo", "-q")
        size = ",".join(map(str, SIZE))
        self.expect(0, "build", "v.raw", "--raw", f"{size},int16", "--spacing", "1", "--labels",
                    "-o", "far.8vo", "-q")
        for words, arguments in [
            (["needs --range"], ["threshold", "v.8vo", "-o", "x.8vo"]),
            (["LOW:HIGH"], ["threshold", "v.8vo", "--range", "7", "-o", "x.8vo"]),
            (["lower end"], ["threshold", "v.8vo", "--range", "9:7", "-o", "x.8vo"]),
            (["HU"], ["threshold", "m.8vo", "--tissue", "bone", "-o", "x.8vo"]),
            (["1 to 255"], ["threshold", "v.8vo", "--class", "0=1:2", "-o", "x.8vo"]),
            (["v.8vo", "octavo threshold"], ["components", "v.8vo"]),
            (["v.8vo", "octavo threshold"], ["measure", "v.8vo"]),
            (["two masks"], ["combine", "m.8vo", "--union", "-o", "x.8vo"]),
            (["s.8vo", "2 x 2 x 2", "70 x 66 x 68"],
             ["combine", "m.8vo", "s.8vo", "--union", "-o", "x.8vo"]),
            (["far.8vo", "spacing 1 x 1 x 1 against 0.5 x 0.5 x 2"],
             ["combine", "m.8vo", "far.8vo", "--union", "-o", "x.8vo"]),
            (["--tissue"], ["threshold", "v.8vo", "--tissue", "bone", "--stored", "-o", "x.8vo"]),
            (["s.8vo", "one grid"], ["measure", "m.8vo", "--of", "s.8vo"]),
        ]:
            self.expect_error(2, words, *arguments)
            self.assertFalse((self.folder / "x.8vo").exists())
        self.expect_error(5, ["exists already"], "threshold", "v.8vo", "--range", "1:", "-o",
                          "m.8vo")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
