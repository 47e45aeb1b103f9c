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

# Fields for which no row stands: their advice is made of the name of the file, or their text says
# all.
WITHOUT_ROW = {"input.format", "repair.source", "step.map_mm"}

OPTION = re.compile(r"--[A-Za-z]")

# Where an error gets the option it is about, by its field.
HINT = re.compile(
    r'with_field\(\s*"([^"]+)"|hints\.push_back\(\{"([^"]+)"|\{\{"([a-z_]+)", "[a-z]+"\}\}')
# A warning and its field.
WARNING = re.compile(r'warnings\.emplace_back\([^;]*?,\s*"([a-z_.]+)"\);')
ROW = re.compile(r'\{k?[\w:]+, "([a-z_.]+)", "[^"]*",')


def sources():
    library = ROOT / "src/octavo"
    paths = sorted(path for path in library.rglob("*") if path.suffix in {".h", ".cpp"})
    assert len(paths) > 300, f"only {len(paths)} sources found"
    return paths


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
        fields = set()
        for path in sources():
            text = path.read_text()
            fields |= {name for match in HINT.findall(text) for name in match if name}
            fields |= set(WARNING.findall(text))
        rows = set(ROW.findall((ROOT / "cli/text/advice.cpp").read_text()))
        self.assertGreater(len(rows), 20)
        self.assertEqual(sorted(fields - rows - WITHOUT_ROW), [])


unittest.main(verbosity=0)
