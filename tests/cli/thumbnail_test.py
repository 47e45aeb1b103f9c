#!/usr/bin/env python3
"""The small picture in a file: built, shown, kept by what writes the volume again.

usage: thumbnail_test.py OCTAVO [unittest arguments]

Everything is generated. Pictures are read with a decoder of a few lines, which takes what a
thumbnail may hold and nothing else.
"""

import struct
import sys
import zlib

import cli_test

SIZE = (40, 30, 24)


def pixels_of(png):
    """Width, height and rows of a PNG without filters."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(png):
        length, name = struct.unpack_from(">I4s", png, at)
        data = png[at + 8 : at + 8 + length]
        assert zlib.crc32(name + data) == struct.unpack_from(">I", png, at + 8 + length)[0]
        chunks[name], at = data, at + 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, depth, color, *rest = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert (depth, rest) == (8, [0, 0, 0])
    bytes_per_row = 1 + width * {0: 1, 2: 3}[color]
    rows = zlib.decompress(chunks[b"IDAT"])
    assert len(rows) == height * bytes_per_row
    rows = [rows[i : i + bytes_per_row] for i in range(0, len(rows), bytes_per_row)]
    assert not any(row[0] for row in rows)
    return width, height, [row[1:] for row in rows]


class Thumbnails(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = bytes(5 * x + z for z in range(24) for y in range(30) for x in range(40))
        (self.folder / "v.raw").write_bytes(voxels)
        self.layout = ["--raw", ",".join(map(str, SIZE)) + ",uint8", "--spacing", "1,1,2"]

    def build(self, name, *options):
        self.expect(0, "build", "v.raw", *self.layout, *options, "-o", name, "-q", "-f")

    def thumbnail(self, name):
        self.expect(0, "info", name, "--thumbnail", "out.png", "-f")
        return (self.folder / "out.png").read_bytes()

    def test_is_built_only_where_asked_for_and_the_same_either_way(self):
        self.build("a.8vo", "--thumbnail")
        self.build("b.8vo")
        self.assertGreater(self.info("a.8vo")["thumbnail_bytes"], 0)
        self.assertEqual(self.info("b.8vo")["thumbnail_bytes"], 0)
        self.assertIn("thumbnail", self.expect(0, "info", "a.8vo").stdout)
        self.assertNotIn("thumbnail", self.expect(0, "info", "b.8vo").stdout)
        png = self.thumbnail("a.8vo")
        self.assertEqual(png, self.thumbnail("b.8vo"))
        self.assertIn(png, (self.folder / "a.8vo").read_bytes())
        width, height, rows = pixels_of(png)
        self.assertEqual((width, height), (40, 48))
        self.assertLess(rows[0][0], rows[0][39])
        self.assertGreater(rows[0][20], rows[47][20])
        self.expect(0, "verify", "a.8vo")

    def test_of_labels_has_colors(self):
        self.build("a.8vo", "--thumbnail", "--labels")
        width, _, rows = pixels_of(self.thumbnail("a.8vo"))
        self.assertEqual(len(rows[0]), 3 * width)
        self.assertGreater(len({bytes(row[i : i + 3]) for row in rows
                                for i in range(0, len(row), 3)}), 50)

    def test_goes_along_where_the_volume_is_moved(self):
        self.build("a.8vo", "--thumbnail")
        before = self.thumbnail("a.8vo")
        for steps, is_same in [(["--translate-mm", "1,2,3"], True),
                               (["--rotate", "z:90"], True),
                               (["--mirror", "x", "--in-place"], False)]:
            self.expect(0, "transform", "a.8vo", *steps, "-o", "moved.8vo", "-q", "-f")
            self.assertGreater(self.info("moved.8vo")["thumbnail_bytes"], 0, steps)
            self.expect(0, "verify", "moved.8vo")
            self.assertEqual(self.thumbnail("moved.8vo") == before, is_same, steps)
        self.build("plain.8vo")
        self.expect(0, "transform", "plain.8vo", "--mirror", "x", "-o", "moved.8vo", "-q", "-f")
        self.assertEqual(self.info("moved.8vo")["thumbnail_bytes"], 0)

    def test_of_masks_goes_along_as_well(self):
        self.expect(0, "build", "v.raw", *self.layout, "-o", "v.8vo", "-q")
        self.expect(0, "threshold", "v.8vo", "--range", "90:", "-o", "m.8vo", "-q")
        self.expect(0, "build", "m.8vo", "--thumbnail", "-o", "mask.8vo", "-q")
        self.expect(0, "transform", "mask.8vo", "--rotate", "z:90", "-o", "moved.8vo", "-q")
        self.assertGreater(self.info("moved.8vo")["thumbnail_bytes"], 0)
        self.expect(0, "verify", "moved.8vo")

    def test_is_kept_by_repair_and_damage_to_it_is_found(self):
        self.build("a.8vo", "--thumbnail")
        whole = (self.folder / "a.8vo").read_bytes()
        damaged = bytearray(whole)
        damaged[whole.index(b"IDAT") + 40] ^= 4
        (self.folder / "b.8vo").write_bytes(damaged)
        self.expect(4, "verify", "b.8vo")
        self.expect(0, "repair", "b.8vo", "-o", "c.8vo", "-q")
        self.assertEqual((self.folder / "c.8vo").read_bytes(), whole)

    def test_names_that_are_no_picture_are_rejected_and_nothing_is_replaced_unasked(self):
        self.build("a.8vo", "--thumbnail")
        before = (self.folder / "a.8vo").read_bytes()
        for name in ("a.8vo", "other.8vo"):
            result = self.expect(2, "info", "a.8vo", "--thumbnail", name, "-f")
            self.assertIn("--thumbnail NAME.png", result.stderr)
        (self.folder / "link.png").hardlink_to(self.folder / "a.8vo")
        self.expect(2, "info", "a.8vo", "--thumbnail", "link.png", "-f")
        self.assertEqual((self.folder / "a.8vo").read_bytes(), before)
        (self.folder / "p.png").write_bytes(b"kept")
        self.expect(5, "info", "a.8vo", "--thumbnail", "p.png")
        self.assertEqual((self.folder / "p.png").read_bytes(), b"kept")
        self.expect(5, "info", "a.8vo", "--thumbnail", "no/such/folder.png")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
