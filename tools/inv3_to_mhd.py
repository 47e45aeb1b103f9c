#!/usr/bin/env python3
"""Turns an InVesalius project (.inv3) into a MetaImage header with its raw voxels.

usage: inv3_to_mhd.py PROJECT.inv3 OUTPUT.mhd

A project is a tar file: main.plist names the matrix, its type, shape (z, y, x) and spacing
(x, y, z).
"""

import pathlib
import plistlib
import shutil
import sys
import tarfile

ELEMENT_TYPES = {"int16": "MET_SHORT", "uint16": "MET_USHORT", "uint8": "MET_UCHAR"}


def convert(project: str, header: pathlib.Path) -> None:
    raw = header.with_suffix(".raw")
    with tarfile.open(project) as tar:
        members = {pathlib.PurePath(m.name).name: m for m in tar.getmembers()}
        plist = plistlib.load(tar.extractfile(members["main.plist"]))
        matrix = plist["matrix"]
        with open(raw, "wb") as out:
            shutil.copyfileobj(tar.extractfile(members[matrix["filename"]]), out)
    numbers = lambda values: " ".join(str(v) for v in values)
    header.write_text(
        "ObjectType = Image\n"
        "NDims = 3\n"
        "BinaryData = True\n"
        "BinaryDataByteOrderMSB = False\n"
        "CompressedData = False\n"
        "TransformMatrix = 1 0 0 0 1 0 0 0 1\n"
        "Offset = 0 0 0\n"
        f"ElementSpacing = {numbers(plist['spacing'])}\n"
        f"DimSize = {numbers(reversed(matrix['shape']))}\n"
        f"ElementType = {ELEMENT_TYPES[matrix['dtype']]}\n"
        f"ElementDataFile = {raw.name}\n"
    )


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    convert(sys.argv[1], pathlib.Path(sys.argv[2]))
