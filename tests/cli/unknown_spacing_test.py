#!/usr/bin/env python3
"""Proves that nothing is said in mm where no spacing is known, and of sides where no place is.

usage: unknown_spacing_test.py OCTAVO [unittest arguments]

Everything is generated: a grey block in the same volume with and without a spacing.
"""

import csv
import io
import json
import struct
import sys

import cli_test

SIZE = (20, 18, 12)


class UnknownSpacing(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = [40 if 4 <= x < 12 and 4 <= y < 12 and 4 <= z < 8 else 10
                  for z in range(SIZE[2]) for y in range(SIZE[1]) for x in range(SIZE[0])]
        (self.folder / "v.raw").write_bytes(struct.pack(f"<{len(voxels)}h", *voxels))
        self.build("known.8vo", "--spacing", "0.5")
        self.build("v.8vo")
        self.said("threshold", "v.8vo", "--range", "30:", "-o", "m.8vo")
        self.said("threshold", "known.8vo", "--range", "30:", "-o", "known-m.8vo")

    def build(self, name, *options):
        layout = ",".join(map(str, SIZE)) + ",int16"
        self.expect(0, "build", "v.raw", "--raw", layout, "--preset", "fast", "-o", name, "-q",
                    *options)

    def said(self, *arguments):
        return self.expect(0, *arguments, "--progress", "none")

    def rows(self, *arguments):
        return list(csv.DictReader(io.StringIO(self.said(*arguments).stdout)))

    def test_a_table_keeps_its_columns_and_leaves_cells_in_mm_empty(self):
        for of, known_of in [([], []), (["--of", "v.8vo"], ["--of", "known.8vo"])]:
            known, = self.rows("measure", "known-m.8vo", "--csv", *known_of)
            row, = self.rows("measure", "m.8vo", "--csv", *of)
            self.assertEqual(list(row), list(known))
            for name, cell in row.items():
                in_mm = "mm" in name or name.startswith("principal_axis")
                self.assertEqual(cell, "" if in_mm else known[name], name)

    def test_options_in_mm_are_rejected_and_told_what_does_the_same(self):
        for what, instead, arguments in [
            ("a position in mm", ", the number of a slice does not",
             ["slice", "v.8vo", "--mm", "3", "-o", "s.png"]),
            ("a place in mm", ", one in voxels does not",
             ["probe", "v.8vo", "--mm", "1,1,1"]),
            ("a box in mm", ", one in voxels does not",
             ["extract", "v.8vo", "--box-mm", "0:2,0:2,0:2", "-o", "b.raw"]),
            ("a translation in mm", ", one in voxels does not",
             ["transform", "v.8vo", "--translate-mm", "1,1,1", "-o", "t.8vo"]),
            ("a distance in mm", ", one in voxels does not",
             ["dilate", "m.8vo", "--mm", "1", "-o", "d.8vo"]),
            ("a volume in mm3", "", ["fill-holes", "m.8vo", "--max-mm3", "1", "-o", "f.8vo"]),
            ("a volume in mm3", "", ["components", "m.8vo", "--min-mm3", "1"]),
        ]:
            with self.subTest(arguments):
                self.expect_error(2, [f"octavo: {arguments[1]}: {what} needs a known spacing"
                                      f"{instead}; build it again with --spacing\n"],
                                  *arguments)

    def test_words_count_voxels_and_numbers_in_mm_are_null(self):
        for place, arguments in [
            (["slices", 0, "pixel_mm"], ["slice", "v.8vo", "-o", "s.png", "-f"]),
            (["points", 0, "world_mm"], ["probe", "v.8vo", "--at", "1,1,1"]),
            (["spacing_mm"], ["transform", "v.8vo", "--translate", "1,0,0", "-o", "t.8vo", "-f"]),
            (["origin_mm"], ["transform", "v.8vo", "--mirror", "x", "-o", "t.8vo", "-f"]),
            (["shift_mm"], ["compare", "v.8vo", "known.8vo"]),
            (["pixel_mm"], ["render", "v.8vo", "--range", "30:", "-o", "r.png", "-f"]),
            (["mm3"], ["shell", "m.8vo"]),
        ]:
            with self.subTest(arguments):
                found = json.loads(self.said(*arguments, "--json").stdout)
                for key in place:
                    found = found[key]
                self.assertIsNone(found)
                words = self.said(*arguments).stdout
                self.assertNotIn(" mm", words)
                self.assertNotIn("mm3", words)
        self.assertIn(" pixels of 0.0384615 voxels (spacing not known), slice",
                      self.said("slice", "v.8vo", "-o", "s.png", "-f").stdout)
        self.assertIn("voxel 1,1,1 of level 0 (spacing not known)\n",
                      self.said("probe", "v.8vo", "--at", "1,1,1").stdout)

    def test_a_slice_has_no_bar(self):
        def picture(name, *options):
            self.said("slice", name, "-o", "s.png", "-f", *options)
            return (self.folder / "s.png").read_bytes()

        self.assertEqual(picture("v.8vo"), picture("v.8vo", "--no-scale-bar"))
        self.assertNotEqual(picture("known.8vo"), picture("known.8vo", "--no-scale-bar"))

    def test_a_file_that_names_a_spacing_all_the_same_is_told_of(self):
        for name, is_told in [("a.mha", True), ("d.mhd", True), ("a.nii", True),
                              ("a.nii.gz", True), ("a.nrrd", False), ("a.tif", False),
                              ("stack/", False), ("a.raw", False)]:
            with self.subTest(name):
                told = (f"octavo: warning: {name}: the spacing of v.8vo is not known; the file "
                        "says 1 mm, as its format needs a number\n")
                self.assertEqual(told in self.said("export", "v.8vo", "-o", name).stderr, is_told)
                self.assertNotIn("spacing", self.said("export", "known.8vo", "-o", name,
                                                      "-f").stderr)
        made = self.said("export", "v.8vo", "--level", "1", "-o", "b.nii", "--json")
        self.assertIn("the file says 2 mm", json.loads(made.stdout)["warnings"][0])
        self.expect_error(7, ["c.nii: the spacing of v.8vo is not known", "--strict"], "export",
                          "v.8vo", "-o", "c.nii", "--strict")
        self.assertNotIn("c.nii", self.files())
        for name in ["a.nrrd", "a.tif"]:
            self.said("export", "v.8vo", "-o", name, "-f")
            self.expect(0, "build", name, "-o", "back.8vo", "-q", "-f")
            self.assertFalse(self.info("back.8vo")["spacing_known"])

    def test_laying_it_over_a_volume_in_mm_warns(self):
        told = (": its spacing is not known and is taken for 1 mm, so that the two grids may not "
                "fit together; give the spacing when it is built\n")
        for verb, inputs in [("combine", ["known-m.8vo", "m.8vo", "--resample", "--union"]),
                             ("combine", ["m.8vo", "known-m.8vo", "--resample", "--xor"]),
                             ("transform", ["m.8vo", "--grid-of", "known-m.8vo"]),
                             ("transform", ["known-m.8vo", "--grid-of", "m.8vo"])]:
            with self.subTest([verb, *inputs]):
                said = self.said(verb, *inputs, "-o", "o.8vo", "-f", "-q").stderr
                self.assertEqual(said, "octavo: warning: m.8vo" + told)
        self.assertEqual(self.said("combine", "m.8vo", "m.8vo", "--resample", "--union", "-o",
                                   "o.8vo", "-f", "-q").stderr, "")

    def test_a_part_of_a_volume_without_a_place_has_none(self):
        def orientation(name):
            lines = self.said("info", name).stdout.splitlines()
            return [line.split(maxsplit=1)[1] for line in lines if "orientation" in line]

        not_given = ["not given; axes as in the source"]
        self.assertEqual(orientation("known.8vo"), not_given)
        for name, box, told in [
            ("b.nrrd", "4:12,4:12,2:8", ""),
            ("b.tif", "4:12,4:12,2:8", ""),
            ("b.nii.gz", "4:12,4:12,2:8",
             "b.nii.gz: cannot say that the box begins at voxel 4,4,2 of known.8vo, as "
             "how the patient lies is not known; .nrrd can"),
            ("c.nii", ":12,:12,:8", ""),
            ("b.mha", "4:12,4:12,2:8",
             "b.mha: how the patient lies is not known in known.8vo; other programs may show "
             "letters for left and right all the same"),
        ]:
            with self.subTest(name):
                said = self.said("extract", "known.8vo", "--box", box, "-o", name).stderr
                self.assertEqual(said, told and f"octavo: warning: {told}\n")
                if name.endswith(".mha"):
                    continue
                self.expect(0, "build", name, "-o", "back.8vo", "-q", "-f")
                self.assertEqual(orientation("back.8vo"), not_given)
                self.assertEqual(self.info("back.8vo")["spacing_mm"], [0.5, 0.5, 0.5])

    def test_a_part_of_a_volume_with_a_place_keeps_it(self):
        direction = "1 0 0 0 0 1 0 -1 0"
        (self.folder / "p.mha").write_bytes(
            ("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
             f"TransformMatrix = {direction}\nOffset = 1 2 3\nElementSpacing = 0.5 1 2\n"
             f"DimSize = {SIZE[0]} {SIZE[1]} {SIZE[2]}\nElementType = MET_SHORT\n"
             "ElementDataFile = LOCAL\n").encode() + (self.folder / "v.raw").read_bytes())
        self.expect(0, "build", "p.mha", "-o", "p.8vo", "-q")
        for name in ["b.nrrd", "b.nii.gz", "b.mha"]:
            with self.subTest(name):
                said = self.said("extract", "p.8vo", "--box", "4:12,4:12,2:8", "-o", name).stderr
                self.assertEqual(said, "")
                self.expect(0, "build", name, "-o", "back.8vo", "-q", "-f")
                back = self.info("back.8vo")
                self.assertEqual(back["origin_mm"], [3, -2, 7])
                self.assertEqual(back["direction"], [1, 0, 0, 0, 0, -1, 0, 1, 0])


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
