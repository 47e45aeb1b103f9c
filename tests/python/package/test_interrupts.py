"""Ctrl-C while a server is silent: every call that reads a URL ends soon and leaves nothing."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
import types

import numpy as np
import pytest

import octavo
from ranged_files import serving


class SlowPlanes:
    """An array whose build takes two seconds on any machine."""

    shape, dtype = (200, 20, 20), np.dtype(np.int16)

    def __getitem__(self, planes):
        count = len(range(*planes.indices(self.shape[0])))
        time.sleep(count / 100)
        return np.zeros((count, *self.shape[1:]), self.dtype)


# Of volumes behind URLs and a folder: grey values, labels, a mask, the same mask elsewhere.
CALLS = {
    "align": lambda a: a.mask.align(a.other, output=a.out("o.txt"), picture=a.out("p.png")),
    "build": lambda a: octavo.build(a.grey, a.out("o.8vo")),
    "build real": lambda a: octavo.build(a.grey.real, a.out("o.8vo")),
    "classify": lambda a: a.grey.classify({1: (0, 100)}),
    "compare": lambda a: a.grey.compare(a.mask),
    "condense": lambda a: a.grey.condense(a.out("o.8vo"), 2),
    "distance": lambda a: a.mask.distance(a.out("o.8vo")),
    "export": lambda a: octavo.export(a.grey, a.out("o.ome.zarr")),
    "label_map": lambda a: a.labels.label_map(),
    "mask": lambda a: a.labels.mask(1),
    "measure": lambda a: a.labels.measure(),
    "measure of": lambda a: a.labels.measure(a.grey),
    "morphometry": lambda a: a.mask.morphometry(),
    "open": lambda a: octavo.open(a.url),
    "read": lambda a: a.grey[...],
    "read a voxel": lambda a: a.grey[3, 4, 5],
    "render cubes": lambda a: a.mask.render("cubes"),
    "render rays": lambda a: a.grey.render("mip"),
    "save_hexahedra": lambda a: a.mask.save_hexahedra(a.out("o.vtu")),
    "save_label_surfaces": lambda a: a.labels.save_label_surfaces(a.out("o")),
    "save_surface": lambda a: a.grey.save_surface(a.out("o.stl"), 0),
    "self_similarity": lambda a: a.grey.self_similarity(),
    "shell": lambda a: a.mask.shell(),
    "slice": lambda a: a.grey.slice("z", 5),
    "surface": lambda a: a.grey.surface(0),
    "threshold": lambda a: a.grey.threshold(0),
    "touch": lambda a: a.labels.touch(),
    "touch masks": lambda a: a.mask.touch(a.other),
    "told of a build": lambda a: octavo.build(SlowPlanes(), a.out("o.8vo"),
                                              progress=lambda *_: a.grey[...]),
    "transform": lambda a: a.grey.transform(a.out("o.8vo"), mirror="x"),
}


@pytest.fixture(scope="module")
def far(tmp_path_factory):
    """Volumes of which most bytes are not fetched when they are opened."""
    pytest.importorskip("aiohttp")
    folder = tmp_path_factory.mktemp("far")
    random = np.random.default_rng(2)
    shape = (176, 160, 161)
    labels = random.integers(0, 9, shape, np.uint8)
    labels[60:] = 0  # noise takes long to encode
    for name, voxels, kind in (
            ("grey", random.integers(-9, 9, shape, np.int16), "grey"),
            ("labels", labels, "labels"),
            ("mask", random.random(shape) < 0.5, "labels")):
        octavo.build(voxels, folder / f"{name}.8vo", kind=kind, spacing=(1, 1, 1),
                     preset="small").close()
    (folder / "other.8vo").write_bytes((folder / "mask.8vo").read_bytes())
    with serving(str(folder)) as (handler, root):
        yield types.SimpleNamespace(
            handler=handler, url=f"{root}/grey.8vo", held=(folder / "grey.8vo").read_bytes(),
            **{name: octavo.open(f"{root}/{name}.8vo", cache_bytes=0)
               for name in ("grey", "labels", "mask", "other")})


@pytest.mark.parametrize("name", CALLS)
def test_an_interrupt_ends_every_call_that_waits_for_a_server(name, far, tmp_path, with_interrupts):
    far.out = lambda name: tmp_path / name
    far.handler.is_waiting.clear()
    far.handler.silence = threading.Event()
    sent = []

    def interrupt():
        if far.handler.is_waiting.wait(20):
            time.sleep(0.1)
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    try:
        with pytest.raises(KeyboardInterrupt):
            CALLS[name](far)
        assert time.monotonic() - sent[0] < 3
    finally:
        far.handler.silence.set()
        far.handler.silence = None
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("planes", [np.s_[60:70], np.s_[90:100]])
def test_an_interrupt_ends_a_call_while_another_thread_waits(planes, far, with_interrupts):
    volume = octavo.open(far.url)
    far.handler.is_waiting.clear()
    far.handler.silence = threading.Event()
    read = []

    def read_on():
        with contextlib.suppress(octavo.StorageError):
            read.append(volume[60:70])

    other = threading.Thread(target=read_on)
    other.start()
    try:
        assert far.handler.is_waiting.wait(20)
        threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        begun = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            volume[planes]
        assert time.monotonic() - begun < 3 and other.is_alive()
    finally:
        far.handler.silence.set()
        far.handler.silence = None
        other.join()
    assert not read or np.array_equal(read[0], volume[60:70])


def test_a_file_system_without_async_calls_is_left_alone(far, with_interrupts, monkeypatch):
    fsspec = pytest.importorskip("fsspec")
    from fsspec.implementations.memory import MemoryFileSystem
    may_go_on, raised = threading.Event(), []

    class Slow(MemoryFileSystem):
        protocol = "slow"
        is_slow = False

        @classmethod
        def _strip_protocol(cls, path):
            return super()._strip_protocol(path.replace("slow://", "memory://"))

        def cat_ranges(self, paths, starts, ends, **kwargs):
            if Slow.is_slow:
                may_go_on.wait(30)
                raise OSError("late")
            return super().cat_ranges(paths, starts, ends, **kwargs)

    fsspec.register_implementation("slow", Slow, clobber=True)
    fsspec.filesystem("slow").pipe("/grey.8vo", far.held)
    volume = octavo.open("slow://grey.8vo", cache_bytes=0)
    monkeypatch.setattr(threading, "excepthook", raised.append)
    Slow.is_slow = True
    threads = threading.active_count()
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        volume[60:70]
    may_go_on.set()
    until = time.monotonic() + 20
    while threading.active_count() > threads and time.monotonic() < until:
        time.sleep(0.01)
    assert not raised


def test_what_was_interrupted_is_read_later(far):
    assert far.grey.threshold(0).voxels == np.count_nonzero(far.grey[...] >= 0)


@pytest.mark.parametrize("whole_group", [False, True])
def test_a_build_by_the_program_leaves_nothing(tmp_path, whole_group):
    (tmp_path / "scan.raw").write_bytes(np.random.default_rng(1).bytes(1600 << 16))
    code = ("import octavo, signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "octavo.build('scan.mhd', 'o.8vo', threads=1)")
    (tmp_path / "scan.mhd").write_text(
        "ObjectType = Image\nNDims = 3\nDimSize = 256 256 1600\nElementType = MET_UCHAR\n"
        "ElementSpacing = 1 1 1\nElementDataFile = scan.raw\n")
    path = os.path.dirname(os.environ["OCTAVO"]) + os.pathsep + os.environ["PATH"]
    python = subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, start_new_session=True,
                              stderr=subprocess.PIPE, text=True, env={**os.environ, "PATH": path})
    until = time.monotonic() + 60
    while not list(tmp_path.glob(".o.8vo.tmp-*")):
        assert python.poll() is None and time.monotonic() < until
        time.sleep(0.01)
    time.sleep(0.1)
    (os.killpg if whole_group else os.kill)(python.pid, signal.SIGINT)
    assert "KeyboardInterrupt" in python.communicate()[1]
    assert sorted(os.listdir(tmp_path)) == ["scan.mhd", "scan.raw"]
