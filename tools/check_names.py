#!/usr/bin/env python3
"""Proves that no two types of one namespace have one name.

usage: check_names.py [ROOT]

Two definitions of one name in one program are undefined behavior, even in sources that never see
each other: the linker takes one destructor for both. Types in unnamed namespaces are free.
"""

import collections
import pathlib
import re
import sys

# Code stands at the first column of its namespace.
OPENED = re.compile(r"namespace(?:\s+([\w:]+))?\s*\{")
CLOSED = re.compile(r"\}\s*//\s*namespace")
TYPE = re.compile(r"(?:template\s*<[^{};]*>\s*)?"
                  r"(?:class|struct|union|enum(?:\s+(?:class|struct))?)\s+"
                  r"(?:\[\[\w+\]\]\s*)?(?:alignas\([^)]*\)\s*)?(\w+)\b(?!::)")
ALIAS = re.compile(r"using\s+(\w+)\s*=")
ONE_LINE = re.compile(r"(namespace\s+[\w:]*\s*\{).*\}\s*$")


def definition(lines: list[str], at: int) -> str | None:
    """The name of the type whose definition begins in a line; a declaration defines none."""
    if match := ALIAS.match(lines[at]):
        return match.group(1)
    match = TYPE.match(lines[at])
    if match is None:
        return None
    for line in lines[at:]:
        if "{" in line:
            # A function may return `struct X`.
            return match.group(1) if ";" not in line.split("{")[0] else None
        if ";" in line:
            return None
    return None


def types_of(path: pathlib.Path):
    """(namespace, name, line number) of every type that `path` defines in a named namespace."""
    spaces: list[str | None] = []
    lines = path.read_text().splitlines()
    for at, line in enumerate(lines):
        if ONE_LINE.match(line):
            continue
        if match := OPENED.match(line):
            spaces.append(match.group(1))
        elif CLOSED.match(line):
            spaces.pop()
        elif spaces and None not in spaces and (name := definition(lines, at)):
            yield "::".join(spaces), name, at + 1


def sources(root: pathlib.Path):
    return [path for folder in ("src/octavo", "cli") for path in sorted((root / folder).rglob("*"))
            if path.suffix in (".h", ".cpp")]


def main(root: pathlib.Path) -> int:
    places = collections.defaultdict(list)
    for path in sources(root):
        for space, name, line in types_of(path):
            places[space, name].append(f"{path.relative_to(root)}:{line}")
    errors = [f"{where[-1]}: {space}::{name} is defined in {where[0]} as well"
              for (space, name), where in places.items() if len(where) > 1]
    print("\n".join(errors) if errors else f"{len(places)} types have a name each")
    return 1 if errors or not places else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
