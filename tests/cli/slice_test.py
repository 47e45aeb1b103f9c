#!/usr/bin/env python3
"""Draws slices, oblique sections, montages and overlays as a user does.

usage: slice_test.py OCTAVO [unittest arguments]

Everything is generated: a ramp along x with a block in it, the block's mask, and labels with names.
"""

import json
import struct
import sys

import cli_test
from render_test import read_png

SIZE = (40, 36, 24)
BARE = ["--no-scale-bar", "--no-sides", "--no-notes", "--no-legend"]


def inside(x, y, z):
    return 10 <= x < 30 and 8 <= y < 28 and 4 <= z < 20


def voxels(value):
    return [value(x, y, z) for z in range(SIZE[2]) for y in range(SIZE[1]) for x in range(SIZE[0])]


class Slices(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        ramp = voxels(lambda x, y, z: 10 * x + (500 if inside(x, y, z) else 0))
        (self.folder / "v.raw").write_bytes(struct.pack(f"<{len(ramp)}h", *ramp))
        self.build("v.raw", "v.8vo", "int16")
        mask = voxels(lambda x, y, z: int(inside(x, y, z)))
        (self.folder / "m.raw").write_bytes(bytes(mask))
        self.build("m.raw", "m.8vo", "uint8", "--labels")

    def build(self, source, name, kind, *options, spacing="1,1,2"):
        size = ",".join(map(str, SIZE))
        self.expect(0, "build", source, "--raw", f"{size},{kind}", "--spacing", spacing, "-o", name,
                    "--preset", "fast", "-q", *options)

    def slice(self, *arguments):
        result = self.expect(0, "slice", *arguments, "-o", "s.png", "-f", "--json", "--progress",
                             "none")
        return json.loads(result.stdout)["slices"][0]

    def pixels(self):
        return read_png(self.folder / "s.png")

    def size(self):
        return struct.unpack(">II", (self.folder / "s.png").read_bytes()[16:24])

    def test_a_plane_along_the_grid_is_the_slice(self):
        made = self.slice("v.8vo", "--index", "12", "--size", "1", "--window", "400,900",
                          *BARE)
        self.assertEqual((made["axis"], made["index"], made["plane"]), ("z", 12, None))
        straight = (self.folder / "s.png").read_bytes()
        made = self.slice("v.8vo", "--plane", "3,4,24,0,0,-7", "--size", "1", "--window",
                          "400,900", *BARE)
        self.assertEqual((self.folder / "s.png").read_bytes(), straight)
        self.assertEqual(made["plane"], {"point_mm": [3, 4, 24], "normal": [0, 0, -7]})
        self.assertIsNone(made["axis"])
        middle = self.slice("v.8vo", "--plane", "1,0,1")
        self.assertEqual(middle["plane"]["point_mm"], [19.5, 17.5, 23])
        told = self.expect(0, "slice", "v.8vo", "--plane=-1,0,2", "-o", "s.png", "-f").stdout
        self.assertIn("section through 19.5, 17.5, 23 mm, normal -1, 0, 2", told)

    def test_warnings_stand_in_the_result(self):
        def warnings(overlay):
            made = self.expect(0, "slice", "v.8vo", "--overlay", overlay, "-o", "s.png", "-f",
                               "--json", "--progress", "none")
            return json.loads(made.stdout)["warnings"]

        self.assertEqual(warnings("m.8vo"), [])
        self.expect(0, "transform", "m.8vo", "--translate", "0,0,500", "-o", "far.8vo", "-q")
        self.assertEqual(warnings("far.8vo"), ["far.8vo: lies beside what is drawn of v.8vo"])

    def test_voxels_too_flat_for_a_picture_are_rejected(self):
        self.build("v.raw", "flat.8vo", "int16", spacing="1e-9,1,1")
        self.expect_error(2, ["too flat"], "slice", "flat.8vo", "-o", "x.png")
        self.expect_error(2, ["too flat"], "slice", "flat.8vo", "--plane", "1,1,0", "-o", "x.png")

    def test_montages_hold_many_slices(self):
        made = self.slice("v.8vo", "--montage", "3x2")
        self.assertEqual(made["indices"], [2, 6, 10, 14, 18, 22])
        self.assertIsNone(made["index"])
        made = self.slice("v.8vo", "--every", "6", "--axis", "x")
        self.assertEqual(made["indices"], [2, 8, 14, 20, 26, 32, 38])
        made = self.slice("v.8vo", "--montage", "2x2", "--every", "3", "--index", "8")
        self.assertEqual(made["indices"], [4, 7, 10, 13])
        self.assertEqual(self.size(), (made["width"], made["height"]))
        told = self.expect(0, "slice", "v.8vo", "--montage", "4x1", "-o", "s.png", "-f").stdout
        self.assertIn("4 slices z = 3 to 21 of level 0", told)

    def test_masks_are_drawn_as_outlines_or_washes(self):
        bare = ["v.8vo", "--size", "1", "--window", "400,900", *BARE]
        self.slice(*bare)
        self.assertEqual((self.folder / "s.png").read_bytes()[25], 0)  # grey
        self.slice(*bare, "--overlay", "m.8vo", "--overlay-color", "#ff0000")
        rows = self.pixels()
        for y in range(SIZE[1]):
            for x in range(SIZE[0]):
                edge = inside(x, y, 12) and (x in (10, 29) or y in (8, 27))
                self.assertEqual(rows[y][x] == (255, 0, 0), edge, (x, y))
        self.slice(*bare, "--overlay", "m.8vo", "--overlay-as", "wash", "--overlay-color",
                   "#ff0000", "--overlay-opacity", "1")
        rows = self.pixels()
        for y in range(SIZE[1]):
            for x in range(SIZE[0]):
                self.assertEqual(rows[y][x] == (255, 0, 0), inside(x, y, 12))

    def test_grey_values_are_drawn_as_isolines_with_their_values(self):
        bare = ["v.8vo", "--size", "400", "--window", "400,900", *BARE]
        self.slice(*bare, "--overlay", "v.8vo", "--overlay-levels", "105,325", "--overlay-color",
                   "#00ff00")
        rows = self.pixels()
        green = [x for x, p in enumerate(rows[10]) if p[1] > 180 and max(p[0], p[2]) < 60]
        # Between voxels of 100 and 110 at 10.5, in the middle of 10 pixels each; 320 and 330.
        self.assertTrue(green)
        for x in green:
            self.assertTrue(abs(x - 109.5) < 4 or abs(x - 329.5) < 4, x)
        self.slice(*bare, "--overlay", "v.8vo", "--overlay-as", "wash", "--overlay-levels",
                   "200,400")
        grey = [p[0] == p[1] == p[2] for p in self.pixels()[10]]
        self.assertTrue(all(grey[:195]) and not any(grey[210:]))

    def test_several_overlays_have_options_in_their_order(self):
        bare = ["v.8vo", "--size", "1", "--window", "400,900", *BARE]
        self.slice(*bare, "--overlay", "m.8vo", "--overlay-as", "wash", "--overlay-opacity", "1",
                   "--overlay-color", "#00ff00", "--overlay", "m.8vo", "--overlay-as", "outline",
                   "--overlay-opacity", "1", "--overlay-color", "#ff0000")
        rows = self.pixels()
        self.assertEqual(rows[8][15], (255, 0, 0))
        self.assertEqual(rows[15][15], (0, 255, 0))

    def test_levels_are_those_of_grey_overlays(self):
        bare = ["v.8vo", "--size", "400", "--window", "400,900", *BARE]
        lines = ["--overlay", "v.8vo", "--overlay-levels", "105,325"]
        self.slice(*bare, "--overlay", "m.8vo", *lines)
        both = (self.folder / "s.png").read_bytes()
        self.slice(*bare, "--overlay", "m.8vo", "--overlay-levels", "none", *lines)
        self.assertEqual((self.folder / "s.png").read_bytes(), both)
        self.slice(*bare, "--overlay", "m.8vo", "--overlay", "v.8vo")
        self.assertNotEqual((self.folder / "s.png").read_bytes(), both)
        self.slice(*bare, "--overlay", "m.8vo")
        self.assertNotEqual((self.folder / "s.png").read_bytes(), both)
        self.expect_error(2, ["levels", "grey"], "slice", *bare, "--overlay", "m.8vo",
                          "--overlay-levels", "5", "-o", "x.png")

    def test_an_overlay_that_lies_elsewhere_is_warned_of(self):
        self.expect(0, "transform", "m.8vo", "--translate-mm", "500,0,0", "-o", "far.8vo", "-q")
        told = self.expect(0, "slice", "v.8vo", "--overlay", "far.8vo", "-o", "s.png")
        self.assertIn("far.8vo: lies beside what is drawn of v.8vo", told.stderr)

    def test_an_overlay_of_nan_does_not_lie_elsewhere(self):
        hollow = voxels(lambda x, y, z: 5.0 if z < 3 else float("nan"))
        (self.folder / "n.raw").write_bytes(struct.pack(f"<{len(hollow)}f", *hollow))
        self.build("n.raw", "n.8vo", "float32")
        for look in ("isolines", "wash"):
            said = self.expect(0, "slice", "v.8vo", "--overlay", "n.8vo", "--overlay-as", look,
                               "-o", "s.png", "-f", "--index", "12")
            self.assertEqual(said.stderr, "")

    def test_a_volume_without_a_number_is_warned_of(self):
        gaps = [float("nan"), float("inf")] * (len(voxels(lambda x, y, z: 0)) // 2)
        for name, values in (("none", gaps), ("some", [5.0, *gaps[1:]])):
            (self.folder / f"{name}.raw").write_bytes(struct.pack(f"<{len(values)}f", *values))
            self.build(f"{name}.raw", f"{name}.8vo", "float32")
        told = self.expect(0, "slice", "none.8vo", "-o", "s.png", "-f")
        self.assertIn("none.8vo: every voxel is NaN or infinite; nothing of it is drawn",
                      told.stderr)
        self.expect(7, "slice", "none.8vo", "-o", "t.png", "--strict")
        self.assertFalse((self.folder / "t.png").exists())
        self.assertEqual(self.expect(0, "slice", "some.8vo", "-o", "s.png", "-f").stderr, "")

    def test_help_says_what_all_axes_go_without(self):
        said = self.expect(0, "slice", "--help").stdout
        self.assertEqual(said.count("not with --axis all"), 2)
        for place in (["--mm", "5"], ["--index", "3"]):
            told = self.expect(2, "slice", "v.8vo", "--axis", "all", *place, "-o", "a.png")
            self.assertIn("goes with one axis", told.stderr)

    def test_what_is_written_can_be_left_out(self):
        pictures = set()
        for options in [[], BARE, *[[option] for option in BARE]]:
            self.slice("v.8vo", "--overlay", "m.8vo", *options)
            pictures.add((self.folder / "s.png").read_bytes())
        # The place of a raw file is not known: there are no sides to leave out.
        self.assertEqual(len(pictures), 5)

    def test_threads_do_not_change_the_picture(self):
        pictures = set()
        for threads in ("1", "3"):
            self.slice("v.8vo", "--plane", "1,2,3", "--overlay", "m.8vo", "--overlay", "v.8vo",
                       "--threads", threads)
            pictures.add((self.folder / "s.png").read_bytes())
        self.assertEqual(len(pictures), 1)

    def test_errors_name_the_reason_and_leave_nothing(self):
        before = self.files()
        for words, arguments in [
            (["--plane", "NX,NY,NZ"], ["--plane", "1,2"]),
            (["--plane", "x"], ["--plane", "1,2,x"]),
            (["--plane", "normal", "not 0", "direction"], ["--plane", "0,0,0"]),
            (["--window: 'foo'", "CENTER,WIDTH", "brain"], ["--window", "foo"]),
            (["0 x 3", "change --montage"], ["--montage", "0x3"]),
            (["does not meet"], ["--plane", "0,0,900,0,0,1"]),
            (["--plane", "--index"], ["--plane", "0,0,1", "--index", "3"]),
            (["--plane", "--axis"], ["--plane", "0,0,1", "--axis", "all"]),
            (["--plane", "--axis"], ["--plane", "0,0,1", "--axis", "y"]),
            (["--montage", "4x3"], ["--montage", "4"]),
            (["100 slices of 24"], ["--montage", "10x10"]),
            (["--every", "1"], ["--every", "0"]),
            (["no room"], ["--montage", "3x3", "--every", "9"]),
            (["--overlay-as", "--overlay"], ["--overlay-as", "wash"]),
            (["--overlay-color", "2 for 1"], ["--overlay", "m.8vo", "--overlay-color", "red",
                                              "--overlay-color", "red"]),
            (["--overlay-color", "#rrggbb"], ["--overlay", "m.8vo", "--overlay-color", "reddish"]),
            (["m.8vo", "outline or wash"], ["--overlay", "m.8vo", "--overlay-as", "isolines"]),
            (["v.8vo", "isolines or wash"], ["--overlay", "v.8vo", "--overlay-as", "outline"]),
            (["levels"], ["--overlay", "v.8vo", "--overlay-levels", "5,3"]),
            (["--overlay-opacity", "0 to 1"], ["--overlay", "m.8vo", "--overlay-opacity", "3"]),
        ]:
            self.expect_error(2, words, "slice", "v.8vo", *arguments, "-o", "x.png")
            self.assertEqual(self.files(), before)
        self.expect_error(5, ["none.8vo"], "slice", "v.8vo", "--overlay", "none.8vo", "-o", "x.png")
        self.expect_error(6, ["raise the limit"], "slice", "v.8vo", "--size", "8192",
                          "--max-memory", "20M", "-o", "x.png")
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
