#!/usr/bin/env python3
"""Files that break one rule each: both readers reject the same ones, at the same time.

usage: crafted_test.py OCTAVO [unittest arguments]

"newer" files are rejected by what they state (exit status 3), also where something else is wrong
with them, "damaged" ones break a rule (4), "large" ones pass a limit of the header (6); what only
the whole file shows, opens and reads. Exits with 77, which means skipped, without NumPy.
"""

import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

from reader_path import ROOT  # first: it finds the others
from crafted_files import Crafted
from file_bytes import TRAILER_LENGTH, crc32c, first_model, sealed
from octavo_reader import OctavoError, OctavoFile, verify

OCTAVO = "octavo"
GOLDEN = ROOT / "tests" / "golden" / "v1"
LIKE = (GOLDEN / "minimal.8vo").read_bytes()
LIKE_MODEL = first_model(LIKE)
LIKE_LABELS = (GOLDEN / "labels-uint8.8vo").read_bytes()
LIKE_GAPS = (GOLDEN / "small-gaps.8vo").read_bytes()
OUTCOME_OF_EXIT = {0: "sound", 3: "newer", 4: "damaged", 6: "large"}
OUTCOME_OF_KIND = {"not_octavo": "newer", "unsupported_version": "newer", "corrupt": "damaged",
                   "truncated": "damaged", "limit_exceeded": "large"}
CODES_INT16 = (0x8001, struct.pack("<BBdd", 3, 0, 0.5, 1.0))
STORED = bytes([1, 3, 2, 4, 0, 191, 1, 2])
CODES = (0, 1, 2, 1, 0, 2, 1, 0)
PLAIN_CODES = sum(code << 2 * i for i, code in enumerate(CODES)).to_bytes(2, "little")
PLAIN_FLOATS = struct.pack("<8f", *CODES)
NAN = (float("nan"),)
CUT_MODEL = LIKE_MODEL[:1] + b"\4" + LIKE_MODEL[2:]
# Models that leave out precision: two thirds of all voxels, or details.
ROUNDING_MODEL = b"\3\0\3\0\0" + LIKE_MODEL[2:]
QUANTIZING_MODEL = b"\3\0\1\x80\4\1" + LIKE_MODEL[2:]
# The axes in the order z, y, x.
TURNED_MODEL = bytes([LIKE_MODEL[0] | 5 << 2]) + LIKE_MODEL[1:]
NOTE = ((b"note", 0, b"text"),)
NEEDED = ((b"need", 1, b"text"),)
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


def patched(section, at, length, data, **more):
    return {"patches": ((section, at, length, data),), **more}


def stored(piece=STORED, **more):
    """A brick of the voxels 10 12 11 13 9 200 10 11, or one that no reader gets to."""
    return {"low": 9, "high": 200, "pieces": (piece,), "voxels": (10, 12, 11, 13, 9, 200, 10, 11),
            **more}


def long_brick(last_piece):
    """A brick of 5 levels whose last piece holds the two coarsest."""
    return {"size": (16, 1, 1), "masks": (1,) * 4, "low": 0, "high": 1,
            "pieces": (b"", b"", b"", last_piece)}


def voxel_of_code(code):
    return code * 0.5 + 1


def stored_floats(head, **more):
    voxels = tuple(map(voxel_of_code, (10, 12, 11, 13, 9, 200, 10, 11)))
    return stored(head + STORED, **{**coding(), "voxels": voxels, **more})


def exact(*pieces, **more):
    """Exact floats that are their codes, 0 to 2."""
    return {**coding(scale=1.0, offset=0.0), "low": 0, "high": 2, "pieces": pieces,
            "voxels": tuple(map(float, CODES)), **more}


def largest_floats(sign):
    end = sign * ((1 << 31) - 1)
    return exact(low=end, high=end, voxels=(sign * 3.4028234663852886e38,) * 8)


def plain_floats(floats=PLAIN_FLOATS, head=b"\x10", **more):
    return exact(head + floats, **more)


def pair(state, *words):
    """Two voxels, 9 and 10, whose one detail is read from `state`."""
    return {"size": (2, 1, 1), "masks": (1,), "low": 9, "high": 10, "voxels": (9, 10),
            "pieces": (b"\0" + struct.pack(f"<I{len(words)}H", state, *words), b"\1")}


def two_tiers(above, **more):
    """Two bricks of 64 voxels in a row, and a sample above each."""
    return {"size": (128, 1, 1), "masks": (1,) * 7, "bricks": 2, "above": above, **more}


def ramps(above, head=b"", voxel_of=int, **more):
    """Bricks of the voxels or codes 0 to 63, stored."""
    fields = sum(code << 6 * code for code in range(64)).to_bytes(48, "little")
    return two_tiers(above, low=0, high=63, pieces=(head + fields,),
                     voxels=tuple(map(voxel_of, range(64))) * 2, **more)


def plain_ramps(above, start=()):
    """Bricks of the floats 0 to 63, the first of them replaced by others, as they are."""
    voxels = (*start, *map(float, range(len(start), 64)))
    return two_tiers(int(above), **coding(scale=1.0, offset=0.0), low=0, high=63,
                     pieces=(b"\x10" + struct.pack("<64f", *voxels),), voxels=voxels * 2)


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
    ("an axis that is no number", turned(float("nan"), 0, 0, 0, 1.0, 0, 0, 0, 1.0), "damaged"),
    ("a mirrored volume", turned(-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0), "sound"),
    # Rescale and max error
    ("no slope", {"slope": 0.0}, "damaged"),
    ("a falling slope", {"slope": -2.5}, "sound"),
    ("a slope that is no number", {"slope": float("nan")}, "damaged"),
    ("a slope beyond all numbers", {"slope": 1e308}, "damaged"),
    ("an intercept beyond all numbers", {"slope": 1e305, "intercept": 1.7e308}, "damaged"),
    ("an endless intercept", {"intercept": float("-inf")}, "damaged"),
    ("a negative max error", {"max_error": -1.0}, "damaged"),
    ("a max error that is no number", {"max_error": float("nan")}, "damaged"),
    ("an endless max error", {"max_error": float("inf")}, "damaged"),
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
    ("a flag of a grey model", stored(model=b"\x81\0"), "newer"),
    ("a flag of a grey model that no brick needs", {"model": b"\x81\0"}, "sound", "newer"),
    ("an axis order", stored(model=bytes([6 << 2, 0])), "newer"),
    ("a fourth cut axis", stored(model=b"\0\x08"), "newer"),
    ("a label model that announces more", stored(kind=2, model=b"\xff" * 8), "newer"),
    ("a flag of a brick's map", stored(b"\x04" + STORED, like=LIKE_GAPS), "newer"),
    ("a flag of a float brick", stored_floats(b"\x20"), "newer"),
    ("a flag of places", stored_floats(b"\x02\x40\0\0"), "newer"),
    ("no seal", {"seal": 0}, "damaged"),
    ("a fourth axis", {"masks": (15,)}, "newer"),
    ("a mask behind the last level", {"masks_behind": b"\1"}, "newer"),
    ("a fourth axis behind the last level", {"masks_behind": b"\x08"}, "newer"),
    ("a flag of a model", stored(model_flags=0x80), "newer"),
    ("a flag of a page", {"page_flags": 1}, "newer"),
    ("something behind a section", {"section_zeros": 1}, "newer"),
    ("something behind the extensions", {"behind_extensions": b"\0\0\0\0\1"}, "newer"),
    ("something in the trailer", {"trailer_zeros": bytes(19) + b"\1"}, "newer"),
    ("a trailer before", {"previous": 512}, "newer"),
    # Newer and damaged: what a later version may have changed is not looked at
    ("another kind without a slope", {"kind": 3, "slope": 0.0}, "newer"),
    ("another voxel type without a coding", {"type": 8, "max_error": -1.0}, "newer"),
    ("another kind that was never finished", {"kind": 3, "seal": 0}, "newer"),
    ("two channels, and a gap before the root",
     patched("header", 280, 1, b"\xff", channels=2), "newer"),
    ("two times of no voxels", {"times": 2, "size": (0, 2, 2)}, "newer"),
    ("a fourth axis of too many levels", {"masks": (15,) + (1,) * 31}, "newer"),
    ("something behind a section, and no spacing",
     {"section_zeros": 1, "spacing": (0.0, 1.0, 1.0)}, "newer"),
    ("something behind the extensions, and two codings",
     {"type": 7, "extensions": 2 * coding()["extensions"], "behind_extensions": b"\1"}, "newer"),
    ("a required extension behind a coding that is too long",
     {"type": 7, "extensions": ((0x8001, bytes(19)), (0x8123, b""))}, "newer"),
    ("a required extension without axes",
     {"extensions": ((0x8123, b""),), "direction": (0.0,) * 9}, "newer"),
    ("a flag of codes without a scale", coding(flags=2, scale=0.0), "newer"),
    ("details of any level, and a max error", {"max_error": 3.0, **details(255)}, "newer"),
    ("another kind, cut short", {"kind": 3, "cut": 5}, "newer"),
    ("a file that is cut short", {"cut": 5}, "damaged"),
    ("a header that is cut short", {"major": 2, "cut": 600}, "damaged"),
    ("another kind and another CRC", {"kind": 3, "header_crc": b"none"}, "damaged"),
    ("a later major version and another CRC", {"major": 2, "header_crc": b"none"}, "newer"),
    ("something in the trailer, and a gap before the root",
     patched("header", 280, 1, b"\xff", trailer_zeros=bytes(19) + b"\1"), "damaged"),
    ("something in the trailer of another file",
     patched("trailer", 8, 1, b"\0", trailer_zeros=bytes(19) + b"\1"), "newer"),
    ("something in what is no trailer",
     patched("trailer", 0, 1, b"\0", trailer_zeros=bytes(19) + b"\1"), "damaged"),
    ("a trailer before, and a part elsewhere",
     patched("directory", 8, 1, b"\0", parts=NOTE, previous=512), "newer"),
    # Extensions and codings
    ("an optional extension", {"extensions": ((9, b"\xaa"),)}, "sound"),
    ("one of them twice", {"extensions": ((9, b"\xaa"), (9, b"\xaa"))}, "sound"),
    ("a required extension", {"extensions": ((0x8123, b""),)}, "newer"),
    ("a required extension that ends behind the header",
     {"behind_extensions": struct.pack("<HH", 0x8123, 300), "extension_count": 1}, "newer"),
    ("an optional extension that ends behind the header",
     {"behind_extensions": struct.pack("<HH", 9, 300), "extension_count": 1}, "damaged"),
    ("two codings", {"type": 7, "extensions": 2 * coding()["extensions"]}, "damaged"),
    ("a coding that is too long", {"type": 7, "extensions": ((0x8001, bytes(19)),)}, "damaged"),
    ("extensions that end early", patched("header", 330, 2, b"\x2d\0"), "damaged"),
    ("an extension that ends late", patched("header", 330, 6, b"\1\0\7\0\xad\0"), "damaged"),
    ("an integer with a coding", {"extensions": (CODES_INT16,)}, "damaged"),
    ("a float without a coding", {"type": 7}, "damaged"),
    ("floats", real(4.5, **coding()), "sound"),
    ("labels of floats", {"kind": 2, **real(4.5, **coding())}, "damaged"),
    ("floats with a max error", real(4.5, max_error=0.5, **coding(3, 0)), "sound"),
    ("exact floats with a max error", real(4.5, max_error=0.5, **coding()), "damaged"),
    ("floats without either", real(4.5, **coding(3, 0)), "damaged"),
    ("exact floats of 16 bits", real(4.5, **coding(3)), "damaged"),
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
    ("a level without details that has bytes", {**details(1), **stored()},
     "damaged"),
    ("the largest code", real(3.4028234663852886e38, low=(1 << 31) - 1, high=(1 << 31) - 1,
                              **coding(scale=1e-9)), "sound"),
    ("the smallest code", real(-3.4028234663852886e38, low=1 - (1 << 31), high=1 - (1 << 31),
                               **coding(scale=1e-9)), "sound"),
    # Sections
    ("pages in the header", patched("header", 256, 2, b"\xff\1"), "damaged"),
    ("a gap before the directory", patched("header", 304, 1, b"\xff"), "damaged"),
    ("a gap before the metadata", patched("header", 232, 1, b"\xff"), "damaged"),
    ("a gap before the root", patched("header", 280, 1, b"\xff"), "damaged"),
    ("another CRC of the metadata", patched("header", 248, 4, b"none"), "damaged"),
    ("another CRC of the root", patched("header", 296, 4, b"none"), "damaged"),
    ("another CRC of all pages", patched("header", 272, 4, b"none"), "sound", "damaged"),
    ("no magic in the trailer", patched("trailer", 0, 1, b"\0"), "damaged"),
    ("the build id of another file", patched("trailer", 8, 1, b"\0"), "damaged"),
    ("another length of the file", patched("trailer", 16, 2, b"\0\0"), "damaged"),
    ("the CRC of another header", patched("trailer", 24, 4, b"none"), "damaged"),
    ("another CRC of all bytes", patched("trailer", 28, 4, b"none"), "sound", "damaged"),
    # Slab trailers
    ("no magic in a slab trailer", patched("slab trailer", 0, 1, b"9"), "sound", "damaged"),
    ("a slab trailer of another file", patched("slab trailer", 4, 1, b"\0"), "sound", "damaged"),
    ("a slab trailer of another slab", patched("slab trailer", 12, 1, b"\1"), "sound", "damaged"),
    ("a slab trailer of another model", patched("slab trailer", 13, 1, b"\1"), "sound", "damaged"),
    ("another length of a piece in a slab trailer", patched("slab trailer", 14, 1, b"\1"), "sound",
     "damaged"),
    ("a needless byte in a slab trailer", patched("slab trailer", 14, 1, b"\x80\0"), "sound",
     "damaged"),
    ("another CRC of a slab", patched("slab trailer", 79, 4, b"none"), "sound", "damaged"),
    ("another length of a slab trailer", patched("slab trailer", 83, 4, b"none"), "sound",
     "damaged"),
    ("a slab trailer that is too long", patched("slab trailer", 83, 0, bytes(2100)), "damaged"),
    # Ladder of levels
    ("more than 32 levels", {"masks": (1,) * 32}, "large"),
    ("a step that halves nothing", {"size": (2, 1, 1), "masks": (6, 1)}, "damaged"),
    ("a step of no axis", {"size": (2, 1, 1), "masks": (0, 1)}, "damaged"),
    ("a step of two axes, one of them short", {"size": (2, 1, 1), "masks": (3,)}, "sound"),
    ("a ladder that ends early", {"size": (4, 4, 4), "masks": (7,)}, "damaged"),
    ("no voxels", {"size": (0, 2, 2), "masks": (7,)}, "damaged"),
    ("an axis beyond the limit", {"size": ((1 << 21) + 1, 1, 1), "masks": (1,) * 22,
                                  "plane_digest": bytes(32)}, "large"),
    ("2^63 voxels", patched("header", 48, 24, struct.pack("<3Q", *(1 << 21,) * 3),
                            masks=(7,) * 21), "large"),
    ("an axis beyond the limit, and a fourth one",
     patched("header", 48, 8, struct.pack("<Q", 1 << 40), masks=(15,)), "newer"),
    # Index and bricks
    ("a stored brick", stored(), "sound"),
    ("a model that ends early", stored(model=b"\0\0"), "damaged"),
    ("a damaged model that no brick needs", {"model": b"\0\0"}, "sound", "damaged"),
    ("a stored brick of labels", stored(b"\0" + STORED, kind=2, like=LIKE_LABELS), "sound"),
    ("a stored brick of floats", stored_floats(b"\0"), "sound"),
    ("exact floats below all ranges", exact(PLAIN_CODES, low=-(1 << 31)), "damaged"),
    ("exact floats in the widest range",
     plain_floats(head=b"\x1c", low=1 - (1 << 31), high=(1 << 31) - 1), "sound"),
    ("the largest float", largest_floats(1), "sound"),
    ("the smallest float", largest_floats(-1), "sound"),
    ("exact floats as they are", exact(b"\0" + PLAIN_CODES), "sound"),
    ("plain floats", plain_floats(), "sound"),
    ("plain floats that end early", plain_floats(PLAIN_FLOATS[:-1]), "damaged"),
    ("plain floats with a byte behind them", plain_floats(PLAIN_FLOATS + b"\0"), "damaged"),
    ("plain floats of which some are absent", plain_floats(head=b"\x11"), "damaged"),
    ("plain floats with places", plain_floats(head=b"\x12"), "damaged"),
    ("plain floats below their range", plain_floats(low=1), "damaged"),
    ("plain floats above their range", plain_floats(high=1), "damaged"),
    ("plain floats above the range that a flag makes", plain_floats(head=b"\x18"), "damaged"),
    ("plain floats in the range that a flag makes", plain_floats(head=b"\x18", high=3), "sound"),
    ("plain floats behind a coarsest segment", exact(PLAIN_FLOATS, b"\x10"), "damaged"),
    ("exact floats coded without coarsest codes", exact(PLAIN_CODES, b"\0"), "damaged"),
    ("exact floats of a model that cuts an axis",
     exact(b"\0" + PLAIN_CODES, model=CUT_MODEL), "damaged"),
    ("a model that cuts an axis", stored(model=CUT_MODEL), "sound"),
    ("a model that rounds voxels of a lossless file", stored(model=ROUNDING_MODEL), "damaged"),
    ("a model that rounds details of a lossless file", stored(model=QUANTIZING_MODEL), "damaged"),
    ("one that no brick needs", {"model": ROUNDING_MODEL}, "sound", "damaged"),
    ("a model that rounds voxels", {"model": ROUNDING_MODEL, "max_error": 1.0}, "sound"),
    ("a model that rounds details", {"model": QUANTIZING_MODEL, "max_error": 1.0}, "sound"),
    ("exact floats of a model that rounds voxels",
     exact(b"\0" + PLAIN_CODES, model=ROUNDING_MODEL), "damaged"),
    ("a coded brick", pair(0x38252), "sound"),
    ("a coded brick whose first state is too small", pair(2, 0), "damaged"),
    ("places that leave out too many bits", stored_floats(b"\x02\x18\0\0"), "damaged"),
    ("a stored brick that is too short", stored(STORED[:-1]), "damaged"),
    ("a stored brick that is too long", stored(STORED + b"\0"), "damaged"),
    ("a range wider than the voxels", stored(high=201), "sound", "damaged"),
    ("a range beyond the voxel type", {"low": 256, "high": 256, "plane_digest": bytes(32)},
     "damaged"),
    ("a range below the voxel type", {"low": -1, "high": -1, "plane_digest": bytes(32)},
     "damaged"),
    ("no model", patched("root", 0, 1, b"\0"), "damaged"),
    ("a model that is not there", patched("root", 0, 1, b"\2"), "damaged"),
    ("a needless byte in the root", patched("root", 0, 1, b"\x81\0"), "damaged"),
    ("a byte behind the root", patched("root", 1000, 0, b"\0"), "damaged"),
    ("a model that is a byte shorter", patched("root", 2, 1, b"\x90"), "damaged"),
    ("another CRC of a page", patched("root", 10, 4, b"none"), "damaged"),
    ("another smallest voxel of a page", patched("root", 14, 1, b"\x0c"), "damaged"),
    ("another largest voxel of a page", patched("root", 15, 1, b"\1"), "damaged"),
    ("fewer uniform bricks of a page", patched("root", 16, 1, b"\0"), "damaged"),
    ("more uniform bricks than bricks", patched("root", 16, 1, b"\2"), "damaged"),
    ("pieces that are not there", patched("root", 17, 1, b"\1"), "damaged"),
    ("pieces beyond any file", patched("root", 17, 1, b"\xff" * 9 + b"\1"), "damaged"),
    ("another voxel in a page", patched("pages", 1, 1, b"\x0c"), "damaged"),
    ("a needless byte in a page", patched("pages", 2, 1, b"\x80\0"), "damaged"),
    ("a byte behind a page", patched("pages", 3, 0, b"\0"), "damaged"),
    ("another CRC of a piece", patched("pages", 5, 4, b"none", **stored()), "damaged"),
    ("a second segment of a stored brick",
     {**stored(), "masks": (1, 6), "pieces": (STORED, b"\0")}, "damaged"),
    ("a last piece without coarsest samples", long_brick(b"\0"), "damaged"),
    ("a last piece that ends early", long_brick(b"\x05\0"), "damaged"),
    ("a last piece with a needless byte", long_brick(b"\x80\0\0"), "damaged"),
    ("a model behind the first slab", {"model_slab": 1}, "damaged"),
    # Tiers
    ("two tiers", two_tiers(7), "sound"),
    ("another next tier", two_tiers(8), "sound", "damaged"),
    ("a model of the next tier", two_tiers(7, coarse_model=LIKE_MODEL), "sound"),
    ("a model of the next tier that rounds voxels",
     two_tiers(7, coarse_model=ROUNDING_MODEL, max_error=1.0), "sound", "damaged"),
    ("a model of all tiers that rounds voxels",
     two_tiers(7, model=ROUNDING_MODEL, max_error=1.0), "sound", "damaged"),
    ("a model of the first tier that rounds voxels",
     two_tiers(7, model=ROUNDING_MODEL, coarse_model=LIKE_MODEL, max_error=1.0), "sound"),
    ("two tiers of means", ramps(32), "sound"),
    ("another mean in the next tier", ramps(31), "sound", "damaged"),
    ("two tiers of votes", ramps(0, b"\0", kind=2, like=LIKE_LABELS), "sound"),
    ("another vote in the next tier", ramps(1, b"\0", kind=2, like=LIKE_LABELS), "sound",
     "damaged"),
    ("two tiers of floats", ramps(32, b"\0", voxel_of_code, **coding()), "sound"),
    ("another float in the next tier", ramps(33, b"\0", voxel_of_code, **coding()), "sound",
     "damaged"),
    ("two tiers of plain floats", plain_ramps(32.0), "sound"),
    ("another float above plain ones", plain_ramps(33.0), "sound", "damaged"),
    ("two tiers of plain floats and NaN", plain_ramps(47.0, NAN * 32), "sound"),
    ("another float above plain ones and NaN", plain_ramps(48.0, NAN * 32), "sound", "damaged"),
    ("two tiers of rounded floats", ramps(32, b"", voxel_of_code, max_error=0.5, **coding(3, 0)),
     "sound"),
    ("another rounded float in the next tier",
     ramps(33, b"", voxel_of_code, max_error=0.5, **coding(3, 0)), "sound", "damaged"),
    ("a code in the next tier that stands for the same float",
     two_tiers(8, voxels=(1.0,) * 128, max_error=0.5, **coding(3, 0, 1e-300)), "sound"),
    # Parts
    ("an optional part", {"parts": ((b"note", 0, b"text"),)}, "sound"),
    ("two of a tag", {"parts": ((b"note", 0, b"text"), (b"note", 2, b""))}, "sound"),
    ("a required part", {"parts": ((b"need", 1, b"text"),)}, "newer"),
    ("a part that follows from more than the voxels", {"parts": ((b"note", 4, b"text"),)}, "sound"),
    ("a part that follows from everything", {"parts": ((b"note", 6, b"text"),)}, "sound"),
    ("a flag of a part", {"parts": ((b"note", 8, b"text"),)}, "newer"),
    ("a tag with a blank", {"parts": ((b"no e", 0, b"text"),)}, "damaged"),
    ("a large thumbnail", {"parts": ((b"thmb", 2, bytes(256 << 10)),)}, "sound", "damaged"),
    ("too large a thumbnail", {"parts": ((b"thmb", 2, bytes((256 << 10) + 1)),)}, "damaged"),
    ("1024 parts", {"parts": ((b"note", 0, b""),) * 1024}, "sound"),
    ("more parts", {"parts": ((b"note", 0, b""),) * 1025}, "large"),
    ("more parts, and another kind", {"parts": ((b"note", 0, b""),) * 1025, "kind": 3}, "newer"),
    ("a part elsewhere", patched("directory", 8, 1, b"\0", parts=NOTE), "damaged"),
    ("a longer part", patched("directory", 16, 1, b"\5", parts=NOTE), "damaged"),
    ("another CRC of a part", patched("directory", 24, 4, b"none", parts=NOTE), "sound", "damaged"),
    ("something behind a part", patched("directory", 28, 1, b"\1", parts=NOTE), "newer"),
    ("two thumbnails", {"parts": ((b"thmb", 2, b""), (b"thmb", 2, b""))}, "damaged"),
    ("a thumbnail", {"parts": ((b"note", 0, b"text"), (b"thmb", 2, BLACK))}, "sound"),
    *((f"a thumbnail with flags {flags}", {"parts": ((b"thmb", flags, BLACK),)}, "damaged")
      for flags in (0, 1, 3, 4, 6)),
    ("a thumbnail with a flag of a later version", {"parts": ((b"thmb", 10, BLACK),)}, "newer"),
    ("a thumbnail of other voxels", stored(parts=((b"thmb", 2, BLACK),)),
     "sound", "damaged"),
    ("an empty thumbnail", {"parts": ((b"thmb", 2, b""),)}, "sound", "damaged"),
    ("a thumbnail with more behind it", {"parts": ((b"thmb", 2, BLACK + b" "),)},
     "sound", "damaged"),
    ("a part that ends behind the directory", {"parts": ((b"note", 0, b"text"),),
                                               "part_length": 1000}, "damaged"),
    ("a required part that does", {"parts": NEEDED, "part_length": 1000}, "newer"),
    ("a required part with a blank in its tag", {"parts": ((b"ne d", 1, b"text"),)}, "newer"),
    ("a required part behind one elsewhere",
     patched("directory", 8, 1, b"\0", parts=NOTE + NEEDED), "newer"),
    ("a required part and half an entry",
     patched("directory", 32, 0, bytes(16), parts=NEEDED), "damaged"),
    ("a required part and another CRC of the root",
     patched("header", 296, 4, b"none", parts=NEEDED), "newer"),
    ("a required part and another CRC of the directory",
     patched("header", 320, 4, b"none", parts=NEEDED), "damaged"),
    ("a part in no directory", {"parts": ((b"note", 0, b"text"),), "directory": b""}, "damaged"),
    ("half an entry", {"directory": bytes(16)}, "damaged"),
    # Digests
    ("another digest of voxels", {"digest": b"d" * 32}, "sound", "damaged"),
    ("other digests of planes", {"plane_digest": b"p" * 32}, "sound", "damaged"),
    # Metadata
    ("long metadata", {"metadata": b'{"a":"' + b"b" * 65536 + b'"}  '}, "sound"),
    ("too long a string", {"metadata": b'{"a":"' + b"b" * 65537 + b'"}'}, "sound", "damaged"),
    ("a number that JSON lacks", {"metadata": b'{"a":NaN}'}, "sound", "damaged"),
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


def with_piece_changed(data, page, piece, level):
    """The file with new checksums of its first brick's changed piece, and of what lists it."""
    offset, length, crc = piece
    renewed = crc32c(data[216:224] + struct.pack("<BQ", level, 0) + data[offset : offset + length])
    replace(data, page.offset, page.length, crc, renewed)
    pages, root = (struct.unpack_from("<QQ", data, field) for field in (256, 280))
    renewed = crc32c(data[page.offset : page.offset + page.length])
    replace(data, *root, page.crc, renewed)
    for field, (begin, size) in ((256, pages), (280, root)):
        struct.pack_into("<I", data, field + 16, crc32c(data[begin : begin + size]))
    return sealed(data[:512], bytes(data[512:-TRAILER_LENGTH]), data[-TRAILER_LENGTH:])


def replace(data, begin, length, old, new):
    """Replaces the one place of a checksum."""
    at = data.index(struct.pack("<I", old), begin, begin + length)
    data[at : at + 4] = struct.pack("<I", new)


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

    def test_the_list_of_parts_of_a_brick_is_proven_by_who_reads_parts(self):
        data = (GOLDEN / "boxes-edges.8vo").read_bytes()
        with OctavoFile(GOLDEN / "boxes-edges.8vo") as file:
            brick = next(file.bricks(0))
            page = file.root.pages[0][0][0]
        offset, length, _ = brick.pieces[1]
        at = offset
        while data[at] >= 128:  # the length of the first part
            at += 1
        data = bytearray(data)
        data[at + 1] ^= 1
        self.path.write_bytes(with_piece_changed(data, page, brick.pieces[1], 1))
        self.assertEqual(self.of_program("verify")[0], "damaged")
        self.assertEqual(self.of_package(verify)[0], "damaged")
        out = str(self.path.parent / "out.raw")
        box = ("--box", "0:34,0:20,0:32", "-o", out, "--stored")
        self.assertEqual(self.of_program("extract", *box)[0], "damaged")
        for threads in ("1", "2"):
            whole = ("-o", out, "--force", "--threads", threads)
            self.assertEqual(self.of_program("export", *whole)[0], "damaged")
        self.assertEqual(self.of_package(lambda file: file.read_level(0))[0], "damaged")
        self.assertEqual(self.of_package(lambda file: file.read_level(1))[0], "sound")

    def test_models_of_other_axis_orders_are_named(self):
        for model, coarse, outcome in ((TURNED_MODEL, TURNED_MODEL, "sound"),
                                       (LIKE_MODEL, TURNED_MODEL, "damaged"),
                                       (TURNED_MODEL, LIKE_MODEL, "damaged")):
            crafted = Crafted(like=LIKE, **two_tiers(7, model=model, coarse_model=coarse))
            self.path.write_bytes(crafted.bytes())
            self.assertEqual(self.of_package(lambda file: file.read_level(0))[0], "sound")
            for found, said in (self.of_program("verify"), self.of_package(verify)):
                self.assertEqual(found, outcome, said)
                self.assertEqual("model 1" in said and "axis order" in said, outcome == "damaged",
                                 said)

    def test_metadata_beyond_their_limit_are_not_read(self):
        data = Crafted(LIKE).bytes()
        begin, length = struct.unpack_from("<QQ", data, 232)
        for growth, outcome in (((16 << 20) - length + 1, "large"), (7, "damaged")):
            header, trailer = bytearray(data[:512]), bytearray(data[-TRAILER_LENGTH:])
            for field, value in ((240, length), (280, begin + length), (224, len(data))):
                struct.pack_into("<Q", header, field, value + growth)
            struct.pack_into("<I", header, 508, crc32c(header[:508]))
            trailer[16:28] = header[224:232] + header[508:512]
            struct.pack_into("<I", trailer, 92, crc32c(trailer[:92]))
            between = (data[512 : begin + length] + b" " * growth
                       + data[begin + length : -TRAILER_LENGTH])
            self.path.write_bytes(header + between + trailer)
            self.assertEqual(self.of_program("verify")[0], outcome)
            self.assertEqual(self.of_package(verify)[0], outcome)

    def test_the_package_ends_with_the_exit_status_of_the_program(self):
        for changes in ({}, {"kind": 3}, {"slope": 0.0}, {"masks": (1,) * 32}):
            self.path.write_bytes(Crafted(**{"like": LIKE, **changes}).bytes())
            command = [OCTAVO, "verify", str(self.path), "--quiet"]
            program = subprocess.run(command, capture_output=True, check=False)
            command = [sys.executable, "-m", "octavo_reader", str(self.path), "--verify"]
            package = subprocess.run(command, capture_output=True, check=False,
                                     cwd=ROOT / "python")
            self.assertEqual(package.returncode, program.returncode, changes)

    def test_both_readers_reject_the_same_files(self):
        out = str(self.path.parent / "out.raw")
        for name, changes, opening, *verifying in ROWS:
            self.path.write_bytes(Crafted(**{"like": LIKE, **changes}).bytes())
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
