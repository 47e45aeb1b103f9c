"""Shows the types that tell where something lies the way people write them, in gdb.

    (gdb) source tools/gdb_printers.py
    (gdb) print box
    $1 = 0:64,0:64,32:64 (64 x 64 x 32)

Index3, Size3, Box; OCode as level, digits and box; MaskTree and MaskCube with their counts.
"""

import gdb

OCTANT_BITS = ((2, "z"), (1, "x"), (0, "y"))  # of a digit of an o-code


def numbers(value):
    return {axis: int(value[axis]) for axis in "xyz"}


def vector_size(vector):
    first, last = vector["_M_impl"]["_M_start"], vector["_M_impl"]["_M_finish"]
    return int(last - first)


class Index3:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        return "({x}, {y}, {z})".format(**numbers(self.value))


class Size3:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        return "{x} x {y} x {z}".format(**numbers(self.value))


class Box:
    """Half-open, as the command line takes it."""

    def __init__(self, value):
        self.lo, self.hi = numbers(value["lo"]), numbers(value["hi"])

    def to_string(self):
        sides = ",".join(f"{self.lo[a]}:{self.hi[a]}" for a in "xyz")
        lengths = " x ".join(str(self.hi[a] - self.lo[a]) for a in "xyz")
        return f"{sides} ({lengths})"


class OCode:
    """The digits of the code from the top, without leading zeros, and the cube."""

    def __init__(self, value):
        self.level, self.code = int(value["level"]), int(value["code"])

    def corner(self):
        place, code, shift = dict(x=0, y=0, z=0), self.code, self.level
        while code:
            for bit, axis in OCTANT_BITS:
                place[axis] |= (code >> bit & 1) << shift
            code, shift = code >> 3, shift + 1
        return place

    def to_string(self):
        side = 1 << self.level
        where = "({x}, {y}, {z})".format(**self.corner())
        return f"level {self.level}, code {self.code:o} (octal): side {side} at {where}"


class MaskCube:
    def __init__(self, value):
        self.full, self.mixed = int(value["full"]), int(value["mixed"])
        self.first = int(value["first"])

    def to_string(self):
        return (f"{bin(self.full).count('1')} full and {bin(self.mixed).count('1')} mixed of 64, "
                f"first mixed at {self.first}")


class MaskTree:
    def __init__(self, value):
        self.value = value

    def to_string(self):
        arrays = self.value["arrays_"]
        words = vector_size(arrays["words"])
        first = arrays["cubes"]["_M_impl"]["_M_start"]
        rank_count = vector_size(arrays["cubes"])
        ranks = [vector_size((first + i).dereference()) for i in range(rank_count)]
        size = Size3(self.value["size_"]).to_string()
        return f"mask of {size} voxels: {words} mixed words, cubes by rank {ranks}"


def make_printers():
    printers = gdb.printing.RegexpCollectionPrettyPrinter("octavo")
    for kind in (Index3, Size3, Box, OCode, MaskCube, MaskTree):
        printers.add_printer(kind.__name__, f"^octavo::{kind.__name__}$", kind)
    return printers


gdb.printing.register_pretty_printer(None, make_printers(), replace=True)
