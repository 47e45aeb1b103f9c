#!/usr/bin/env python3
"""Names of files with control characters: what every verb prints has none, and no line more.

usage: shown_names_test.py OCTAVO [unittest arguments]
"""

import pathlib
import sys
import unittest

import cli_test
import ways_out_test

# Colors by an escape sequence in both forms, the end of a line, and letters that are shown.
STRANGE = "\x1b[31m\n\u009b1m\x7f\r\u00e4"


class ShownNames(ways_out_test.Kept):
    def setUp(self):
        super().setUp()
        for name in "gl":
            (self.folder / f"{name}.8vo").rename(self.folder / self.strange(f"{name}.8vo"))
        (self.folder / self.strange("out/")).mkdir()

    @staticmethod
    def strange(argument):
        for plain, other in (("out/", f"out{STRANGE}/"), ("g.8vo", f"g{STRANGE}.8vo"),
                             ("l.8vo", f"l{STRANGE}.8vo")):
            argument = argument.replace(plain, other)
        return argument

    def assert_shown(self, result, arguments):
        said = result.stdout + result.stderr
        for sign in said:
            self.assertTrue(sign in "\n\t" or sign.isprintable(), (sign, arguments, said))
        self.assertNotIn("[31m\n", said, arguments)

    def test_of_every_verb_names_are_on_one_line(self):
        ways = [(verb, arguments) for verb, many in ways_out_test.WAYS.items()
                for arguments in many]
        ways += [("info", ["g.8vo"]), ("info", ["g.8vo", "--metadata"]),
                 ("verify", ["g.8vo", "--against", "g.8vo"]),
                 ("part", ["out/scan.plan", "--parts", "0", "-o", "out/parts/"]),
                 ("join", ["out/scan.plan", "out/parts/", "-o", "out/joined.8vo"]),
                 ("phantom", ["--size", "8", "-o", "out/p.8vo"])]
        for verb, arguments in ways:
            given = [self.strange(argument) for argument in arguments]
            with self.subTest(verb=verb, arguments=arguments):
                result = self.expect(0, verb, *given, "-f", "--progress", "plain")
                self.assert_shown(result, arguments)
                if verb == "build":
                    self.assertIn(r"out\x1b[31m\x0a\xc2\x9b1m\x7f\x0d" + "\u00e4/", result.stdout)

    def test_failures_are_one_line(self):
        whole = (self.folder / self.strange("g.8vo")).read_bytes()
        (self.folder / self.strange("out/g.8vo")).write_bytes(whole[:-9])
        for verb, arguments in (("info", ["out/g.8vo"]), ("verify", ["out/g.8vo"]),
                                ("info", ["out/none.8vo"]), ("build", ["out/none.nii", "-o", "a"]),
                                ("repair", ["g.8vo", "-o", "out/g.8vo"]),
                                ("build", ["out/g.8vo", "-o", "g.8vo"])):
            given = [self.strange(argument) for argument in arguments]
            with self.subTest(verb=verb, arguments=arguments):
                result = self.octavo(verb, *given, "--progress", "none")
                self.assertNotEqual(result.returncode, 0)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
                self.assert_shown(result, arguments)


if __name__ == "__main__":
    cli_test.OCTAVO = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
