"""Many reads: random slices beside the program, and files that are opened again and again."""

import gc
import os
import threading

import numpy as np
import pytest

import octavo

SLICES = 500
OPENS = 1000


def scans(folder):
    """One file of each kind."""
    random = np.random.default_rng(11)
    walk = random.integers(-60, 61, (70, 81, 97)).cumsum(2)
    blobs = (walk // 700) % 5
    given = {
        "int16": (walk.astype(np.int16), dict(unit="HU", slope=2, intercept=-1000)),
        "uint8": (walk.astype(np.uint8), dict(preset="fast")),
        "int32": (walk.astype(np.int32) * 70001, {}),
        "float32": ((walk / 7).astype(np.float32), {}),
        "boxes": (walk.astype(np.uint16), dict(preset="fast", access="boxes")),
        "bounded": (walk.astype(np.int16), dict(max_error=3)),
        "details": (walk.astype(np.int16), dict(keep_details=1)),
        "mask": ((blobs == 0).astype(np.uint8), dict(kind="labels")),
        "labels": (blobs.astype(np.int16) * 1000, dict(kind="labels")),
    }
    return [octavo.build(voxels, folder / f"{name}.8vo", spacing=(2, 1, 1), **options)
            for name, (voxels, options) in given.items()]


@pytest.mark.skipif("OCTAVO_LONG" not in os.environ, reason="starts the program 500 times")
def test_random_slices_of_every_kind_and_level_are_those_of_the_program(run, tmp_path):
    random = np.random.default_rng(12)
    volumes = scans(tmp_path)
    raw = tmp_path / "slice.raw"
    for number in range(SLICES):
        volume = volumes[number % len(volumes)]
        view = volume.levels[int(random.integers(len(volume.levels)))]
        axis = int(random.integers(3))
        index = int(random.integers(view.shape[axis]))
        ends = [(0, n) for n in view.shape]
        ends[axis] = (index, index + 1)
        box = ",".join(f"{low}:{high}" for low, high in ends[::-1])
        done = run("extract", volume.name, "--level", view.level, "--box", box, "-o", raw, "-f")
        assert done.returncode == 0, done.stderr
        key = tuple(index if a == axis else slice(None) for a in range(3))
        wanted = np.fromfile(raw, volume.dtype).reshape([b - a for a, b in ends]).squeeze(axis)
        assert np.array_equal(view[key], wanted), (volume.name, view.level, key)


def resident_bytes():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def open_files():
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.parametrize("how", ["read", "raise", "forget"])
def test_a_thousand_opens_and_reads_leave_nothing_behind(path, voxels, how):
    def one(number):
        if how == "forget":
            assert octavo.open(path)[number % 130, 3, 5] == voxels[number % 130, 3, 5]
            return
        with octavo.open(path) as volume:
            if how == "read":
                key = np.s_[number % 130, :, number % 150]
                assert np.array_equal(volume[key], voxels[key])
            else:
                with pytest.raises(octavo.ArgumentError):
                    volume.read(((0, 0, 0), (1, 1, 1)), level=99)

    for number in range(100):
        one(number)
    gc.collect()
    files, threads, memory = open_files(), threading.active_count(), resident_bytes()
    for number in range(OPENS):
        one(number)
    gc.collect()
    assert open_files() == files
    assert threading.active_count() == threads
    # A file of this size and what belongs to it takes 1 MB and more.
    assert resident_bytes() - memory < 32 << 20
