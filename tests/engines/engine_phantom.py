"""A phantom and labels of it for the tests of surfaces in other programs."""

import json
import pathlib
import subprocess
import tempfile
import unittest

OCTAVO = ""


def use(octavo):
    """Names the program."""
    global OCTAVO
    OCTAVO = str(pathlib.Path(octavo).resolve())


class OfPhantom(unittest.TestCase):
    """All tests of a class share a folder: p.8vo is a scan, l.8vo its soft and hard parts."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.octavo("phantom", "--size", "40,36,30", "--noise", "200", "-o", "p.8vo")
        cls.octavo("threshold", "p.8vo", "--class", "1=-500:300", "--class", "2=300:", "-o",
                   "l.8vo")

    @classmethod
    def octavo(cls, *arguments):
        return subprocess.run([OCTAVO, *arguments, "-q"], cwd=cls.folder, check=True,
                              stdout=subprocess.PIPE, text=True).stdout

    def surface(self, name, *more):
        """What the report says of a surface of p.8vo in a file of that name."""
        return json.loads(self.octavo("surface", "p.8vo", "--isovalue", "300", *more, "-o", name,
                                      "-f", "--json"))
