#!/usr/bin/env python3
"""Completion scripts and manual pages: what a shell offers, and whether man can show the pages.

usage: completion_test.py OCTAVO [unittest arguments]

zsh, fish and groff are asked where they are installed; a test that misses one is skipped and says
so.
"""

import json
import re
import shutil
import subprocess
import sys

import cli_test

# An option of the help that takes one of some words.
CHOICE = r"^ +(?:-\w,)?(--[\w-]+)(?:,--[\w-]+)* [^\s\[]+:\{(.+?)\}"

COMPLETE = """
source ./script
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_octavo
printf '%s\\n' "${COMPREPLY[@]}"
"""


def needs(program):
    return cli_test.unittest.skipUnless(shutil.which(program), f"{program} is not installed")


class WithVerbs(cli_test.InFolder):
    def verbs(self):
        """All verbs, as the help of the program lists them."""
        listed = self.expect(0, "--help").stdout.split("Verbs:")[1]
        return re.findall(r"^  ([a-z][a-z-]*) ", listed, re.MULTILINE)


class Completion(WithVerbs):
    def script(self, shell):
        path = self.folder / "script"
        path.write_text(self.expect(0, "completion", shell).stdout)
        return path

    def offered(self, *words):
        """What bash offers for the last of `words`, the command itself left out."""
        self.script("bash")
        result = subprocess.run(["bash", "-c", COMPLETE, "bash", "octavo", *words],
                                cwd=self.folder, capture_output=True, text=True, check=True)
        self.assertEqual(result.stderr, "")
        return sorted(result.stdout.split())

    def test_bash_offers_every_verb(self):
        verbs = self.verbs()
        self.assertGreater(len(verbs), 20)
        self.assertEqual(self.offered(""), sorted(verbs))
        self.assertEqual(self.offered("ver"), ["verify"])

    def test_bash_offers_options_also_those_of_which_one_is_chosen(self):
        self.assertEqual(self.offered("build", "--max"),
                         ["--max-error", "--max-memory", "--max-voxels"])
        self.assertEqual(self.offered("combine", "a.8vo", "--un"), ["--union"])
        self.assertEqual(self.offered("-q", "dilate", "a.8vo", "--m"),
                         ["--max-memory", "--max-voxels", "--mm"])

    def test_bash_offers_the_values_of_choices_and_files_elsewhere(self):
        (self.folder / "scan.8vo").write_text("")
        (self.folder / "two words.8vo").write_text("")
        for words, values in [
            (["build", "--preset", ""], ["fast", "small"]),
            (["build", "--preset", "sm"], ["small"]),
            (["build", "--preset", "=", "fa"], ["fast"]),
            (["build", "--preset", "="], ["fast", "small"]),
            (["components", "--connectivity", ""], ["18", "26", "6"]),
            (["completion", ""], ["bash", "fish", "zsh"]),
            (["info", "sc"], ["scan.8vo", "script"]),
            (["build", "-o", "sca"], ["scan.8vo"]),
            (["info", "two"], ["two", "words.8vo"]),
        ]:
            with self.subTest(words):
                self.assertEqual(self.offered(*words), values)

    def test_every_choice_of_the_help_is_offered(self):
        found = 0
        for verb in self.verbs():
            text = self.expect(0, verb, "--help").stdout
            for name, words in re.findall(CHOICE, text, re.MULTILINE):
                with self.subTest(f"{verb} {name}"):
                    self.assertEqual(self.offered(verb, name, ""), sorted(words.split(",")))
                found += 1
        self.assertGreater(found, 60)

    def test_words_that_stand_for_values_are_those_that_parsers_take(self):
        self.expect(0, "phantom", "--size", "8", "-o", "p.8vo")
        # What parsers say of a word that they do not know names all others.
        for words, said in [
            (["slice", "p.8vo", "-o", "p.png", "--window"], "CENTER,WIDTH or one of (.*)"),
            (["slice", "p.8vo", "-o", "p.png", "--overlay-color"], "#rrggbb or one of (.*)"),
            (["render", "p.8vo", "-o", "p.png", "--background"], "#rrggbb or one of (.*)"),
            (["render", "p.8vo", "-o", "p.png", "--mode", "volume", "--transfer"],
             "presets are (.*)"),
            (["phantom", "-o", "q.8vo", "--type"], "expected one of (.*)"),
        ]:
            with self.subTest(words):
                error = self.octavo(*words, "nonsense").stderr
                known = re.split(r", | or ", re.search(said, error)[1])
                files = ["p.8vo", "script"] if words[-1] == "--transfer" else []
                self.assertEqual(self.offered(*words, ""), sorted(known + files))
        self.assertEqual(self.offered("surface", "--smooth", ""), ["off"])
        self.assertEqual(self.offered("serve", "--token", ""), ["auto"])
        error = self.octavo("export", "p.8vo", "-o", "p.raw", "--salvage", "nonsense").stderr
        self.assertIn("neither lowest, coarse nor", error)
        self.assertIn("FILL:(lowest coarse)", self.script("zsh").read_text())
        sides = self.offered("render", "--direction", "")
        self.assertEqual(len(sides), 26)
        for side in sides:
            self.expect(0, "render", "p.8vo", "--mode", "mip", "--direction", side, "--size", "4",
                        "-o", "p.png", "-f")

    def test_bash_reads_the_script(self):
        subprocess.run(["bash", "-n", self.script("bash")], check=True)

    @needs("zsh")
    def test_zsh_reads_the_script_and_knows_every_verb(self):
        script = self.script("zsh")
        subprocess.run(["zsh", "-n", script], check=True)
        text = script.read_text()
        for verb in self.verbs():
            self.assertIn(f"    '{verb}:", text)
            self.assertIn(f"    {verb})\n", text)

    @needs("fish")
    def test_fish_offers_verbs_options_and_values(self):
        subprocess.run(["fish", "--no-execute", self.script("fish")], check=True)
        for line, values in [
            ("octavo verif", ["verify"]),
            ("octavo combine --un", ["--union"]),
            ("octavo build --preset ", ["fast", "small"]),
            ("octavo completion ", ["bash", "fish", "zsh"]),
            ("octavo slice --window bo", ["bone"]),
            ("octavo render --transfer sc", ["script"]),
            ("octavo render --transfer ski", ["skin"]),
        ]:
            with self.subTest(line):
                asked = f"source ./script; complete -C {json.dumps(line)}"
                result = subprocess.run(["fish", "--no-config", "-c", asked], cwd=self.folder,
                                        capture_output=True, text=True, check=True)
                found = sorted(row.split("\t")[0] for row in result.stdout.splitlines())
                self.assertEqual(found, values)


class Manual(WithVerbs):
    def test_every_verb_has_a_page_with_its_options_and_an_example(self):
        self.expect(0, "manual", "-o", "pages")
        verbs = self.verbs()
        self.assertEqual(self.files(), sorted(
            ["pages", "octavo.1"] + [f"octavo-{verb}.1" for verb in verbs]))
        for verb in verbs:
            page = (self.folder / "pages" / f"octavo-{verb}.1").read_text()
            self.assertEqual(page, self.expect(0, "manual", verb).stdout)
            for section in ["NAME", "SYNOPSIS", "OPTIONS OF EVERY VERB", "EXAMPLES",
                            "EXIT STATUS"]:
                self.assertIn(f".SH {section}\n", page)
        self.assertIn("\\fB\\-\\-union\\fR", self.expect(0, "manual", "combine").stdout)
        self.assertEqual((self.folder / "pages/octavo.1").read_text(),
                         self.expect(0, "manual").stdout)

    def test_pages_that_are_there_are_replaced_with_force_only(self):
        self.expect(0, "manual", "-o", "pages")
        (self.folder / "pages/octavo.1").write_text("mine")
        self.expect_error(5, ["octavo.1: exists", "--force"], "manual", "-o", "pages")
        self.assertEqual((self.folder / "pages/octavo.1").read_text(), "mine")
        self.expect(0, "manual", "-o", "pages", "--force")
        self.assertNotEqual((self.folder / "pages/octavo.1").read_text(), "mine")

    @needs("groff")
    def test_groff_has_nothing_to_warn_of(self):
        self.expect(0, "manual", "-o", "pages")
        for page in sorted((self.folder / "pages").iterdir()):
            result = subprocess.run(["groff", "-man", "-Tutf8", "-ww", page],
                                    capture_output=True, text=True, check=True)
            self.assertEqual(result.stderr, "", page.name)
            self.assertIn(page.stem, result.stdout)


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
