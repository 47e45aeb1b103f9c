#!/usr/bin/env python3
"""Proves the limits of length: 600 lines a file, 100 columns a line, 30 .cpp files a folder.

usage: check_lengths.py [ROOT]

The limit holds for tables, too. The README of a module stays within 40 lines.
"""

import collections
import pathlib
import sys

MAX_LINES = 600
MAX_README_LINES = 40
MAX_COLUMNS = 100
MAX_SOURCES = 30
FOLDERS = ("src", "cli", "tests", "bench", "tools", "examples", "cmake", "web", "python")
GENERATED = {"node_modules", "__pycache__"}
SOURCES = {".h", ".cpp", ".py", ".cmake", ".ts", ".js"}


def sources(root: pathlib.Path):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            is_source = path.suffix in SOURCES or path.name in ("README.md", "CMakeLists.txt")
            if path.is_file() and is_source and not is_generated(path.relative_to(root).parts):
                yield path


def is_generated(parts) -> bool:
    return bool(GENERATED & set(parts)) or (parts[0] == "web" and "dist" in parts)


def check_file(path: pathlib.Path, root: pathlib.Path) -> list[str]:
    name = path.relative_to(root)
    lines = path.read_text().splitlines()
    limit = MAX_README_LINES if path.name == "README.md" and "octavo" in name.parts else MAX_LINES
    errors = []
    if len(lines) > limit:
        errors.append(f"{name}: {len(lines)} lines, at most {limit}")
    if path.name != "README.md":
        errors += [f"{name}:{number}: {len(line)} columns, at most {MAX_COLUMNS}"
                   for number, line in enumerate(lines, 1) if len(line) > MAX_COLUMNS]
    return errors


def check_folders(paths: list[pathlib.Path], root: pathlib.Path) -> list[str]:
    counts = collections.Counter(path.parent for path in paths if path.suffix == ".cpp")
    return [f"{folder.relative_to(root)}: {count} .cpp files, at most {MAX_SOURCES}"
            for folder, count in counts.items() if count > MAX_SOURCES]


def main(root: pathlib.Path) -> int:
    paths = list(sources(root))
    errors = [error for path in paths for error in check_file(path, root)]
    errors += check_folders(paths, root)
    print("\n".join(errors) if errors else f"{len(paths)} files are within the limits")
    return 1 if errors or not paths else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
