"""Where the bytes of a file come from: a path, bytes in memory, a URL, a file object."""

import concurrent.futures
import contextlib
import io
import os
import pickle
import re
import threading
import time
import urllib.parse

from . import _octavo
from ._errors import ArgumentError, ExistsError, MissingError, StorageError, package_error


def source_of(place, options=None):
    """What opens `place`: a path, bytes, https:// or another URL of fsspec, a file object.

    Its `name` stands in messages; its `place` is what it opens in a form that holds in other
    folders and pickles.

    Parameters
    ----------
    options : dict, optional
        Of the file system of fsspec, for URLs alone.
    """
    if options is not None and not (isinstance(place, str) and "://" in place):
        raise ArgumentError("storage_options are of URLs")
    if not isinstance(options or {}, dict):
        raise ArgumentError(f"storage_options is a dictionary, not {type(options).__name__}")
    if isinstance(place, (bytes, bytearray, memoryview)):
        return _Bytes(bytes(place))
    if _is_of_fsspec(place):
        if getattr(place, "compression", None):
            raise ArgumentError(f"{without_secrets(place.full_name)}: files are read as they are "
                                "stored; open it without compression")
        return _Url(place.full_name, file=place)
    if isinstance(place, os.PathLike):
        place = os.fspath(place)
    if isinstance(place, str):
        require_name(place)
        return _Url(place, options) if "://" in place else _Path(place)
    if all(hasattr(place, name) for name in ("read", "seek", "tell")):
        return _Stream(place)
    raise ArgumentError("give a path, a URL, the bytes of a file or a file object that seeks, not "
                        f"{type(place).__name__}")


def _is_of_fsspec(place):
    """Whether it is an OpenFile of fsspec, or a file that it opened."""
    return all(hasattr(place, name) for name in ("fs", "path", "full_name"))


def without_secrets(url):
    """The URL, or chain of URLs, without user, password and query, as it may stand in messages."""
    return "::".join(map(_public_name, re.split(r"::(?=[\w.+-]+::|[\w.+-]+://)", url)))


def _public_name(url):
    if re.match("https?://", url, re.IGNORECASE):
        return _octavo.public_name(url)
    try:
        parts = urllib.parse.urlsplit(url)
    except ValueError:
        return url.partition("://")[0] + "://..."
    place = parts.netloc.rpartition("@")[2]
    return urllib.parse.urlunsplit((parts.scheme, place, parts.path, "", ""))


def require_name(path):
    """Raises ArgumentError for names that the library cannot pass on whole."""
    if "\0" in path:
        raise ArgumentError(f"{path!r}: no file has a NUL in its name")
    try:
        path.encode()
    except UnicodeEncodeError:
        raise ArgumentError(f"{path!r}: names that are no UTF-8 cannot be opened from Python; "
                            "a link with another name helps") from None


def written_path(path):
    """The path of a file to write as text. Raises ArgumentError for anything else."""
    try:
        path = os.fspath(path)
    except TypeError:
        path = None
    if not isinstance(path, str):
        raise ArgumentError("the file to write is a path")
    require_name(path)
    return path


def if_written(path):
    """As `written_path`; empty where no file was asked for."""
    return "" if path is None else written_path(path)


def require_there(path):
    """Raises MissingError for a path, no URL, where nothing is."""
    if "://" not in path and not os.path.exists(path):
        raise MissingError(f"{path}: is not there", "is not there", path)


def require_free(path, overwrite):
    """Raises ExistsError for a path where something is that shall not be replaced."""
    if not overwrite and os.path.lexists(path):
        raise ExistsError(f"{path}: exists already (overwrite=True replaces it)", "exists already",
                          path)


class _Path:
    def __init__(self, path):
        self.name = path
        self.place = os.path.abspath(path)
        self._was_opened = False  # until then messages name a path as it was given

    def open(self, cache_bytes):
        handle = _octavo.OpenFile(self.place if self._was_opened else self.name, cache_bytes)
        self._was_opened = True
        return handle


class _Bytes:
    name = "bytes"

    def __init__(self, held):
        self.place = held

    def open(self, cache_bytes):
        held = self.place
        return _octavo.OpenFile({"read_at": lambda at, length: held[at:at + length],
                                 "size": len(held), "name": self.name}, cache_bytes)


class _Stream:
    """A file object of bytes that seeks; one reader at a time, where it is no file on disk."""

    def __init__(self, file):
        self.place = file
        self._lock = None  # of the place in the file
        self._on_disk = _file_on_disk(file)
        name = getattr(file, "name", None)
        self.name = name if isinstance(name, str) else type(file).__name__

    def open(self, cache_bytes):
        # In a forked process the one of before may be held by a thread that is not there.
        self._lock = threading.Lock()
        try:
            self.place.seek(0, os.SEEK_END)
            size = self.place.tell()
            is_binary = isinstance(self.place.read(0), bytes)
        except (OSError, ValueError) as error:
            raise StorageError(f"{self.name}: {error}", path=self.name) from None
        if not is_binary:
            raise ArgumentError(f"{self.name}: is a file of text; open it with the mode \"rb\"")
        return _octavo.OpenFile({"read_at": self._read, "size": size, "name": self.name},
                                cache_bytes)

    def _read(self, at, length):
        parts = []
        while length > 0:
            part = self._part(at, length)
            if not part:
                break
            parts.append(part)
            at += len(part)
            length -= len(part)
        return b"".join(parts)

    def _part(self, at, length):
        if self._on_disk is not None:
            return os.pread(self._on_disk.fileno(), length, at)
        with self._lock:
            self.place.seek(at)
            return self.place.read(length)


def _file_on_disk(file):
    """The file of the system that a file object reads as it is, else None. Forked processes share
    the place in it, so that nobody reads there."""
    if type(file) in (io.BufferedReader, io.BufferedRandom):
        file = file.raw
    return file if type(file) is io.FileIO else None


_LOOK_SECONDS = 0.1  # between two looks whether an answer is still wanted


class _Url:
    """A file behind fsspec, read in ranges; blocks that were fetched are kept."""

    # Pieces that follow one another in a file are mostly wanted together.
    _BLOCK = 1 << 16
    _BLOCKS_KEPT = 512

    # Where everything begins: the header, and what the index of most files fits into with what is
    # read before it.
    _HEAD, _TAIL = _BLOCK, 5 * _BLOCK

    _MOST_WHOLE = 1 << 20  # of a file that is taken whole from a server without ranges

    _SILENT_SECONDS = 60  # that a server may be
    _PAUSES = 0.2, 0.4, 0.8  # before what failed for a while is asked for again
    _LONGEST_PAUSE = 60  # that a busy server may ask for

    def __init__(self, url, options=None, file=None):
        """file  an OpenFile of it, where there is one"""
        self._url = url
        self._storage_options = options or {}
        self.place = url if file is None else file
        self._of_file = None if file is None else (file.fs, file.path)
        self._process = os.getpid()
        self._blocks = None
        self._waiters = None
        self._ends = {}  # offset: bytes that came with the length of the file
        self._answers = []  # seconds and bytes of what was asked for when it was opened
        self.name = without_secrets(url)

    def _forget(self):
        """Fetches everything anew from now on: some of it was not as it should be."""
        self._ends = {}
        self._blocks.forget()

    def open(self, cache_bytes):
        try:
            import fsspec.asyn
        except ImportError as error:
            raise package_error("fsspec", f"{self.name}: URLs are read through fsspec (pip install "
                                "fsspec aiohttp)", error) from None
        self._waiters = _octavo.Waiters()
        try:
            files, path = self._found(fsspec)
            size = self._opened(files, path)
        except (ImportError, ValueError) as error:
            raise ArgumentError(f"{self.name}: {self._words_of(error)}",
                                path=self.name) from None
        except Exception as error:
            failure = MissingError if self._is_missing(error) else StorageError
            raise failure(f"{self.name}: {self._words_of(error)}", path=self.name) from None
        if size is None:
            raise StorageError(f"{self.name}: the server does not tell the length of the file",
                               path=self.name)

        def fetch(start, stop):
            held = self._held(start, stop)
            if held is not None:
                return held
            try:
                return self._tried(lambda: _asked(files, "cat_file", path, start=start, end=stop))
            except _Stopped:
                raise
            except Exception as error:
                raise OSError(self._words_of(error)) from None

        self._blocks = _Blocks(fetch, size, self._BLOCK, self._BLOCKS_KEPT, self._require_waiters)

        def fetch_all(offsets, lengths):
            ranges = [(offset, offset + length) for offset, length in zip(offsets, lengths)]
            found = {one: self._held(*one) for one in ranges}
            wanted = [one for one in ranges if found[one] is None]
            asked = time.perf_counter()
            try:
                if wanted:
                    found.update(zip(wanted, self._all_ranges(files, path, wanted)))
            except Exception as error:
                raise OSError(self._words_of(error)) from None
            taken = time.perf_counter() - asked if wanted else 0.0
            return [found[one] for one in ranges], taken, sum(b - a for a, b in wanted)

        return _octavo.OpenFile(
            {"read_at": self._blocks.read, "fetch": fetch_all, "forget": self._forget,
             "size": size, "name": self.name, "answers": self._answers, "waiters": self._waiters},
            cache_bytes)

    def _found(self, fsspec):
        """(file system, path)"""
        _renew_loop(fsspec.asyn)
        if self._of_file is None:
            return fsspec.core.url_to_fs(self._url, **self._options())
        files, path = self._of_file
        here = os.getpid()
        if self._process != here or getattr(files, "_pid", here) != here:
            # Its threads do not live on in a forked process.
            self._of_file = pickle.loads(pickle.dumps(files)), path
            self._process = here
        return self._of_file

    def _opened(self, files, path):
        """The length of the file. Both its ends come in the same round, where servers can that."""
        self._ends = {}
        self._answers = []
        if not self._is_http():
            return self._tried(lambda: _asked(files, "size", path))
        import asyncio

        async def timed(answer):
            start = time.perf_counter()
            return await answer, time.perf_counter() - start

        async def asked():
            info, *parts = await asyncio.gather(
                timed(files._info(path)), timed(self._part(files, path, f"0-{self._HEAD - 1}")),
                timed(self._part(files, path, f"-{self._TAIL}")), return_exceptions=True)
            for answer in info, *(part for part in parts if isinstance(part, _NoRanges)):
                if isinstance(answer, BaseException):
                    raise answer
            return info, *parts

        (info, seconds), *parts = self._tried(
            lambda: asyncio.run_coroutine_threadsafe(asked(), files.loop))
        self._answers.append((seconds, 0))
        for part in parts:
            # What failed is asked for again when it is read, and fails then.
            if isinstance(part, BaseException):
                continue
            part, seconds = part
            if part is not None and part[2] == info["size"]:
                self._ends[part[0]] = part[1]
                self._answers.append((seconds, len(part[1])))
        return info["size"]

    @staticmethod
    async def _part(files, path, span):
        """(offset, bytes, length of the file) of a range; None of servers that do not know it."""
        words = dict(files.kwargs)
        words["headers"] = {**words.get("headers", {}), "Range": f"bytes={span}"}
        session = await files.set_session()
        async with session.get(files.encode_url(path), **words) as answer:
            if answer.status == 200 and span.startswith("0-"):
                return await _Url._whole(answer)
            said = re.fullmatch(r"bytes (\d+)-(\d+)/(\d+)",
                                answer.headers.get("Content-Range", ""))
            if answer.status != 206 or not said:
                return None  # before the rest of the file arrives
            first, last, size = map(int, said.groups())
            if last - first >= _Url._TAIL:
                return None
            held = await answer.read()
            return (first, held, size) if len(held) == last + 1 - first else None

    @staticmethod
    async def _whole(answer):
        """All of a small file that comes where a range was asked for, as `_part` has it."""
        size = answer.content_length
        if size is None or size > _Url._MOST_WHOLE:
            raise _NoRanges("the server does not serve ranges of a file")
        held = await answer.read()
        return 0, held, len(held)

    def _held(self, start, stop):
        """The bytes [start, stop), where an end of the file has them."""
        for at, held in self._ends.items():
            if at <= start and stop <= at + len(held):
                return held[start - at:stop - at]
        return None

    def _is_http(self):
        return self._url.startswith(("http://", "https://"))

    def _options(self):
        given = self._storage_options
        if not self._is_http():
            return given
        try:
            import aiohttp
        except ImportError:
            return given
        silent = aiohttp.ClientTimeout(total=None, sock_connect=self._SILENT_SECONDS,
                                       sock_read=self._SILENT_SECONDS)
        return {**given, "client_kwargs": {"timeout": silent, **given.get("client_kwargs", {})}}

    def _all_ranges(self, files, path, ranges):
        """The bytes of each; raises what any of them failed with."""
        def ask():
            # Some versions of fsspec return errors even where they are asked to raise them.
            return _asked(files, "cat_ranges", [path] * len(ranges), *map(list, zip(*ranges)),
                          on_error="return")

        return map(bytes, self._tried(ask, _first_error_of))

    def _tried(self, ask, error_in=lambda answer: None):
        """What the future of `ask` holds; asked again as long as a server is busy or loses
        connections. Raises _Stopped once the call that asks has ended."""
        for pause in (*self._PAUSES, None):
            try:
                answer = self._awaited(ask())
                error = error_in(answer)
                if error is None:
                    return answer
                raise error
            except Exception as error:
                if pause is not None:
                    pause = self._pause_before(error, pause)
                if pause is None:
                    raise
            until = time.monotonic() + pause
            while (left := until - time.monotonic()) > 0:
                time.sleep(min(left, _LOOK_SECONDS))
                self._require_waiters()

    def _awaited(self, future):
        try:
            return _result_of(future, self._require_waiters)
        except BaseException:
            future.cancel()
            raise

    def _require_waiters(self):
        if self._waiters.are_stopped():
            raise _Stopped("stopped")

    def _pause_before(self, error, pause):
        """Seconds until it is worth asking again: at least `pause`. None: it is not."""
        reason = _reason_of(error)
        status = getattr(reason, "status", None) or 0
        if status != 429 and not 500 <= status < 600:
            return pause if self._is_http() and _is_lost(reason) else None
        asked = (getattr(reason, "headers", None) or {}).get("Retry-After", "")
        if not asked.strip().isdecimal():
            return pause
        return max(pause, int(asked)) if int(asked) <= self._LONGEST_PAUSE else None

    def _is_missing(self, error):
        """Whether there is no such file."""
        if not isinstance(error, FileNotFoundError):
            return False
        reason = _reason_of(error)
        is_of_server = "http://" in self._url or "https://" in self._url
        return reason is None or not is_of_server or getattr(reason, "status", None) in (404, 410)

    def _words_of(self, error):
        """Why fetching failed, without the secrets of the URL."""
        if self._is_missing(error):
            return "is not there"
        reason = _reason_of(error)
        status = getattr(reason, "status", None)
        if status:
            return f"the server answered {status}"
        words = _octavo.without_secrets(str(reason).replace(self._url, self.name)).strip()
        return words or f"the server did not answer ({type(reason).__name__})"


def _renew_loop(asyn):
    """Lets fsspec start its loop anew in a forked process; newer versions do so themselves."""
    thread = asyn.iothread[0]
    if thread is not None and not thread.is_alive() and hasattr(asyn, "reset_lock"):
        asyn.reset_lock()


class _Stopped(OSError):
    """The call that wanted bytes has ended."""


def _result_of(future, require_waiters):
    """What a future holds or raises; what `require_waiters` raises before that."""
    while not concurrent.futures.wait([future], timeout=_LOOK_SECONDS).done:
        require_waiters()
    return future.result()


class _NoRanges(OSError):
    """A server sends whole files alone, and this one is large."""


def _asked(files, name, *args, **options):
    """The future of what a method of a file system returns. Who cancels it does not wait."""
    if getattr(files, "async_impl", False) and not getattr(files, "asynchronous", False):
        import asyncio
        ask = getattr(files, "_" + name)
        return asyncio.run_coroutine_threadsafe(ask(*args, **options), files.loop)
    future = concurrent.futures.Future()

    def work():
        try:
            tell, found = future.set_result, getattr(files, name)(*args, **options)
        except BaseException as error:
            tell, found = future.set_exception, error
        with contextlib.suppress(concurrent.futures.InvalidStateError):  # cancelled
            tell(found)

    threading.Thread(target=work, daemon=True).start()
    return future


def _first_error_of(answers):
    return next((one for one in answers if isinstance(one, BaseException)), None)


def _reason_of(error):
    """What is behind an error of fsspec, which says that the file is not found, whatever a server
    answers."""
    return error.__cause__ if isinstance(error, FileNotFoundError) else error


def _is_lost(reason):
    """Whether a connection was lost, or not made."""
    try:
        import aiohttp
    except ImportError:
        return False
    return isinstance(reason, (aiohttp.ClientConnectionError, aiohttp.ClientPayloadError)) and \
        not isinstance(reason, (aiohttp.ServerTimeoutError, aiohttp.ClientSSLError))


class _Blocks:
    """Ranges of a file, fetched in whole blocks of which the last ones are kept.

    Any number of threads may read; no block is fetched by two of them at once.
    """

    def __init__(self, fetch, size, block, kept, require_waiters=lambda: None):
        """require_waiters  raises _Stopped on threads whose call has ended"""
        self._fetch = fetch
        self._require_waiters = require_waiters
        self._size = size
        self._block = block
        self._kept = kept
        self._lock = threading.Lock()
        self._blocks = {}  # number: future of its bytes

    def read(self, at, length):
        first, last = at // self._block, (at + max(length, 1) - 1) // self._block
        while True:
            found, runs = self._claim(first, last)
            try:
                for run in runs:
                    self._fetch_run(run)
            except BaseException as error:
                self._give_up([block for run in runs for block in run], error)
                raise
            try:
                joined = b"".join(_result_of(one, self._require_waiters) for one in found)
            except _Stopped:
                # Of the call that fetches for this one as well, or of this one.
                self._require_waiters()
                continue
            return joined[at - first * self._block:at - first * self._block + length]

    def forget(self):
        with self._lock:
            self._blocks = {n: future for n, future in self._blocks.items() if not future.done()}

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
        if not isinstance(error, Exception):
            error = _Stopped("stopped")
        for number, future in claimed:
            if not future.done():
                with self._lock:
                    self._blocks.pop(number, None)
                future.set_exception(error)
