#!/usr/bin/env python3
"""The code that takes header, index and trailer apart is short enough to be read in an hour.

usage: tools/check_parser.py [ROOT]

Counts lines of code, without comments and blank lines, in the files of the parser; functions
and classes that only write (encode_..., put_..., make_build_id, ...Writer) are left out. Prints the
count; exit 1 above 800.
"""

import pathlib
import re
import sys

# index_root.cpp looks up what these have proven.
FILES = ["byte_codec.h", "layout.cpp", "directory.cpp", "index.cpp", "pieces.cpp"]
MOST_LINES = 800
WRITES = re.compile(r"^\S.*?\b(encode_\w+|put_\w+|make_build_id|store_\w+)\(|^class \w*Writer ")


def code_lines(path):
    """Lines of code outside writing functions."""
    count = 0
    is_writing = False
    for line in path.read_text(encoding="utf-8").splitlines():
        text = line.strip()
        if not text or text.startswith("//"):
            continue
        if WRITES.match(line):
            is_writing = not text.endswith((";", "}"))
            continue
        if is_writing:
            is_writing = line not in ("}", "};")
            continue
        count += 1
    return count


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    counts = {name: code_lines(root / "src/octavo/file" / name) for name in FILES}
    total = sum(counts.values())
    print(f"goal Q2: {total} lines of code parse header, directory, index and trailer, "
          f"at most {MOST_LINES}"
          f" ({', '.join(f'{name} {count}' for name, count in counts.items())})")
    return 0 if total <= MOST_LINES else 1


if __name__ == "__main__":
    sys.exit(main())
