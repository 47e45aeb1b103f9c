#!/usr/bin/env python3
"""Files whose metadata are no metadata: every verb reads their voxels all the same.

usage: metadata_test.py OCTAVO [unittest arguments]

Everything is generated; files are given other metadata with fitting checksums.
"""

import json
import struct
import sys

import cli_test
from file_bytes import with_metadata

SIZE = (16, 16, 16)
SIZE_OF_TEXT = 100_000
# Every verb is given these.
DEEP = {
    "nested lists": b"[" * (SIZE_OF_TEXT // 2) + b"]" * (SIZE_OF_TEXT // 2),
    "a nested member": b'{"x":' + b"[" * (SIZE_OF_TEXT // 2) + b"]" * (SIZE_OF_TEXT // 2) + b"}",
}
# And some verbs these as well.
OTHERS = {
    "nested objects": b'{"a":' * (SIZE_OF_TEXT // 6) + b"1" + b"}" * (SIZE_OF_TEXT // 6),
    "open brackets": b"[" * SIZE_OF_TEXT,
    "many values": b'{"labels":[' + b"1," * SIZE_OF_TEXT + b"1]}",
    "a long string": b'{"unit":"' + b"a" * SIZE_OF_TEXT + b'"}',
    "no UTF-8": b'{"unit":"\xff\xfe"}',
    "no object": b"null",
    "nothing": b"",
}

# What every verb is given; "out" is new each time.
OF_GREY = [
    ["info"], ["info", "--metadata"], ["info", "--json"], ["probe", "--at", "1,1,1"],
    ["threshold", "--range", "20:", "-o", "out.8vo"], ["condense", "-o", "out.8vo", "--flat", "1"],
    ["transform", "--rotate", "z:90", "-o", "out.8vo"], ["build", "-o", "out.8vo"],
    ["build", "--isotropic", "--max-error", "1", "-o", "out.8vo"],
    ["export", "-o", "out.nrrd"], ["export", "-o", "out.nii.gz"], ["export", "-o", "out.mha"],
    ["export", "-o", "out.tif"], ["export", "-o", "out.raw"],
    ["extract", "--box", "0:4,0:4,0:4", "-o", "out.nrrd"],
    ["slice", "--axis", "z", "-o", "out.png"], ["codes", "--range", "20:"],
]
OF_LABELS = [
    ["info"], ["info", "--metadata"], ["info", "--json"], ["measure"], ["measure", "--csv"],
    ["measure", "--json"], ["touch"], ["codes", "--counts"], ["codes", "--list", "--json"],
    ["probe", "--at", "5,5,5"], ["components", "-o", "out.8vo"], ["shell", "-o", "out.8vo"],
    ["dilate", "--voxels", "1", "-o", "out.8vo"], ["fill-holes", "-o", "out.8vo"],
    ["transform", "--rotate", "z:90", "-o", "out.8vo"], ["build", "-o", "out.8vo"],
    ["export", "-o", "out.nii.gz"], ["slice", "--axis", "z", "-o", "out.png"],
    ["render", "--size", "32x32", "-o", "out.png"],
    ["combine", "l.8vo", "--union", "-o", "out.8vo"], ["compare", "l.8vo", "--labels"],
    ["measure", "--of", "v.8vo"], ["touch", "l.8vo"],
]


class Metadata(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        voxels = bytearray(x + y + z for z in range(16) for y in range(16) for x in range(16))
        (self.folder / "v.raw").write_bytes(voxels)
        (self.folder / "l.raw").write_bytes(bytes(voxel // 20 for voxel in voxels))
        layout = ",".join(map(str, SIZE)) + ",uint8"
        for name, options in [("v", ["--grey"]), ("l", ["--labels"])]:
            self.expect(0, "build", f"{name}.raw", "--raw", layout, "--spacing", "1,1,2", *options,
                        "-o", f"{name}.8vo", "-q")

    def give(self, name, text):
        """bad.8vo: the file `name` with other metadata."""
        whole = (self.folder / name).read_bytes()
        (self.folder / "bad.8vo").write_bytes(with_metadata(whole, text))

    def expect_read(self, what, arguments):
        verb, *options = arguments
        result = self.octavo(verb, "bad.8vo", *options, "-f", "--progress", "none")
        with self.subTest(metadata=what, verb=verb, options=options):
            self.assertEqual(result.returncode, 0, result.stderr[:200])
        if result.returncode == 0 and "out.8vo" in options:
            self.expect(0, "info", "out.8vo")
        for out in self.folder.glob("out.*"):
            out.unlink()

    def test_other_metadata_make_a_sound_file(self):
        text = b'{"unit":"HU","labels":{"1":{"name":"a"}}}'
        self.give("v.8vo", text)
        self.expect(0, "verify", "bad.8vo")
        self.assertEqual(self.info("bad.8vo")["metadata"], json.loads(text))

    def test_what_is_no_metadata_is_damage_to_verify_and_named_by_info(self):
        for what, text in {**DEEP, **OTHERS, "blanks": b"   ", "words": b"not json"}.items():
            self.give("v.8vo", text)
            with self.subTest(metadata=what):
                told = self.expect_error(4, ["metadata at byte", "no JSON object"],
                                         "verify", "bad.8vo")
                self.assertLess(len(told.stderr), 1000)
                self.assertIn("cannot be read", self.expect(0, "info", "bad.8vo").stdout)

    def test_metadata_beyond_1_mib_are_not_shown_but_where_they_stand(self):
        long_name = "n" * 500
        names = {str(label): {"name": f"{label} {long_name}"} for label in range(1, 3000)}
        identity = {f"Name{i}": "w" * 1000 for i in range(1100)}
        for what, text in {
                "names": json.dumps({"labels": names}),
                "identity": json.dumps({"identity": {"kept": True, "attributes": identity}}),
                "no object": "[" + "1," * 600_000 + "1]",
                "nested": '{"x":' + "[" * 14 + "1," * 60_000 + "1" + "]" * 14 + "}",
        }.items():
            data = text.encode()
            self.give("l.8vo", data)
            with self.subTest(metadata=what):
                place, = struct.unpack_from("<Q", (self.folder / "bad.8vo").read_bytes(), 232)
                shown = self.expect(0, "info", "bad.8vo", "--metadata").stdout
                self.assertLess(len(shown), 1 << 16)
                self.assertIn(f"{len(data)} bytes from byte {place} of the file on", shown)
                out = self.expect(0, "info", "bad.8vo", "--json").stdout
                self.assertLess(len(out), 1 << 16)
                self.assertEqual(json.loads(out)["metadata"],
                                 {"left_out": {"offset": place, "bytes": len(data)}})

    def test_nested_brackets_stop_no_verb_that_reads_grey_values(self):
        for what, text in DEEP.items():
            self.give("v.8vo", text)
            for arguments in OF_GREY:
                self.expect_read(what, arguments)

    def test_nested_brackets_stop_no_verb_that_reads_labels(self):
        for what, text in DEEP.items():
            self.give("l.8vo", text)
            for arguments in OF_LABELS:
                self.expect_read(what, arguments)

    def test_no_other_text_stops_a_verb(self):
        for what, text in OTHERS.items():
            self.give("v.8vo", text)
            for arguments in OF_GREY[:3] + [["threshold", "--range", "20:", "-o", "out.8vo"],
                                            ["build", "--max-error", "1", "-o", "out.8vo"]]:
                self.expect_read(what, arguments)

    def test_what_is_no_metadata_and_is_kept_takes_no_names(self):
        (self.folder / "names.txt").write_text("1 a\n")
        self.give("l.8vo", DEEP["nested lists"])
        named = ["build", "bad.8vo", "--labels", "--label-names", "names.txt", "-o", "out.8vo"]
        self.expect_error(4, ["metadata cannot be read", "no names"], *named, "--keep-identity")
        self.assertFalse((self.folder / "out.8vo").exists())
        # As it may tell who, such text is not passed on, and leaves room for names.
        self.expect(0, *named)
        self.assertEqual(self.info("out.8vo")["metadata"]["labels"], {"1": {"name": "a"}})


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
