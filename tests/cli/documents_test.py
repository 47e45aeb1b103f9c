#!/usr/bin/env python3
"""Runs the commands of README.md and docs/verbs.md, on a phantom that has the names of the demo,
compares the sizes that README.md states with bench/results/sizes.csv, and gives the magic of
docs/registry.md to file(1).

Those of docs/gallery.md are run by tools/gallery.

usage: documents_test.py OCTAVO [unittest arguments]
"""

import csv
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import unittest

import cli_test

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERB_ROW = re.compile(r"^\| `([a-z-]+)` \|.*\| `octavo (.*)` \|$", re.MULTILINE)
COMMAND = re.compile(r"^    octavo (.*?)(?: +#.*)?$", re.MULTILINE)
# A picture that a script draws of what commands made.
DRAWN = re.compile(r"`tools/\w+\.py \S+ (\S+\.png)`")
DAMAGE = re.compile(r"^    (python3 -c .*)$", re.MULTILINE)
WRITTEN = re.compile(r' -o (?:"\$out/)?([\w.-]+)')
SIZE_ROW = re.compile(r"^\| ([\w -]+)(?:, \d+ bit)? \|.*\| \*\*([\d.]+)\*\* \|$", re.MULTILINE)
SERVERS = ("serve", "view")
DIFFERS = ("compare",)  # exit code 1 is what they are for
SCANS = {"CT head": "cranium", "micro-CT of bone": "uct_bone",
         "micro-CT of a mouse head": "uct_mouse", "light-sheet brain": "lightsheet",
         "MR head": "chris_t1"}


def tour():
    """The commands of the README."""
    return COMMAND.findall((ROOT / "README.md").read_text().split("## Ten commands")[1]
                           .split("\n## ")[0])


class Documents(cli_test.InFolder):
    def setUp(self):
        super().setUp()
        self.expect(0, "phantom", "--size", "192,192,82", "--noise", "5", "-o", "cranium.mhd")
        # A page of the viewer that is none, and a browser that shows nothing.
        page = self.folder / "page"
        page.mkdir()
        for name in ("index.html", "style.css", "viewer.js", "worker.js", "octavo.wasm"):
            (page / name).touch()
        before = {name: os.environ.get(name) for name in ("OCTAVO_WEB", "BROWSER")}
        os.environ.update(OCTAVO_WEB=str(page), BROWSER="true")
        self.addCleanup(lambda: [os.environ.pop(name, None) if value is None
                                 else os.environ.update({name: value})
                                 for name, value in before.items()])

    def run_line(self, line):
        verb, *rest = shlex.split(line)
        if verb in SERVERS:
            self.run_server(line)
            return
        result = self.octavo(verb, *rest, "--progress", "none")
        self.assertEqual(result.returncode, 1 if verb in DIFFERS else 0,
                         f"octavo {line}\n{result.stderr}")

    def run_server(self, line):
        """Starts what serves until it is stopped, and stops it once it says where."""
        with subprocess.Popen([cli_test.OCTAVO, *shlex.split(line)], cwd=self.folder, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            self.assertTrue(process.stdout.readline().startswith("http://127.0.0.1:"), line)
            process.send_signal(signal.SIGINT)
            process.communicate()
            self.assertEqual(process.returncode, 130, line)

    def test_the_table_of_verbs_has_all_and_its_examples_run(self):
        self.expect(0, "build", "cranium.mhd", "-o", "cranium.8vo")
        self.expect(0, "threshold", "cranium.8vo", "--range", "226:", "-o", "bone.8vo")
        self.expect(0, "components", "bone.8vo", "--keep-largest", "1", "-o", "skull.8vo")
        page = (ROOT / "docs/verbs.md").read_text()
        for line in DAMAGE.findall(page):
            subprocess.run(shlex.split(line), cwd=self.folder, check=True)
        rows = VERB_ROW.findall(page)
        listed = self.expect(0, "--help").stdout.split("Verbs:")[1]
        self.assertEqual(sorted(verb for verb, _ in rows),
                         sorted(re.findall(r"^  ([a-z][a-z-]*) ", listed, re.MULTILINE)))
        for verb, line in rows:
            with self.subTest(line):
                self.assertEqual(line.split()[0], verb)
                self.run_line(line)

    def test_the_commands_of_the_readme_run(self):
        lines = tour()
        self.assertEqual(len(lines), 10)
        for line in lines:
            with self.subTest(line):
                self.run_line(line)

    def test_demo_readme_and_verbs_write_different_files(self):
        rows = VERB_ROW.findall((ROOT / "docs/verbs.md").read_text())
        commands = [(ROOT / "demo").read_text(), *tour(), *[line for _, line in rows]]
        written = [name for command in commands for name in WRITTEN.findall(command)]
        self.assertGreater(len(written), 30)
        self.assertEqual(sorted(written), sorted(set(written)))

    def test_the_sizes_in_the_readme_are_those_of_the_results(self):
        with (ROOT / "bench/results/sizes.csv").open(newline="") as rows:
            ratios = {row["data_set"]: f"{float(row['ratio']):.2f}" for row in csv.DictReader(rows)
                      if (row["preset"], row["max_error"]) == ("small", "0")}
        stated = dict(SIZE_ROW.findall((ROOT / "README.md").read_text()))
        self.assertEqual(stated, {words: ratios[name] for words, name in SCANS.items()})

    def test_each_picture_of_the_gallery_stands_beside_its_command(self):
        page = (ROOT / "docs/gallery.md").read_text()
        shown = re.findall(r"\(gallery/([a-z0-9-]+\.a?png)\)", page)
        made = [shlex.split(line)[-1] for line in COMMAND.findall(page)]
        made += DRAWN.findall(page)
        pictures = [path.name for path in (ROOT / "docs/gallery").iterdir()]
        self.assertEqual(sorted(shown), sorted(pictures))
        self.assertEqual(sorted(name for name in made if name.endswith("png")), sorted(shown))

    @unittest.skipUnless(shutil.which("file"), "file(1) is not installed")
    def test_the_magic_of_the_registry_names_what_a_file_holds(self):
        page = (ROOT / "docs/registry.md").read_text()
        (self.folder / "magic").write_text(re.search(r"```text\n(.*?)```", page, re.DOTALL)[1])

        def named(name, *options):
            command = ["file", "--brief", "-m", self.folder / "magic", *options, name]
            return subprocess.run(command, capture_output=True, text=True, check=True).stdout

        for name, words in [("small-int16", "grey, 44 x 36 x 30 voxels"),
                            ("labels-uint8", "labels, 41 x 33 x 26 voxels")]:
            golden = ROOT / f"tests/golden/v1/{name}.8vo"
            self.assertEqual(named(golden), f"Octavo volume version 1.0, {words}\n")
            self.assertEqual(named(golden, "--mime-type"), "application/vnd.octavo\n")
            self.assertEqual(named(golden, "--extension"), "8vo\n")
        unfinished = bytearray((ROOT / "tests/golden/v1/small-int16.8vo").read_bytes()[:512])
        unfinished[15] = 0
        (self.folder / "u.8vo").write_bytes(unfinished)
        self.assertEqual(named(self.folder / "u.8vo"),
                         "Octavo volume version 1.0, grey, 44 x 36 x 30 voxels, unfinished\n")
        self.assertEqual(named(ROOT / "tests/golden/v1/newer/trial.8vo"), "data\n")


if __name__ == "__main__":
    cli_test.OCTAVO = cli_test.os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
