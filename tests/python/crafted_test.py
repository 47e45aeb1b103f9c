#!/usr/bin/env python3
"""Files that break one rule each: both readers reject the same ones, at the same time.

usage: crafted_test.py OCTAVO [unittest arguments]

"newer" files are rejected by what they state (exit status 3), "damaged" ones break a rule; what
only the whole file shows, opens and reads. Exits with 77, which means skipped, without NumPy.
"""

import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python"), str(pathlib.Path(__file__).parent),
                str(ROOT / "tests" / "support")]

try:
    import numpy  # noqa: F401
except ImportError:
    print(f"skipped: {sys.executable} has no numpy; tools/setup installs python3-numpy")
    sys.exit(77)

from crafted_files import Crafted  # noqa: E402
from octavo_reader import OctavoError, OctavoFile, verify  # noqa: E402

OCTAVO = "octavo"
LIKE = (ROOT / "tests" / "golden" / "v1" / "minimal.8vo").read_bytes()
OUTCOME_OF_EXIT = {0: "sound", 3: "newer", 4: "damaged", 6: "damaged"}
OUTCOME_OF_KIND = {"not_octavo": "newer", "unsupported_version": "newer", "corrupt": "damaged",
                   "truncated": "damaged"}
CODES_INT16 = (0x8001, struct.pack("<BBdd", 3, 0, 0.5, 1.0))
STORED_BRICK = {"low": 9, "high": 200, "stored": bytes([1, 3, 2, 4, 0, 191, 1, 2]),
                "voxels": (10, 12, 11, 13, 9, 200, 10, 11)}
# Two by two pixels, all black.
BLACK = bytes.fromhex(
    "89504e470d0a1a0a0000000d494844520000000200000002080000000057dd52f80000000a494441"
    "5478016300030000060001795e978f0000000049454e44ae426082")


def coding(code_type=5, flags=1, scale=0.5, offset=1.0):
    return {"type": 7, "extensions": ((0x8001, struct.pack("<BBdd", code_type, flags, scale,
                                                          offset)),)}


def details(level):
    return {"extensions": ((0x8002, bytes([level])),)}


def real(value, **more):
    """A float32 file whose one code stands for `value`."""
    return {"voxels": (value,) * 8, **more}


def turned(*direction):
    return {"direction": direction}


# What is changed; the outcome of opening and reading, and of verification where that differs.
ROWS = [
    ("nothing", {}, "sound"),
    # Geometry
    ("the smallest spacing", {"spacing": (1e-9, 1.0, 1.0)}, "sound"),
    ("a smaller spacing", {"spacing": (0.9e-9, 1.0, 1.0)}, "damaged"),
    ("the smallest number as spacing", {"spacing": (1.0, 5e-324, 1.0)}, "damaged"),
    ("the largest spacing", {"spacing": (1.0, 1e9, 1.0)}, "sound"),
    ("a larger spacing", {"spacing": (1.0, 1.0, 1.1e9)}, "damaged"),
    ("an endless spacing", {"spacing": (1e308, 1.0, 1.0)}, "damaged"),
    ("no spacing", {"spacing": (0.0, 1.0, 1.0)}, "damaged"),
    ("a negative spacing", {"spacing": (1.0, -1.0, 1.0)}, "damaged"),
    ("a spacing that is no number", {"spacing": (float("nan"), 1.0, 1.0)}, "damaged"),
    ("the farthest origin", {"origin": (-1e12, 1e12, 0.0)}, "sound"),
    ("an origin beyond", {"origin": (0.0, 0.0, 1.1e12)}, "damaged"),
    ("an infinite origin", {"origin": (0.0, float("inf"), 0.0)}, "damaged"),
    ("long axes", turned(1000.0, 0, 0, 0, 1000.0, 0, 0, 0, 1000.0), "damaged"),
    ("an axis within its limit", turned(1.00009, 0, 0, 0, 1.0, 0, 0, 0, 0.99991), "sound"),
    ("an axis beyond it", turned(1.0002, 0, 0, 0, 1.0, 0, 0, 0, 1.0), "damaged"),
    ("axes in a plane", turned(1.0, 1.0, 0, 0, 0, 0, 0, 0, 1.0), "damaged"),
    ("no axes", turned(*(0.0,) * 9), "damaged"),
    ("a mirrored volume", turned(-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0), "sound"),
    # Rescale and max error
    ("no slope", {"slope": 0.0}, "damaged"),
    ("a falling slope", {"slope": -2.5}, "sound"),
    ("a slope beyond all numbers", {"slope": 1e308}, "damaged"),
    ("an intercept beyond all numbers", {"slope": 1e305, "intercept": 1.7e308}, "damaged"),
    ("an endless intercept", {"intercept": float("-inf")}, "damaged"),
    ("a negative max error", {"max_error": -1.0}, "damaged"),
    ("half a voxel unit as max error", {"max_error": 0.5}, "damaged"),
    ("a max error beyond integers", {"max_error": 4294967296.0}, "damaged"),
    ("a max error", {"max_error": 3.0, "error": 2}, "sound"),
    ("an error beyond the max error", {"max_error": 3.0, "error": 4}, "damaged"),
    ("labels with a max error", {"kind": 2, "max_error": 1.0}, "damaged"),
    # Numbers that were not given out
    ("another kind", {"kind": 3}, "newer"),
    ("no kind", {"kind": 0}, "newer"),
    ("a voxel type that is set aside", {"type": 8}, "newer"),
    ("no voxel type", {"type": 0}, "newer"),
    ("two channels", {"channels": 2}, "newer"),
    ("no channel", {"channels": 0}, "newer"),
    ("two times", {"times": 2}, "newer"),
    ("a later minor version", {"minor": 7}, "sound"),
    ("the last minor version", {"minor": 65535}, "sound"),
    ("a later major version", {"major": 2}, "newer"),
    ("another seal", {"seal": 2}, "newer"),
    ("no seal", {"seal": 0}, "damaged"),
    ("a fourth axis", {"masks": (15,)}, "newer"),
    ("a mask behind the last level", {"masks_behind": b"\1"}, "newer"),
    ("a fourth axis behind the last level", {"masks_behind": b"\x08"}, "newer"),
    ("a flag of a model", {**STORED_BRICK, "model_flags": 0x80}, "newer"),
    ("a flag of a page", {"page_flags": 1}, "newer"),
    ("something behind a section", {"section_zeros": 1}, "newer"),
    ("something behind the extensions", {"behind_extensions": b"\0\0\0\0\1"}, "newer"),
    ("something in the trailer", {"trailer_zeros": bytes(19) + b"\1"}, "newer"),
    ("a trailer before", {"previous": 512}, "newer"),
    # Extensions and codings
    ("an optional extension", {"extensions": ((9, b"\xaa"),)}, "sound"),
    ("one of them twice", {"extensions": ((9, b"\xaa"), (9, b"\xaa"))}, "sound"),
    ("a required extension", {"extensions": ((0x8123, b""),)}, "newer"),
    ("a required extension that ends behind the header",
     {"behind_extensions": struct.pack("<HH", 0x8123, 300), "extension_count": 1}, "newer"),
    ("an optional extension that ends behind the header",
     {"behind_extensions": struct.pack("<HH", 9, 300), "extension_count": 1}, "damaged"),
    ("an integer with a coding", {"extensions": (CODES_INT16,)}, "damaged"),
    ("a float without a coding", {"type": 7}, "damaged"),
    ("floats", real(4.5, **coding()), "sound"),
    ("labels of floats", {"kind": 2, **real(4.5, **coding())}, "damaged"),
    ("floats with a max error", real(4.5, max_error=0.5, **coding(3, 0)), "sound"),
    ("exact floats with a max error", real(4.5, max_error=0.5, **coding()), "damaged"),
    ("floats without either", real(4.5, **coding(3, 0)), "damaged"),
    ("exact floats of 16 bits", real(4.5, **coding(3)), "damaged"),
    ("two codings", {"type": 7, "extensions": coding()["extensions"] * 2}, "damaged"),
    ("codes of floats", coding(code_type=7), "newer"),
    ("a flag of codes", coding(flags=2), "newer"),
    ("no scale", coding(scale=0.0), "damaged"),
    ("a negative scale", coding(scale=-1.0), "damaged"),
    ("an offset that is no number", coding(offset=float("nan")), "damaged"),
    ("floats beyond their range", real(3.4028234663852886e38, **coding(scale=1e300)), "sound"),
    ("floats that vanish", real(0.0, low=-1, high=-1, **coding(scale=5e-324, offset=-0.0)),
     "sound"),
    ("floats that nearly vanish", real(0.0, low=-1, high=-1, **coding(scale=1e-46, offset=-0.0)),
     "sound"),
    # Details left out
    ("details of level 1 on", {**details(1), "error": 9}, "sound"),
    ("details of level 0 on", details(0), "damaged"),
    ("details of a level that is not there", details(2), "damaged"),
    ("details of a level beyond the bricks", details(6), "newer"),
    ("details of any level", details(255), "newer"),
    ("details of two levels", {"extensions": ((0x8002, b"\1"), (0x8002, b"\1"))}, "damaged"),
    ("details of two bytes", {"extensions": ((0x8002, b"\1\0"),)}, "damaged"),
    ("details without a level", {"extensions": ((0x8002, b""),)}, "damaged"),
    ("details of labels", {"kind": 2, **details(1)}, "damaged"),
    ("details and a max error", {"max_error": 3.0, **details(1)}, "damaged"),
    ("details of floats", real(4.5, type=7, extensions=(*coding()["extensions"],
                                                        *details(1)["extensions"])), "damaged"),
    ("an error beyond the voxel type", {**details(1), "error": 256}, "damaged"),
    ("a level without details that has bytes", {**details(1), **STORED_BRICK},
     "damaged"),
    # Ladder of levels
    ("a step that halves nothing", {"size": (2, 1, 1), "masks": (6, 1)}, "damaged"),
    ("a step of no axis", {"size": (2, 1, 1), "masks": (0, 1)}, "damaged"),
    ("a step of two axes, one of them short", {"size": (2, 1, 1), "masks": (3,)}, "sound"),
    ("a ladder that ends early", {"size": (4, 4, 4), "masks": (7,)}, "damaged"),
    ("no voxels", {"size": (0, 2, 2), "masks": (7,)}, "damaged"),
    ("an axis beyond the limit", {"size": ((1 << 21) + 1, 1, 1), "masks": (1,) * 22,
                                  "plane_digest": bytes(32)}, "damaged"),
    # Index and bricks
    ("a stored brick", STORED_BRICK, "sound"),
    ("a range wider than the voxels", {**STORED_BRICK, "high": 201}, "sound", "damaged"),
    ("a range beyond the voxel type", {"low": 256, "high": 256, "plane_digest": bytes(32)},
     "damaged"),
    ("a range below the voxel type", {"low": -1, "high": -1, "plane_digest": bytes(32)},
     "damaged"),
    ("a model behind the first slab", {"model_slab": 1}, "damaged"),
    # Parts
    ("an optional part", {"parts": ((b"note", 0, b"text"),)}, "sound"),
    ("two of a tag", {"parts": ((b"note", 0, b"text"), (b"note", 2, b""))}, "sound"),
    ("a required part", {"parts": ((b"need", 1, b"text"),)}, "newer"),
    ("a flag of a part", {"parts": ((b"note", 4, b"text"),)}, "newer"),
    ("a tag with a blank", {"parts": ((b"no e", 0, b"text"),)}, "damaged"),
    ("two thumbnails", {"parts": ((b"thmb", 0, b""), (b"thmb", 0, b""))}, "damaged"),
    ("a thumbnail", {"parts": ((b"note", 0, b"text"), (b"thmb", 2, BLACK))}, "sound"),
    ("a thumbnail without flags", {"parts": ((b"thmb", 0, BLACK),)}, "sound"),
    ("a thumbnail of other voxels", {**STORED_BRICK, "parts": ((b"thmb", 2, BLACK),)},
     "sound", "damaged"),
    ("an empty thumbnail", {"parts": ((b"thmb", 2, b""),)}, "sound", "damaged"),
    ("a thumbnail with more behind it", {"parts": ((b"thmb", 2, BLACK + b" "),)},
     "sound", "damaged"),
    ("a part that ends behind the directory", {"parts": ((b"note", 0, b"text"),),
                                               "part_length": 1000}, "damaged"),
    ("a required part that does", {"parts": ((b"need", 1, b"text"),), "part_length": 1000},
     "damaged"),
    ("a part in no directory", {"parts": ((b"note", 0, b"text"),), "directory": b""}, "damaged"),
    ("half an entry", {"directory": bytes(16)}, "damaged"),
    # Digests
    ("another digest of voxels", {"digest": b"d" * 32}, "sound", "damaged"),
    ("other digests of planes", {"plane_digest": b"p" * 32}, "sound", "damaged"),
    # Metadata
    ("long metadata", {"metadata": b'{"a":"' + b"b" * 65536 + b'"}  '}, "sound"),
    ("one name twice", {"metadata": b'{"a":1,"a":2}'}, "sound"),
    ("no metadata", {"metadata": b""}, "sound", "damaged"),
    ("blank metadata", {"metadata": b"   "}, "sound", "damaged"),
    ("words", {"metadata": b"not json"}, "sound", "damaged"),
    ("an array", {"metadata": b"[1]"}, "sound", "damaged"),
    ("other bytes than UTF-8", {"metadata": b'{"a":"\xff\xfe"}'}, "sound", "damaged"),
    ("a byte order mark", {"metadata": b"\xef\xbb\xbf{}"}, "sound", "damaged"),
    ("metadata that are nested too deep", {"metadata": b'{"a":' + b"[" * 16 + b"]" * 16 + b"}"},
     "sound", "damaged"),
    ("too many values", {"metadata": b'{"a":[' + b"1," * 65536 + b"1]}"}, "sound", "damaged"),
]


class Crafts(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.path = pathlib.Path(holder.name) / "crafted.8vo"

    def of_program(self, verb, *arguments):
        command = [OCTAVO, verb, str(self.path), *arguments, "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        return OUTCOME_OF_EXIT.get(done.returncode, str(done.returncode)), done.stderr

    def of_package(self, read):
        try:
            with OctavoFile(self.path) as file:
                read(file)
            return "sound", ""
        except OctavoError as error:
            return OUTCOME_OF_KIND.get(error.kind, error.kind), str(error)

    def test_both_readers_reject_the_same_files(self):
        out = str(self.path.parent / "out.raw")
        for name, changes, opening, *verifying in ROWS:
            self.path.write_bytes(Crafted(like=LIKE, **changes).bytes())
            with self.subTest(name, reader="program", verb="export"):
                found, said = self.of_program("export", "-o", out, "--stored", "--force")
                self.assertEqual(found, opening, said)
            with self.subTest(name, reader="program", verb="verify"):
                found, said = self.of_program("verify")
                self.assertEqual(found, (verifying or [opening])[0], said)
            with self.subTest(name, reader="package", verb="read"):
                found, said = self.of_package(lambda file: file.read_level(0))
                self.assertEqual(found, opening, said)
            with self.subTest(name, reader="package", verb="verify"):
                found, said = self.of_package(verify)
                self.assertEqual(found, (verifying or [opening])[0], said)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    OCTAVO = sys.argv.pop(1)
    unittest.main()
