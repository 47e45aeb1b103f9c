"""Where files come from: bytes, URLs; damage; processes and threads that share a volume."""

import concurrent.futures
import contextlib
import errno
import gc
import io
import multiprocessing
import os
import pathlib
import pickle
import re
import signal
import threading

import numpy as np
import pytest

import octavo
from ranged_files import serving


def test_what_is_not_there_is_a_missing_file(tmp_path, voxels):
    absent = str(tmp_path / "a.8vo")
    for make in (lambda: octavo.open(absent), lambda: octavo.from_ome_zarr(absent, "b.8vo")):
        with pytest.raises(FileNotFoundError) as raised:
            make()
        assert isinstance(raised.value, octavo.StorageError)
        assert (raised.value.errno, raised.value.filename) == (errno.ENOENT, absent)
        assert str(raised.value).startswith(f"{absent}: ") and raised.value.kind == "io"
    with pytest.raises(octavo.StorageError) as raised:
        octavo.open(tmp_path)
    assert not isinstance(raised.value, FileNotFoundError)


def test_a_missing_file_is_the_same_where_it_was_pickled(tmp_path):
    absent = str(tmp_path / "a.8vo")
    with pytest.raises(octavo.MissingError) as raised:
        octavo.open(absent)
    with contextlib.suppress(ImportError):  # with which distributed has errors pickled
        from tblib import pickling_support
        pickling_support.install()
    for error in raised.value, pickle.loads(pickle.dumps(raised.value)):
        assert isinstance(error, octavo.MissingError) and error.path == absent
        assert (error.errno, error.filename) == (errno.ENOENT, absent)
        assert error.strerror == os.strerror(errno.ENOENT)
        assert str(error) == str(raised.value)


def test_bytes_are_a_file(path, voxels):
    volume = octavo.open(pathlib.Path(path).read_bytes())
    assert np.array_equal(volume[60:70], voxels[60:70])
    assert np.array_equal(pickle.loads(pickle.dumps(volume))[5], voxels[5])


def forked(holds):
    """Whether `holds` in a forked process: what waits for its status, 0 where it does."""
    pid = os.fork()
    if pid == 0:
        status = 1
        try:
            signal.alarm(30)
            status = 0 if holds() else 2
        finally:
            os._exit(status)
    return lambda: os.waitpid(pid, 0)[1]


@pytest.fixture
def served(path, monkeypatch):
    monkeypatch.setattr("octavo._sources._Url._PAUSES", (0.01, 0.02, 0.03))
    with serving(os.path.dirname(path)) as (handler, root):
        yield handler, root


def test_of_a_url_only_what_is_needed_is_fetched(served, voxels, path):
    pytest.importorskip("aiohttp")
    handler, root = served
    volume = octavo.open(f"{root}/scan.8vo")
    assert np.array_equal(volume[64], voxels[64])
    assert handler.sent < os.path.getsize(path) / 2
    assert np.array_equal(volume[...], voxels)


@pytest.mark.parametrize("suffixes", (True, False))
def test_a_url_is_opened_in_one_round(served, volume, path, suffixes):
    pytest.importorskip("aiohttp")
    handler, url = served
    handler.has_suffixes = suffixes
    with octavo.open(f"{url}/{os.path.basename(path)}") as remote:
        spans = sorted(span for method, span in handler.asked if method == "GET")
        assert spans[:2] == ["bytes=-327680", "bytes=0-65535"]
        # The end comes by its place where the server does not count from there.
        assert (len(spans) == 2) == (suffixes or os.path.getsize(path) <= 65536), spans
        assert remote.attrs == volume.attrs
        assert np.array_equal(remote[40:50, 30:40], volume[40:50, 30:40])


@pytest.mark.parametrize("answers, rounds", (
    ([], 2),
    ([(0.02, 0), (0.02, 300_000)], 1),   # a server that brings much while a round lasts
    ([(0.02, 0), (2.02, 300_000)], 2)))  # little
def test_bricks_come_whole_where_that_is_sooner_than_a_round(tmp_path, answers, rounds):
    from octavo import _octavo
    steps = np.random.default_rng(3).integers(-9, 10, (70, 130, 130))
    voxels = steps.cumsum(2).astype(np.int16)
    octavo.build(voxels, tmp_path / "cut.8vo", preset="fast", access="boxes").close()
    held = (tmp_path / "cut.8vo").read_bytes()
    calls = []

    def fetch(offsets, lengths):
        calls.append(sum(lengths))
        return [held[a:a + n] for a, n in zip(offsets, lengths)], 0.0, sum(lengths)

    def read_at(at, length):
        return held[at:at + length]

    file = _octavo.OpenFile(
        {"read_at": read_at, "fetch": fetch, "forget": None, "answers": answers,
         "waiters": _octavo.Waiters(), "size": len(held), "name": "cut"}, 1 << 24)
    calls.clear()
    out = np.empty((8, 130, 8), np.int16)
    file.read((2, 0, 60), (10, 130, 68), 0, out, 1)
    assert np.array_equal(out, voxels[2:10, :, 60:68])
    assert len(calls) == rounds, calls


def test_a_url_that_is_not_there_says_so(served):
    pytest.importorskip("aiohttp")
    _, root = served
    for place in f"{root}/none.8vo", "memory://none.8vo", "file:///no/such/none.8vo":
        with pytest.raises(octavo.MissingError, match="none.8vo: is not there") as raised:
            octavo.open(place)
        assert raised.value.filename == place
    with pytest.raises(octavo.Error, match="nosuch"):
        octavo.open("nosuch://a/b.8vo")


def test_a_server_that_rejects_says_why(served):
    pytest.importorskip("aiohttp")
    handler, root = served
    for status in (403, 500):
        handler.status = status
        with pytest.raises(octavo.StorageError, match=f"the server answered {status}") as raised:
            octavo.open(f"{root}/scan.8vo")
        assert not isinstance(raised.value, octavo.MissingError)
    with pytest.raises(octavo.StorageError, match="onnect") as raised:
        octavo.open("http://127.0.0.1:1/scan.8vo")
    assert not isinstance(raised.value, octavo.MissingError)


def test_a_server_that_is_busy_is_asked_again(served, voxels):
    pytest.importorskip("aiohttp")
    handler, root = served
    handler.busy[:] = [503, 502]
    volume = octavo.open(f"{root}/scan.8vo")
    for statuses in ([503], [429, 500, 503]):
        handler.busy[:] = statuses
        assert np.array_equal(volume[60:70], voxels[60:70])
        assert not handler.busy
        volume = octavo.open(f"{root}/scan.8vo")
    handler.status = 503
    handler.asked.clear()
    with pytest.raises(octavo.StorageError, match="the server answered 503"):
        volume[100]
    handler.status = 403  # which no patience helps
    with pytest.raises(octavo.StorageError, match="the server answered 403"):
        volume[100]


def test_secrets_of_urls_are_never_seen(served, voxels):
    pytest.importorskip("aiohttp")
    handler, root = served
    volume = octavo.open(f"{root}/scan.8vo?sig=hunter2")
    assert np.array_equal(volume[3], voxels[3])
    assert np.array_equal(pickle.loads(pickle.dumps(volume))[3], voxels[3])
    said = [repr(volume), repr(volume.levels[1]), volume.name]
    handler.status = 500
    for place in (f"{root}/scan.8vo?sig=hunter2", f"{root}/none.8vo?sig=hunter2"):
        with pytest.raises(octavo.StorageError) as caught:
            octavo.open(place)
        said.append(str(caught.value) + str(caught.value.path))
    with pytest.raises(octavo.StorageError) as caught:
        volume[100]
    said.append(str(caught.value))
    assert not [text for text in said if "hunter2" in text]


def test_secrets_of_chained_urls_are_never_seen():
    pytest.importorskip("aiohttp")
    for place, name in (
            ("simplecache::http://u:hunter2@127.0.0.1:1/x.8vo?t=hunter2",
             "simplecache::http://127.0.0.1:1/x.8vo"),
            ("zip://a.8vo::http://u:hunter2@127.0.0.1:1/x.zip?t=hunter2",
             "zip://a.8vo::http://127.0.0.1:1/x.zip"),
            ("http://u:hunter/2@127.0.0.1:1/x.8vo", "http://..."),
            ("nosuch://[hunter2", "nosuch://...")):
        with pytest.raises(octavo.Error) as caught:
            octavo.open(place)
        assert str(caught.value).startswith(name + ": ") and caught.value.path == name
        assert "hunter" not in str(caught.value)


def test_bytes_that_came_damaged_are_fetched_again(served, voxels):
    pytest.importorskip("aiohttp")
    handler, root = served
    volume = octavo.open(f"{root}/scan.8vo")
    handler.flips = 40000
    with pytest.raises(octavo.CorruptError):
        volume[...]
    handler.flips = 0
    assert np.array_equal(volume[...], voxels)


def test_a_server_without_ranges_is_named(served):
    pytest.importorskip("aiohttp")
    handler, root = served
    handler.has_ranges = False
    with pytest.raises(octavo.StorageError, match="does not serve ranges"):
        octavo.open(f"{root}/scan.8vo")
    assert {method for method, _ in handler.asked} == {"HEAD", "GET"} and len(handler.asked) == 3


def test_a_small_file_is_taken_whole_from_a_server_without_ranges(served, voxels):
    pytest.importorskip("aiohttp")
    handler, root = served
    handler.has_ranges = False
    small = os.path.join(handler.directory, "small.8vo")
    octavo.build(voxels[:20], small)
    assert np.array_equal(octavo.open(f"{root}/small.8vo")[...], voxels[:20])
    os.unlink(small)


def test_options_of_a_file_system_are_kept(served, voxels, path):
    fsspec = pytest.importorskip("fsspec")
    pytest.importorskip("aiohttp")
    handler, root = served
    handler.wanted = "Bearer secret"
    with pytest.raises(octavo.StorageError, match="401"):
        octavo.open(f"{root}/scan.8vo")
    options = {"headers": {"Authorization": "Bearer secret"},
               "client_kwargs": {"trust_env": False}}
    volume = octavo.open(f"{root}/scan.8vo", storage_options=options)
    assert np.array_equal(volume[5], voxels[5])
    for one in volume, volume.levels[0]:
        assert np.array_equal(pickle.loads(pickle.dumps(one))[6], voxels[6])
    there = fsspec.open(f"{root}/scan.8vo", **options)
    assert np.array_equal(octavo.open(there)[7], voxels[7])
    for place in path, b"bytes":
        with pytest.raises(octavo.ArgumentError, match="storage_options are of URLs"):
            octavo.open(place, storage_options={})
    with pytest.raises(octavo.ArgumentError, match="dictionary"):
        octavo.open(f"{root}/scan.8vo", storage_options="secret")


def test_open_files_and_files_of_fsspec_are_read(path, voxels):
    held = pathlib.Path(path).read_bytes()
    volume = octavo.open(io.BytesIO(held))
    assert np.array_equal(volume[5], voxels[5])
    assert np.array_equal(pickle.loads(pickle.dumps(volume))[6], voxels[6])
    with open(path, "rb", buffering=0) as file:
        volume = octavo.open(file)
        assert volume.name == path and np.array_equal(volume[...], voxels)
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            assert all(pool.map(lambda z: np.array_equal(volume[z], voxels[z]), range(40)))
    with open(path) as file, pytest.raises(octavo.ArgumentError, match="text"):
        octavo.open(file)
    with pytest.raises(octavo.FormatError):
        octavo.open(io.BytesIO(b"nothing of the kind" * 99))
    fsspec = pytest.importorskip("fsspec")
    volume = octavo.open(fsspec.open(path))
    assert np.array_equal(pickle.loads(pickle.dumps(volume))[6], voxels[6])
    with pytest.raises(octavo.ArgumentError, match="without compression"):
        octavo.open(fsspec.open(path, compression="gzip"))


def test_a_forked_process_reads_what_fsspec_reads(served, voxels):
    fsspec = pytest.importorskip("fsspec")
    pytest.importorskip("aiohttp")
    _, root = served
    there = fsspec.open(f"{root}/scan.8vo")
    for place in there, f"{root}/scan.8vo":
        volume = octavo.open(place)
        assert np.array_equal(volume[64], voxels[64])
        assert forked(lambda: np.array_equal(volume[...], voxels))() == 0
    assert forked(lambda: np.array_equal(octavo.open(there)[...], voxels))() == 0


class Waiting(io.BytesIO):
    """Bytes whose reads wait once they are told to."""

    waits = False

    def __init__(self, held):
        super().__init__(held)
        self.is_waiting, self.may_go_on = threading.Event(), threading.Event()

    def read(self, length=-1):
        if self.waits:
            self.is_waiting.set()
            self.may_go_on.wait()
        return super().read(length)


def test_a_process_that_is_forked_amid_a_read_of_a_file_object_reads(path, voxels):
    file = Waiting(pathlib.Path(path).read_bytes())
    volume = octavo.open(file)
    file.waits = True
    reading = threading.Thread(target=lambda: volume[5])
    reading.start()
    file.is_waiting.wait()
    file.waits = False
    wait = forked(lambda: np.array_equal(volume[9], voxels[9]))
    file.may_go_on.set()
    reading.join()
    assert wait() == 0


@pytest.mark.parametrize("buffering", (0, -1))
def test_processes_that_share_an_open_file_read_side_by_side(path, voxels, buffering):
    with open(path, "rb", buffering=buffering) as file:
        volume = octavo.open(file, cache_bytes=0)

        def reads():
            return all(np.array_equal(volume[z], voxels[z]) for z in (*range(0, 130, 3),) * 3)

        waits = [forked(reads) for _ in range(2)]
        assert reads() and [wait() for wait in waits] == [0, 0]


def test_a_block_that_fails_is_fetched_again():
    from octavo._sources import _Blocks
    held = bytes(range(200)) * 5
    asked = []

    def fetch(start, stop):
        asked.append((start, stop))
        if len(asked) == 2:
            raise OSError("broke off")
        return held[start:stop]

    blocks = _Blocks(fetch, len(held), 100, 20)
    assert blocks.read(250, 20) == held[250:270]
    with pytest.raises(OSError, match="broke off"):
        blocks.read(90, 700)  # blocks 0 and 1, and behind the one that is there 3 to 7
    assert blocks.read(90, 700) == held[90:790]
    assert asked == [(200, 300), (0, 200), (0, 200), (300, 800)]


@pytest.mark.parametrize("raised", [KeyboardInterrupt, "stopped"])
def test_who_waits_for_a_block_fetches_it_where_another_call_has_ended(raised):
    from octavo._sources import _Blocks, _Stopped
    held = bytes(range(200))
    is_asked, may_end = threading.Event(), threading.Event()

    def fetch(start, stop):
        if not is_asked.is_set():
            is_asked.set()
            may_end.wait()
            raise _Stopped("stopped") if raised == "stopped" else raised
        return held[start:stop]

    blocks = _Blocks(fetch, len(held), 100, 20)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        first = pool.submit(blocks.read, 0, 20)
        is_asked.wait()
        second = pool.submit(blocks.read, 10, 20)
        assert not concurrent.futures.wait([second], timeout=0.2).done
        may_end.set()
        assert second.result() == held[10:30]
        with pytest.raises(_Stopped if raised == "stopped" else raised):
            first.result()


def test_threads_fetch_no_block_twice():
    from octavo._sources import _Blocks
    held = os.urandom(64000)
    asked = []

    def fetch(start, stop):
        asked.append((start, stop))
        return held[start:stop]

    blocks = _Blocks(fetch, len(held), 1000, 100)
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        places = [(7 * i * 613 % 60000, 3000) for i in range(200)]
        for (at, length), part in zip(places, pool.map(lambda p: blocks.read(*p), places)):
            assert part == held[at:at + length]
    fetched = [n for start, stop in asked for n in range(start, stop, 1000)]
    assert len(fetched) == len(set(fetched))


def test_damage_raises_and_fills_nothing(path, tmp_path):
    held = bytearray(pathlib.Path(path).read_bytes())
    held[len(held) // 3] ^= 64
    with octavo.open(bytes(held)) as volume:
        with pytest.raises(octavo.CorruptError) as caught:
            volume[...]
        assert caught.value.kind == "corrupt"
    with pytest.raises(octavo.TruncatedError):
        octavo.open(bytes(held[:len(held) // 2]))
    with pytest.raises(octavo.FormatError):
        octavo.open(b"no file of ours, but long enough to be looked at" * 9)
    with pytest.raises(octavo.StorageError, match="none.8vo"):
        octavo.open(tmp_path / "none.8vo")
    with pytest.raises(octavo.ArgumentError, match="not int"):
        octavo.open(5)
    for cache_bytes in (-1, 1 << 70, 1.5):
        with pytest.raises(octavo.ArgumentError, match="cache_bytes is a whole number"):
            octavo.open(path, cache_bytes=cache_bytes)


def test_what_interrupts_a_fetch_is_what_is_raised(path):
    from octavo import _octavo
    held = pathlib.Path(path).read_bytes()
    is_over = []

    def read_at(at, length):
        if is_over:
            raise KeyboardInterrupt
        return held[at:at + length]

    file = _octavo.OpenFile({"read_at": read_at, "size": len(held), "name": "a"}, 1 << 20)
    is_over.append(True)
    with pytest.raises(KeyboardInterrupt):
        file.read((0, 0, 0), (5, 5, 5), 0, np.empty((5, 5, 5), np.int16), 1)


def test_a_relative_path_is_that_of_when_it_was_opened(path, voxels, monkeypatch, tmp_path):
    monkeypatch.chdir(os.path.dirname(path))
    volume = octavo.open(os.path.basename(path))
    monkeypatch.chdir(tmp_path)
    assert np.array_equal(pickle.loads(pickle.dumps(volume))[9], voxels[9])
    monkeypatch.setattr(volume._file, "_process", -1)  # as in one that was forked
    assert volume.name == "scan.8vo" and np.array_equal(volume[9], voxels[9])


def test_bytes_of_any_kind_pickle(path, voxels):
    held = pathlib.Path(path).read_bytes()
    for kind in bytes, bytearray, memoryview:
        volume = pickle.loads(pickle.dumps(octavo.open(kind(held))))
        assert np.array_equal(volume[9], voxels[9])


@pytest.mark.parametrize("given", [
    {}, {"slope": 3}, {"spacing": (1, 1, 1)}, {"origin": (0, 0, 1)},
    {"kind": "labels", "slope": None}])
def test_a_pickle_of_a_file_does_not_open_another_one(tmp_path, given):
    path = tmp_path / "a.8vo"
    voxels = np.arange(1000, dtype=np.int16).reshape(10, 10, 10)
    facts = dict(spacing=(2, 1, 1), slope=1 if "kind" in given else 2)
    volume = octavo.build(voxels, path, **facts)
    pickled = [pickle.dumps(one) for one in (volume, volume.levels[1], volume.levels[0])]
    octavo.build(voxels, path, preset="fast", overwrite=True, **facts)
    assert np.array_equal(pickle.loads(pickled[0])[...], voxels)  # the same in other bytes
    octavo.build(voxels if given else voxels + 1, path, overwrite=True, **{**facts, **given})
    for one in pickled:
        with pytest.raises(octavo.StorageError, match="a.8vo: was replaced by another file"):
            pickle.loads(one)


def test_a_forked_process_says_each_time_that_a_file_was_replaced(tmp_path):
    path = tmp_path / "a.8vo"
    volume = octavo.build(np.zeros((9, 9, 9), np.uint8), path)
    octavo.build(np.ones((9, 9, 9), np.uint8), path, overwrite=True)

    def is_told():
        with pytest.raises(octavo.StorageError, match="was replaced by another file"):
            volume[3]
        return True

    assert forked(lambda: is_told() and is_told())() == 0
    assert not volume[...].any()


def test_a_volume_pickles_as_its_place(volume, voxels, monkeypatch, tmp_path):
    there = pickle.dumps(volume)
    assert len(there) < 1000
    level = pickle.dumps(volume.levels[2])
    monkeypatch.chdir(tmp_path)
    assert np.array_equal(pickle.loads(level)[...], volume.levels[2][...])
    assert np.array_equal(pickle.loads(there)[9], voxels[9])


def test_tokens_of_dask_follow_the_voxels(path, tmp_path, voxels):
    octavo.build(voxels[:9], tmp_path / "a.8vo")
    first = octavo.open(tmp_path / "a.8vo")
    octavo.build(voxels[1:10], tmp_path / "a.8vo", overwrite=True)
    second = octavo.open(tmp_path / "a.8vo")
    tokens = [view.__dask_tokenize__() for volume in (first, second)
              for view in (volume, volume.levels[1], volume.real)]
    assert len(set(tokens)) == len(tokens)
    assert octavo.open(tmp_path / "a.8vo").__dask_tokenize__() == tokens[3]


@pytest.mark.parametrize("given", [{"kind": "labels"}, {"preset": "fast"}, {"dtype": np.int8}])
def test_levels_that_differ_are_two_arrays_of_one_computation(tmp_path, given):
    dask = pytest.importorskip("dask")
    pytest.importorskip("dask.array")
    voxels = np.random.default_rng(1).integers(0, 5, (64, 64, 64)).astype(np.uint8)
    a = octavo.build(voxels, tmp_path / "a.8vo")
    b = octavo.build(voxels.astype(given.pop("dtype", np.uint8)), tmp_path / "b.8vo", **given)
    assert a.voxels_sha256 == b.voxels_sha256
    for level in 0, 1:
        views = a.levels[level], b.levels[level]
        computed = dask.compute(*map(octavo.as_dask, views))
        for view, one in zip(views, computed):
            assert one.dtype == view.dtype and np.array_equal(one, view[...])


def test_many_threads_read_one_volume(volume, voxels):
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        for z, plane in enumerate(pool.map(volume.__getitem__, range(voxels.shape[0]))):
            assert np.array_equal(plane, voxels[z])


shared = None


def sum_of_plane(z):
    return int(shared[z].astype(np.int64).sum())


def test_forked_processes_read_a_volume_that_was_open(path, voxels):
    global shared
    shared = octavo.open(path)
    shared.read(threads=4)
    is_over = threading.Event()

    def keep_reading():
        while not is_over.is_set():
            shared[10:30]

    reading = threading.Thread(target=keep_reading)
    reading.start()
    try:
        with multiprocessing.get_context("fork").Pool(3) as pool:
            sums = pool.map_async(sum_of_plane, range(voxels.shape[0])).get(120)
    finally:
        is_over.set()
        reading.join()
    assert sums == voxels.astype(np.int64).sum((1, 2)).tolist()


def resident_bytes():
    return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_a_thousand_openings_leave_nothing_behind(path):
    def many():
        for i in range(500):
            octavo.open(path)[i % 130]

    many()
    gc.collect()
    files, memory = len(os.listdir("/proc/self/fd")), resident_bytes()
    many()
    assert len(os.listdir("/proc/self/fd")) == files
    assert resident_bytes() - memory < 8 << 20


def test_a_read_is_few_calls_of_the_file_system(path, voxels):
    fsspec = pytest.importorskip("fsspec")
    from fsspec.implementations.memory import MemoryFileSystem

    class Counted(MemoryFileSystem):
        protocol = "counted"
        calls = []

        @classmethod
        def _strip_protocol(cls, path):
            return super()._strip_protocol(path.replace("counted://", "memory://"))

        def cat_ranges(self, paths, starts, ends, **kwargs):
            self.calls.append(len(paths))
            return super().cat_ranges(paths, starts, ends, **kwargs)

        def cat_file(self, path, start=None, end=None, **kwargs):
            self.calls.append("one")
            return super().cat_file(path, start=start, end=end, **kwargs)

    fsspec.register_implementation("counted", Counted, clobber=True)
    files = fsspec.filesystem("counted")
    with open(path, "rb") as file:
        files.pipe("/scan.8vo", file.read())
    volume = octavo.open("counted://scan.8vo", cache_bytes=0)
    first = True
    for key in (np.s_[64], np.s_[:, 50], np.s_[3:20, 40:60, 90:100]):
        Counted.calls.clear()
        assert np.array_equal(volume[key], voxels[key])
        # MemoryFileSystem brings each range of a call by cat_file; a model of bricks that is not
        # known yet is a call of its own.
        calls = [call for call in Counted.calls if call != "one"]
        assert first <= len(calls) <= 2 and len(Counted.calls) == len(calls) + sum(calls)
        first = False
        Counted.calls.clear()
        assert np.array_equal(volume[key], voxels[key]) and Counted.calls == []
