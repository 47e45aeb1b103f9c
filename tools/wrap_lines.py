#!/usr/bin/env python3
"""Breaks the lines of C++ files that are longer than 100 columns, and leaves all others alone.

usage: wrap_lines.py FILE...

Needs clang-format; .clang-format in the root holds the style.
"""

import pathlib
import subprocess
import sys

MAX_COLUMNS = 100


def wrap(path: str) -> int:
    """The number of lines that were too long."""
    lines = pathlib.Path(path).read_text().splitlines()
    long = [number for number, line in enumerate(lines, 1) if len(line) > MAX_COLUMNS]
    if long:
        ranges = [f"--lines={number}:{number}" for number in long]
        subprocess.run(["clang-format", "-i", *ranges, path], check=True)
    return len(long)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print(sum(wrap(path) for path in sys.argv[1:]), "lines wrapped")
