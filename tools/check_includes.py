#!/usr/bin/env python3
"""Proves the dependency rule: who may include whom.

usage: check_includes.py [ROOT]

The rule stands in docs/architecture.md. Every violation is printed as FILE:LINE: reason.
"""

import collections
import pathlib
import re
import sys

# The rooms of src/octavo, and the rooms each may include besides itself.
BELOW_FILE = {"core", "threads", "octree", "codec"}
MAY_INCLUDE = {
    "core": set(),
    "threads": set(),
    "octree": {"core"},
    "planes": {"core"},
    "codec": {"core", "threads", "octree"},
    "file": BELOW_FILE,
    "builder": BELOW_FILE | {"file", "planes"},
    "dist": BELOW_FILE | {"file", "planes", "builder"},
    "io": BELOW_FILE | {"file", "planes"},
    "ops": BELOW_FILE | {"file", "planes"},
    "render": BELOW_FILE | {"file"},
    "mesh": BELOW_FILE | {"file"},
}
MAY_INCLUDE["tasks"] = set(MAY_INCLUDE)

# The command line parses, calls a task and prints: it sees tasks, core, and these headers.
CLI_MAY_INCLUDE = {"tasks", "core"}
CLI_HEADERS = {
    "octavo/io/isolation/import_worker.h",  # main runs as the process that reads a scan
    "octavo/planes/between/isotropic_source.h",  # a type of the options of build_scan
    "octavo/dist/communicator.h",  # what ranks speak through, which cli/mpi makes
    "octavo/dist/rank_report.h",  # a result that cli/mpi prints
    "octavo/dist/mpi/mpi_communicator.h",
}

# Inside a room: its folders, and the files at its root ("."), by what they may include of the same
# room besides themselves. Rooms that are not listed are flat, or their folders are free.
WITHIN = {
    "codec": {
        "entropy": set(),
        "grey": {
            "entropy",
            "brick_codec.h",
            "encoders.h", "stored_brick.h",
            "simd_level.h",
            "simd_targets.h",
            "refine_model.h",
        },
        "label": {
            "entropy",
            "brick_codec.h",
            "label_bricks.h",
            "encoders.h", "stored_brick.h",
            "simd_level.h",
            "simd_targets.h",
        },
        ".": {"entropy", "grey", "label"},
    },
    "file": {
        "storage": set(),
        ".": {"storage"},
        "write": {"storage", "."},
        "repair": {"storage", ".", "write"},
    },
    "io": {
        "source": {"source_options.h"},
        "dicom": {"source", "source_options.h"},
        "images": {"source", "source_options.h"},
        "volumes": {"source", "source_options.h"},
        "export": {"source"},
        "http": {"source"},
        "serve": set(),
        ".": {"source", "dicom", "images", "volumes", "zarr"},
        "isolation": {"source", "."},
    },
    "planes": {".": set(), "between": {"."}},
    "render": {".": set(), "slice": {"."}, "cubes": {"."}, "transparency": {".", "cubes"},
               "rays": {"."}},
}

# More .cpp files than this make a folder hard to find one's way in.
MAX_SOURCES_PER_FOLDER = 30

# Third-party headers by library, and the rooms that may see each; cli may see all of them.
LIBRARIES = {
    "ITK": (re.compile(r"itk\w+\.(h|hxx)$"), set()),
    "GDCM": (re.compile(r"gdcm\w*\.h$"), {"io"}),
    "libtiff": (re.compile(r"tiff\w*\.h$"), {"io"}),
    "libpng": (re.compile(r"png\w*\.h$"), {"io", "render"}),
    "FreeType": (re.compile(r"freetype/"), {"render"}),
    "libwebp": (re.compile(r"webp/"), {"render"}),
    "zlib": (re.compile(r"zlib\.h$"), {"io", "render"}),
    "meshoptimizer": (re.compile(r"meshoptimizer\.h$"), {"mesh"}),
    "minizip": (re.compile(r"minizip/"), {"mesh"}),
    "libcurl": (re.compile(r"curl/"), {"io"}),
    "libcrypto": (re.compile(r"openssl/"), {"builder"}),
    "oneTBB": (re.compile(r"(oneapi/)?tbb/"), {"threads", "builder", "render"}),
    "Highway": (re.compile(r"hwy/"), {"codec", "ops", "render"}),
    "nlohmann-json": (re.compile(r"nlohmann/"), set()),
    "fmt": (re.compile(r"fmt/"), {"io", "tasks"}),
    "MPI": (re.compile(r"mpi\.h$"), {"dist"}),
    "CLI11": (re.compile(r"CLI/"), set()),
}

# The standard library has no dot in its names; POSIX headers serve disk and CPU check.
SYSTEM = re.compile(r"([a-z_0-9]+|(sys/|linux/|asm/|arpa/|netinet/|net/)?[a-z_0-9]+\.h)$")

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')

# What the reading half must do without besides every library above.
NOT_WHEN_READING = {"thread", "future", "fstream", "filesystem", "fcntl.h", "unistd.h", "format",
                    "ranges"}

# Words of C++20 that the standard library of Emscripten 3.1 lacks.
NOT_EVERYWHERE = re.compile(r"std::(bit_cast|ranges|views|format|jthread|make_unique_for_overwrite|"
                            r"make_shared_for_overwrite|source_location)\b")


def includes(path: pathlib.Path):
    """Line number, target and whether it is quoted, of every include."""
    for number, line in enumerate(path.read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(2), match.group(1) == '"'


def place_of(target: str) -> tuple[str, str, str]:
    """Room, folder within it ("." at its root) and name of an include "octavo/..."."""
    parts = target.split("/")[1:]
    return parts[0], parts[1] if len(parts) > 2 else ".", parts[-1]


def own_include_error(module: str, folder: str, target: str) -> str | None:
    room, other_folder, name = place_of(target)
    if module == "cli":
        if room in CLI_MAY_INCLUDE or target in CLI_HEADERS:
            return None
        return f"cli must not include {target} (allowed: tasks, core)"
    if room != module:
        if room in MAY_INCLUDE[module]:
            return None
        allowed = ", ".join(sorted(MAY_INCLUDE[module])) or "the standard library only"
        return f"{module} must not include {room} (allowed: {allowed})"
    within = WITHIN.get(module, {}).get(folder)
    if within is None or other_folder == folder or {other_folder, name} & within:
        return None
    allowed = ", ".join(sorted(within)) or "itself only"
    where = module if folder == "." else f"{module}/{folder}"
    return f"{where} must not include {target} (allowed within {module}: {allowed})"


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
    below = path.relative_to(root).parts
    folder = below[3] if len(below) > 4 else "."
    for number, target, quoted in includes(path):
        if target.startswith("octavo/"):
            error = own_include_error(module, folder, target)
        elif quoted and (path.parent / target).exists():
            error = None if module == "cli" else "own headers are included as octavo/MODULE/NAME.h"
        elif quoted and module == "cli" and (root / "cli" / target).exists():
            error = None
        else:
            error = foreign_include_error(module, target)
        if error:
            errors.append(f"{path}:{number}: {error}")
    return errors


def words_missing_elsewhere(path: pathlib.Path) -> list[str]:
    return [f"{path}:{number}: the reading half must do without {match.group()}"
            for number, line in enumerate(path.read_text().splitlines(), 1)
            if (match := NOT_EVERYWHERE.search(line))]


def check_reading_half(root: pathlib.Path) -> list[str]:
    """Follows the includes of the sources of octavo::read to all headers they reach."""
    folder = root / "src/octavo"
    listed = (folder / "ReadingHalf.cmake").read_text()
    waiting = [folder / name for name in re.findall(r"^  ([\w/]+\.cpp)$", listed, re.MULTILINE)]
    seen, errors = set(waiting), []
    # Vectorized decoders see Highway, and must compile wherever the others do.
    for path in {folder / name for name in re.findall(r"[\w/]+\.cpp", listed)} - seen:
        errors += words_missing_elsewhere(path)
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
        errors += words_missing_elsewhere(path)
    return errors if seen else ["src/octavo/ReadingHalf.cmake: lists no sources"]


def built_sources(root: pathlib.Path) -> set[pathlib.Path]:
    """Every .cpp that the CMakeLists.txt of src/octavo and cli name."""
    built = set()
    lists = [*root.glob("src/octavo/**/CMakeLists.txt"), *root.glob("cli/**/CMakeLists.txt")]
    for path in lists + [root / "src/octavo/ReadingHalf.cmake"]:
        text = re.sub(r"#.*", "", path.read_text())
        built |= {path.parent / name for name in re.findall(r"[\w/-]+\.cpp", text)}
    return built


def check_folders(paths: list[pathlib.Path]) -> list[str]:
    counts = collections.Counter(path.parent for path in paths if path.suffix == ".cpp")
    return [f"{folder}: {count} .cpp files (at most {MAX_SOURCES_PER_FOLDER})"
            for folder, count in counts.items()
            if count > MAX_SOURCES_PER_FOLDER and folder.name != "cli"]


def main(root: pathlib.Path) -> int:
    errors, visited = [], []
    for path in sorted(root.glob("src/octavo/**/*")) + sorted(root.glob("cli/**/*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        module = "cli" if path.is_relative_to(root / "cli") else path.relative_to(root).parts[2]
        if module != "cli" and module not in MAY_INCLUDE:
            errors.append(f"{path}: unknown room {module}")
            continue
        errors += check_file(path, module, root)
        visited.append(path)
    built = built_sources(root)
    errors += [f"{path}: built, but not among the files this script visits"
               for path in sorted(built - set(visited))]
    errors += [f"{path}: stands in no list of the build"
               for path in visited if path.suffix == ".cpp" and path not in built]
    errors += check_folders(visited)
    errors += check_reading_half(root)
    print("\n".join(errors) if errors else f"{len(visited)} files follow the dependency rule")
    return 1 if errors or not built else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
