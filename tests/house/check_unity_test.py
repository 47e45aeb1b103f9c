"""The check of sources that are compiled together sees every kind of name.

usage: check_unity_test.py SOURCE_FOLDER
"""
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv.pop())
sys.path.insert(0, str(ROOT / "tools"))
import check_unity  # noqa: E402

SOURCE = "namespace octavo {\nnamespace {\n%s\n}  // namespace\n}  // namespace octavo\n"
HEADER = "#pragma once\nnamespace octavo {\n%s\n}  // namespace octavo\n"


def found(**files):
    """What is named alike, of sources and headers by their names."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "src/octavo").mkdir(parents=True)
        for name, text in files.items():
            ending = ".h" if name.startswith("header") else ".cpp"
            (root / "src/octavo" / (name + ending)).write_text(text)
        return check_unity.clashes(root, sorted((root / "src/octavo").glob("*.cpp")))


class TwoSources(unittest.TestCase):
    def expect(self, is_clash, a, b):
        errors = found(a=SOURCE % a, b=SOURCE % b)
        self.assertEqual(len(errors), is_clash, f"{a} and {b}: {errors}")

    def test_name_nothing_alike(self):
        for a, b in [("struct One {};", "class One;"),
                     ("constexpr double kNear = 0.5;", "const int kNear{2};"),
                     ("enum Place { kNear, kFar = 2 };", "enum Way : int { kOut, kNear };"),
                     ("enum { kNear };", "constexpr int kNear = 1;"),
                     ("using Share = int;", "using Share = double;"),
                     ("double near(const Box& box) { return 1; }", "int near(Box other);"),
                     ("bool near() { return true; }", "constexpr bool near = true;"),
                     ("template <class T>\nT near(T a) { return a; }",
                      "template <class T>\nT near(T b) { return b; }")]:
            self.expect(1, a, b)
            self.expect(1, b, a)

    def test_name_what_differs(self):
        for a, b in [("enum class Place { kNear };", "enum class Way { kNear };"),
                     ("using Share = int;", "using Share = int;"),
                     ("int near(int a);", "int near(double a);"),
                     ("struct One { int kNear; };", "constexpr int kNear = 1;"),
                     ("int f() { constexpr int kNear = 1; return kNear; }",
                      "constexpr int kNear = 1;")]:
            self.expect(0, a, b)


class ASourceAndAHeader(unittest.TestCase):
    def expect(self, is_clash, header, source, reads=""):
        errors = found(header=HEADER % header, a='#include "octavo/header.h"\n',
                       b=reads + SOURCE % source)
        self.assertEqual(len(errors), is_clash, f"{header} and {source}: {errors}")

    def test_that_others_read_name_nothing_alike(self):
        for header, source in [("constexpr double kNear = 0.5;", "constexpr double kNear = 1;"),
                               ("enum Place { kNear };", "constexpr int kNear = 1;"),
                               ("enum class Access { kNone };", "struct Access {};"),
                               ("extern const int kNear;", "constexpr int kNear = 1;"),
                               ("double near(int a);", "double near(int b) { return b; }"),
                               ("inline bool near() { return true; }", "bool near();")]:
            self.expect(1, header, source)

    def test_that_it_reads_is_up_to_the_compiler(self):
        self.expect(0, "double near(int a);", "double near(int b);",
                    '#include "octavo/header.h"\n')

    def test_are_apart_by_namespace_or_parameters(self):
        self.expect(0, "namespace detail { constexpr int kNear = 1; }", "constexpr int kNear = 1;")
        self.expect(0, "struct One { static constexpr int kNear = 1; };",
                    "constexpr int kNear = 1;")
        self.expect(0, "double near(int a);", "double near(double a);")

    def test_is_found_behind_another_header(self):
        errors = found(header_far=HEADER % "constexpr int kNear = 1;",
                       header='#include "octavo/header_far.h"\n',
                       a='#include "octavo/header.h"\n',
                       b=SOURCE % "constexpr int kNear = 2;")
        self.assertEqual(errors, ["src/octavo/b.cpp: src/octavo/header_far.h names kNear as well"])


unittest.main(verbosity=0)
