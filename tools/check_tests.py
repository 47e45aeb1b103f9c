#!/usr/bin/env python3
"""Proves that a test is found where its subject is and is built, and that tools name real tests.

usage: check_tests.py [ROOT]

- tests/unit/PATH/NAME_test.cpp tests src/octavo/PATH/NAME, or a part of it: NAME_PART_test.cpp
- every test source stands in the CMakeLists.txt of its folder or of one above
- a script that is run class by class is run with every class that has tests
- tools/nightly_goals.py, tools/race_free and tools/coverage name programs that exist
"""

import ast
import pathlib
import re
import sys

REGISTERED = re.compile(r"octavo_test\((\w+)\s")
LOOPED = re.compile(r"foreach\((\w+)\s+([^)]*)\)(.*?)endforeach", re.DOTALL)
SCRIPT = re.compile(r"octavo_script\(\w+\s+\w+\s+(\w+\.py)\s+([^)]*)\)")


def subjects(path: pathlib.Path):
    """The names a test may have its name from, the longest first: a_b_c, a_b, a."""
    parts = path.name.removesuffix("_test.cpp").split("_")
    for count in range(len(parts), 0, -1):
        yield "_".join(parts[:count])


def check_places(root: pathlib.Path) -> list[str]:
    errors = []
    for path in sorted(root.glob("tests/unit/**/*.cpp")):
        place = root / "src/octavo" / path.parent.relative_to(root / "tests/unit")
        found = [name for name in subjects(path) for ending in (".h", ".cpp", "-inl.h")
                 if (place / (name + ending)).exists()]
        if not path.name.endswith("_test.cpp") or not found:
            errors.append(f"{path.relative_to(root)}: {place.relative_to(root)} has no file it is "
                          "named after")
    return errors


def lists_above(path: pathlib.Path, top: pathlib.Path):
    for folder in path.parents:
        listed = folder / "CMakeLists.txt"
        if listed.exists():
            yield folder, listed.read_text()
        if folder == top:
            return


def check_built(root: pathlib.Path) -> list[str]:
    errors = []
    for path in sorted(root.glob("tests/**/*_test.cpp")):
        for folder, text in lists_above(path, root / "tests"):
            name = str(path.relative_to(folder))
            # Lists with a loop over names write ${name}_test.cpp.
            if re.search(rf"(?<![\w/]){re.escape(name)}", text) or (
                    "${name}_test.cpp" in text and name.removesuffix("_test.cpp") in text):
                break
        else:
            errors.append(f"{path.relative_to(root)}: no CMakeLists.txt builds it")
    return errors


def classes_with_tests(path: pathlib.Path) -> set[str]:
    tree = ast.parse(path.read_text())
    return {node.name for node in tree.body if isinstance(node, ast.ClassDef)
            and any(isinstance(item, ast.FunctionDef) and item.name.startswith("test")
                    for item in node.body)}


def check_scripts(root: pathlib.Path) -> list[str]:
    errors = []
    for listed in sorted(root.glob("tests/**/CMakeLists.txt")):
        named: dict[str, set[str]] = {}
        for script, arguments in SCRIPT.findall(listed.read_text()):
            words = set(re.findall(r"(?<![\w$<{/])[A-Z]\w*(?![\w>}/])", arguments))
            named.setdefault(script, set()).update(words)
        for script, classes in named.items():
            if classes and classes != classes_with_tests(listed.parent / script):
                different = classes ^ classes_with_tests(listed.parent / script)
                errors.append(f"{listed.relative_to(root)}: {script}: {', '.join(different)} "
                              "must be both in the script and here")
    return errors


def programs(root: pathlib.Path) -> dict[str, str]:
    """The names of all octavo_test programs, and the folders of tests/ that build them."""
    folders = {}
    for listed in root.glob("tests/**/CMakeLists.txt"):
        text = listed.read_text()
        names = REGISTERED.findall(text)
        for variable, values, body in LOOPED.findall(text):
            if f"octavo_test(${{{variable}}}" in body:
                names += values.split()
        folders.update(dict.fromkeys(names, str(listed.parent.relative_to(root / "tests"))))
    return folders


def check_tools(root: pathlib.Path) -> list[str]:
    known = programs(root)
    goals = (root / "tools/nightly_goals.py").read_text()
    errors = [f"tools/nightly_goals.py: tests/{folder} builds no {name}"
              for folder, name in re.findall(r'gtest\("([\w/]+)", "(\w+)"', goals)
              if known.get(name) != folder]
    for tool, start in [("tools/race_free", "targets=("), ("tools/coverage", "programs=(")]:
        lists = re.findall(re.escape(start) + r"([\w\s]+)\)", (root / tool).read_text())
        errors += [f"{tool}: no test program {name}"
                   for words in lists for name in words.split() if name not in known]
        errors += [] if lists else [f"{tool}: lists no test programs"]
    return errors


def main(root: pathlib.Path) -> int:
    errors = check_places(root) + check_built(root) + check_scripts(root) + check_tools(root)
    count = len(list(root.glob("tests/**/*_test.cpp")))
    print("\n".join(errors) if errors else f"{count} test files are where they belong")
    return 1 if errors or not count else 0


if __name__ == "__main__":
    default = pathlib.Path(__file__).resolve().parent.parent
    sys.exit(main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else default))
