#!/usr/bin/env python3
"""Reads what the program says, as a user does: errors, notes, warnings and words of numbers.

usage: message_test.py OCTAVO [unittest arguments]

Everything is generated: a grey volume in HU with a block of 40 in a surrounding of 10, and a mask
of the block.
"""

import json
import os
import pathlib
import struct
import sys

import cli_test
from file_bytes import TRAILER_LENGTH, sealed, with_metadata
from identity_test import tiff

ROOT = pathlib.Path(__file__).resolve().parents[2]

SIZE = (20, 18, 12)


def block(inside, outside):
    return [inside if 4 <= x < 12 and 4 <= y < 12 and 4 <= z < 8 else outside
            for z in range(SIZE[2]) for y in range(SIZE[1]) for x in range(SIZE[0])]


class Messages(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.build("v.8vo", block(40, 10), "int16", "h")
        self.build("m.8vo", block(1, 0), "uint8", "B", "--labels")

    def build(self, name, voxels, type_name, code, *options, size=SIZE):
        (self.folder / "in.raw").write_bytes(struct.pack(f"<{len(voxels)}{code}", *voxels))
        self.expect(0, "build", "in.raw", "--raw", ",".join(map(str, size)) + "," + type_name,
                    "--spacing", "1", "--preset", "fast", "-o", name, "-q", *options)

    def test_values_in_place_of_nan_are_for_floats(self):
        layout = self.random_raw("v.raw", (10, 9, 8))
        for option in ["--nan", "--inf"]:
            self.expect_error(2, ["float32", "int16"], "build", "v.raw", "--raw", layout,
                              "--spacing", "1", option, "3", "-o", "f.8vo")
        self.assertNotIn("f.8vo", self.files())

    def test_a_folder_that_takes_no_files_is_found_before_the_work(self):
        # Work on these would end in exit code 2: nothing lies inside. Nothing is created in /proc.
        self.build("e.8vo", block(0, 0), "uint8", "B", "--labels")
        for verb in (["surface", "v.8vo", "--isovalue", "1000"], ["surface", "e.8vo"],
                     ["hexahedra", "e.8vo"]):
            ending = "vtu" if verb[0] == "hexahedra" else "stl"
            self.expect(2, *verb, "-o", f"x.{ending}")
            self.expect_error(5, [f"/proc/x.{ending}: cannot create"], *verb, "-o",
                              f"/proc/x.{ending}")
        self.expect(2, "surface", "e.8vo", "--parts", "-o", "parts")
        self.expect_error(5, ["/proc/parts: cannot create"], "surface", "e.8vo", "--parts", "-o",
                          "/proc/parts")
        self.expect_error(5, ["/proc: cannot create files in it"], "surface", "e.8vo", "--parts",
                          "-o", "/proc")
        self.assertEqual(sorted(self.files()), ["e.8vo", "in.raw", "m.8vo", "v.8vo"])

    def test_the_fewest_triangles_are_told_in_words_that_fit(self):
        self.expect_error(2, ["a surface of 1 piece has 4 triangles or more; the limit is 1",
                              "or one piece with --seed"],
                          "surface", "v.8vo", "--isovalue", "20", "--triangles", "1", "-o", "x.stl")
        told = self.expect_error(2, ["are the fewest that were reached; the limit is 1",
                                     "give more --triangles"],
                                 "surface", "m.8vo", "--parts", "--triangles", "1", "-o", "parts")
        self.assertNotIn("--seed", told.stderr)

    def test_verify_prints_json_of_what_cannot_be_opened(self):
        (self.folder / "no.8vo").write_bytes(b"no such thing" * 99)
        for name, code in [("no.8vo", 3), ("missing.8vo", 5)]:
            result = self.octavo("verify", name, "--json")
            self.assertEqual(result.returncode, code)
            said = json.loads(result.stdout)
            self.assertEqual((said["file"], said["sound"]), (name, None))
            self.assertEqual(said["error"]["exit_code"], code)
            self.assertEqual(said["error"], json.loads(result.stderr.splitlines()[-1])["error"])

    def test_a_volume_of_nan_alone_has_no_values(self):
        (self.folder / "n.raw").write_bytes(b"\x00\x00\xc0\xff" * (70 * 9 * 66))
        self.expect(0, "build", "n.raw", "--raw", "70,9,66,float32", "--spacing", "1", "-o",
                    "n.8vo")
        self.assertIn("values       none: every voxel is NaN or infinite\n",
                      self.expect(0, "info", "n.8vo").stdout)
        info = self.info("n.8vo")
        self.assertEqual((info["min"], info["max"]), (None, None))
        probe = self.expect(0, "probe", "n.8vo", "--at", "3,3,3").stdout
        self.assertIn("value   nan\n", probe)
        self.expect_error(2, ["n.8vo: no voxel has a finite value"], "render", "n.8vo", "--mode",
                          "iso", "--isovalue", "0", "-o", "iso.png")
        for mode in ["volume", "mip", "minip", "mean"]:
            drawn = self.said("render", "n.8vo", "--mode", mode, "-o", f"{mode}.png", "--json")
            self.assertEqual(json.loads(drawn.stdout)["warnings"],
                             ["n.8vo: no voxel is seen; the picture is empty"], mode)

    def said(self, *arguments):
        return self.expect(0, *arguments, "--progress", "none")

    def test_an_empty_text_is_no_option_left_out(self):
        kept = self.files()
        for option, arguments in [
            ("--scale", ["transform", "v.8vo", "--scale", "", "--mirror", "x", "-o", "x.8vo"]),
            ("--fill", ["transform", "v.8vo", "--shift", "1,1,1", "--fill", "", "-o", "x.8vo"]),
            ("--grid-of", ["transform", "v.8vo", "--mirror", "x", "--grid-of", "", "-o", "x.8vo"]),
            ("--max-mm3", ["fill-holes", "m.8vo", "--max-mm3", "", "-o", "x.8vo"]),
            ("--range", ["codes", "v.8vo", "--range", ""]),
            ("--neighbors", ["codes", "m.8vo", "--neighbors", ""]),
            ("--window", ["render", "v.8vo", "--mode", "transparency", "--window", "", "-o",
                          "x.png"]),
            ("--of", ["measure", "m.8vo", "--of", ""]),
            ("--mm", ["dilate", "m.8vo", "--mm", "", "-o", "x.8vo"]),
            ("--max-memory", ["info", "v.8vo", "--max-memory", ""]),
            ("--output", ["components", "m.8vo", "-o", ""]),
            ("file", ["info", ""]),
        ]:
            with self.subTest(arguments):
                self.expect_error(2, [option + ": is empty; expected "], *arguments)
                self.assertEqual(self.files(), kept)

    def test_a_tissue_given_as_a_range_is_told_what_takes_it(self):
        for verb in ["threshold", "render"]:
            self.expect_error(2, ["226: in HU", "--tissue bone"], verb, "v.8vo", "--range", "bone",
                              "-o", "x.png")
        self.expect_error(2, ["-190:-30 in HU"], "threshold", "v.8vo", "--class", "1=fat", "-o",
                          "x.8vo")

    def test_numbers_out_of_range_are_told_what_is_expected(self):
        for words, arguments in [
            ("--zoom: 0; expected a number above 0; ",
             ["render", "v.8vo", "--zoom", "0", "-o", "x.png"]),
            ("--zoom: wide; expected a number above 0; ",
             ["render", "v.8vo", "--zoom", "wide", "-o", "x.png"]),
            ("--elevation: 100; expected a number, -90 to 90; ",
             ["render", "v.8vo", "--elevation", "100", "-o", "x.png"]),
            ("--fade: 1.5; expected a number, 0 to 1; ",
             ["render", "v.8vo", "--fade", "1.5", "-o", "x.png"]),
            ("--turntable: 0; expected a whole number, 1 to 999; ",
             ["render", "v.8vo", "--turntable", "0", "-o", "x.png"]),
            ("--keep-largest: 0; expected a whole number of 1 or more; ",
             ["components", "m.8vo", "--keep-largest", "0"]),
            ("--keep-largest: 2.5; expected a whole number of 1 or more; ",
             ["components", "m.8vo", "--keep-largest", "2.5"]),
            ("--min-mm3: -3; expected a number of 0 or more; ",
             ["components", "m.8vo", "--min-mm3", "-3"]),
            ("--min-mm3: nan; expected a number of 0 or more; ",
             ["components", "m.8vo", "--min-mm3", "nan"]),
            ("--rows: -1; expected a whole number of 0 or more; ",
             ["components", "m.8vo", "--rows", "-1"]),
            ("--max-mm3: -1; expected a number of 0 or more; ",
             ["fill-holes", "m.8vo", "--max-mm3", "-1", "-o", "x.8vo"]),
            ("--percentile: 101; expected a number, 0 to 100; ",
             ["measure", "m.8vo", "--of", "v.8vo", "--percentile", "101"]),
            ("--threads: 0; expected a whole number, 1 to 1024; ", ["info", "v.8vo", "-j", "0"]),
            ("--size: 9999; expected a whole number, 1 to 8192; ",
             ["slice", "v.8vo", "--size", "9999", "-o", "x.png"]),
        ]:
            with self.subTest(arguments):
                self.expect_error(2, [words], *arguments)

    def test_what_is_no_8vo_file_is_told_how_it_becomes_one(self):
        (self.folder / "scan").mkdir()
        (self.folder / "Head.NII.gz").write_bytes(b"x" * 400)
        (self.folder / "notes.txt").write_bytes(b"x" * 400)
        for code, words, name in [
            (5, ["scan: is a folder", "'octavo build scan -o scan.8vo'"], "scan"),
            (5, ["'octavo build scan -o scan.8vo'"], "scan/"),
            (3, ["'octavo build Head.NII.gz -o Head.8vo'"], "Head.NII.gz"),
            (3, ["'octavo build in.raw --raw NX,NY,NZ,TYPE -o in.8vo'"], "in.raw"),
        ]:
            self.expect_error(code, words, "info", name)
        told = self.expect_error(3, ["notes.txt: not an 8vo file"], "info", "notes.txt")
        self.assertNotIn("octavo build", told.stderr)

    def test_pictures_say_what_is_amiss_with_the_path_first(self):
        dark = self.said("render", "v.8vo", "--mode", "transparency", "--range", "900:", "-o",
                         "d.png", "--direction", "1,0,0", "--json")
        told = "v.8vo: no voxel is lit; the picture is empty"
        self.assertEqual(json.loads(dark.stdout)["warnings"], [told])
        series = self.said("render", "v.8vo", "--mode", "transparency", "--range", "900:", "-o",
                           "t.png", "--turntable", "4", "--json")
        self.assertEqual(json.loads(series.stdout)["warnings"], [told])
        lit = self.said("render", "v.8vo", "--mode", "transparency", "--range", "30:", "-o",
                        "l.png", "--direction", "1,0,0", "--json")
        self.assertEqual(json.loads(lit.stdout)["warnings"], [])
        empty = self.said("render", "v.8vo", "--range", "900:", "-o", "e.png", "--json")
        self.assertEqual(json.loads(empty.stdout)["warnings"],
                         ["v.8vo: no voxel is drawn; the picture is empty"])
        for warned, options in [("no voxel is drawn", ["--range", "900:"]),
                                ("the cuts leave no voxel", ["--range", "30:"])]:
            cut = self.said("render", "v.8vo", *options, "--cut", "x<2", "-o", "cut.png", "-f",
                            "--json")
            self.assertEqual(json.loads(cut.stdout)["warnings"],
                             [f"v.8vo: {warned}; the picture is empty"])
        lying = self.said("render", "v.8vo", "--range", "30:", "--direction", "front", "-o",
                          "f.png")
        self.assertIn("octavo: v.8vo: does not say how the patient lies", lying.stderr)
        self.expect_error(2, ["30:50", "--range", "--mode transparency"], "render",
                          "v.8vo", "--range", "30:50=red:0.2", "-o", "c.png")
        self.expect_error(6, ["the picture would take about", "the limit is 100 MiB"], "render",
                          "v.8vo", "--range", "30:", "--size", "16384", "--max-memory", "100M",
                          "-o", "c.png")

    def test_info_says_what_a_volume_was_made_by(self):
        def row(name):
            lines = self.said("info", name).stdout.splitlines()
            return [line.split(maxsplit=2)[2] for line in lines if line.startswith("  made by ")]

        self.assertEqual(row("v.8vo"), [])
        for arguments, words in [
            (["condense", "v.8vo", "--flat", "7"],
             "condensed with tolerance 7: cubes that vary no more hold their mean"),
            (["threshold", "v.8vo", "--range", "30:50.5", "--range", "60:"],
             "threshold: units real, ranges 30:50.5, 60:"),
            (["threshold", "v.8vo", "--class", "1=:20", "--class", "2=20:"],
             "threshold: units real, ranges :20, 2 = 20:"),
            (["components", "m.8vo", "--keep-largest", "1", "--min-mm3", "2"],
             "components: connectivity 6, keep largest 1, min mm3 2"),
            (["transform", "v.8vo", "--rotate", "z:90", "--rotate", "x:180", "--in-place"],
             "transform: rotate z:90,x:180, in place"),
            (["transform", "v.8vo", "--translate", "1,2,-3"],
             "transform: translate, voxels 1,2,-3"),
            (["combine", "m.8vo", "m.8vo", "--xor"], "xor: masks 2"),
            (["dilate", "m.8vo", "--mm", "1.5"], "dilate: mm 1.5"),
        ]:
            self.said(*arguments, "-o", "made.8vo", "-f")
            self.assertEqual(row("made.8vo"), [words])
        self.said("condense", "v.8vo", "--flat", "7", "-o", "flat.8vo")
        self.assertIn("grey, condensed, not lossless\n", self.said("info", "flat.8vo").stdout)

    def rows(self, name, begin):
        lines = self.said("info", name).stdout.splitlines()
        return [line[15:] for line in lines if line.startswith(f"  {begin:<12} ")]

    def test_info_lists_parts_and_extensions(self):
        golden = ROOT / "tests" / "golden" / "v1"
        self.assertEqual(self.rows(golden / "parts.8vo", "part"), [
            "Xnot, 32 bytes: unknown to this program, stands for itself",
            "Xvox, 3.02 kB: unknown to this program, follows from the voxels",
            "Xmet, 27 bytes: unknown to this program, follows from the rest of the file",
            "Xall, 15 bytes: unknown to this program, follows from the voxels, follows from the "
            "rest of the file",
            "Xnot, 15 bytes: unknown to this program, stands for itself"])
        info = self.info(golden / "parts.8vo")
        self.assertEqual(info["parts"][1], {
            "tag": "Xvox", "bytes": 3015, "known": False, "required": False,
            "follows_from_voxels": True, "follows_from_rest": False})
        self.assertEqual(info["unknown_extensions"], [])
        info = self.info(golden / "thumbnail.8vo")
        self.assertEqual([(part["tag"], part["known"]) for part in info["parts"]], [("thmb", True)])
        self.assertEqual(len(self.rows(golden / "thumbnail.8vo", "part")), 1)
        self.assertEqual(self.rows("v.8vo", "part") + self.info("v.8vo")["parts"], [])

        data = (self.folder / "v.8vo").read_bytes()
        header = bytearray(data[:512])
        header[330:338] = bytes([1, 0, 0x01, 0x7f, 2, 0, 0xaa, 0xbb])
        between, trailer = data[512:-TRAILER_LENGTH], bytearray(data[-TRAILER_LENGTH:])
        (self.folder / "x.8vo").write_bytes(sealed(header, between, trailer))
        self.assertEqual(self.rows("x.8vo", "extension"),
                         ["0x7f01, 2 bytes: unknown to this program"])
        self.assertEqual(self.info("x.8vo")["unknown_extensions"], [{"tag": "0x7f01", "bytes": 2}])

    def test_info_says_who_coded_the_voxels(self):
        own = {"name": "octavo", "revision": 1}
        self.assertEqual(self.info("v.8vo")["written_by"], own)
        self.assertEqual(self.rows("v.8vo", "coded by"), ["octavo, revision 1"])
        data = (self.folder / "v.8vo").read_bytes()
        text = json.dumps({"coding": {"preset": "fast"},
                           "written_by": {"name": "other\n", "revision": 7}}).encode()
        (self.folder / "x.8vo").write_bytes(with_metadata(data, text))
        self.assertIn("  coded by     other\\x0a, revision 7\n", self.said("info", "x.8vo").stdout)
        # Bricks that are copied stay as they were coded.
        self.said("transform", "x.8vo", "--translate", "1,2,3", "-o", "moved.8vo")
        self.assertEqual(self.info("moved.8vo")["written_by"]["revision"], 7)
        self.assertEqual(self.info("moved.8vo")["metadata"]["coding"], {"preset": "fast"})
        for arguments in (["build", "x.8vo"], ["transform", "x.8vo", "--mirror", "x", "--in-place"],
                          ["threshold", "x.8vo", "--range", "30:"],
                          ["condense", "x.8vo", "--flat", "1"]):
            self.said(*arguments, "-o", "made.8vo", "-f")
            self.assertEqual(self.info("made.8vo")["written_by"], own, arguments)
            self.assertNotIn("revision\": 7", json.dumps(self.info("made.8vo")), arguments)
        (self.folder / "x.8vo").write_bytes(with_metadata(data, b"{}"))
        self.assertIsNone(self.info("x.8vo")["written_by"])
        self.assertNotIn("coded by", self.said("info", "x.8vo").stdout)

    def test_codes_says_what_the_cube_itself_is(self):
        voxels = [0] * 64
        for at in (0, 1, 4, 5, 16, 17, 20, 21):
            voxels[at] = 1
        voxels[2] = 5
        self.build("c.8vo", voxels, "uint8", "B", "--labels", size=(4, 4, 4))
        for cube, notation, first, kind in [
            ("08", "mixed", "08: level 1, side 2; a leaf of value 1",
             {"kind": "leaf", "level": 1, "code": "08", "value": 1}),
            ("03", "mixed", "03: level 0, side 1; part of the leaf 08 of level 1 and value 1",
             {"kind": "leaf", "level": 1, "code": "08", "value": 1}),
            ("2", "linear", "2: level 1, side 2; divided into smaller leaves", {"kind": "smaller"}),
            ("78", "mixed", "78: level 1, side 2; background", {"kind": "background"}),
            ("-", "mixed", "88: level 2, side 4; divided into smaller leaves",
             {"kind": "smaller"}),
            ("-", "linear", "-: level 2, side 4; divided into smaller leaves",
             {"kind": "smaller"}),
        ]:
            asked = ["codes", "c.8vo", "--neighbors", cube, "--notation", notation]
            self.assertEqual(self.said(*asked).stdout.splitlines()[0], first)
            self.assertEqual(json.loads(self.said(*asked, "--json").stdout)["cube"], kind)

    def test_leaves_and_components_count_against_the_limit_of_memory(self):
        # A checkerboard: every other voxel is a leaf, and a component, of its own.
        size = (64, 64, 32)
        voxels = [(x + y + z) % 2 for z in range(size[2]) for y in range(size[1])
                  for x in range(size[0])]
        self.build("b.8vo", voxels, "uint8", "B", "--labels", size=size)
        self.expect_error(6, ["the octree would take about", "the limit is 1024 KiB"], "codes",
                          "b.8vo", "--max-memory", "1M")
        self.said("codes", "b.8vo", "--list", "--max-memory", "8M")
        told = self.expect(6, "codes", "b.8vo", "--list", "--json", "--max-memory", "8M")
        self.assertIn("the list of leaves would take", told.stderr)
        self.expect_error(6, ["the components would take about"], "components", "b.8vo",
                          "--max-memory", "8M")
        self.said("components", "b.8vo", "--max-memory", "40M")
        told = self.expect(6, "components", "b.8vo", "--json", "--max-memory", "40M")
        self.assertIn("the table of components would take", told.stderr)

    def test_layers_of_bricks_count_against_the_limit_of_memory(self):
        self.expect(0, "phantom", "--size", "200,200,80", "-o", "p.8vo", "-q")
        kept = self.files()
        for arguments in [["export", "p.8vo", "-o", "p.raw"],
                          ["compare", "p.8vo", "p.8vo", "--voxels"], ["verify", "p.8vo"],
                          ["codes", "p.8vo", "--range", "0:"]]:
            self.expect_error(6, ["would take about", "the limit is 4096 KiB"], *arguments,
                              "--max-memory", "4M")
            self.assertEqual(self.files(), kept)
            self.said(*arguments, "--max-memory", "100M")
            kept = self.files()

    def test_options_that_would_change_nothing_are_rejected(self):
        for words, arguments in [
            (["v.8vo: is an .8vo file", "--spacing changes nothing in it"],
             ["verify", "v.8vo", "--spacing", "3"]),
            (["--raw changes nothing in it"], ["verify", "v.8vo", "--raw", "9,9,9,uint8"]),
            (["--list goes with --counts under --json"], ["codes", "m.8vo", "--list", "--counts"]),
            (["the max error must not be negative"],
             ["compare", "v.8vo", "v.8vo", "--max-error", "-1"]),
        ]:
            self.expect_error(2, words, *arguments)
        both = json.loads(self.said("codes", "m.8vo", "--list", "--counts", "--json").stdout)
        self.assertTrue(both["labels"] and both["codes"])

    def test_a_table_without_regions_has_its_columns(self):
        self.build("none.8vo", block(0, 0), "uint8", "B", "--labels")
        for options in [[], ["--of", "v.8vo"], ["--of", "v.8vo", "--percentile", "10"]]:
            head = self.said("measure", "m.8vo", "--csv", *options).stdout.splitlines()[0]
            table = self.said("measure", "none.8vo", "--csv", *options).stdout
            self.assertEqual(table, head + "\n")

    def test_more_threads_than_cores_are_started_without_a_word(self):
        threads = str(min(64, 4 * (os.cpu_count() or 1) + 3))
        for arguments in [
            ["build", "in.raw", "--raw", ",".join(map(str, SIZE)) + ",uint8", "--spacing", "1",
             "-o", "j.8vo"],
            ["verify", "v.8vo"],
            ["export", "v.8vo", "-o", "j.nrrd"],
            ["slice", "v.8vo", "-o", "j.png"],
            ["render", "v.8vo", "--range", "30:", "-o", "j.png"],
            ["render", "v.8vo", "--mode", "transparency", "--range", "30:", "--direction", "1,0,0",
             "-o", "j.png"],
            ["threshold", "v.8vo", "--range", "30:", "-o", "j.8vo"],
            ["measure", "m.8vo", "--of", "v.8vo"],
            ["compare", "v.8vo", "v.8vo"],
            ["dilate", "m.8vo", "--voxels", "1", "-o", "j.8vo"],
            ["transform", "v.8vo", "--scale", "2", "-o", "j.8vo"],
        ]:
            with self.subTest(arguments):
                said = self.said(*arguments, "-f", "-q", "-j", threads)
                self.assertEqual(said.stderr, "")

    def test_grids_that_differ_in_their_axes_alone_are_told_by_them(self):
        for name, axes in [("straight", "(1,0,0) (0,1,0)"), ("turned", "(0.8,0.6,0) (-0.6,0.8,0)")]:
            head = ("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspace: LPS\n"
                    f"space directions: {axes} (0,0,1)\nspace origin: (0,0,0)\n\n").encode()
            (self.folder / f"{name}.nrrd").write_bytes(head + bytes([1] * 7 + [0]))
            self.expect(0, "build", f"{name}.nrrd", "--labels", "-o", f"{name}.8vo", "-q")
        self.expect_error(2, ["axes turned by up to 36.8699 degrees"], "touch", "straight.8vo",
                          "turned.8vo")

    def test_windows_and_tissues_in_hu_are_for_grey_values_in_hu(self):
        voxels = struct.pack("<8h", *range(8))
        head = ("NRRD0004\ntype: int16\ndimension: 3\nsizes: 2 2 2\nendian: little\n"
                "encoding: raw\nspacings: 1 1 1\n\n").encode()
        (self.folder / "n.nrrd").write_bytes(head + voxels)
        self.expect(0, "build", "n.nrrd", "-o", "n.8vo", "-q")
        (self.folder / "gy.tif").write_bytes(tiff({270: "ImageJ=1.53t\nvunit=Gy\n"}))
        self.expect(0, "build", "gy.tif", "-o", "gy.8vo", "-q")
        for arguments in [["slice", "n.8vo", "--window", "bone", "-o", "n.png"],
                          ["threshold", "n.8vo", "--tissue", "air", "--range", "3:", "-o",
                           "n2.8vo"],
                          ["render", "n.8vo", "--tissue", "soft", "-o", "n3.png"],
                          ["render", "n.8vo", "--mode", "transparency", "--tissue", "soft", "-o",
                           "n4.png", "--direction", "1,0,0"]]:
            with self.subTest(arguments):
                told = self.said(*arguments).stderr
                self.assertIn("warning: n.8vo: its unit is not known; ", told)
                self.assertEqual(told.count("its unit is not known"), 1)
                self.expect_error(7, ["its unit is not known"], *arguments, "--strict",
                                           "-f")
        for words, arguments in [
            (["octavo: m.8vo: a window goes with grey values; this file holds labels"],
             ["slice", "m.8vo", "--window", "bone", "-o", "s.png"]),
            (["octavo: m.8vo: the tissue bone is in HU", "this volume holds labels"],
             ["threshold", "m.8vo", "--tissue", "bone", "-o", "x.8vo"]),
            (["octavo: gy.8vo: the tissue bone is in HU, and this volume is in Gy", "--range"],
             ["render", "gy.8vo", "--tissue", "bone", "-o", "x.png"]),
            (["octavo: gy.8vo: the tissue bone is in HU, and this volume is in Gy", "--range"],
             ["render", "gy.8vo", "--mode", "transparency", "--tissue", "bone", "-o", "x.png",
              "--direction", "1,0,0"]),
            (["octavo: gy.8vo: the window bone is in HU, and this volume is in Gy", "--window"],
             ["slice", "gy.8vo", "--window", "bone", "-o", "x.png"]),
            (["octavo: m.8vo: holds labels, not grey values"],
             ["measure", "m.8vo", "--of", "m.8vo"]),
        ]:
            with self.subTest(arguments):
                self.expect_error(2, words, *arguments)
        told = self.said("slice", "--help").stdout
        for name in ["brain", "stroke", "bone", "lung", "mediastinum", "abdomen", "liver"]:
            self.assertIn(name, told)

    def test_a_mask_of_which_nothing_is_left_is_told_of(self):
        (self.folder / "away.txt").write_text("1 0 0 0\n0 1 0 -17\n0 0 1 0\n0 0 0 1\n")
        for told, arguments in [
            ("x.8vo: is empty; no voxel of m.8vo is left", ["erode", "m.8vo", "--voxels", "9"]),
            ("m.8vo: a shift by 0,-18,0 moves all of its 20 x 18 x 12 voxels out of the grid",
             ["transform", "m.8vo", "--shift", "0,-18,0"]),
            ("x.8vo: is empty; no labeled voxel of m.8vo is left in the grid",
             ["transform", "m.8vo", "--shift", "0,-17,0"]),
            ("x.8vo: is empty; no labeled voxel of m.8vo is left in the grid",
             ["transform", "m.8vo", "--affine", "away.txt"]),
        ]:
            self.expect_error(7, [told], *arguments, "-o", "x.8vo", "--strict")
            said = self.said(*arguments, "-o", "x.8vo", "-q").stderr
            self.assertEqual(said, f"octavo: warning: {told}\n")
            (self.folder / "x.8vo").unlink()
        self.assertEqual(self.said("erode", "m.8vo", "--voxels", "1", "-o", "x.8vo", "-q").stderr,
                         "")
        self.assertEqual(self.said("transform", "m.8vo", "--shift", "0,-11,0", "-o", "x.8vo",
                                   "-q", "-f").stderr, "")

    def test_files_that_are_not_as_they_should_be_are_told_why(self):
        (self.folder / "empty.8vo").write_bytes(b"")
        self.expect_error(3, ["empty.8vo: not an 8vo file: the file is empty"], "info",
                          "empty.8vo")
        self.expect_error(5, ["its folder does not exist"], "condense", "v.8vo", "--flat", "3",
                          "-o", "nowhere/x.8vo")

    def test_a_volume_is_never_replaced_by_a_picture_or_an_export_of_it(self):
        self.expect(0, "phantom", "--size", "40", "-o", "p.8vo", "-q")
        for name, words in [("t.png", ["slice"]), ("t.png", ["render", "--range", "1:"]),
                            ("t.nrrd", ["export"]), ("t.mha", ["export"]), ("t.nii", ["export"])]:
            with self.subTest(name, words=words):
                before = (self.folder / "p.8vo").read_bytes()
                (self.folder / name).write_bytes(before)
                self.expect_error(2, [f"{name}: is the input itself"], *words, name, "-o", name,
                                  "-f")
                self.assertEqual((self.folder / name).read_bytes(), before)

    def test_one_of_a_kind_is_one(self):
        voxels = [0] * (SIZE[0] * SIZE[1] * SIZE[2])
        voxels[0] = 1
        self.build("one.8vo", voxels, "uint8", "B", "--labels")
        moved = voxels[:]
        moved[0], moved[1] = 0, 1
        self.build("next.8vo", moved, "uint8", "B", "--labels")
        self.assertEqual(self.said("erode", "one.8vo", "--voxels", "0", "-o", "x.8vo").stdout,
                         "x.8vo: 1 voxel, 1 mm3 (before: 1 voxel, 1 mm3)\n")
        touching = self.said("touch", "one.8vo", "next.8vo").stdout
        self.assertIn("touching:   1 voxel of one.8vo alone", touching)
        self.assertIn("in between: 1 face, 1 mm2", touching)
        self.assertIn("one.8vo: 1 component, 1 kept\n", self.said("components", "one.8vo").stdout)
        self.assertIn("pixels", self.said("render", "one.8vo", "-o", "o.png").stdout)
        self.assertIn(", 1 leaf;", self.said("render", "one.8vo", "-o", "o.png", "-f").stdout)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
