"""./check repeats the tests when any file of the tree changed.

usage: check_fingerprint_test.py SOURCE_FOLDER
"""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(sys.argv.pop())
MADE = {"__pycache__", "node_modules", "dist"}


def fingerprinted(root):
    """The files that ./check looks at."""
    command = re.search(r"find \. .*?-print0", (ROOT / "check").read_text(), re.DOTALL).group()
    found = subprocess.run(["bash", "-c", command], cwd=root, capture_output=True, check=True)
    return {name.removeprefix("./") for name in found.stdout.decode().split("\0")}


class Fingerprint(unittest.TestCase):
    def test_every_file_of_the_tree_counts(self):
        folders = ["bench", "cli", "cmake", "docs", "examples", "python", "src", "tests", "tools",
                   "web"]
        files = {str(path.relative_to(ROOT)) for folder in folders
                 for path in (ROOT / folder).rglob("*")
                 if path.is_file() and not path.is_symlink() and not MADE & set(path.parts)}
        self.assertGreater(len(files), 1000)
        self.assertEqual(sorted(files - fingerprinted(ROOT)), [])

    def test_what_is_made_does_not(self):
        made = ("build/", "build-", "demo-out/", ".git/")
        self.assertEqual([name for name in fingerprinted(ROOT) if name.startswith(made)], [])


unittest.main(verbosity=0)
