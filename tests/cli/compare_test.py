#!/usr/bin/env python3
"""What compare says of two files, by their digests and label by label.

usage: compare_test.py OCTAVO [unittest arguments]

Everything is generated.
"""

import hashlib
import json
import struct
import sys

import cli_test


class Compare(cli_test.InFolder):
    def test_files_that_state_the_same_digest_are_the_same_without_reading_voxels(self):
        size = (70, 11, 9)
        source = ["v.raw", "--raw", self.random_raw("v.raw", size), "--spacing", "1"]
        self.expect(0, "build", *source, "-o", "a.8vo")
        self.expect(0, "build", *source, "--preset", "fast", "-o", "b.8vo")
        voxels = (self.folder / "v.raw").read_bytes()
        bytes_of_plane = 2 * size[0] * size[1]
        planes = [hashlib.sha256(voxels[at : at + bytes_of_plane]).digest()
                  for at in range(0, len(voxels), bytes_of_plane)]
        digest = hashlib.sha256(b"".join(planes)).hexdigest()
        self.assertEqual([self.info(name)["voxels_sha256"] for name in ("a.8vo", "b.8vo")],
                         [digest] * 2)
        files = ["compare", "a.8vo", "b.8vo"]
        self.assertIn("by the digests that both files state", self.expect(0, *files).stdout)
        told = json.loads(self.expect(0, *files, "--json").stdout)
        self.assertEqual((told["compared_as"], told["equal"]), ("digest", True))
        told = json.loads(self.expect(0, *files, "--voxels", "--json").stdout)
        self.assertEqual((told["compared_as"], told["equal"]), ("stored", True))

    def test_neighbors_among_floats_are_told_apart(self):
        for name, last in (("a", 1.0), ("b", 1.0 + 2**-23)):
            (self.folder / f"{name}.raw").write_bytes(struct.pack("<8f", *range(7), last))
            self.expect(0, "build", f"{name}.raw", "--raw", "2,2,2,float32", "--spacing", "1",
                        "-o", f"{name}.8vo")
        text = self.expect(1, "compare", "a.8vo", "b.8vo").stdout
        self.assertIn("first at x,y,z = 1,1,1: 1 against 1.0000001", text)

    def test_label_maps_are_compared_label_by_label(self):
        layout = self.random_raw("a_labels.raw", (12, 11, 10), "B", 4)
        a = (self.folder / "a_labels.raw").read_bytes()
        b = bytes(9 if i % 7 == 0 and v == 2 else v for i, v in enumerate(a))
        (self.folder / "b_labels.raw").write_bytes(b)
        for name in "ab":
            self.expect(0, "build", f"{name}_labels.raw", "--raw", layout, "--spacing", "1",
                        "--labels", "-o", f"{name}.8vo")
        same = json.loads(self.expect(0, "compare", "a.8vo", "a.8vo", "--labels", "--json").stdout)
        self.assertEqual([one["dice"] for one in same["labels"]], [1] * len(set(a) - {0}))
        told = json.loads(self.expect(1, "compare", "a.8vo", "b.8vo", "--labels", "--json").stdout)
        for one in told["labels"]:
            in_a, in_b = a.count(one["label"]), b.count(one["label"])
            both = sum(x == y == one["label"] for x, y in zip(a, b))
            self.assertEqual([one["a_voxels"], one["b_voxels"], one["both_voxels"]],
                             [in_a, in_b, both])
            self.assertAlmostEqual(one["dice"], 2 * both / (in_a + in_b))
        self.assertEqual([one["label"] for one in told["labels"]], sorted(set(a + b) - {0}))
        text = self.expect(1, "compare", "a.8vo", "b.8vo", "--labels").stdout
        self.assertIn("2 of them the same in both", text)
        self.expect(0, "phantom", "--size", "12", "-o", "p.8vo", "-q")
        self.expect_error(2, ["p.8vo", "grey"], "compare", "a.8vo", "p.8vo", "--labels")
        self.expect(2, "compare", "a.8vo", "b.8vo", "--labels", "--max-error", "1")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
