"""The library does not know the command line: it names fields, the face turns them into options.

usage: library_words_test.py SOURCE_FOLDER
"""
import pathlib
import re
import sys
import tempfile
import unittest

from cpp_strings import strings

ROOT = pathlib.Path(sys.argv.pop())

# Fields for which no row stands: their advice is made of the names of files, or their text says
# all.
WITHOUT_ROW = {"index", "input.format", "parts.missing", "parts.plan_path", "repair.source",
               "step.map_mm", "view.side"}
# Options of a transform, one rule each: the text names what is allowed.
ALLOWED_BY_TEXT = re.compile(r"step(\.\w+)?")

OPTION = re.compile(r"--[A-Za-z]")

# Where an error gets the option it is about, by its field.
HINT = re.compile(
    r'with_field\(\s*"([^"]+)"|hints\.push_back\(\{"([^"]+)"|\{\{"([a-z_]+)", "[a-z]+"\}\}')
# A function that takes the field of its error last, and what stands for one that is not given.
TAKES_FIELD = re.compile(r"\b(re(?:ject|quire)\w*)\([^(){};]*"
                         r"(?:const char\*|const std::string&) field\)\s*\{")
USUAL_FIELD = re.compile(r'\bfield = "([a-z_.]+)"[;)]')
# What a label map is opened as, and a setting of a build that is to be continued.
FIELD_OF_USE = re.compile(r'LabelUse \w+ = \{"[^"]*", "([^"]+)"\}|^    \{"[^"]*", "[^"]*", '
                          r'"(interrupted\.[a-z_.]+)"\},', re.MULTILINE)
# A warning and its field.
WARNING = re.compile(r'warnings\.emplace_back\([^;]*?,\s*"([a-z_.]+)"\);')
ROW = re.compile(r'\{k?[\w:]+, "([a-z_.]+)", "[^"]*",')


def sources():
    library = ROOT / "src/octavo"
    paths = sorted(path for path in library.rglob("*") if path.suffix in {".h", ".cpp"})
    assert len(paths) > 300, f"only {len(paths)} sources found"
    return paths


def named_fields():
    """The fields that errors, warnings and notes name."""
    texts = [path.read_text() for path in sources()]
    fields = set()
    for text in texts:
        functions = "|".join([*TAKES_FIELD.findall(text), "require_same_grid", "require_hu",
                              r"context\.note"])
        called = re.compile(rf'\b(?:{functions})\((?:[^;]|;[^\n])*?'
                            r'"([a-z_]+(?:\.[a-z_]+)*)"\)+;')
        fields |= {name for match in HINT.findall(text) for name in match if name}
        fields |= {name for match in FIELD_OF_USE.findall(text) for name in match if name}
        for pattern in (WARNING, USUAL_FIELD, called):
            fields |= set(pattern.findall(text))
    return fields


class LibraryWords(unittest.TestCase):
    def test_no_string_of_the_library_holds_an_option(self):
        found = [f"{path.relative_to(ROOT)}:{line}: {text}"
                 for path in sources() for line, text in strings(path) if OPTION.search(text)]
        self.assertEqual(found, [])

    def test_options_are_found_in_strings_of_every_kind_and_nowhere_else(self):
        code = """// "--no"
f('"', "give --force", R"(a " --raw)"); /* "--no" */ i--; g("\\"--x");
"""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.cpp"
            path.write_text(code)
            texts = [text for _, text in strings(path) if OPTION.search(text)]
        self.assertEqual(texts, ["give --force", 'a " --raw', '\\"--x'])

    def test_every_field_that_an_error_or_a_warning_names_has_a_row_of_advice(self):
        fields = named_fields()
        rows = set(ROW.findall((ROOT / "cli/text/advice.cpp").read_text()))
        self.assertGreater(len(rows), 20)
        without = {field for field in fields - rows if not ALLOWED_BY_TEXT.fullmatch(field)}
        self.assertEqual(sorted(without - WITHOUT_ROW), [])

    def test_fields_are_found_wherever_a_function_takes_them(self):
        fields = named_fields()
        for field in ["view.side", "overlays.levels", "montage", "labels.kind", "mask.kind",
                      "interrupted.preset", "turntable"]:
            self.assertIn(field, fields)

    def test_every_row_of_advice_is_for_a_field_that_the_library_names(self):
        rows = set(ROW.findall((ROOT / "cli/text/advice.cpp").read_text()))
        self.assertEqual(sorted(rows - named_fields()), [])


unittest.main(verbosity=0)
