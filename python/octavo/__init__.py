"""Octavo: scans as compressed multi-resolution octrees.

    import octavo
    v = octavo.open("scan.8vo")
    v[40:60, :, 128]            # numpy's rules, [z, y, x]
    v.levels[2][...]            # a quarter as fine
    octavo.build(array, "new.8vo", spacing=(1.5, 0.96, 0.96), unit="HU")

Arrays, spacings and origins are in the order z, y, x; mm and LPS.
"""

from . import _octavo
from ._building import Writer, build
from ._errors import (ArgumentError, Cancelled, CorruptError, Error, FormatError, InternalError,
                      LimitError, OutOfMemoryError, SourceError, StorageError, TruncatedError,
                      VersionError)
from ._volume import DEFAULT_CACHE_BYTES, RealView, View, Volume

__version__ = _octavo.version

__all__ = [
    "ArgumentError", "Cancelled", "CorruptError", "Error", "FormatError", "InternalError",
    "LimitError", "OutOfMemoryError", "RealView", "SourceError", "StorageError", "TruncatedError",
    "VersionError", "View", "Volume", "Writer", "build", "open",
]


def open(source, *, cache_bytes=DEFAULT_CACHE_BYTES):
    """Open an .8vo file.

    Parameters
    ----------
    source : str, os.PathLike or bytes
        A path, the bytes of a file, or a URL that fsspec reads (https://, s3://, ...): of that,
        only the ranges that are needed are fetched.
    cache_bytes : int
        Of decoded bricks to keep for reads that follow.

    Returns
    -------
    Volume

    Raises
    ------
    octavo.FormatError, octavo.VersionError, octavo.CorruptError, octavo.StorageError
    """
    return Volume(source, cache_bytes)
