"""Octavo: scans as compressed multi-resolution octrees.

    import octavo
    v = octavo.open("scan.8vo")
    v[40:60, :, 128]            # numpy's rules, [z, y, x]
    v.levels[2][...]            # a quarter as fine
    bone = v.threshold(226).components(keep_largest=1)   # octrees: a & b, ~a, bone.dilate(mm=2)
    bone.measure(of=v)          # a list of dicts
    octavo.build(array, "new.8vo", spacing=(1.5, 0.96, 0.96), unit="HU")

Arrays, spacings and origins are in the order z, y, x; mm and LPS.
"""

import importlib

from . import _octavo
from ._building import Writer, build
from ._errors import (ArgumentError, Cancelled, CorruptError, Error, ExistsError, FormatError,
                      InternalError, LimitError, MissingError, OutOfMemoryError, SourceError,
                      StorageError, TruncatedError, VersionError)
from ._label_map import LabelMap
from ._surfaces import Surface
from ._notebook import viewer
from ._volume import DEFAULT_CACHE_BYTES, RealView, View, Volume
from ._zarr import as_dask, as_zarr, export, from_ome_zarr

__version__ = _octavo.version

__all__ = [
    "ArgumentError", "Cancelled", "CorruptError", "Error", "ExistsError", "FormatError",
    "InternalError", "LabelMap", "LimitError", "MissingError", "OutOfMemoryError", "RealView",
    "SourceError", "StorageError", "Surface", "TruncatedError", "VersionError", "View", "Volume",
    "Writer", "as_dask", "as_zarr", "build", "export", "from_ome_zarr", "open", "viewer",
]


_WITH_PEERS = ("dask", "napari", "sitk", "slicer", "torch", "vtk", "xarray")


def __getattr__(name):
    # Modules that import other packages are imported once they are used.
    if name in _WITH_PEERS:
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def open(source, *, cache_bytes=DEFAULT_CACHE_BYTES, storage_options=None):
    """Open an .8vo file.

    Parameters
    ----------
    source : str, os.PathLike, bytes or file object
        A path, the bytes of a file, or a URL that fsspec reads (https://, s3://, ...): of that,
        only the ranges that are needed are fetched. Also an OpenFile of fsspec, or a file object
        of bytes that seeks, which nobody else may move while the volume is in use. A volume of it
        pickles where the object does.
    cache_bytes : int
        Of decoded bricks to keep for reads that follow.
    storage_options : dict, optional
        Of the file system of fsspec that reads a URL: credentials, endpoints, headers. They go into
        pickles of the volume.

    Returns
    -------
    Volume

    Raises
    ------
    octavo.FormatError, octavo.VersionError, octavo.CorruptError, octavo.StorageError
    """
    return Volume(source, cache_bytes, storage_options)
