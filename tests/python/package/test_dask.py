"""Scans built in parts by schedulers of dask that need no cluster."""

import os
import pathlib
import shutil

import dask
import numpy as np
import pytest

import octavo
import octavo.dask

SHAPE = (140, 512, 512)  # of uint16: groups of 64, 64 and 12 planes
PLANNED = dict(spacing=(2, 1, 1), preset="fast", plan_options=("--raw", "512,512,140,uint16"))


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """scan.raw, and whole.8vo as one process makes it."""
    folder = tmp_path_factory.mktemp("scan")
    voxels = np.zeros(SHAPE, "<u2")
    voxels[:, 100:130, 200:280] = np.random.default_rng(3).integers(0, 900, (140, 30, 80))
    voxels.tofile(folder / "scan.raw")
    octavo.build(voxels, folder / "array.8vo", spacing=(2, 1, 1), preset="fast").close()
    return folder


@pytest.fixture
def folder(scan, tmp_path, monkeypatch):
    os.link(scan / "scan.raw", tmp_path / "scan.raw")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.path.dirname(os.environ["OCTAVO"]), prepend=os.pathsep)
    with dask.config.set(scheduler="synchronous"):
        yield tmp_path


@pytest.fixture(scope="module")
def whole(scan, run):
    done = run("build", scan / "scan.raw", "--raw", "512,512,140,uint16", "--spacing", "1,1,2",
               "--preset", "fast", "-q", "-o", scan / "whole.8vo")
    assert done.returncode == 0, done.stderr
    return (scan / "whole.8vo").read_bytes()


def before(monkeypatch, folder, script):
    """Runs `script` before each run of the program, whose verb is $1."""
    (folder / "bin").mkdir(exist_ok=True)
    program = folder / "bin" / "octavo"
    program.write_text(f'#!/bin/sh\n{script}\nexec {os.environ["OCTAVO"]} "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)


def expect_only_the_mark_left():
    left = set(os.listdir()) - {"scan.8vo", "scan.raw"}
    assert len(left) == 1 and left.pop().startswith(".scan.8vo.join-done-")


def test_the_file_is_that_of_one_process(folder, whole):
    told = []
    built = octavo.dask.build("scan.raw", "scan.8vo", parts=3, **PLANNED,
                              progress=lambda *said: told.append(said))
    assert built.shape == SHAPE
    assert pathlib.Path("scan.8vo").read_bytes() == whole
    assert told == [(n, 3, "parts") for n in range(4)]
    expect_only_the_mark_left()


def test_workers_may_copy_side_by_side(folder, whole):
    told = []
    with dask.config.set(scheduler="threads"):
        octavo.dask.build(["scan.raw"], folder / "scan.8vo", parts=2, joins_side_by_side=True,
                          **PLANNED, progress=lambda *said: told.append(said))
    assert pathlib.Path("scan.8vo").read_bytes() == whole
    assert told == [(n, 2, what) for what in ("parts", "copies") for n in range(3)]
    expect_only_the_mark_left()


def test_the_next_call_goes_on_where_one_has_failed(folder, whole, monkeypatch):
    # The first part is made, and no other.
    before(monkeypatch, folder,
           '[ "$1" = part ] && ! mkdir once 2>/dev/null && echo no disk >&2 && exit 5')
    with pytest.raises(octavo.StorageError, match="^no disk$"):
        octavo.dask.build("scan.raw", "scan.8vo", parts=3, retries=1, **PLANNED)
    assert not os.path.exists("scan.8vo")
    shutil.rmtree(folder / "bin")
    os.rmdir("once")
    told = []
    octavo.dask.build("scan.raw", "scan.8vo", parts=3, **PLANNED,
                      progress=lambda *said: told.append(said))
    assert told[0] == (1, 3, "parts") and told[-1] == (3, 3, "parts")
    assert pathlib.Path("scan.8vo").read_bytes() == whole
    expect_only_the_mark_left()


@pytest.mark.parametrize("side_by_side", [False, True])
def test_the_next_call_goes_on_with_what_a_join_holds(folder, whole, monkeypatch, side_by_side):
    # The join is done up to its end, which fails.
    before(monkeypatch, folder, '[ "$1" = join ] && case "$*" in *seal*|*--consume*)\n'
           'mkdir once 2>/dev/null &&\n'
           f'{{ {os.environ["OCTAVO"]} "$@" >/dev/null; exit 5; }};; esac')
    options = dict(parts=2, joins_side_by_side=side_by_side, retries=0, **PLANNED)
    with pytest.raises(octavo.StorageError, match="ended with 5"):
        octavo.dask.build("scan.raw", "scan.8vo", **options)
    octavo.dask.build("scan.raw", "scan.8vo", overwrite=True, **options)
    assert pathlib.Path("scan.8vo").read_bytes() == whole
    assert not os.path.exists("scan.8vo.parts")


def test_a_part_that_fails_once_is_made_again(folder, whole, monkeypatch):
    before(monkeypatch, folder, '[ "$1" = part ] && mkdir once 2>/dev/null && exit 5')
    octavo.dask.build("scan.raw", "scan.8vo", parts=3, **PLANNED)
    assert pathlib.Path("scan.8vo").read_bytes() == whole


def test_what_the_plan_warns_of_is_a_warning(folder):
    with pytest.warns(UserWarning, match="spacing is not in the files"):
        octavo.dask.build("scan.raw", "scan.8vo", **{**PLANNED, "spacing": None})


def test_parts_of_another_plan_are_not_taken(folder, monkeypatch):
    before(monkeypatch, folder, '[ "$1" = join ] && exit 5')
    with pytest.raises(octavo.StorageError):
        octavo.dask.build("scan.raw", "scan.8vo", parts=1, retries=0, **PLANNED)
    shutil.rmtree(folder / "bin")
    with pytest.raises(octavo.ArgumentError, match="part of another plan"):
        octavo.dask.build("scan.raw", "scan.8vo", parts=1, retries=0,
                          **{**PLANNED, "preset": "small"})
    assert not os.path.exists("scan.8vo")


def test_what_cannot_be_built_is_said(folder, voxels, monkeypatch):
    build = octavo.dask.build
    for wrong, said in (({"parts": 2, "part_size": "4M"}, "one of parts"),
                        ({"source": voxels}, "octavo.build"), ({"source": []}, "octavo.build"),
                        ({"source": 5}, "sources are several"), ({"retries": -1}, "retries"),
                        ({"path": "scan.raw"}, "8vo"),
                        ({"parts": 0}, "parts"), ({"part_size": "x"}, "x"),
                        ({"part_size": 0}, "part_size"), ({"bands": "2"}, "bands"),
                        ({"kind": "gray"}, "kind"), ({"plan_options": ("--none",)}, "none")):
        with pytest.raises(octavo.ArgumentError, match=said):
            build(**{"source": "scan.raw", "path": "scan.8vo", **PLANNED, **wrong})
    with pytest.raises(octavo.MissingError, match="none.raw") as raised:
        build(["scan.raw", "none.raw"], "scan.8vo", **PLANNED)
    assert raised.value.filename == "none.raw"
    with pytest.raises(octavo.StorageError, match="none/scan.8vo.parts: No such file"):
        build("scan.raw", "none/scan.8vo", **PLANNED)
    pathlib.Path("there.8vo").write_bytes(b"kept")
    with pytest.raises(octavo.StorageError, match="overwrite=True"):
        build("scan.raw", "there.8vo", **PLANNED)
    assert pathlib.Path("there.8vo").read_bytes() == b"kept"
    monkeypatch.setenv("PATH", str(folder))
    with pytest.raises(octavo.ArgumentError, match="not on PATH"):
        build("scan.raw", "scan.8vo", **PLANNED)
    assert sorted(os.listdir()) == ["scan.raw", "there.8vo"]
