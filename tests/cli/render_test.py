#!/usr/bin/env python3
"""Draws pictures as a user does: render and shell.

usage: render_test.py OCTAVO [unittest arguments]

Everything is generated: a block of 40 with a hole of one voxel in its middle, that bears a smaller
block of 90, in a surrounding of 10.
"""

import json
import struct
import sys
import zlib

import cli_test
from png_rows import unfiltered

SIZE = (40, 36, 20)
BLOCK = ((4, 24), (4, 20), (2, 18))
KNOB = ((24, 34), (8, 12), (4, 8))


def scene():
    """Voxels [z][y][x]."""
    voxels = [10] * (SIZE[0] * SIZE[1] * SIZE[2])
    for (xs, ys, zs), value in [(BLOCK, 40), (KNOB, 90)]:
        for z in range(*zs):
            for y in range(*ys):
                for x in range(*xs):
                    voxels[(z * SIZE[1] + y) * SIZE[0] + x] = value
    voxels[(9 * SIZE[1] + 12) * SIZE[0] + 12] = 10
    return voxels


def read_png(path):
    """Width, height and the pixels of an 8-bit RGB file, as rows of tuples."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", body[:10])
            assert (depth, color) == (8, 2)
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    raw, stride = zlib.decompress(packed), 3 * width
    rows, above = [], bytes(stride)
    for y in range(height):
        begin = y * (stride + 1)
        above = unfiltered(raw[begin], raw[begin + 1 : begin + 1 + stride], above, 3)
        rows.append(list(zip(above[::3], above[1::3], above[2::3])))
    return rows


class Pictures(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = scene()
        (self.folder / "v.raw").write_bytes(struct.pack(f"<{len(voxels)}h", *voxels))
        self.build("v.raw", "v.8vo", "int16")

    def build(self, source, name, kind, *options):
        size = ",".join(map(str, SIZE))
        self.expect(0, "build", source, "--raw", f"{size},{kind}", "--spacing", "1,1,2", "-o", name,
                    "--preset", "fast", "-q", *options)

    def render(self, name, *arguments):
        """The result, and the pixels of the picture without writing on it."""
        result = self.expect(0, "render", *arguments, "-o", name, "-f", "--json", "--progress",
                             "none", "--no-scale-bar", "--no-sides", "--no-legend")
        made = json.loads(result.stdout)
        return made, read_png(self.folder / made["outputs"][0])

    def extent(self, rows, background=(0, 0, 0)):
        """The first and last column and row with anything drawn, and how many pixels are."""
        drawn = [(x, y) for y, row in enumerate(rows) for x, p in enumerate(row) if p != background]
        xs, ys = [x for x, _ in drawn], [y for _, y in drawn]
        return min(xs), max(xs), min(ys), max(ys), len(drawn)

    def test_surface_is_the_picture_of_cubes_with_fewer_leaves(self):
        for view in (["--direction", "1,1,1"], ["--direction", "left"], ["--azimuth", "40",
                     "--elevation", "-25", "--zoom", "1.7"]):
            asked = ["v.8vo", "--range", "40:", "--size", "150x120", *view]
            cubes, rows = self.render("c.png", *asked)
            surface, same = self.render("s.png", *asked, "--mode", "surface", "--shade", "flat")
            self.assertEqual(rows, same)
            self.assertEqual(cubes["removed"], 0)
            self.assertEqual(surface["leaves"], cubes["leaves"])
            self.assertGreater(surface["removed"], 0)
            self.assertEqual(surface["drawn"] + surface["removed"], surface["leaves"])
            self.assertEqual(surface["size"], [150, 120])

    def test_objects_are_drawn_true_in_size_and_placed(self):
        made, rows = self.render("f.png", "v.8vo", "--range", "40:", "--direction", "front",
                                 "--size", "200", "--fade", "0")
        left, right, top, bottom, count = self.extent(rows)
        pixel = made["pixel_mm"]
        self.assertAlmostEqual((right - left + 1) * pixel, 30, delta=2 * pixel)  # 4 .. 34
        self.assertAlmostEqual((bottom - top + 1) * pixel, 32, delta=2 * pixel)  # 16 planes of 2 mm
        area = 20 * 32 + 10 * 8
        self.assertAlmostEqual(count * pixel * pixel, area, delta=area / 20)
        # Seen from the front the knob is on the right: x runs to the patient's left.
        self.assertEqual(rows[(top + bottom) // 2][right], (0, 0, 0))
        lowest = bottom - int(8 / pixel)
        self.assertNotEqual(rows[lowest][right - 2], (0, 0, 0))

    def test_the_level_moves_nothing_in_the_picture(self):
        # A corner of 36 x 29 mm that reaches three faces; no side is a multiple of 2.
        size = (53, 45, 49)
        value = lambda x, y, z: min(8 * x - 140, 8 * z - 164)
        values = [value(x, y, z) for z in range(size[2]) for y in range(size[1])
                  for x in range(size[0])]
        # Every value that is a mean of these is there: outside in a row, and deep inside.
        for i in range(21):
            values[i] = 8 * i - 160
        for i in range(34):
            values[(40 * size[1] + 22) * size[0] + 19 + i] = 8 * i + 8
        (self.folder / "w.raw").write_bytes(struct.pack(f"<{len(values)}h", *values))
        self.expect(0, "build", "w.raw", "--raw", "53,45,49,int16", "--spacing", "1,1,1", "-o",
                    "w.8vo", "-q")
        asked = ["w.8vo", "--direction", "front", "--size", "200x170", "--isovalue", "0", "--mode",
                 "iso"]
        for more in ([], ["--perspective", "20"], ["--cut", "z>44"]):
            made, rows = self.render("p.png", *asked, "--level", "0", *more)
            first = self.extent(rows)[:4]
            for level in ("1", "2", "3"):
                coarse, rows = self.render("p.png", *asked, "--level", level, *more)
                self.assertEqual(coarse["level"], int(level))
                self.assertAlmostEqual(coarse["pixel_mm"], made["pixel_mm"], places=12)
                for here, there in zip(self.extent(rows)[:4], first):
                    self.assertLessEqual(abs(here - there), 1, (level, more))
        for mode in ("mip", "volume", "transparency"):
            scales = {self.render("m.png", "w.8vo", "--mode", mode, "--level", level)[0]["pixel_mm"]
                      for level in ("0", "2")}
            self.assertEqual(len(scales), 1, mode)

    def test_ranges_have_colors_of_their_own(self):
        _, one = self.render("a.png", "v.8vo", "--range", "40:", "--size", "100", "--fade", "0")
        made, two = self.render("b.png", "v.8vo", "--range", "40:50", "--range", "30:90", "--size",
                                "100", "--fade", "0")
        shades = lambda rows: {p for row in rows for p in row if p != (0, 0, 0)}
        self.assertEqual(len(shades(one)), 3)
        self.assertEqual(len(shades(two)), 6)
        self.assertEqual(made["masks"], 2)
        self.assertEqual(self.extent(one), self.extent(two))

    def test_ranges_and_labels_take_colors(self):
        labels = [{10: 0, 40: 3, 90: 250}[v] for v in scene()]
        (self.folder / "l.raw").write_bytes(bytes(labels))
        self.build("l.raw", "l.8vo", "uint8", "--labels")
        for name, ranges in [("v.8vo", ["40:50=#00ff00", "60:=#0000ff"]),
                             ("l.8vo", ["3:3=#00ff00", "4:=#0000ff"])]:
            options = [word for text in ranges for word in ("--range", text)]
            _, rows = self.render("c.png", name, *options, "--size", "100", "--fade", "0")
            shades = {p for row in rows for p in row if p != (0, 0, 0)}
            self.assertEqual(len(shades), 6)
            self.assertTrue(all(red == 0 and min(green, blue) == 0 for red, green, blue in shades))

    def test_labels_are_drawn_in_one_pass_and_chosen_by_range(self):
        labels = [{10: 0, 40: 3, 90: 250}[v] for v in scene()]
        (self.folder / "l.raw").write_bytes(bytes(labels))
        self.build("l.raw", "l.8vo", "uint8", "--labels")
        made, rows = self.render("l.png", "l.8vo", "--size", "100", "--fade", "0")
        self.assertEqual(made["masks"], 2)
        self.assertEqual(len({p for row in rows for p in row}), 7)
        made, rows = self.render("l.png", "l.8vo", "--range", "250:", "--size", "100", "--fade",
                                 "0")
        self.assertEqual(made["masks"], 1)
        self.assertEqual(len({p for row in rows for p in row}), 4)

    def test_cuts_take_one_side_away(self):
        def width(*cuts):
            options = [word for cut in cuts for word in ("--cut", cut)]
            made, rows = self.render("k.png", "v.8vo", "--range", "40:", "--direction", "front",
                                     "--size", "200", *options)
            left, right, *_ = self.extent(rows)
            return (right - left + 1) * made["pixel_mm"]

        self.assertAlmostEqual(width(), 30, delta=0.5)
        self.assertAlmostEqual(width("x<14"), 10, delta=0.5)
        self.assertAlmostEqual(width("x>13"), 20, delta=0.5)
        self.assertAlmostEqual(width("x>7", "x<30", "z<12"), 22, delta=0.5)
        result = self.octavo("render", "v.8vo", "--range", "40:", "--cut", "y>30", "-o", "e.png")
        self.assertEqual(result.returncode, 0)
        self.assertIn("empty", result.stderr)

    def test_coarser_levels_keep_their_size(self):
        fine, rows = self.render("0.png", "v.8vo", "--range", "25:", "--size", "160")
        coarse, same = self.render("1.png", "v.8vo", "--range", "25:", "--size", "160", "--level",
                                   "1")
        self.assertLess(coarse["leaves"], fine["leaves"])
        self.assertAlmostEqual(coarse["pixel_mm"], fine["pixel_mm"], delta=0.03)
        for a, b in zip(self.extent(rows), self.extent(same)):
            self.assertAlmostEqual(a, b, delta=max(4, 0.06 * a))

    def test_threads_do_not_change_the_picture(self):
        pictures = []
        for threads in ("1", "3"):
            self.render("t.png", "v.8vo", "--range", "40:", "--threads", threads)
            pictures.append((self.folder / "t.png").read_bytes())
        self.assertEqual(pictures[0], pictures[1])

    def test_turntables_are_numbered_pictures_of_one_scale(self):
        made, first = self.render("turn.png", "v.8vo", "--range", "40:", "--size", "90",
                                  "--direction", "front", "--turntable", "4")
        self.assertEqual(made["outputs"], [f"turn-{i:03}.png" for i in range(4)])
        self.assertFalse((self.folder / "turn.png").exists())
        _, left = self.render("l.png", "v.8vo", "--range", "40:", "--size", "90", "--direction",
                              "left")
        self.assertNotEqual(read_png(self.folder / "turn-001.png"), first)
        heights = set()
        for i in range(4):
            *_, top, bottom, _ = self.extent(read_png(self.folder / f"turn-{i:03}.png"))
            heights.add(bottom - top)
        self.assertEqual(len(heights), 1)

    def test_backgrounds_have_names_and_numbers(self):
        for text, color in [("white", (255, 255, 255)), ("#102030", (16, 32, 48))]:
            _, rows = self.render("b.png", "v.8vo", "--range", "40:", "--size", "64",
                                  "--background", text)
            self.assertEqual(rows[0][0], color)

    def needle(self):
        """Voxels a hundredth of a pixel wide."""
        (self.folder / "n.raw").write_bytes(struct.pack("<300h", *range(50, 350)))
        self.expect(0, "build", "n.raw", "--raw", "1,1,300,int16", "--spacing", "0.1,0.1,2", "-o",
                    "n.8vo", "-q")

    def test_what_is_too_thin_to_be_seen_is_warned_of_where_rays_miss_it(self):
        self.needle()
        for options in (["--mode", "mip"], ["--mode", "minip"], ["--mode", "mean"],
                        ["--mode", "volume"], ["--mode", "iso", "--isovalue", "40"]):
            made, rows = self.render("n.png", "n.8vo", "--direction", "front", "--size", "100",
                                     *options)
            self.assertEqual({p for row in rows for p in row}, {(0, 0, 0)})
            self.assertEqual(made["warnings"], ["n.8vo: no voxel is seen; the picture is empty"])

    def test_cubes_thinner_than_a_pixel_are_a_pixel_wide(self):
        self.needle()
        for options in (["--mode", "cubes"], ["--mode", "surface", "--shade", "flat"],
                        ["--mode", "surface"]):
            made, rows = self.render("n.png", "n.8vo", "--direction", "front", "--size", "100",
                                     "--range", "0:", *options)
            self.assertEqual(made["warnings"], [])
            wide = {sum(p != (0, 0, 0) for p in row) for row in rows[6:94]}
            self.assertEqual(wide, {1})

    def test_voxels_in_the_color_of_the_background_are_told_from_none(self):
        for options in (["--mode", "surface", "--shade", "flat", "--fade", "0"], []):
            made, rows = self.render("n.png", "v.8vo", "--range", "40:=black", *options)
            self.assertEqual({p for row in rows for p in row} - {(0, 0, 0)}, set())
            self.assertEqual(made["warnings"], [
                "v.8vo: the voxels have the color of the background; nothing shows"])

    def test_shell_is_a_mask_of_the_leaves_that_render_draws(self):
        self.expect(0, "threshold", "v.8vo", "--range", "40:", "-o", "m.8vo", "-q")
        made = json.loads(self.expect(0, "shell", "m.8vo", "-o", "s.8vo", "--json").stdout)
        surface, _ = self.render("s.png", "m.8vo", "--mode", "surface", "--size", "64")
        self.assertEqual((made["leaves"], made["kept"], made["removed"]),
                         (surface["leaves"], surface["drawn"], surface["removed"]))
        counted = json.loads(self.expect(0, "codes", "s.8vo", "--counts", "--json").stdout)
        self.assertIn(str(made["kept"]), json.dumps(counted))
        self.assertEqual(self.info("s.8vo")["metadata"]["made_by"]["operation"], "shell")
        told = self.expect(0, "shell", "m.8vo").stdout
        self.assertIn("leaves lie at the surface", told)

    def test_rays_share_their_picture_with_meshes_and_marks(self):
        (self.folder / "plate.obj").write_text(
            "v 0 0 20\nv 39 0 20\nv 39 35 20\nv 0 35 20\nf 1 2 3 4\n")
        rays = ("--mode", "volume", "--direction", "front-top", "--size", "64")
        _, without = self.render("a.png", "v.8vo", *rays)
        _, plate = self.render("b.png", "v.8vo", *rays, "--mesh", "plate.obj=#ff0000:1")
        self.assertNotEqual(plate, without)
        self.assertIn(True, [red > 120 and green < 60 for row in plate for red, green, _ in row])
        _, mark = self.render("c.png", "v.8vo", *rays, "--mark", "20,18,40=knob")
        self.assertNotEqual(mark, without)
        report, _ = self.render("d.png", "v.8vo", *rays, "--time-budget", "1000")
        self.assertTrue(report["is_complete"])
        self.assertEqual(report["passes"][-1]["level"], report["level"])
        told = self.expect(0, "render", "v.8vo", *rays, "--transfer", "skin", "--time-budget",
                           "1000", "-o", "e.png").stderr
        self.assertEqual(told.count("its unit is not known"), 1, told)

    def test_rays_see_masks_and_labels_and_refine(self):
        labels = [{10: 0, 40: 3, 90: 250}[v] for v in scene()]
        (self.folder / "l.raw").write_bytes(bytes(labels))
        self.build("l.raw", "l.8vo", "uint8", "--labels")
        rays = ("--mode", "volume", "--direction", "front-top", "--size", "64")
        _, whole = self.render("a.png", "v.8vo", *rays)
        _, labeled = self.render("b.png", "v.8vo", *rays, "--labels", "l.8vo", "--label", "3",
                                 "--label-look", "3=#ff0000:0.8", "--label-look", "other=none")
        seen = [p for row in labeled for p in row if max(p) > 20]
        self.assertTrue(seen)
        self.assertTrue(all(p[0] > p[1] + 10 or min(p) > 150 for p in seen), seen[:9])
        _, masked = self.render("c.png", "v.8vo", *rays, "--mask", "l.8vo")
        self.assertNotEqual(masked, labeled)
        for option in ("--adaptive", "--smooth-edges"):
            _, refined = self.render("d.png", "v.8vo", *rays, option)
            self.assertEqual(len(refined), len(whole))
        self.expect_error(2, ["--label-look", "LABEL=COLOR"], "render", "v.8vo", *rays,
                          "--labels", "l.8vo", "--label-look", "3", "-o", "x.png")
        self.expect_error(2, ["--labels FILE"], "render", "v.8vo", *rays, "--label-look",
                          "3=red", "-o", "x.png")

    def test_rays_take_no_value_from_what_cuts_take_away(self):
        voxels = [200 if x == 20 else 10 for _ in range(SIZE[2] * SIZE[1]) for x in range(SIZE[0])]
        (self.folder / "p.raw").write_bytes(struct.pack(f"<{len(voxels)}h", *voxels))
        self.build("p.raw", "p.8vo", "int16")
        rays = ("--mode", "mip", "--window", "10,400", "--azimuth", "60", "--size", "96")
        for cut, greys in (((), {128, 249}), (("--cut", "x<20"), {128}),
                           (("--cut", f"20:21,0:{SIZE[1]},0:{SIZE[2]}"), {128})):
            _, rows = self.render("m.png", "p.8vo", *rays, *cut)
            seen = {p[0] for row in rows for p in row} - {0}
            self.assertEqual({min(seen), max(seen)}, greys, cut)

    def test_an_animation_is_one_file(self):
        self.expect(0, "render", "v.8vo", "--range", "40:", "--size", "64", "--turntable", "3",
                    "--grow", "-o", "turn.apng", "-q")
        self.expect(0, "render", "v.8vo", "--range", "40:", "--size", "64", "--turntable", "3",
                    "-o", "turn.webp", "-q")
        self.assertEqual((self.folder / "turn.webp").read_bytes().count(b"ANMF"), 3)
        self.assertEqual((self.folder / "turn.apng").read_bytes().count(b"fcTL"), 3)
        self.assertFalse((self.folder / "turn-000.png").exists())

    def test_errors_name_the_reason_and_leave_nothing(self):
        self.expect(0, "threshold", "v.8vo", "--range", "7:", "-o", "l.8vo", "-q")
        before = self.files()
        for code, words, arguments in [
            (2, ["v.8vo", "--range", "--tissue"], ["v.8vo"]),
            (2, ["HU", "holds labels"], ["l.8vo", "--tissue", "bone"]),
            (2, ["LOW:HIGH"], ["v.8vo", "--range", "7"]),
            (2, ["--direction", "front"], ["v.8vo", "--range", "7:", "--direction", "up"]),
            (2, ["step"], ["v.8vo", "--range", "7:", "--direction", "0,0,0"]),
            (2, ["--size"], ["v.8vo", "--range", "7:", "--size", "1x2x3"]),
            (2, ["16384"], ["v.8vo", "--range", "7:", "--size", "20000"]),
            (2, ["#rrggbb"], ["v.8vo", "--range", "7:", "--background", "#12"]),
            (2, ["--cut", "x<120"], ["v.8vo", "--range", "7:", "--cut", "w<3"]),
            (2, ["0 to 39"], ["v.8vo", "--range", "7:", "--cut", "x<40"]),
            (2, ["no voxel"], ["v.8vo", "--range", "7:", "--cut", "x<4", "--cut", "x>9"]),
            (2, ["level"], ["v.8vo", "--range", "7:", "--level", "77"]),
            (2, ["z = 0:99"], ["v.8vo", "--range", "7:", "--cut", "0:4,0:4,0:99"]),
            (2, ["--cut", "x0:x1"], ["v.8vo", "--range", "7:", "--cut", "0:4"]),
            (2, ["--mode volume or iso"], ["v.8vo", "--range", "7:", "--mesh", "m.ply"]),
            (2, [".stl, .ply or .obj", "--mesh"],
             ["v.8vo", "--mode", "volume", "--mesh", "v.raw=red:0.5"]),
            (5, ["m.ply"], ["v.8vo", "--mode", "volume", "--mesh", "m.ply"]),
            (2, ["--mesh", "'reddish'", "#rrggbb"],
             ["v.8vo", "--mode", "volume", "--mesh", "l.8vo=reddish"]),
            (2, ["--mark"], ["v.8vo", "--mode", "volume", "--mark", "1,2"]),
            (2, ["--turntable"], ["v.8vo", "--mode", "volume", "--grow"]),
            (2, ["--time-budget"], ["v.8vo", "--range", "7:", "--time-budget", "3"]),
            (2, ["--shadows"], ["v.8vo", "--mode", "mip", "--shadows"]),
            (6, ["zoom"], ["v.8vo", "--range", "7:", "--zoom", "1e12"]),
            (5, ["missing.8vo"], ["missing.8vo"]),
        ]:
            self.expect_error(code, words, "render", *arguments, "-o", "x.png")
            self.assertEqual(self.files(), before)
        self.expect_error(2, [".png"], "render", "v.8vo", "--range", "7:", "-o", "x.gif")
        (self.folder / "x-001.png").write_bytes(b"mine")
        self.expect_error(5, ["x-001.png", "exists"], "render", "v.8vo", "--range", "7:", "-o",
                          "x.png", "--turntable", "3")
        self.assertEqual((self.folder / "x-001.png").read_bytes(), b"mine")
        self.expect_error(2, ["octavo threshold"], "shell", "v.8vo", "-o", "x.8vo")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
