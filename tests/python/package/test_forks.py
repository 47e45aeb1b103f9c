"""Processes that are forked and end normally, as those of servers do: what they leave alone."""

import os
import subprocess
import sys

import pytest

# Children are killed where they wait for threads that are not there.
FORKED = """
import gc, os, signal, sys
import numpy as np
import octavo

def fork(work):
    pid = os.fork()
    if pid == 0:
        signal.alarm(30)
        work()
        sys.exit(0)
    status = os.waitpid(pid, 0)[1]
    if status != 0:
        sys.exit(f"the child ended with the status {status}")

path = sys.argv[1]
"""

WRITERS = """
planes = int(sys.argv[2])
voxels = np.random.default_rng(1).integers(0, 99, (130, 40, 70)).astype(np.uint8)
w = octavo.Writer(path, voxels.shape, voxels.dtype)
w.add(voxels[:planes])

def drop():
    global w
    del w

def use():
    assert w.added == planes
    for work in (lambda: w.add(voxels[0]), w.close):
        try:
            work()
        except octavo.ArgumentError as error:
            assert "opened by another process" in str(error), error
        else:
            sys.exit(1)

fork(lambda: None)
fork(lambda: w.abandon())
fork(drop)
fork(use)
w.add(voxels[planes:])
w.close()
assert np.array_equal(octavo.open(path)[...], voxels)
"""

MASKS = """
octavo.build(np.random.default_rng(1).random((40, 40, 40)) < .5, path)
mask = octavo.open(path).mask()
saved = mask.saved()
fork(lambda: None)
fork(lambda: globals().pop("mask"))
assert os.path.exists(saved.name) and mask.measure()[0]["voxels"] == mask.voxels
name = saved.name
del mask, saved
gc.collect()
assert not os.path.exists(os.path.dirname(name))
"""

BUILDS = """
import threading
voxels = np.random.default_rng(1).integers(0, 999, (130, 70, 70)).astype(np.int16)
volume = octavo.build(voxels, path)
mask = volume.threshold(500)
stop = False

def read():
    while not stop:
        volume[...]

def build(name):
    out = f"{path}.{name}.8vo"
    if name == "array":
        octavo.build(voxels, out)
    elif name == "volume":
        octavo.build(volume, out, preset="fast")
    elif name == "writer":
        with octavo.Writer(out, voxels.shape, voxels.dtype) as w:
            w.add(voxels)
    elif name == "mask":
        mask.save(out)
        assert octavo.open(out).mask() == mask
        os.unlink(out)
        return
    elif name == "transform":
        volume.transform(out, mirror="x")
        assert np.array_equal(octavo.open(out)[:, :, ::-1], voxels)
        os.unlink(out)
        return
    elif name == "zarr":
        octavo.build(path + ".zarr", out)
    assert np.array_equal(octavo.open(out)[...], voxels)
    os.unlink(out)

octavo.export(volume, path + ".zarr")
threads = [threading.Thread(target=read) for _ in range(2)]
for thread in threads:
    thread.start()
try:
    for _ in range(int(sys.argv[3])):
        fork(lambda: build(sys.argv[2]))
finally:
    stop = True
    for thread in threads:
        thread.join()
"""


def ran(code, *words):
    done = subprocess.run([sys.executable, "-c", FORKED + code, *map(str, words)],
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("planes", [5, 129])
def test_a_writer_stays_with_the_process_that_opened_it(tmp_path, planes):
    ran(WRITERS, tmp_path / "a.8vo", planes)
    assert os.listdir(tmp_path) == ["a.8vo"]


def test_the_file_of_a_mask_stays_with_its_process(tmp_path):
    ran(MASKS, tmp_path / "a.8vo")


@pytest.mark.parametrize("name", ["array", "volume", "writer", "mask", "transform", "zarr"])
def test_files_are_built_while_threads_of_the_parent_read(tmp_path, name):
    ran(BUILDS, tmp_path / "a.8vo", name, 3)
