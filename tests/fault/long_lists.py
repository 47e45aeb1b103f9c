#!/usr/bin/env python3
"""Headers with long lists take time by their length, and not by its square.

usage: long_lists.py OCTAVO [unittest arguments]
"""

import gzip
import json
import os
import struct
import sys
import unittest

import claims
import dicom_bytes


class LongLists(claims.InFolder):
    def write_image(self, axes, array):
        image = {"axes": axes, "datasets": [{"path": "0"}]}
        group = {"zarr_format": 3, "node_type": "group",
                 "attributes": {"ome": {"version": "0.5", "multiscales": [image]}}}
        self.write("a.zarr/zarr.json", json.dumps(group).encode())
        (self.folder / "a.zarr" / "0").mkdir(exist_ok=True)
        self.write("a.zarr/0/zarr.json", json.dumps({
            "zarr_format": 3, "node_type": "array", "shape": [4, 4, 4], "data_type": "uint8",
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [4, 4, 4]}},
            "fill_value": 0, **array}).encode())

    def test_of_zarr(self):
        many = {"name": "transpose", "configuration": {"order": [0] * 65_000}}
        for words, axes, codecs in (
                ("an image has 2 to 5 axes", [f"{i}" for i in range(65_000)], []),
                ("transpose has no order", list("zyx"), [many, {"name": "bytes"}]),
                ("30001 codecs", list("zyx"), [{"name": "bytes"}] + [{"name": "crc32c"}] * 30_000)):
            with self.subTest(words):
                self.write_image(axes, {"codecs": codecs})
                self.expect_cheap(7, [words], "build", "a.zarr", "-o", "o.8vo", "--force")

    def write_nrrd(self, lines):
        self.write("a.nrrd", b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n"
                   + lines.encode() + b"\n\n" + bytes(8))

    def test_of_nrrd(self):
        for lines in (f"space directions: (1,0,0) (0,1,0) (0,0,{'none ' * 60_000}1)",
                      "space directions: (1,0,0) (0,1,0) (0,0,1)\n"
                      f"space origin: {'none ' * 60_000}(0,0,0)",
                      "spacings: 1 1 1\n" + "".join(f"#{i}\n" for i in range(9000)) +
                      "#8999\n" * 140_000 + "#"):
            with self.subTest(lines[:60]):
                self.write_nrrd(lines)
                self.expect_cheap(0, [], "build", "a.nrrd", "-o", "o.8vo", "--force")

    def test_of_names_of_one_file(self):
        names = 3000
        self.write("a.raw.gz", gzip.compress(bytes(64 << 20)))
        self.write("a.nhdr", b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 %d\n"
                   b"encoding: gzip\ndata file: LIST\n" % names + b"a.raw.gz\n" * names)
        self.expect_cheap(0, [], "build", "a.nhdr", "-o", "o.8vo", "--force",
                          "--spacing", "1,1,1")

    def test_of_fragments_of_dicom(self):
        frames = 10_000
        picture = struct.pack("<16I", 2, 64, 66, *[0] * 13) + b"\xc1\0" * 2  # 8 x 8 zeros
        self.write("a.dcm", dicom_bytes.compressed_frames(dicom_bytes.RUN_LENGTHS, 8, 16, frames,
                                                          ([picture] + [b""] * 40) * frames))
        self.expect_cheap(0, [], "build", "a.dcm", "-o", "o.8vo", "--force",
                          "--spacing", "1,1,1")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    claims.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
