#!/usr/bin/env python3
"""What the program says to command lines that it does not understand.

usage: usage_test.py OCTAVO
"""

import os
import sys
import unittest

import cli_test


class Usage(cli_test.InFolder):
    def test_help_is_given_by_every_name(self):
        of_slice = self.expect(0, "slice", "--help").stdout
        self.assertIn("--window", of_slice)
        self.assertEqual(self.expect(0, "help", "slice").stdout, of_slice)
        of_all = self.expect(0, "--help").stdout
        self.assertEqual(self.expect(0, "help").stdout, of_all)
        self.assertEqual(self.expect(2).stdout, of_all)
        self.assertIn("Verbs:", of_all)
        self.assertNotIn("ubcommand", of_all)

    def test_help_says_what_values_are_of_and_what_is_rounded(self):
        for verb, words in [
            ("export", "on an oblique grid the box of voxels around them"),
            ("build", "the stored value that takes the place of NaN"),
            ("build", "the stored value that takes the place of +infinity"),
            ("build", "that was rounded before: twice in all"),
        ]:
            told = self.expect(0, verb, "--help").stdout
            self.assertIn(words, " ".join(told.split()))

    def test_what_may_have_been_meant_is_named(self):
        for arguments, words in [
            (["rendr", "a.8vo"], "no verb 'rendr'; did you mean render?"),
            (["Build", "a.mhd"], "no verb 'Build'; did you mean build?"),
            (["xyzzyx"], "no verb 'xyzzyx'; see octavo --help"),
            (["render", "a.8vo", "--azimut", "30", "-o", "b.png"],
             "no option --azimut; did you mean --azimuth?; see octavo render --help"),
            (["slice", "--hlp"], "no option --hlp; did you mean --help?"),
            (["slice", "a.8vo", "--indxe=3"], "no option --indxe; did you mean --index?"),
            (["--jsn", "info", "a.8vo"], "no option --jsn; did you mean --json?"),
            (["-j", "2", "infos", "a.8vo"], "no verb 'infos'; did you mean info?"),
        ]:
            with self.subTest(arguments):
                self.expect_error(2, [words], *arguments)

    def test_values_are_not_taken_for_options(self):
        self.expect(0, "phantom", "--size", "9", "-o", "p.8vo")
        self.expect_error(2, ["no option --indx"], "slice", "p.8vo", "--mm", "-12.5", "--indx", "1",
                          "-o", "a.png")

    def test_what_is_given_twice_or_not_at_all_is_said(self):
        self.expect(0, "phantom", "--size", "9", "-o", "p.8vo")
        self.expect_error(2, ["--size is given 2 times; give it once"], "slice", "p.8vo",
                          "--size", "64", "--size", "65", "-o", "a.png")
        self.expect_error(2, ["give one of --union, --intersect"], "combine", "p.8vo", "p.8vo",
                          "-o", "a.8vo")

    def test_no_option_is_ignored(self):
        self.expect(0, "phantom", "--size", "9", "-o", "p.8vo")
        self.expect(0, "threshold", "p.8vo", "--range", "0:", "-o", "m.8vo")
        for words, arguments in [
            (["--percentile", "--of"], ["measure", "m.8vo", "--percentile", "50"]),
            (["leave out --fps"], ["render", "p.8vo", "--fps", "5", "-o", "a.png"]),
            (["leave out --fps"], ["render", "p.8vo", "--turntable", "4", "--fps", "5", "-o",
                                   "a.png"]),
            ([".webp", "NAME.apng"], ["render", "p.8vo", "--turntable", "4", "-o", "a.gif"]),
        ]:
            self.expect_error(2, words, *arguments)
            self.assertEqual(self.files(), ["m.8vo", "p.8vo"])
        for verb in ("measure", "morphometry"):
            told = self.expect(2, verb, "m.8vo", "--csv", "--json")
            self.assertIn("--csv and --json do not go together", told.stderr)
            self.assertEqual(told.stdout, "")

    def test_three_numbers_are_one_place(self):
        self.expect(0, "phantom", "--size", "9", "-o", "p.8vo")
        wanted = self.expect(0, "probe", "p.8vo", "--at", "1,2,3").stdout
        self.assertEqual(self.expect(0, "probe", "p.8vo", "--at", "1", "2", "3").stdout, wanted)
        self.assertEqual(self.expect(0, "probe", "--at", "1", "2", "3", "p.8vo").stdout, wanted)
        two = self.expect(0, "probe", "p.8vo", "--at", "1", "2", "3", "--at", "1,2,3").stdout
        for words in (("--at", "1,2,3", "1,2,3"), ("--at", "1", "2", "3", "1", "2", "3"),
                      ("--at", "1,2,3", "1", "2", "3")):
            self.assertEqual(self.expect(0, "probe", "p.8vo", *words).stdout, two)
            self.assertEqual(self.expect(0, "probe", *words, "p.8vo").stdout, two)
        self.assertEqual(two, 2 * wanted)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    unittest.main()
