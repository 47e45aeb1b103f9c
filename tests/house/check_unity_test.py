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


class ProgramsOfTests(unittest.TestCase):
    def with_targets(self, text, sources, take):
        """What is taken of a tree with one folder of tests and of the sources of its targets."""
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            tests = root / "tests/unit/core"
            tests.mkdir(parents=True)
            (tests / "CMakeLists.txt").write_text(text)
            for name, source in sources.items():
                (tests / name).write_text(source)
            return take(root, check_unity.sources_by_test(root))

    def clashes(self, text, *sources):
        def take(root, targets):
            return [error for paths in targets.values()
                    for error in check_unity.clashes(root, paths)]

        return self.with_targets(text, dict(zip(("a.cpp", "b.cpp"), sources)), take)

    def test_are_joined_as_they_are_listed(self):
        text = """
            set(more c_test.cpp  # in one
              deep/d_test.cpp)
            octavo_test(core short SOURCES a_test.cpp b_test.cpp ${more} USES octavo_core FULL)
            octavo_test(alone short SOURCES e_test.cpp USES octavo_core)
            add_library(octavo_samples STATIC f.cpp g.cpp)
            octavo_unity(octavo_samples)
            add_library(octavo_apart STATIC h.cpp i.cpp)
            """
        targets = self.with_targets(text, {}, lambda _, found: {
            name: [path.stem for path in paths] for (_, name), paths in found.items()})
        self.assertEqual(targets, {"core": ["a_test", "b_test", "c_test", "d_test"],
                                   "octavo_samples": ["f", "g"]})

    def test_name_nothing_alike_within_one(self):
        a = SOURCE % "constexpr int kSize = 3;\nTEST(Box, IsClosed) { EXPECT_EQ(kSize, 3); }"
        b = SOURCE % "constexpr int kSize = 4;\nTEST(Box, IsOpen) { EXPECT_EQ(kSize, 4); }"
        self.assertEqual(self.clashes("octavo_test(a short SOURCES a.cpp)\n"
                                      "octavo_test(b short SOURCES b.cpp)", a, b), [])
        self.assertEqual(self.clashes("octavo_test(a short SOURCES a.cpp b.cpp)", a, b),
                         ["tests/unit/core/b.cpp: tests/unit/core/a.cpp names kSize as well"])

    def test_of_this_tree_are_all_there(self):
        targets = check_unity.sources_by_test(ROOT)
        paths = {path for paths in targets.values() for path in paths}
        self.assertEqual([path for path in paths if not path.exists()], [])
        for name in ("core", "io_source", "octavo_source_files"):
            self.assertTrue(any(target == name for _, target in targets), name)


unittest.main(verbosity=0)
