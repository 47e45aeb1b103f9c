"""Building: arrays of every form, planes as they come, scans by the program."""

import errno
import os
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import octavo
from conftest import steps
from octavo._errors import make_error


@pytest.mark.parametrize("dtype", ["int8", "uint8", "int16", "uint16", "int32", "uint32",
                                   "float32"])
@pytest.mark.parametrize("preset", ["small", "fast"])
def test_every_type_comes_back(tmp_path, dtype, preset):
    array = steps((20, 30, 70), dtype)
    assert np.array_equal(octavo.build(array, tmp_path / "a.8vo", preset=preset)[...], array)


FORMS = {
    "Fortran order": np.asfortranarray,
    "negative strides": lambda a: a[::-1, ::-1, ::-1],
    "steps": lambda a: a[::2, ::3, ::2],
    "turned axes": lambda a: a.transpose(2, 0, 1),
    "other byte order": lambda a: a.astype(a.dtype.newbyteorder()),
    "read-only": lambda a: np.frombuffer(a.tobytes(), a.dtype).reshape(a.shape),
}


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_an_array_is_copied_right(tmp_path, form):
    array = FORMS[form](steps((40, 31, 50), np.int16))
    assert np.array_equal(octavo.build(array, tmp_path / "a.8vo")[...], array)


def test_the_file_is_that_of_the_program(tmp_path, voxels, run):
    raw = tmp_path / "a.raw"
    voxels.tofile(raw)
    z, y, x = voxels.shape
    done = run("build", raw, "--raw", f"{x},{y},{z},int16", "--spacing", "1,1,2", "-o",
               tmp_path / "a.8vo")
    assert done.returncode == 0, done.stderr
    built = octavo.build(voxels, tmp_path / "b.8vo", spacing=(2, 1, 1))
    assert built.voxels_sha256 == octavo.open(tmp_path / "a.8vo").voxels_sha256
    assert run("verify", built.name).returncode == 0


def test_bool_becomes_a_mask_and_half_becomes_float(tmp_path):
    mask = steps((20, 20, 20), np.int16) > 0
    built = octavo.build(mask, tmp_path / "m.8vo", label_names={1: "bone"})
    assert (built.kind, built.dtype, built.label_names) == ("labels", np.uint8, {1: "bone"})
    assert np.array_equal(built[...], mask)
    half = steps((9, 9, 9), np.float16) / 8
    for given in half, half.astype(half.dtype.newbyteorder()):
        built = octavo.build(given, tmp_path / "h.8vo", overwrite=True)
        assert built.dtype == np.float32 and np.array_equal(built[...], half.astype(np.float32))


BIG = 1 << 31


@pytest.mark.parametrize("given, becomes", [
    (np.int64([[[-3, BIG - 1]]]), np.int32), (np.int64([[[3, BIG]]]), np.uint32),
    (np.uint64([[[3, 2 * BIG - 1]]]), np.uint32), (np.float64([[[3, -4]]]), np.int32),
    (np.float64([[[3, BIG]]]), np.uint32), (np.float64([[[.5, -4]]]), np.float32),
    (np.float64([[[np.nan, .25]]]), np.float32)], ids=str)
def test_wide_numbers_become_voxels_that_hold_them(tmp_path, given, becomes):
    for form in given, given.astype(given.dtype.newbyteorder()):
        built = octavo.build(form, tmp_path / "a.8vo", overwrite=True)
        assert built.dtype == becomes
        np.testing.assert_array_equal(built[...].astype(given.dtype), given)


def test_wide_numbers_become_what_the_program_makes_of_them(tmp_path, run):
    smooth = np.random.default_rng(5).normal(size=(40, 20, 30))
    smooth[:3] = 0
    smooth.tofile(tmp_path / "a.raw")
    done = run("build", tmp_path / "a.raw", "--raw", "30,20,40,float64", "--spacing", "1,1,1", "-o",
               tmp_path / "a.8vo")
    assert done.returncode == 0, done.stderr
    with pytest.warns(UserWarning, match="float64 .* rounded") as caught:
        built = octavo.build(smooth, tmp_path / "b.8vo")
    assert str(caught[0].message) in done.stderr
    assert np.array_equal(built[...], smooth.astype(np.float32))
    assert built.voxels_sha256 == octavo.open(tmp_path / "a.8vo").voxels_sha256


@pytest.mark.parametrize("first, later, text", [
    (np.int64(1), 1 << 40, "the value 1099511627776 at x,y,z = 2,1,35 does not fit int32"),
    (np.float64(1), .5, "the value 0.5 at x,y,z = 2,1,35 does not fit int32, .* float32 first"),
    (np.float64(.5), 1e300, "the value 1e[+]300 at x,y,z = 2,1,35 does not fit float32")])
def test_wide_numbers_that_come_late_and_do_not_fit_are_rejected(tmp_path, first, later, text):
    array = np.arange(40 * 2 * 3).reshape(40, 2, 3).astype(first.dtype) * first
    array[35, 1, 2] = later
    with pytest.raises(octavo.SourceError, match=text):
        octavo.build(array, tmp_path / "a.8vo")
    assert not list(tmp_path.iterdir())


def test_wide_numbers_are_read_by_the_plane(tmp_path):
    """And what reading them raises is what the caller gets, also while the type is chosen."""
    class Rows(OfOtherType):
        asked = []

        def __getitem__(self, key):
            self.asked.append(key)
            if len(self.asked) == Rows.last:
                raise KeyError("a chunk is gone")
            return super().__getitem__(key)

    array = np.arange(50 * 4 * 5).reshape(50, 4, 5)
    Rows.last = 0
    assert np.array_equal(octavo.build(Rows(array, array.dtype), tmp_path / "a.8vo")[...], array)
    assert len(Rows.asked) == 32 + 50
    for Rows.last in 20, 60:
        Rows.asked.clear()
        with pytest.raises(KeyError, match="a chunk is gone"):
            octavo.build(Rows(array, array.dtype), tmp_path / "b.8vo")
    assert [one.name for one in tmp_path.iterdir()] == ["a.8vo"]


def test_labels_of_64_bits_stay_labels(tmp_path):
    labels = np.arange(60).reshape(3, 4, 5) // 7
    for given in labels, labels.astype(np.float64):
        built = octavo.build(given, tmp_path / "a.8vo", kind="labels", overwrite=True)
        assert (built.kind, built.dtype) == ("labels", np.int32)
        assert np.array_equal(built[...], labels)
    with pytest.raises(octavo.ArgumentError, match="labels"):
        octavo.build(labels / 7, tmp_path / "b.8vo", kind="labels")
    assert [one.name for one in tmp_path.iterdir()] == ["a.8vo"]


@pytest.mark.parametrize("dtype", ["int64", "uint64", "float64"])
def test_planes_that_come_once_are_of_32_bits(tmp_path, dtype):
    with pytest.raises(octavo.ArgumentError, match=f"what {dtype} becomes follows"):
        octavo.Writer(tmp_path / "a.8vo", (3, 4, 5), dtype)
    with pytest.raises(octavo.ArgumentError, match=f"what {dtype} becomes follows"):
        octavo.build(iter(np.zeros((3, 4, 5), dtype)), tmp_path / "a.8vo", shape=(3, 4, 5))
    assert not list(tmp_path.iterdir())


class OfOtherType:
    """An array with a type of its own, as those of torch and of tensorstore."""

    def __init__(self, array, dtype):
        self._array = array
        self.shape = array.shape
        self.dtype = dtype

    def __getitem__(self, key):
        return self._array[key]


def test_a_volume_is_known_as_the_source_wherever_the_process_is(tmp_path, voxels, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkdir("other")
    volume = octavo.build(voxels[:9], "a.8vo")
    octavo.build(voxels[:5], "other/a.8vo").close()
    monkeypatch.chdir("other")
    assert np.array_equal(octavo.build(volume, "a.8vo", overwrite=True)[...], voxels[:9])
    with pytest.raises(octavo.ArgumentError, match="is the volume that is read"):
        octavo.build(volume, "../a.8vo", overwrite=True)


def test_a_source_whose_name_is_no_utf_8_is_looked_for(tmp_path):
    for make in octavo.build, octavo.from_ome_zarr:
        with pytest.raises(octavo.MissingError):
            make(f"{tmp_path}/\udcff.nii", tmp_path / "a.8vo")


def test_types_of_other_libraries_are_known_or_rejected(tmp_path, voxels):
    class NamingNumpys:
        numpy_dtype = voxels.dtype

    built = octavo.build(OfOtherType(voxels[:9], NamingNumpys()), tmp_path / "a.8vo")
    assert np.array_equal(built[...], voxels[:9])
    for dtype in "torch.int16", "|S3,", object():
        with pytest.raises(octavo.ArgumentError):
            octavo.build(OfOtherType(voxels[:9], dtype), tmp_path / "b.8vo")


def test_floats_come_back_bit_by_bit(tmp_path):
    array = np.random.default_rng(3).normal(size=(20, 30, 40)).astype(np.float32)
    array[3, 2, 1], array[4, 5, 6], array[7, 8, 9] = np.nan, np.inf, -0.0
    built = octavo.build(array, tmp_path / "f.8vo")
    assert np.array_equal(built[...].view(np.uint32), array.view(np.uint32))
    lossy = octavo.build(array, tmp_path / "g.8vo", max_error=0.1, nan=0, inf=9)
    assert np.abs(lossy[0] - array[0]).max() <= 0.1
    with pytest.raises(octavo.SourceError, match="nan=VALUE replaces NaN"):
        octavo.build(array, tmp_path / "h.8vo", max_error=0.1, inf=9)
    assert not (tmp_path / "h.8vo").exists()


def test_real_values_stay_within_a_max_error(tmp_path, voxels):
    built = octavo.build(voxels, tmp_path / "a.8vo", max_error=3)
    assert 0 < np.abs(built[...].astype(int) - voxels).max() <= 3
    assert built.max_error == 3


class Sliced:
    """An array that only gives planes, and says which."""

    def __init__(self, array, chunks):
        self.array, self.shape, self.dtype, self.chunks = array, array.shape, array.dtype, chunks
        self.reads = []

    def __getitem__(self, key):
        self.reads.append((key.start, key.stop))
        return self.array[key]


@pytest.mark.parametrize("chunks", [(64, 97, 150), ((64, 64, 2), (97,), (150,)), None])
def test_arrays_of_others_are_read_in_order_and_once(tmp_path, voxels, chunks):
    source = Sliced(voxels, chunks)
    assert np.array_equal(octavo.build(source, tmp_path / "a.8vo")[...], voxels)
    assert [a for a, _ in source.reads] == sorted({a for a, _ in source.reads})
    if chunks:
        assert source.reads == [(0, 64), (64, 128), (128, 130)]


def test_a_level_of_a_volume_is_built_like_an_array(tmp_path, volume):
    level = volume.levels[2]
    built = octavo.build(level, tmp_path / "a.8vo")
    assert np.array_equal(built[...], level[...])
    assert (built.spacing, built.origin, built.unit) == (level.spacing, level.origin, volume.unit)
    built = octavo.build(level, tmp_path / "b.8vo", spacing=(9, 8, 7), slope=3, unit="mm")
    assert (built.spacing, built.slope, built.unit) == ((9, 8, 7), 3, "mm")
    assert (built.origin, built.intercept) == (level.origin, volume.intercept)
    built = octavo.build(volume.real.levels[2], tmp_path / "c.8vo")
    assert np.array_equal(built[...], volume.real.levels[2][...])
    assert (built.spacing, built.origin, built.unit) == (level.spacing, level.origin, volume.unit)
    assert (built.slope, built.dtype) == (1, np.float32)
    for place in volume.name, f"file://{volume.name}":
        with pytest.raises(octavo.ArgumentError, match="is the volume that is read"):
            octavo.build(octavo.open(place), volume.name, overwrite=True)


BAD = {
    "long floats": (np.zeros((2, 2, 2), np.longdouble), {}, "voxels of type float128"),
    "complex": (np.zeros((2, 2, 2), np.complex64), {}, "voxels of type complex64"),
    "text": (np.full((2, 2, 2), "a"), {}, "voxels of type <U1"),
    "structures": (np.zeros((2, 2, 2), "i2,i2"), {}, "voxels of type"),
    "a mask": (np.ma.masked_less(np.zeros((2, 2, 2), np.int16), 1), {}, "files hold no mask"),
    "spacing of text": (np.zeros((2, 2, 2), np.int16), {"spacing": "abc"}, "spacing has three"),
    "unit": (np.zeros((2, 2, 2), np.int16), {"unit": 5}, "unit is text"),
    "names": (np.zeros((2, 2, 2), np.int16), {"label_names": ["a"]}, "label_names is"),
    "name": (np.zeros((2, 2, 2), np.int16), {"label_names": {1: None}}, "gives text to labels"),
    "memory": (np.zeros((2, 2, 2), np.int16), {"max_memory": 1 << 70}, "max_memory is a whole"),
    "details": (np.zeros((2, 2, 2), np.int16), {"keep_details": 1.5}, "keep_details is a whole"),
    "2-D": (np.zeros((2, 2), np.int16), {}, r"shape \(2, 2\) is no volume"),
    "empty": (np.zeros((2, 0, 2), np.int16), {}, "is no volume"),
    "a number": (5, {}, "give an array, a path or an open volume"),
    "preset": (np.zeros((2, 2, 2), np.int16), {"preset": "tiny"}, "preset is"),
    "kind": (np.zeros((2, 2, 2), np.int16), {"kind": "gray"}, "kind is"),
    "spacing": (np.zeros((2, 2, 2), np.int16), {"spacing": (1, 1)}, "spacing has three numbers"),
    "spacing 0": (np.zeros((2, 2, 2), np.int16), {"spacing": (0, 1, 1)}, "no geometry"),
    "slope": (np.zeros((2, 2, 2), np.int16), {"slope": 0}, "slope is 0"),
    "max error": (np.zeros((2, 2, 2), np.int16), {"max_error": -1}, "max_error is 0 or more"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_built_is_one_error(tmp_path, case):
    array, options, text = BAD[case]
    with pytest.raises(octavo.ArgumentError, match=text):
        octavo.build(array, tmp_path / "a.8vo", **options)
    assert not list(tmp_path.iterdir())


def test_slices_are_of_the_type_of_the_array(tmp_path, voxels):
    class Rising(Sliced):
        def __getitem__(self, key):
            return super().__getitem__(key) + 0.75

    with pytest.raises(octavo.SourceError, match="of int16, and slices of it are of float64"):
        octavo.build(Rising(voxels, None), tmp_path / "a.8vo")
    assert not list(tmp_path.iterdir())


def test_names_are_checked(tmp_path, voxels):
    (tmp_path / "victim").write_text("mine")
    for name in (f"{tmp_path}/victim\0.8vo", f"{tmp_path}/x\udcff.8vo"):
        with pytest.raises(octavo.ArgumentError):
            octavo.build(voxels[:3], name, overwrite=True)
        with pytest.raises(octavo.ArgumentError):
            octavo.Writer(name, voxels.shape, voxels.dtype, overwrite=True)
        with pytest.raises(octavo.ArgumentError):
            octavo.open(name)
    assert (tmp_path / "victim").read_text() == "mine"
    with pytest.raises(octavo.ArgumentError, match="is a path"):
        octavo.build(voxels[:3], b"a.8vo")
    with pytest.raises(octavo.ArgumentError, match="ends in .8vo"):
        octavo.build(voxels, tmp_path / "a.nii")
    octavo.build(voxels[:3], tmp_path / "a.8vo")
    array, path = voxels[:3], str(tmp_path / "a.8vo")
    for build in (lambda: octavo.build(array, path), lambda: octavo.build(path, path),
                  lambda: octavo.Writer(path, array.shape, array.dtype),
                  lambda: octavo.open(path).threshold(0).save(path),
                  lambda: octavo.open(path).transform(path, mirror="x")):
        with pytest.raises(octavo.ExistsError, match="overwrite=True replaces it") as raised:
            build()
        assert isinstance(raised.value, FileExistsError)
        assert raised.value.errno == errno.EEXIST and raised.value.filename == path
    with pytest.raises(octavo.ArgumentError, match=r"not list.*shape=\(z, y, x\)"):
        octavo.build([*array], tmp_path / "b.8vo")
    assert np.array_equal(octavo.build(voxels[:2], tmp_path / "a.8vo", overwrite=True)[...],
                          voxels[:2])


def test_an_array_that_fails_leaves_nothing(tmp_path, voxels):
    class Failing(Sliced):
        def __getitem__(self, key):
            if key.start > 100:
                raise RuntimeError("the camera is off")
            return super().__getitem__(key)

    with pytest.raises(RuntimeError, match="the camera is off"):
        octavo.build(Failing(voxels, None), tmp_path / "a.8vo")
    assert not list(tmp_path.iterdir())


def test_progress_is_told_and_may_end_the_work(tmp_path, voxels):
    told = []
    octavo.build(voxels, tmp_path / "a.8vo", progress=lambda *what: told.append(what))
    assert told[-1][0] == told[-1][1] > 0

    def stop(*_):
        raise StopIteration("enough")

    with pytest.raises(StopIteration):
        octavo.build(steps((300, 150, 150), np.int16), tmp_path / "b.8vo", progress=stop)
    assert [p.name for p in tmp_path.iterdir()] == ["a.8vo"]


def test_an_interrupt_ends_a_build(tmp_path, with_interrupts):
    array = steps((300, 300, 200), np.int16)
    threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        octavo.build(array, tmp_path / "a.8vo")
    assert not list(tmp_path.iterdir())


KILLED = """
import os, pathlib, signal, sys, time
import numpy as np
import octavo

voxels = np.load(sys.argv[1])
w = octavo.Writer(sys.argv[2], voxels.shape, voxels.dtype, preset="fast")
w.add(voxels[:-1])
folder = pathlib.Path(sys.argv[2]).parent
while not any(journal.stat().st_size for journal in folder.glob(".*.journal")):
    time.sleep(0.01)
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_an_interrupted_build_says_how_to_go_on(tmp_path):
    voxels = np.zeros((140, 512, 512), np.uint16)  # groups of 64, 64 and 12 planes
    voxels[:, 100:130] = np.arange(512) % 7
    np.save(tmp_path / "voxels.npy", voxels)
    done = subprocess.run([sys.executable, "-c", KILLED, tmp_path / "voxels.npy",
                           tmp_path / "a.8vo"], check=False, timeout=100)
    assert done.returncode == -signal.SIGKILL and not (tmp_path / "a.8vo").exists()
    with pytest.raises(octavo.StorageError) as raised:
        octavo.build(voxels, tmp_path / "a.8vo", preset="fast")
    assert str(raised.value).endswith("(resume=True goes on with it, overwrite=True starts anew)")
    built = octavo.build(voxels, tmp_path / "a.8vo", preset="fast", resume=True)
    assert np.array_equal(built[...], voxels)
    assert "(" not in str(make_error("corrupt", "not sealed", "a.8vo", 8, [("interrupted", "")]))


def sealed_by_a_block(array, path):
    with octavo.Writer(path, array.shape, array.dtype, threads=1) as w:
        w.add(array)


def built_of_planes(array, path):
    octavo.build(iter(array), path, shape=array.shape, threads=1)


@pytest.mark.parametrize("make", [sealed_by_a_block, built_of_planes])
def test_an_interrupt_ends_the_sealing(tmp_path, with_interrupts, make):
    # All of it is encoded where it is sealed.
    array = np.random.default_rng(1).integers(0, 4000, (100, 400, 400)).astype(np.uint16)
    threading.Timer(0.4, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        make(array, tmp_path / "a.8vo")
    assert not list(tmp_path.iterdir())


def warnings_of(make):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        make()
    return [(str(one.message), os.path.basename(one.filename)) for one in caught]


def test_what_coarse_levels_do_not_hold_is_a_warning(tmp_path):
    array = np.random.default_rng(1).random((20, 20, 20)).astype(np.float32)
    array[5, 5, 5] = 3e38
    [(text, file)] = warnings_of(lambda: octavo.build(array, tmp_path / "a.8vo"))
    assert "1 voxel lies beyond what coarse levels hold, at 3e+38" in text
    assert file == os.path.basename(__file__)
    w = octavo.Writer(tmp_path / "b.8vo", array.shape, array.dtype)
    w.add(array)
    [(text, file)] = warnings_of(w.close)
    assert "1 voxel lies beyond" in text and file == os.path.basename(__file__)
    for make in sealed_by_a_block, built_of_planes:
        [(text, file)] = warnings_of(lambda: make(array, tmp_path / f"{make.__name__}.8vo"))
        assert "1 voxel lies beyond" in text and file == os.path.basename(__file__)


def test_what_the_program_warns_of_is_a_warning(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", os.path.dirname(os.environ["OCTAVO"]), prepend=os.pathsep)
    steps((5, 6, 7), np.float64).tofile(tmp_path / "a.raw")
    (tmp_path / "a.nhdr").write_text(
        "NRRD0004\ntype: double\ndimension: 3\nsizes: 7 6 5\nendian: little\n"
        "encoding: raw\ndata file: a.raw\n")
    said = warnings_of(lambda: octavo.build(tmp_path / "a.nhdr", tmp_path / "a.8vo"))
    assert any("spacing" in text for text, _ in said)
    assert {file for _, file in said} == {os.path.basename(__file__)}


def test_progress_of_the_program_is_told_and_may_end_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", os.path.dirname(os.environ["OCTAVO"]), prepend=os.pathsep)
    noise = np.random.default_rng(1).integers(0, 4000, (60, 300, 300)).astype(float)
    noise.tofile(tmp_path / "a.raw")
    (tmp_path / "a.nhdr").write_text(
        "NRRD0004\ntype: double\ndimension: 3\nsizes: 300 300 60\nspacings: 1 1 1\n"
        "endian: little\nencoding: raw\ndata file: a.raw\n")

    def stop(done, total, what):
        raise ValueError("enough")

    with pytest.raises(ValueError, match="enough"):
        octavo.build(tmp_path / "a.nhdr", tmp_path / "a.8vo", threads=1, progress=stop)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nhdr", "a.raw"]
    told = []
    octavo.build(tmp_path / "a.nhdr", tmp_path / "a.8vo", preset="fast",
                 progress=lambda *what: told.append(what))
    assert told[-1][0] == told[-1][1] > 0 and all(isinstance(what, str) for *_, what in told)
    with pytest.raises(octavo.SourceError, match="not a DICOM"):
        octavo.build(tmp_path / "a.raw", tmp_path / "b.8vo", progress=told.append)


def test_a_writer_makes_the_file_of_the_array(tmp_path, voxels):
    octavo.build(voxels, tmp_path / "a.8vo", spacing=(2, 1, 1))
    with octavo.Writer(tmp_path / "b.8vo", voxels.shape, voxels.dtype, spacing=(2, 1, 1)) as w:
        w.add(voxels[0])
        w.add(voxels[1:100])
        assert w.added == 100
        for plane in voxels[100:]:
            w.add(np.asfortranarray(plane))
    assert (tmp_path / "a.8vo").read_bytes() == (tmp_path / "b.8vo").read_bytes()


def test_an_output_without_a_folder_is_rejected_before_planes_are_read(tmp_path, voxels):
    path = tmp_path / "none" / "a.8vo"
    with pytest.raises(octavo.StorageError, match="its folder does not exist"):
        octavo.Writer(path, voxels.shape, voxels.dtype)
    with pytest.raises(octavo.StorageError, match="its folder does not exist"):
        octavo.build(Sliced(voxels, None), path, progress=lambda *_: pytest.fail("has begun"))


def test_a_writer_leaves_nothing_of_what_is_not_whole(tmp_path, voxels):
    with pytest.raises(octavo.ArgumentError, match="9 of 130 planes"):
        with octavo.Writer(tmp_path / "a.8vo", voxels.shape, voxels.dtype) as w:
            w.add(voxels[:9])
    with pytest.raises(RuntimeError, match="mine"):
        with octavo.Writer(tmp_path / "a.8vo", voxels.shape, voxels.dtype) as w:
            w.add(voxels[:9])
            raise RuntimeError("mine")
    w = octavo.Writer(tmp_path / "a.8vo", voxels.shape, voxels.dtype)
    w.add(voxels[:9])
    del w
    assert not list(tmp_path.iterdir())


def test_a_block_that_raises_behind_the_last_plane_leaves_what_was_there(tmp_path, voxels):
    octavo.build(voxels[:3], tmp_path / "a.8vo")
    with pytest.raises(RuntimeError, match="mine"):
        with octavo.Writer(tmp_path / "a.8vo", voxels.shape, voxels.dtype, overwrite=True) as w:
            w.add(voxels)
            time.sleep(1)
            raise RuntimeError("mine")
    assert np.array_equal(octavo.open(tmp_path / "a.8vo")[...], voxels[:3])
    assert [path.name for path in tmp_path.iterdir()] == ["a.8vo"]


def test_planes_are_taken_all_or_none(tmp_path, voxels):
    with octavo.Writer(tmp_path / "a.8vo", voxels.shape, voxels.dtype) as w:
        w.add(voxels[:10])
        with pytest.raises(octavo.ArgumentError, match="10 of 130 planes were added"):
            w.add(voxels)
        assert w.added == 10
        w.add(voxels[10:])
    assert np.array_equal(octavo.open(tmp_path / "a.8vo")[...], voxels)


def test_threads_that_share_a_writer_take_turns(tmp_path, voxels):
    w = octavo.Writer(tmp_path / "a.8vo", voxels.shape, voxels.dtype)
    failed = []

    def add():
        try:
            while True:
                w.add(voxels[0])
        except octavo.ArgumentError as error:
            failed.append(str(error))

    threads = [threading.Thread(target=add) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(failed) == 4 and all("130 of 130 planes were added" in text or
                                    "all 130 planes" in text for text in failed)
    w.close()
    assert (octavo.open(tmp_path / "a.8vo")[...] == voxels[0]).all()


def test_a_writer_is_closed_or_abandoned_once(tmp_path, voxels):
    with octavo.Writer(tmp_path / "a.8vo", (2, 97, 150), np.int16) as w:
        w.add(voxels[:2])
        w.close()
        w.close()
    assert (octavo.open(tmp_path / "a.8vo")[...] == voxels[:2]).all()
    with octavo.Writer(tmp_path / "b.8vo", (2, 97, 150), np.int16) as w:
        w.add(voxels[0])
        w.abandon()
        w.close()
        with pytest.raises(octavo.ArgumentError, match="closed"):
            w.add(voxels[1])
    assert [path.name for path in tmp_path.iterdir()] == ["a.8vo"]


def test_a_writer_takes_the_planes_that_were_announced(tmp_path, voxels):
    with pytest.raises(octavo.ArgumentError, match="closed"):
        with octavo.Writer(tmp_path / "a.8vo", (2, 97, 150), np.int16) as w:
            with pytest.raises(octavo.ArgumentError, match=r"shape \(97, 150\)"):
                w.add(voxels[0, 1:])
            with pytest.raises(octavo.ArgumentError, match="planes are of int16"):
                w.add(voxels[0].astype(np.int32))
            w.add(voxels[:2])
            with pytest.raises(octavo.ArgumentError, match="2 of 2 planes were added"):
                w.add(voxels[0])
            w.close()
            w.add(voxels[0])
    assert np.array_equal(octavo.open(tmp_path / "a.8vo")[...], voxels[:2])


def test_a_scan_on_disk_goes_through_the_program(tmp_path, voxels, monkeypatch):
    folder = os.path.dirname(os.environ["OCTAVO"])
    octavo.build(voxels[:20], tmp_path / "a.8vo", spacing=(2, 1, 1))
    monkeypatch.setenv("PATH", folder, prepend=os.pathsep)
    built = octavo.build(tmp_path / "a.8vo", tmp_path / "b.8vo", preset="fast")
    assert np.array_equal(built[...], voxels[:20])
    for option in ({"unit": "HU"}, {"origin": (0, 0, 0)}):
        with pytest.raises(octavo.ArgumentError, match="array"):
            octavo.build(tmp_path / "a.8vo", tmp_path / "c.8vo", **option)
    # The program is told of a series, and says that a file of its own has none.
    with pytest.raises(octavo.ArgumentError, match="series"):
        octavo.build(tmp_path / "a.8vo", tmp_path / "c.8vo", series=1)
    with pytest.raises(octavo.ArgumentError, match="series are of paths"):
        octavo.build(voxels[:3], tmp_path / "c.8vo", series=1)
    monkeypatch.chdir(tmp_path)
    octavo.build(voxels[:3], "--force.8vo")
    assert np.array_equal(octavo.build("--force.8vo", "-o.8vo")[...], voxels[:3])
    with pytest.raises(octavo.StorageError, match="is not there"):
        octavo.build(tmp_path / "none", tmp_path / "c.8vo")
    with pytest.raises(octavo.StorageError, match="exist"):
        octavo.build(tmp_path / "a.8vo", tmp_path / "b.8vo")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(octavo.ArgumentError, match="not on PATH"):
        octavo.build(tmp_path / "a.8vo", tmp_path / "d.8vo")
    with pytest.raises(octavo.MissingError, match="none: is not there"):
        octavo.build(tmp_path / "none", tmp_path / "c.8vo")
