"""Reads .8vo files with nothing but the standard library and NumPy.

Written from docs/format.md and its chapters alone: where this package and the C++ library agree,
the documents say enough. It reads whole levels, one brick after another, and is in no hurry.
"""

from .errors import OctavoError

__all__ = ["OctavoError", "OctavoFile", "verify"]


def __getattr__(name: str):
    # NumPy is imported only here, so that the command line can say that it is missing.
    if name == "OctavoFile":
        from .file import OctavoFile
        return OctavoFile
    if name == "verify":
        from .whole_file import verify
        return verify
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
