#!/usr/bin/env python3
"""Proves that every relative link of the documents leads to a file, and every #anchor to a heading.

usage: check_links.py [ROOT]
"""

import pathlib
import re
import sys

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+\s+(.*)$", re.MULTILINE)


def anchor(heading: str) -> str:
    """The anchor that hosts of Markdown give to a heading."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def documents(root: pathlib.Path):
    yield from sorted(root.glob("*.md"))
    for folder in ("docs", "src", "cli", "tests", "bench", "tools", "examples", "python", "web"):
        for path in sorted((root / folder).rglob("*.md")):
            if "node_modules" not in path.parts:
                yield path


def link_error(document: pathlib.Path, target: str) -> str | None:
    if re.match(r"[a-z]+:", target):
        return None
    name, _, fragment = target.partition("#")
    path = document.parent / name if name else document
    if not path.exists():
        return f"no such file: {name}"
    if fragment and path.suffix == ".md":
        if fragment not in {anchor(h) for h in HEADING.findall(path.read_text())}:
            return f"no such heading: {target}"
    return None


def main(root: pathlib.Path) -> int:
    errors, count = [], 0
    for document in documents(root):
        for target in LINK.findall(document.read_text()):
            count += 1
            error = link_error(document, target)
            if error:
                errors.append(f"{document.relative_to(root)}: {error}")
    print("\n".join(errors) if errors else f"{count} links resolve")
    return 1 if errors else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
