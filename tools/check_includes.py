#!/usr/bin/env python3
"""Proves the dependency rule: who may include whom.

usage: check_includes.py [ROOT]

The rule stands in docs/architecture.md. Every violation is printed as FILE:LINE: reason.
"""

import pathlib
import re
import sys

# Modules of src/octavo each module may include besides itself.
MAY_INCLUDE = {
    "core": set(),
    "codec": {"core"},
    "file": {"core", "codec"},
    "build": {"core", "codec", "file"},
    "ops": {"core", "codec", "file"},
    "mesh": {"core", "codec", "file"},
    "render": {"core", "codec", "file"},
    "io": {"core", "codec", "file", "build"},
    "dist": {"core", "codec", "file", "build"},
}

# Third-party headers by library, and the modules that may see each; cli may see all of them.
LIBRARIES = {
    "ITK": (re.compile(r"itk\w+\.(h|hxx)$"), {"io"}),
    "GDCM": (re.compile(r"gdcm\w*\.h$"), {"io"}),
    "libtiff": (re.compile(r"tiff\w*\.h$"), {"io"}),
    "libpng": (re.compile(r"png\w*\.h$"), {"io", "render"}),
    "zlib": (re.compile(r"zlib\.h$"), {"io", "render"}),
    "libcurl": (re.compile(r"curl/"), {"io"}),
    "oneTBB": (re.compile(r"(oneapi/)?tbb/"), set(MAY_INCLUDE) - {"core"}),
    "Highway": (re.compile(r"hwy/"), {"codec", "ops", "render"}),
    "nlohmann-json": (re.compile(r"nlohmann/"), {"io", "build"}),
    "fmt": (re.compile(r"fmt/"), {"io"}),
    "MPI": (re.compile(r"mpi\.h$"), {"dist"}),
    "CLI11": (re.compile(r"CLI/"), set()),
}

# The standard library has no dot in its names; POSIX headers serve disk and CPU check.
SYSTEM = re.compile(r"([a-z_0-9]+|(sys/|linux/)?[a-z_0-9]+\.h)$")

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')

# What the reading half must do without besides every library above.
NOT_WHEN_READING = {"thread", "future", "fstream", "filesystem", "fcntl.h", "unistd.h"}


def includes(path: pathlib.Path):
    """Line number, target and whether it is quoted, of every include."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(2), match.group(1) == '"'


def own_include_error(module: str, target: str) -> str | None:
    other = target.split("/")[1]
    if module == "cli" or other == module or other in MAY_INCLUDE[module]:
        return None
    allowed = ", ".join(sorted(MAY_INCLUDE[module])) or "the standard library only"
    return f"{module} must not include {other} (allowed: {allowed})"


def foreign_include_error(module: str, target: str) -> str | None:
    for library, (pattern, modules) in LIBRARIES.items():
        if not pattern.match(target):
            continue
        if module == "cli" or module in modules:
            return None
        return f"{module} must not see {library} ({target})"
    if module != "cli" and not SYSTEM.match(target):
        return f"{module} includes an unknown library ({target})"
    return None


def check_file(path: pathlib.Path, module: str, root: pathlib.Path) -> list[str]:
    errors = []
    for number, target, quoted in includes(path):
        if target.startswith("octavo/"):
            error = own_include_error(module, target)
        elif quoted and (path.parent / target).exists():
            error = None if module == "cli" else "own headers are included as octavo/MODULE/NAME.h"
        elif quoted and module == "cli" and (root / "cli" / target).exists():
            error = None
        else:
            error = foreign_include_error(module, target)
        if error:
            errors.append(f"{path}:{number}: {error}")
    return errors


def check_reading_half(root: pathlib.Path) -> list[str]:
    """Follows the includes of the sources of octavo::read to all headers they reach."""
    folder = root / "src/octavo"
    listed = (folder / "ReadingHalf.cmake").read_text()
    waiting = [folder / name for name in re.findall(r"^  (\w+/\w+\.cpp)$", listed, re.MULTILINE)]
    seen, errors = set(waiting), []
    while waiting:
        path = waiting.pop()
        if not path.exists():
            errors.append(f"src/octavo/ReadingHalf.cmake: no such file: {path.relative_to(folder)}")
            continue
        for number, target, _ in includes(path):
            header = root / "src" / target
            if target.startswith("octavo/") and header not in seen:
                seen.add(header)
                waiting.append(header)
            is_foreign = any(pattern.match(target) for pattern, _ in LIBRARIES.values())
            if is_foreign or target in NOT_WHEN_READING:
                errors.append(f"{path}:{number}: the reading half must not include {target}")
    return errors if seen else ["src/octavo/ReadingHalf.cmake: lists no sources"]


def main(root: pathlib.Path) -> int:
    errors, count = [], 0
    for path in sorted(root.glob("src/octavo/*/**/*")) + sorted(root.glob("cli/**/*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        module = "cli" if path.is_relative_to(root / "cli") else path.relative_to(root).parts[2]
        if module != "cli" and module not in MAY_INCLUDE:
            errors.append(f"{path}: unknown module {module}")
            continue
        errors += check_file(path, module, root)
        count += 1
    errors += check_reading_half(root)
    print("\n".join(errors) if errors else f"{count} files follow the dependency rule")
    return 1 if errors or count == 0 else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
