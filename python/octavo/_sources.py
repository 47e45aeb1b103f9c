"""Where the bytes of a file come from: a path, bytes in memory, a URL."""

import concurrent.futures
import os
import threading

from . import _octavo
from ._errors import ArgumentError, StorageError


def source_of(place):
    """What opens `place`: a path, bytes, https:// or another URL of fsspec."""
    if isinstance(place, (bytes, bytearray, memoryview)):
        return _Bytes(bytes(place))
    if isinstance(place, os.PathLike):
        place = os.fspath(place)
    if not isinstance(place, str):
        raise ArgumentError("give a path, a URL or the bytes of a file, not "
                            f"{type(place).__name__}")
    require_name(place)
    return _Url(place) if "://" in place else _Path(place)


def require_name(path):
    """Raises ArgumentError for names that the library cannot pass on whole."""
    if "\0" in path:
        raise ArgumentError(f"{path!r}: no file has a NUL in its name")
    try:
        path.encode()
    except UnicodeEncodeError:
        raise ArgumentError(f"{path!r}: names that are no UTF-8 cannot be opened from Python; "
                            "a link with another name helps") from None


class _Path:
    def __init__(self, path):
        self.name = path

    def open(self, cache_bytes):
        return _octavo.OpenFile(self.name, cache_bytes)


class _Bytes:
    name = "bytes"

    def __init__(self, held):
        self._held = held

    def open(self, cache_bytes):
        held = self._held
        return _octavo.OpenFile(lambda at, length: held[at:at + length], len(held), self.name,
                                cache_bytes)


class _Url:
    """A file behind fsspec, read in ranges; blocks that were fetched are kept."""

    # Pieces that follow one another in a file are mostly wanted together.
    _BLOCK = 1 << 16
    _BLOCKS_KEPT = 512

    def __init__(self, url):
        self.name = url

    def open(self, cache_bytes):
        try:
            import fsspec
        except ImportError:
            raise ArgumentError(f"{self.name}: URLs are read through fsspec, which is not "
                                "installed (pip install fsspec aiohttp)") from None
        try:
            files, path = fsspec.core.url_to_fs(self.name)
            size = files.size(path)
        except FileNotFoundError as error:
            raise StorageError(f"{self.name}: is not there", path=self.name) from error
        except (ImportError, ValueError) as error:
            raise ArgumentError(f"{self.name}: {error}", path=self.name) from error
        except Exception as error:
            raise StorageError(f"{self.name}: {error}", path=self.name) from error
        if size is None:
            raise StorageError(f"{self.name}: the server does not tell the length of the file",
                               path=self.name)
        blocks = _Blocks(lambda a, b: files.cat_file(path, start=a, end=b), size, self._BLOCK,
                         self._BLOCKS_KEPT)
        return _octavo.OpenFile(blocks.read, size, self.name, cache_bytes)


class _Blocks:
    """Ranges of a file, fetched in whole blocks of which the last ones are kept.

    Any number of threads may read; no block is fetched by two of them at once.
    """

    def __init__(self, fetch, size, block, kept):
        self._fetch = fetch
        self._size = size
        self._block = block
        self._kept = kept
        self._lock = threading.Lock()
        self._blocks = {}  # number: future of its bytes

    def read(self, at, length):
        first, last = at // self._block, (at + max(length, 1) - 1) // self._block
        found, runs = self._claim(first, last)
        try:
            for run in runs:
                self._fetch_run(run)
        except BaseException as error:
            self._give_up([block for run in runs for block in run], error)
            raise
        joined = b"".join(future.result() for future in found)
        return joined[at - first * self._block:at - first * self._block + length]

    def _claim(self, first, last):
        """The futures of blocks, and those among them that the caller has to fetch, in runs."""
        found, runs = [], []
        with self._lock:
            for number in range(first, last + 1):
                future = self._blocks.get(number)
                if future is None:
                    future = self._blocks[number] = concurrent.futures.Future()
                    if runs and runs[-1][-1][0] == number - 1:
                        runs[-1].append((number, future))
                    else:
                        runs.append([(number, future)])
                found.append(future)
            done = [n for n, future in self._blocks.items() if future.done()]
            for number in done[:max(0, len(self._blocks) - self._kept)]:
                del self._blocks[number]
        return found, runs

    def _fetch_run(self, run):
        start = run[0][0] * self._block
        stop = min((run[-1][0] + 1) * self._block, self._size)
        fetched = bytes(self._fetch(start, stop))
        if len(fetched) != stop - start:
            raise OSError(f"the server sent {len(fetched)} bytes for the {stop - start} asked "
                          "for: it may not serve ranges")
        for number, future in run:
            at = number * self._block - start
            future.set_result(fetched[at:at + self._block])

    def _give_up(self, claimed, error):
        """Nobody waits for blocks that will not come; who asks again fetches them again."""
        for number, future in claimed:
            if not future.done():
                with self._lock:
                    self._blocks.pop(number, None)
                future.set_exception(error)
