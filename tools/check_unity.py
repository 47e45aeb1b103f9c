#!/usr/bin/env python3
"""Proves that sources which are compiled together do not name two things alike.

usage: check_unity.py [ROOT]

A unity build joins sources of one library, so that their anonymous namespaces become one. Which
ones it joins changes with every new source; so within a library no two sources may have

- a type or a constant of the same name, or an alias of that name for another type
- a function of the same name with parameters that one call fits alike: `const T&` and `T` are
  the same, and so is a function that a header of the library or of core defines
"""

import pathlib
import re
import sys

WHAT_IS_NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'',
    re.DOTALL)
DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
TYPE = re.compile(r"^(?:struct|class|union|enum(?: class| struct)?)\s+(?:\[\[.*?\]\]\s*)?(\w+)")
ALIAS = re.compile(r"^using\s+\w+\s*=")
APART = re.compile(r"set_source_files_properties\(([^)]*)SKIP_UNITY_BUILD_INCLUSION", re.DOTALL)
QUALIFIED = re.compile(r"[\w\]>]\s*::\s*~?\w+\s*\($")


def code_of(path: pathlib.Path) -> str:
    text = WHAT_IS_NO_CODE.sub(lambda found: " " if found.group().startswith("/") else '""',
                               path.read_text())
    return DIRECTIVE.sub("", text)


def closing(text: str, start: int, pair: str) -> int:
    """The place behind the bracket that closes the one at start."""
    depth = 0
    for i in range(start, len(text)):
        if text[i] == pair[0]:
            depth += 1
        elif text[i] == pair[1]:
            depth -= 1
            if depth == 0:
                return i + 1
    return len(text)


def statements(text: str):
    """Heads of what a namespace declares: what stands before a body or a semicolon."""
    head = ""
    i = 0
    while i < len(text):
        if text[i] == "{":
            # Braces behind a function's parameters or a type are a body, others a value.
            yield head.strip()
            i = closing(text, i, "{}")
            head = ""
        elif text[i] == ";":
            yield head.strip()
            head = ""
            i += 1
        elif text[i] == "(":
            end = closing(text, i, "()")
            head += text[i:end]
            i = end
        else:
            head += text[i]
            i += 1


def without_templates(head: str) -> str:
    while head.startswith("template"):
        head = head[closing(head, head.index("<"), "<>"):].strip()
    return head


def parameter_types(parameters: str) -> str:
    """Of `const T& a, int b = 3` that is `T,int`: a call does not tell `T` and `const T&` apart."""
    types, depth, start = [], 0, 0
    for i, letter in enumerate(parameters + ","):
        depth += (letter in "<([{") - (letter in ">)]}")
        if letter == "," and depth <= 0:
            one = parameters[start:i].split("=")[0].strip()
            start = i + 1
            named = re.fullmatch(r"(.*[\w>\]&*)\s])\b(\w+)", one, re.DOTALL)
            if named and not re.fullmatch(r"(const|unsigned|long|short|signed)\s+\w+", one):
                one = named.group(1)
            one = re.sub(r"^const\s+(.*\S)\s*&$", r"\1", one.strip(), flags=re.DOTALL)
            types.append(re.sub(r"\s+", "", one))
    return ",".join(types)


def name_of(head: str) -> str | None:
    """What a declaration names, a function with the types of its parameters."""
    head = re.sub(r"\[\[.*?\]\]\s*", "", without_templates(head)).strip()
    if not head or head.startswith(("namespace", "friend", "static_assert", "using namespace")):
        return None
    if named := TYPE.match(head):
        return named.group(1)
    if head.startswith("using "):
        return " ".join(head.split()) if ALIAS.match(head) else None
    value = re.split(r"(?<![=!<>])=(?!=)", head)[0].strip()
    called = re.search(r"(\w+|operator\W+)\s*\(", value)
    if not called:
        words = re.findall(r"\w+", re.sub(r"\[.*?\]", "", value))
        return words[-1] if len(words) > 1 else None
    if QUALIFIED.search(value[:called.end()]):
        return None  # a member, defined outside its type
    parameters = value[called.end():closing(value, called.end() - 1, "()") - 1]
    return f"{called.group(1).strip()}({parameter_types(parameters)})"


def names_in(path: pathlib.Path) -> set[str]:
    text = code_of(path)
    names = set()
    for start in re.finditer(r"\bnamespace\s*\{", text):
        end = closing(text, start.end() - 1, "{}")
        names |= {name_of(head) for head in statements(text[start.end():end - 1])}
    return names - {None}


def functions_of_headers(root: pathlib.Path) -> dict:
    """What headers of each room define in namespace octavo itself: functions, and where."""
    rooms = {}
    for path in sorted((root / "src/octavo").rglob("*.h")):
        functions = rooms.setdefault(path.relative_to(root / "src/octavo").parts[0], {})
        text = code_of(path)
        for start in re.finditer(r"\bnamespace\s+octavo\s*\{", text):
            end = closing(text, start.end() - 1, "{}")
            for head in statements(text[start.end():end - 1]):
                if head.startswith("inline ") and "(" in head:
                    functions[name_of(head)] = path
    return rooms


def sources_by_target(root: pathlib.Path) -> dict:
    """Sources that may be compiled together: of a library, those of the reading half apart."""
    reading = (root / "src/octavo/ReadingHalf.cmake").read_text()
    targets = {}
    for top in ("src/octavo", "cli"):
        for path in sorted((root / top).rglob("*.cpp")):
            folder = next(f for f in path.parents if (f / "CMakeLists.txt").exists())
            apart = APART.findall((folder / "CMakeLists.txt").read_text())
            if str(path.relative_to(folder)) in " ".join(apart).split():
                continue
            is_read = str(path.relative_to(root / top)) in reading.split()
            targets.setdefault((folder, is_read), []).append(path)
    return targets


def check(root: pathlib.Path) -> list[str]:
    errors = []
    libraries = sources_by_target(root)
    headers = functions_of_headers(root)
    for (folder, _), paths in libraries.items():
        seen = {**headers.get("core", {}), **headers.get(folder.name, {})}
        first = {}
        for path in paths:
            for name in sorted(names_in(path)):
                if name in seen:
                    errors.append(f"{path.relative_to(root)}: {seen[name].relative_to(root)} "
                                  f"names {name} as well")
                # The same alias twice is one.
                is_alias = name.startswith("using ")
                key = name.split("=")[0].split()[1] if is_alias else name
                other, same = first.setdefault(key, (path, name))
                if other != path and not (is_alias and same == name):
                    errors.append(f"{path.relative_to(root)}: {other.relative_to(root)} names "
                                  f"{name} as well")
    if len(libraries) < 10:
        errors.append(f"only {len(libraries)} libraries found under {root}")
    return errors


if __name__ == "__main__":
    found = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "."))
    for line in found:
        print(line)
    sys.exit(1 if found else 0)
