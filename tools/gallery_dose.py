#!/usr/bin/env python3
"""Writes a made-up dose in Gy on a coarse grid over the CT head of the demo, as MetaImage.

usage: gallery_dose.py OUT.mhd
"""

import array
import math
import pathlib
import sys

SIZE = (52, 52, 34)
SPACING = 5.0
CENTERS = ((120.0, 150.0, 95.0, 60.0, 24.0), (150.0, 120.0, 80.0, 34.0, 38.0))  # mm, Gy, mm


def dose(x: float, y: float, z: float) -> int:
    """In hundredths of a Gy: two targets with soft edges."""
    total = 0.0
    for cx, cy, cz, peak, radius in CENTERS:
        distance = math.dist((x, y, z), (cx, cy, cz))
        total = max(total, peak / (1 + math.exp((distance - radius) / 6)))
    return round(100 * total)


def main(path: pathlib.Path) -> None:
    voxels = array.array("h", (dose(x * SPACING, y * SPACING, z * SPACING)
                               for z in range(SIZE[2]) for y in range(SIZE[1])
                               for x in range(SIZE[0])))
    if sys.byteorder == "big":
        voxels.byteswap()
    raw = path.with_suffix(".raw")
    raw.write_bytes(voxels.tobytes())
    path.write_text(f"ObjectType = Image\nNDims = 3\nDimSize = {SIZE[0]} {SIZE[1]} {SIZE[2]}\n"
                    f"ElementSpacing = {SPACING} {SPACING} {SPACING}\nElementType = MET_SHORT\n"
                    f"ElementByteOrderMSB = False\nElementDataFile = {raw.name}\n")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
