#!/usr/bin/env python3
"""Proves the table of awkward files in docs/sources.md: every row is run and must be true.

usage: awkward_test.py OCTAVO docs/sources.md [--write]

A row names a source of the shared folder `awkward`, the options given to `octavo build`, the exit
code, and what comes out of it: the message word by word, or the size, type and spacing of the
volume, how it is rescaled, the CRC-32 of its stored voxels as `export` writes them (x fastest,
little-endian), and the warnings. With --write the last two columns are written anew.
Every file of the shared folder has a row. Skipped with a message where that folder is missing.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import zlib

HEADING = "| Source | What it is | Options | Exit | What Octavo says or builds |"
SKIPPED = 77


def awkward_folder():
    given = os.environ.get("OCTAVO_SHARED_DATA")
    if given:
        candidates = [pathlib.Path(given)]
    else:
        candidates = [p / "shared" / "data" for p in pathlib.Path(__file__).resolve().parents]
    return next((c / "awkward" for c in candidates if (c / "awkward").is_dir()), None)


def rows_of(text):
    """The lines of the table, each with its cells; a cell never holds a bar."""
    lines = text.splitlines()
    start = lines.index(HEADING) + 2
    rows = []
    for number in range(start, len(lines)):
        if not lines[number].startswith("|"):
            break
        rows.append((number, [cell.strip() for cell in lines[number].strip("| ").split(" | ")]))
    return rows


def number_text(value):
    return f"{value:.7g}"


def built_text(octavo, file, folder, warnings):
    info = json.loads(subprocess.run([octavo, "info", file, "--json"], check=True,
                                     capture_output=True, text=True).stdout)
    raw = folder / "voxels.raw"
    subprocess.run([octavo, "export", file, "-o", raw, "--progress", "none", "-q", "--force"],
                   check=True)
    text = " x ".join(map(str, info["size"])) + f" {info['type']}"
    text += " labels" if info["kind"] == "labels" else ""
    text += ", " + " x ".join(map(number_text, info["spacing_mm"])) + " mm"
    text += {"user": " (given)", "assumed": " (assumed)"}.get(
        info["metadata"].get("spacing_source"), "")
    slope, intercept = info["rescale"]["slope"], info["rescale"]["intercept"]
    if (slope, intercept) != (1, 0):
        text += f", real value {slope!r} x + {intercept!r}"
    text += f", voxels `{zlib.crc32(raw.read_bytes()):08x}`"
    return "".join([text, *(f"<br>warning: {warning}" for warning in warnings)])


def outcome(octavo, awkward, source, options):
    """The exit code and the last cell of a row."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [octavo, "build", source, "-o", folder / "a.8vo", "--progress", "none", "-q"]
        result = subprocess.run([*command, *options.split()], cwd=awkward, capture_output=True,
                                text=True, check=False)
        said = [line.removeprefix("octavo: ") for line in result.stderr.splitlines()]
        warnings = [s.removeprefix("warning: ") for s in said if s.startswith("warning: ")]
        if result.returncode == 0:
            return 0, built_text(octavo, folder / "a.8vo", folder, warnings)
        left = [p.name for p in folder.iterdir()]
        errors = [line for line in said if not line.startswith("warning: ")]
        if left or result.stdout or len(errors) != 1:
            return result.returncode, f"left behind: {left}, said: {said} {result.stdout}"
        return result.returncode, f"`{errors[0]}`"


def missing_rows(awkward, sources):
    """Files of the folder that no row names, itself or the folder they lie in."""
    return [str(path.relative_to(awkward)) for path in awkward.iterdir()
            if not any(re.match(re.escape(path.name) + "(/|$)", source) for source in sources)]


def main():
    octavo = os.path.abspath(sys.argv[1])
    page = pathlib.Path(sys.argv[2])
    awkward = awkward_folder()
    if awkward is None:
        print("skipped: no shared volumes; tests/README.md says what they are")
        return SKIPPED
    lines = page.read_text().splitlines()
    rows = rows_of(page.read_text())
    failures = 0
    for number, cells in rows:
        source, what = cells[0].strip("`"), cells[1]
        options = "" if cells[2] == "-" else cells[2].strip("`")
        code, text = outcome(octavo, awkward, source, options)
        if "--write" in sys.argv:
            cells = [cells[0], what, cells[2], str(code), text.replace("|", "/")]
            lines[number] = "| " + " | ".join(cells) + " |"
        elif (str(code), text) != (cells[3], cells[4]):
            failures += 1
            print(f"{source} {options}\n  the table: {cells[3]} {cells[4]}\n"
                  f"  the program: {code} {text}")
    if "--write" in sys.argv:
        page.write_text("\n".join(lines) + "\n")
    for name in missing_rows(awkward, [cells[0].strip("`") for _, cells in rows]):
        failures += 1
        print(f"{name}: no row in the table")
    print(f"{len(rows)} rows, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
