#!/usr/bin/env python3
"""Proves that every relative link of the documents leads to a file, and every #anchor to a heading.

CONTRIBUTING.md and docs/*.md also name files between backticks, from the root of the tree or from
src/octavo: each of these must exist, braces and stars meant as in a shell. Names with a word in
capitals (NAME) are placeholders.

usage: check_links.py [ROOT]
"""

import pathlib
import re
import sys

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
SPAN = re.compile(r"`([^`\n]+)`")
TREE_PATH = re.compile(r"[\w.*-]+/[\w./*{},-]*")
PLACEHOLDER = re.compile(r"(?<![A-Za-z])[A-Z]{3,}(?![A-Za-z]|\.md)")
OUTPUT = {"build", "build-nightly", "demo-out"}
BRACES = re.compile(r"\{([^{}]*)\}")
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


def expanded(path: str) -> list[str]:
    """The paths that a name with braces stands for."""
    match = BRACES.search(path)
    if not match:
        return [path]
    return [one for choice in match.group(1).split(",")
            for one in expanded(path[:match.start()] + choice + path[match.end():])]


def path_errors(text: str, root: pathlib.Path) -> tuple[int, list[str]]:
    """How many files of the tree a text names between backticks, and those that do not exist."""
    bases = (root, root / "src/octavo")
    count, errors = 0, []
    for words in SPAN.findall(text):
        for name in words.split():
            first = name.split("/")[0]
            is_known = any((base / first).is_dir() for base in bases) and first not in OUTPUT
            if not is_known or not TREE_PATH.fullmatch(name) or PLACEHOLDER.search(name):
                continue
            for path in expanded(name):
                count += 1
                if not any(any(base.glob(path.rstrip("/"))) for base in bases):
                    errors.append(f"no such file: {path}")
    return count, errors


def main(root: pathlib.Path) -> int:
    errors, count, path_count = [], 0, 0
    for document in documents(root):
        name, text = document.relative_to(root), document.read_text()
        for target in LINK.findall(text):
            count += 1
            error = link_error(document, target)
            if error:
                errors.append(f"{name}: {error}")
        if name.parent.name == "docs" or name.name == "CONTRIBUTING.md":
            paths, missing = path_errors(text, root)
            path_count += paths
            errors += [f"{name}: {error}" for error in missing]
    print("\n".join(errors) if errors else f"{count} links resolve, and {path_count} paths")
    return 1 if errors else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
