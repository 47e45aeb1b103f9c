#!/usr/bin/env python3
"""Proves that code, documents, help and messages use American spelling and the words of the field.

usage: check_words.py [ROOT]

Three lists: spellings, words with a better one, and phrases. A word is found inside names as well:
snake_case and CamelCase are taken apart. EXCEPTIONS says where a word stays, and why.
"""

import functools
import os
import pathlib
import re
import sys

FOLDERS = ("bench", "cli", "cmake", "docs", "examples", "python", "src", "tests", "tools", "web")
ENDINGS = {".h", ".cpp", ".inc", ".py", ".md", ".cmake", ".txt", ".yml", ".ts"}
SKIPPED = ("bench/results/", "tests/golden/v1/", "tools/check_words.py", "web/node_modules/",
           "web/reader/dist/", "web/viewer/dist/")

# British, to American.
SPELLINGS = {
    "analyse": "analyze", "artefact": "artifact", "behaviour": "behavior",
    "catalogue": "catalog", "centre": "center", "colour": "color", "favour": "favor",
    "fibre": "fiber", "honour": "honor", "judgement": "judgment", "labelled": "labeled",
    "learnt": "learned", "licence": "license", "litre": "liter", "metre": "meter",
    "millimetre": "millimeter", "micrometre": "micrometer", "centimetre": "centimeter",
    "nanometre": "nanometer", "modelled": "modeled", "neighbour": "neighbor",
    "neighbourhood": "neighborhood", "recognise": "recognize", "signalled": "signaled",
    "spelt": "spelled", "travelled": "traveled", "tumour": "tumor", "whilst": "while",
}
# The stems of verbs in -ise and nouns in -isation.
ISE_STEMS = ("capital", "character", "colou?r", "general", "initial", "maxim", "minim", "normal",
             "optim", "organ", "parallel", "parametr", "polar", "quant", "random", "recogn",
             "serial", "special", "standard", "summar", "synchron", "util", "vector", "visual")
ISE = re.compile(rf"(de|un|re|pre)?({'|'.join(ISE_STEMS)})is(e|ed|es|er|ers|ing|ation|ations)")

# A word, and what to say instead.
WORDS = {
    "foresee": "predict", "foreseen": "predicted", "foresees": "predicts", "ink": "emission",
    "lesson": "training sample", "lessons": "training samples", "mend": "repair",
    "mended": "repaired", "mending": "repair", "mendings": "repairs", "mends": "repairs",
    "refusal": "error", "refusals": "errors", "refused": "rejected", "refuses": "rejects",
    "tone": "density class", "tones": "density classes", "truth": "target, or reference",
    "veil": "transmittance", "veils": "transmittance", "verdict": "component",
    "verdicts": "components",
}
# In names alone: "at least" is good prose.
NAME_WORDS = {"least": "minimum", "greatest": "maximum"}
GOOD_NAMES = re.compile(r"at_?least|least_?squares", re.IGNORECASE)
# In prose alone: names of functions may say it.
PROSE_WORDS = {"walk": "traversal, visit", "walks": "visits", "walked": "visited"}
PHRASES = {
    r"\bends in words\b": "is an error", r"\bis told\b(?! (of|apart))": "is reported",
    r"\bput before\b": "composite over", r"\bpictures a second\b": "fps",
    r"\bpromised for bad days\b": "failure guarantees",
    r"\bnot as they should be\b": "malformed input",
    r"\bwords are explained in\b": "glossary",
}

# Path, word or phrase, reason.
EXCEPTIONS = [
    ("src/octavo/io/source/length_unit.cpp", r".*met(re|er)s?", "units as input files spell them"),
    ("tests/", r".*met(re|er)s?", "units as input files spell them"),
    ("src/octavo/io/http/", "refused", "what a server does with a connection"),
    ("tests/unit/io/http/", "refused", "what a server does with a connection"),
    ("", "quantised", "the name of a golden file, which never changes"),
]

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
PLAIN = re.compile(r"(?<![\w./-])[A-Za-z]+(?![\w/-]|\.\w)")
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
STRING = re.compile(r'"(?:[^"\\]|\\.)*"|\'(?:[^\'\\]|\\.)*\'')


def files(root: pathlib.Path):
    for folder in FOLDERS:
        for place, folders, names in os.walk(root / folder):
            inside = pathlib.Path(place).relative_to(root).as_posix()
            folders[:] = sorted(f for f in folders if f"{inside}/{f}/" not in SKIPPED)
            for name in sorted(names):
                path = pathlib.Path(place, name)
                is_script = path.suffix == "" and folder in ("tools", "bench")
                if ((path.suffix in ENDINGS or is_script) and not path.is_symlink()
                        and not f"{inside}/{name}".startswith(SKIPPED)):
                    yield path
    yield from (p for p in sorted(root.iterdir())
                if p.suffix in {".md", ".txt"} or p.name in {"check", "demo"})


@functools.cache
def better_word(found: str) -> str | None:
    word = found.lower()
    return american(word) or WORDS.get(word)


def american(word: str) -> str | None:
    """What a word is in American spelling, where it is British."""
    singular = word.rstrip("sd") if word.rstrip("sd") in SPELLINGS else word
    if singular in SPELLINGS:
        return SPELLINGS[singular]
    return word.replace("is", "iz") if ISE.fullmatch(word) else None


def split(line: str, suffix: str) -> tuple[str, str]:
    """The code of a line, strings left out, and its prose."""
    if suffix == ".md":
        return "", line
    mark = "//" if suffix in {".h", ".cpp", ".inc", ".ts"} else "#"
    bare = STRING.sub('""', line)
    code, _, prose = bare.partition(mark)
    return code, prose


def offenses(line: str, suffix: str):
    for found in WORD.findall(line):
        if better := better_word(found):
            yield found.lower(), better
    code, prose = split(line, suffix)
    for name in NAME.findall(code):
        for part in WORD.findall(GOOD_NAMES.sub("", name)):
            if part.lower() in NAME_WORDS:
                yield name, NAME_WORDS[part.lower()]
    for found in PLAIN.findall(prose):
        if found.lower() in PROSE_WORDS:
            yield found.lower(), PROSE_WORDS[found.lower()]
    for pattern, better in PHRASES.items():
        match = re.search(pattern, line, re.IGNORECASE)
        if match:
            yield match.group(), better


# What is in every line that has a name, a word of prose or a phrase to change.
HINTS = [*NAME_WORDS, *PROSE_WORDS,
         *(re.sub(r"\\b|\(\?!.*", "", pattern) for pattern in PHRASES)]


def suspects(text: str):
    """The lines of a file, with their numbers, that may have something to change."""
    lower = text.lower()
    marks = [hint for hint in HINTS if hint in lower]
    marks += {word.lower() for word in set(WORD.findall(text)) if better_word(word)}
    if marks:
        for number, line in enumerate(text.splitlines(), 1):
            if any(mark in line.lower() for mark in marks):
                yield number, line


def is_exception(name: str, word: str) -> bool:
    return any(name.startswith(path) and re.fullmatch(pattern, word)
               for path, pattern, _ in EXCEPTIONS)


def main() -> int:
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    count = 0
    visited = 0
    for path in files(root):
        visited += 1
        name = path.relative_to(root).as_posix()
        for number, line in suspects(path.read_text(errors="replace")):
            for word, better in offenses(line, path.suffix):
                if not is_exception(name, word):
                    print(f"{name}:{number}: '{word}'; say '{better}'")
                    count += 1
    print(f"{visited} files, {count} words to change")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
