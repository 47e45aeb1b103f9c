"""Reads .8vo files with nothing but the standard library and NumPy.

Written from docs/format.md and its chapters alone: where this package and the C++ library agree,
the documents say enough. It reads whole levels, one brick after another, and is in no hurry.
"""

from .errors import OctavoError
from .file import OctavoFile

__all__ = ["OctavoError", "OctavoFile"]
