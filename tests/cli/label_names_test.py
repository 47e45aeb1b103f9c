#!/usr/bin/env python3
"""Names of labels from a text file into the file, and from there into every table.

usage: label_names_test.py OCTAVO [unittest arguments]

Everything is generated: two blocks side by side, and a grain apart.
"""

import csv
import io
import json
import sys

import cli_test

SIZE = (16, 16, 16)
AAL = "# atlas\r\n3 Left_Lung 2001\r\n5 Right_Lung 2002\r\n40 Elsewhere 2003\r\n"
COLORED = "3 Left Lung 255 0 0\n5 \"Right, \\ 2\" 0 128 255\n"


class LabelNames(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = bytearray(SIZE[0] * SIZE[1] * SIZE[2])
        for z in range(4, 8):
            for y in range(4, 8):
                for x in range(4, 12):
                    voxels[(z * SIZE[1] + y) * SIZE[0] + x] = 3 if x < 8 else 5
        voxels[0] = 7
        (self.folder / "l.raw").write_bytes(voxels)

    def build(self, name, text, *options, code=0):
        (self.folder / "names.txt").write_bytes(text.encode() if isinstance(text, str) else text)
        layout = ",".join(map(str, SIZE)) + ",uint8"
        return self.expect(code, "build", "l.raw", "--raw", layout, "--spacing", "1", "--labels",
                           "--label-names", "names.txt", "-o", name, "--progress", "none", "-f",
                           *options)

    def json(self, *arguments, code=0):
        return json.loads(
            self.expect(code, *arguments, "--json", "--progress", "none").stdout)

    def text(self, *arguments, code=0):
        return self.expect(code, *arguments, "--progress", "none").stdout

    def row(self, text, label):
        """The words of the line that begins with a label."""
        return next(line.split() for line in text.splitlines()
                    if line.split()[:1] == [str(label)])

    def test_the_file_holds_names_and_colors(self):
        self.assertIn("uint8 labels (3 named)", self.build("a.8vo", AAL).stdout)
        self.assertEqual(self.info("a.8vo")["metadata"]["labels"],
                         {"3": {"name": "Left_Lung"}, "5": {"name": "Right_Lung"},
                          "40": {"name": "Elsewhere"}})
        self.assertIn("  labels       3 named: 3 Left_Lung, 5 Right_Lung, 40 Elsewhere\n",
                      self.text("info", "a.8vo"))
        self.assertEqual(json.loads(self.build("a.8vo", COLORED, "--json").stdout)["named_labels"],
                         2)
        self.assertEqual(self.info("a.8vo")["metadata"]["labels"],
                         {"3": {"name": "Left Lung", "color": "#ff0000"},
                          "5": {"name": "Right, \\ 2", "color": "#0080ff"}})

    def test_measure_names_its_rows(self):
        self.build("a.8vo", AAL)
        table = self.text("measure", "a.8vo")
        self.assertEqual(self.row(table, 3)[:3], ["3", "Left_Lung", "64"])
        self.assertEqual(self.row(table, 7)[:2], ["7", "1"])
        objects = {o["label"]: o["name"] for o in self.json("measure", "a.8vo")["objects"]}
        self.assertEqual(objects, {3: "Left_Lung", 5: "Right_Lung", 7: None})
        self.build("a.8vo", COLORED)
        rows = list(csv.DictReader(io.StringIO(self.text("measure", "a.8vo", "--csv"))))
        self.assertEqual([row["name"] for row in rows], ["Left Lung", "Right, \\ 2", ""])

    def test_touch_names_both_sides(self):
        self.build("a.8vo", AAL)
        self.assertEqual(self.row(self.text("touch", "a.8vo"), 3)[:5],
                         ["3", "Left_Lung", "5", "Right_Lung", "16"])
        pair, = self.json("touch", "a.8vo")["pairs"]
        self.assertEqual(pair["names"], ["Left_Lung", "Right_Lung"])

    def test_compare_shows_names_of_either_where_they_differ(self):
        self.build("a.8vo", AAL)
        self.build("b.8vo", "3 Left_Lung\n5 Rechts\n7 Korn\n")
        table = self.text("compare", "a.8vo", "b.8vo", "--labels")
        self.assertEqual(self.row(table, 3)[1:3], ["Left_Lung", "64"])
        self.assertEqual(self.row(table, 5)[1:5], ["Right_Lung", "(B:", "Rechts)", "64"])
        self.assertEqual(self.row(table, 7)[1:3], ["Korn", "1"])
        labels = self.json("compare", "a.8vo", "b.8vo", "--labels")["labels"]
        self.assertEqual([(one["a_name"], one["b_name"]) for one in labels],
                         [("Left_Lung", "Left_Lung"), ("Right_Lung", "Rechts"), (None, "Korn")])

    def test_probe_names_the_voxel(self):
        self.build("a.8vo", AAL)
        self.assertIn("value   3 Left_Lung\n", self.text("probe", "a.8vo", "--at", "4,4,4"))
        points = self.json("probe", "a.8vo", "--at", "4,4,4", "--at", "0,0,0")["points"]
        self.assertEqual([point["name"] for point in points], ["Left_Lung", None])

    def test_codes_count_and_take_labels_by_name(self):
        self.build("a.8vo", AAL)
        self.assertEqual(self.row(self.text("codes", "a.8vo", "--counts"), 5)[:4],
                         ["5", "Right_Lung", "1", "64"])
        by_name = self.json("codes", "a.8vo", "--label", "Right_Lung", "--counts", "--list")
        self.assertEqual(by_name, self.json("codes", "a.8vo", "--label", "5", "--counts",
                                            "--list"))
        self.assertEqual([one["name"] for one in by_name["labels"]], ["Right_Lung"])
        around = self.text("codes", "a.8vo", "--neighbors", by_name["codes"][0]["code"])
        self.assertIn("a leaf of value 5 Right_Lung\n", around)
        self.assertIn(" 3 Left_Lung\n", around)
        self.expect_error(2, ["no label has the name 'Lung'", "info --metadata"],
                          "codes", "a.8vo", "--label", "Lung")

    def test_every_verb_takes_a_label_by_number_and_by_name(self):
        self.build("a.8vo", AAL)
        for arguments in [["measure"], ["threshold", "-o", "o.8vo"], ["slice", "-o", "o.png"],
                          ["render", "-o", "o.png", "--size", "64"], ["codes", "--list"]]:
            made = []
            for label in ["5", "Right_Lung"]:
                shown = self.text(arguments[0], "a.8vo", *arguments[1:], "--label", label,
                                  *(["-f"] if "-o" in arguments else []))
                output = self.folder / arguments[2] if "-o" in arguments else None
                made.append(output.read_bytes() if output else shown)
            self.assertEqual(*made, arguments)
            self.expect_error(2, ["a.8vo: no label has the name 'Lung'", "info --metadata"],
                              arguments[0], "a.8vo", *arguments[1:], "--label", "Lung")
            self.expect_error(2, ["label 0 is the background"],
                              arguments[0], "a.8vo", *arguments[1:], "--label", "0")
        rows = self.json("measure", "a.8vo", "--label", "Left_Lung", "--label", "7")["objects"]
        self.assertEqual([(row["label"], row["voxels"]) for row in rows], [(3, 64), (7, 1)])
        made = self.json("threshold", "a.8vo", "--label", "Left_Lung", "--label", "7", "-o",
                         "m.8vo")
        self.assertEqual(made["objects"], [{"label": 1, "voxels": 65, "mm3": 65}])
        absent = self.expect(0, "measure", "a.8vo", "--label", "Elsewhere", "--json",
                             "--progress", "none")
        self.assertEqual(json.loads(absent.stdout)["warnings"],
                         ["a.8vo: no voxel has label 40 (Elsewhere)"])

    def test_names_stay_with_labels_and_leave_with_them(self):
        self.build("a.8vo", AAL)
        for arguments in [["transform", "a.8vo", "--rotate", "z:90"], ["build", "a.8vo"]]:
            self.text(*arguments, "-o", "same.8vo", "-f")
            self.assertIn("labels", self.info("same.8vo")["metadata"], arguments)
        for arguments in [["components", "a.8vo"], ["threshold", "a.8vo", "--range", "3:5"],
                          ["combine", "a.8vo", "a.8vo", "--union"],
                          ["dilate", "a.8vo", "--voxels", "1"], ["shell", "a.8vo"],
                          ["build", "a.8vo", "--grey"]]:
            self.text(*arguments, "-o", "other.8vo", "-f")
            self.assertNotIn("labels", self.info("other.8vo")["metadata"], arguments)

    def test_names_are_escaped_before_they_are_shown(self):
        # A color table of Latin-1 text, a name that would turn a terminal red.
        self.build("a.8vo", b"3 Ar\xe9ole\n5 x\n")
        self.assertIn("Ar\u00e9ole", self.text("measure", "a.8vo"))
        self.assertEqual(self.info("a.8vo")["metadata"]["labels"]["3"], {"name": "Ar\u00e9ole"})
        rows = list(csv.DictReader(io.StringIO(self.text("measure", "a.8vo", "--csv"))))
        self.assertEqual(rows[0]["name"], "Ar\u00e9ole")
        # Lists are rejected with it; an image of OME-Zarr may hold it.
        self.build("a.8vo", b"3 RED\n5 x\n")
        self.expect(0, "export", "a.8vo", "-o", "a.ome.zarr")
        for path in self.folder.rglob("zarr.json"):
            path.write_text(path.read_text().replace("RED", "a\\u009b31mred"))
        self.expect(0, "build", "a.ome.zarr", "-o", "a.8vo", "--labels", "-f")
        for arguments in [["info"], ["measure"], ["measure", "--csv"], ["touch"],
                          ["codes", "--counts"], ["probe", "--at", "4,4,4"]]:
            shown = self.text(arguments[0], "a.8vo", *arguments[1:])
            self.assertIn("a\\xc2\\x9b31mred", shown, arguments)
            self.assertNotIn("\x9b", shown, arguments)

    def test_a_resumed_build_ends_in_the_same_file(self):
        self.build("a.8vo", AAL)
        self.build("b.8vo", AAL, "--resume")
        self.assertEqual((self.folder / "a.8vo").read_bytes(), (self.folder / "b.8vo").read_bytes())

    def test_bad_lists_are_told_with_their_line_and_leave_no_file(self):
        for text, words in [("3 a\n5\n", ["names.txt: line 2: '5' is neither"]),
                            ("3 a\n3 b\n", ["line 2: label 3 has another name in line 1"]),
                            ("3 \x1b[31m\n", ["line 1: holds a control character"]),
                            ("3 a\x9b31m\n", ["line 1: holds a control character"]),
                            ("", ["names no label"])]:
            error = self.build("bad.8vo", text, code=7).stderr
            for word in words:
                self.assertIn(word, error)
            self.assertFalse((self.folder / "bad.8vo").exists())
        self.expect_error(5, ["nowhere.txt"], "build", "l.raw", "--raw", "16,16,16,uint8",
                          "--labels", "--label-names", "nowhere.txt", "-o", "bad.8vo")

    def test_grey_values_have_no_names(self):
        (self.folder / "names.txt").write_text(AAL)
        self.expect_error(2, ["l.raw: holds grey values", "leave out --label-names", "--labels"],
                          "build", "l.raw", "--raw", "16,16,16,uint8", "--spacing", "1",
                          "--label-names", "names.txt", "-o", "g.8vo")
        self.assertFalse((self.folder / "g.8vo").exists())


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
