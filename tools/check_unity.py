#!/usr/bin/env python3
"""Proves that sources which are compiled together do not name two things alike.

usage: check_unity.py [ROOT]

A unity build joins sources of one target, a library or a program of tests, so that their anonymous
namespaces become one. Which ones it joins changes with every new source; so within a target no two
sources may have

- a type, a constant or an enumerator of the same name, or an alias of that name for another type
- a function of the same name with parameters that one call fits alike: `const T&` and `T` are
  the same

nor may a source name anything in that way like a header that others of them read and it does not.
"""

import functools
import pathlib
import re
import sys

WHAT_IS_NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<!\w)\'(?:\\.|[^\'\\\n])+\'',
    re.DOTALL)
DIRECTIVE = re.compile(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", re.MULTILINE)
TYPE = re.compile(r"^(?:struct|class|union|enum(?: class| struct)?)\s+(?:\[\[.*?\]\]\s*)?(\w+)")
UNSCOPED = re.compile(r"^enum\b(?!\s+(?:class|struct)\b)")
INCLUDE = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
ALIAS = re.compile(r"^using\s+\w+\s*=")
APART = re.compile(r"set_source_files_properties\(([^)]*)SKIP_UNITY_BUILD_INCLUSION", re.DOTALL)
COMMENT = re.compile(r"#[^\n]*")
COMMAND = re.compile(r"(\w+)\s*\(([^()]*)\)")
KEYWORD = re.compile(r"[A-Z]+")
BRACKETS = {pair: re.compile(f"[{pair}]") for pair in ("{}", "()", "<>")}
END_OF_HEAD = re.compile(r"[{;(]")
QUALIFIED = re.compile(r"[\w\]>]\s*::\s*~?\w+\s*\($")


def code_of(path: pathlib.Path) -> str:
    text = WHAT_IS_NO_CODE.sub(lambda found: " " if found.group().startswith("/") else '""',
                               path.read_text())
    return DIRECTIVE.sub("", text)


def closing(text: str, start: int, pair: str) -> int:
    """The place behind the bracket that closes the one at start."""
    depth = 0
    for bracket in BRACKETS[pair].finditer(text, start):
        depth += 1 if bracket.group() == pair[0] else -1
        if depth == 0:
            return bracket.end()
    return len(text)


def statements(text: str):
    """What a namespace declares: what stands before a body or a semicolon, and the body."""
    head = ""
    i = 0
    while found := END_OF_HEAD.search(text, i):
        head += text[i:found.start()]
        i = found.start()
        if found.group() == "{":
            # Braces behind a function's parameters or a type are a body, others a value.
            end = closing(text, i, "{}")
            yield head.strip(), text[i + 1:end - 1]
            i = end
            head = ""
        elif found.group() == ";":
            yield head.strip(), ""
            head = ""
            i += 1
        else:
            end = closing(text, i, "()")
            head += text[i:end]
            i = end


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


def names_within(text: str, namespace: str) -> set[str]:
    """What the namespaces that an expression finds the beginnings of declare themselves."""
    names = set()
    for start in re.finditer(namespace, text):
        end = closing(text, start.end() - 1, "{}")
        for head, body in statements(text[start.end():end - 1]):
            names.add(name_of(head))
            if UNSCOPED.match(head):
                # Their enumerators are names of the namespace.
                names |= {one.split("=")[0].strip() for one in body.split(",")}
    return names - {None, ""}


@functools.cache
def names_in(path: pathlib.Path) -> set[str]:
    """What the anonymous namespaces of a source declare."""
    return names_within(code_of(path), r"\bnamespace\s*\{")


@functools.cache
def names_of_header(path: pathlib.Path) -> dict:
    """What a header declares in namespace octavo itself, by the names alone."""
    names = {}
    for name in names_within(code_of(path), r"\bnamespace\s+octavo\s*\{"):
        names.setdefault(bare(name), set()).add(name)
    return names


def bare(name: str) -> str:
    """The name alone, of an alias or of a function with its parameters as well."""
    return name.split("=")[0].split()[1] if name.startswith("using ") else name.split("(")[0]


def are_one(a: str, b: str) -> bool:
    """Whether two declarations of one name cannot stand side by side."""
    if a.startswith("using ") and b.startswith("using "):
        return a != b  # the same alias twice is one
    if "(" in a and "(" in b:
        return a == b
    return True


@functools.cache
def read_headers(root: pathlib.Path, path: pathlib.Path) -> tuple:
    """The headers of the tree that a file reads itself."""
    places = [folder / name for name in INCLUDE.findall(path.read_text())
              for folder in (root / "src", root / "cli", root / "python/bindings", root / "tests")]
    return tuple(place for place in places if place.exists())


@functools.cache
def headers_of(root: pathlib.Path, path: pathlib.Path) -> frozenset:
    """The headers of the tree that a file reads, directly or not."""
    found, waiting = set(), [path]
    while waiting:
        for header in read_headers(root, waiting.pop()):
            if header not in found:
                found.add(header)
                waiting.append(header)
    return frozenset(found)


def sources_by_target(root: pathlib.Path) -> dict:
    """Sources that may be compiled together: of a library, those of the reading half apart."""
    reading = (root / "src/octavo/ReadingHalf.cmake").read_text()
    targets = {}
    for top in ("src/octavo", "cli", "python"):
        for path in sorted((root / top).rglob("*.cpp")):
            folder = next(f for f in path.parents if (f / "CMakeLists.txt").exists())
            apart = APART.findall((folder / "CMakeLists.txt").read_text())
            if str(path.relative_to(folder)) in " ".join(apart).split():
                continue
            is_read = str(path.relative_to(root / top)) in reading.split()
            targets.setdefault((folder, is_read), []).append(path)
    return targets


def commands_of(path: pathlib.Path):
    """The commands of a CMakeLists.txt with their words, the values of its variables put in."""
    variables = {}
    for command, text in COMMAND.findall(COMMENT.sub("", path.read_text())):
        words = []
        for word in text.split():
            known = word[2:-1] if word.startswith("${") and word.endswith("}") else None
            words += variables.get(known, [word])
        if command == "set" and words:
            variables[words[0]] = words[1:]
        yield command, words


def sources_among(words: list[str]) -> list[str]:
    """The words behind SOURCES, up to the next keyword."""
    sources = []
    for word in words[words.index("SOURCES") + 1:]:
        if KEYWORD.fullmatch(word):
            break
        sources.append(word)
    return sources


def sources_by_test(root: pathlib.Path) -> dict:
    """Sources of tests that may be compiled together: of a program of octavo_test, and of a library
    that is given to octavo_unity. One source is compiled alone."""
    targets = {}
    for path in sorted((root / "tests").rglob("CMakeLists.txt")):
        libraries = {}
        for command, words in commands_of(path):
            if command == "octavo_test":
                targets[path.parent, words[0]] = sources_among(words)
            elif command == "add_library":
                libraries[words[0]] = [word for word in words[1:] if word.endswith(".cpp")]
            elif command == "octavo_unity" and words[0] in libraries:
                targets[path.parent, words[0]] = libraries[words[0]]
    return {(folder, name): [folder / source for source in sources]
            for (folder, name), sources in targets.items() if len(sources) > 1}


def clashes(root: pathlib.Path, paths: list[pathlib.Path]) -> list[str]:
    """What sources that may be compiled together name alike."""
    errors = []
    first = {}
    declared = {}
    for header in sorted(set().union(*(headers_of(root, path) for path in paths))):
        for name, same in names_of_header(header).items():
            declared.setdefault(name, []).extend((header, one) for one in same)
    for path in paths:
        # What a source reads itself its own compilation judges.
        own_headers = headers_of(root, path)
        for name in sorted(names_in(path)):
            known = first.setdefault(bare(name), [])
            clash = [other for other, same in known if other != path and are_one(name, same)]
            known.append((path, name))
            clash += [header for header, same in declared.get(bare(name), ())
                      if header not in own_headers and are_one(name, same)]
            if clash:
                errors.append(f"{path.relative_to(root)}: {clash[0].relative_to(root)} names "
                              f"{name} as well")
    return errors


def check(root: pathlib.Path) -> list[str]:
    errors = []
    for kind, targets in [("libraries", sources_by_target(root)),
                          ("programs of tests", sources_by_test(root))]:
        missing = [path for paths in targets.values() for path in paths if not path.exists()]
        errors += [f"{path.relative_to(root)} is not there" for path in missing]
        if not missing:
            errors += [error for paths in targets.values() for error in clashes(root, paths)]
        if len(targets) < 10:
            errors.append(f"only {len(targets)} {kind} found under {root}")
    return errors


if __name__ == "__main__":
    found = check(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "."))
    for line in found:
        print(line)
    sys.exit(1 if found else 0)
