"""A folder that all tests of a class share."""

import pathlib
import tempfile


def folder_of(tests):
    """A fresh folder, which goes when all tests of the class `tests` are done."""
    holder = tempfile.TemporaryDirectory()
    tests.addClassCleanup(holder.cleanup)
    return pathlib.Path(holder.name)
