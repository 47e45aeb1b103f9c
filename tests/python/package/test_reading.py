"""Reading: numpy's rules of indexing, levels, places, what a volume says of itself."""

import subprocess
import sys
import warnings

import numpy as np
import pytest

import octavo

KEYS = [
    np.s_[...], np.s_[3], np.s_[-1], np.s_[-1, ..., 5], np.s_[1, 2, 3], np.s_[:, 7],
    np.s_[..., 149], np.s_[::2], np.s_[100:3:-7, ::3, 5:90:4], np.s_[::-1, ::-1, ::-1],
    np.s_[::70, ::-1],
    np.s_[..., None, 3], np.s_[None], np.s_[5:5], np.s_[90:20], np.s_[200:], np.s_[-5:],
    np.s_[1, 2, 3, ...], np.s_[4, ..., 1, 2], np.s_[np.int64(4), np.uint8(6)],
    np.s_[63:65, 63:65, 63:65], np.s_[129:130:5],
]


@pytest.mark.parametrize("key", KEYS, ids=str)
def test_an_index_chooses_what_numpy_does(volume, voxels, key):
    chosen, wanted = volume[key], voxels[key]
    assert np.array_equal(chosen, wanted)
    assert np.shape(chosen) == np.shape(wanted)
    assert chosen.dtype == wanted.dtype
    for one in chosen, volume.real[key]:
        assert isinstance(one, np.ndarray) == isinstance(wanted, np.ndarray)


def test_random_boxes_and_steps_choose_what_numpy_does(volume, voxels):
    random = np.random.default_rng(7)
    for _ in range(60):
        key = []
        for size in voxels.shape:
            a, b = random.integers(-size - 3, size + 4, 2)
            step = int(random.choice([1, 1, 2, 5, 17, 80, -1, -3, -70]))
            key.append(slice(int(a), int(b), step))
        assert np.array_equal(volume[tuple(key)], voxels[tuple(key)]), key


@pytest.mark.parametrize("key, text", [
    (130, "index 130 is out of bounds for axis 0 with size 130"),
    (-131, "index -131 is out of bounds for axis 0"),
    ((1, 2, 3, 4), "too many indices"),
    ((..., 1, ...), "single ellipsis"),
    ([1, 2], "choose voxels by arrays"),
    (True, "choose voxels by a mask"),
    (1.5, "only integers"),
    (np.array(130), "index 130 is out of bounds"),
    (np.array(True), "choose voxels by a mask"),
    (np.array(1.5), "only integers"),
], ids=str)
def test_other_indices_are_rejected_as_by_numpy(volume, key, text):
    with pytest.raises(IndexError, match=text):
        volume[key]


@pytest.mark.parametrize("key", [
    np.array(3), (np.array(-1), slice(None), np.array(4)), (..., np.array(2), np.uint8(1)),
    (np.array(1), np.array(2), np.array(3)), slice(np.array(1), np.int64(5)), ()], ids=str)
def test_arrays_without_axes_are_indices(volume, voxels, key):
    found = volume[key]
    assert np.array_equal(found, voxels[key])
    assert type(found) is type(voxels[key])


def test_a_step_of_0_is_rejected(volume):
    with pytest.raises(ValueError):
        volume[::0]


def test_levels_are_those_of_the_program(volume, run, tmp_path):
    for level in volume.levels:
        out = tmp_path / f"{level.level}.npy"
        raw = tmp_path / f"{level.level}.raw"
        done = run("extract", volume.name, "--level", level.level, "-o", raw)
        assert done.returncode == 0, done.stderr
        wanted = np.fromfile(raw, volume.dtype).reshape(level.shape)
        assert np.array_equal(level[...], wanted)
        assert not out.exists()


def test_a_level_lies_where_its_voxels_do(volume):
    for level in volume.levels[1:]:
        # The middle of the first voxel of a level is that of the voxels of level 0 that it is of.
        middle = (np.array(level.factor) - 1) / 2
        wanted = volume.affine @ [*middle, 1]
        assert np.allclose(level.affine @ [0, 0, 0, 1], wanted)
        assert np.allclose(np.array(level.origin) - volume.origin, level.translation)


def test_the_affine_takes_indices_to_the_world(volume):
    assert np.allclose(volume.affine @ [3, 2, 1, 1], [10 + 0.25, 20 + 2 * 0.5, 30 + 3 * 2, 1])
    assert np.allclose(volume.affine_ras @ [0, 0, 0, 1], [-10, -20, 30, 1])


def test_real_values_are_rescaled(volume, voxels):
    assert np.array_equal(volume.real[5, 4:9], (voxels[5, 4:9] * 2.0 - 1000).astype(np.float32))
    assert volume.real.dtype == np.float32
    assert volume.real.levels[3].shape == volume.levels[3].shape
    assert volume.real.levels[1][2].dtype == np.float32


def test_what_takes_much_memory_is_a_warning_to_who_asks(volume, monkeypatch):
    monkeypatch.setattr("octavo._volume._memory_bytes", lambda: 8)
    for ask in (lambda: volume[...], lambda: volume.levels[1][...], lambda: volume.real[...],
                lambda: np.asarray(volume.real)):
        with pytest.warns(UserWarning, match="would fit") as caught:
            ask()
        assert [one.filename for one in caught] == [__file__]


def test_a_point_in_mm_is_the_nearest_voxel(volume, voxels):
    assert volume.at_mm((30 + 2 * 7.4, 20 + 0.5 * 3.6, 10 + 0.25 * 9)) == voxels[7, 4, 9]
    with pytest.raises(octavo.ArgumentError, match="outside"):
        volume.at_mm((0, 0, 0))


def test_a_box_in_mm_has_the_voxels_whose_centers_it_has(volume, voxels):
    corners = (30 + 2 * 10, 20 + 0.5 * 5, 10), (30 + 2 * 20.5, 20 + 0.5 * 8, 10 + 0.25 * 4)
    assert np.array_equal(volume.at_mm(corners), voxels[10:21, 5:9, 0:5])
    assert np.array_equal(volume.at_mm(corners[::-1]), voxels[10:21, 5:9, 0:5])


def test_a_box_in_mm_is_the_smallest_of_an_oblique_grid(tmp_path):
    """Against all centers, one by one."""
    random = np.random.default_rng(5)
    shape = (23, 31, 27)
    counts = [0, 0]
    for turn in range(8):
        direction, _ = np.linalg.qr(random.normal(size=(3, 3)))
        if turn == 7:  # turned about one axis alone
            direction = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
        spacing = random.uniform(0.3, 2, 3)
        voxels = random.integers(0, 99, shape).astype(np.uint8)
        with octavo.build(voxels, tmp_path / f"{turn}.8vo", spacing=spacing, origin=(5, -7, 9),
                          direction=direction) as volume:
            index = np.indices(shape).reshape(3, -1)
            centers = volume.affine @ [*index, np.ones(index.shape[1])]
            for _ in range(12):
                middle = centers[:3, random.integers(centers.shape[1])]
                half = random.uniform(0.05, 9, 3)
                corners = (middle + half * random.uniform(-0.5, 1, 3))[::-1], (middle - half)[::-1]
                low, high = np.sort(corners, axis=0)[:, ::-1]
                inside = index[:, ((centers[:3].T >= low) & (centers[:3].T <= high)).all(1)]
                counts[inside.size > 0] += 1
                if inside.size == 0:
                    with pytest.raises(octavo.ArgumentError, match="no voxel has its center"):
                        volume.at_mm(corners)
                    continue
                wanted = tuple(slice(a, b + 1) for a, b in zip(inside.min(1), inside.max(1)))
                assert np.array_equal(volume.at_mm(corners), voxels[wanted])
    assert min(counts) >= 5


@pytest.mark.parametrize("call, text", [
    (lambda v: v.read(1), "a box has two corners, .* not 1"),
    (lambda v: v.read(((0, 0, 0), (1, 1, 1), (2, 2, 2))), "a box has two corners"),
    (lambda v: v.read("ab"), "three whole numbers"),
    (lambda v: v.read(level="a"), "level 'a' is not there: .*scan.8vo has levels 0 to "),
    (lambda v: v.read(level=1.5), "level 1.5 is not there"),
    (lambda v: v.read(level=None), "level None is not there"),
    (lambda v: v.at_mm("a"), "in mm"),
    (lambda v: v.at_mm(((1, 2, 3), (1, 2))), "in mm"),
    (lambda v: v.at_mm((0, 0, 0), level=1.0), "level 1.0 is not there"),
    (lambda v: v.at_mm((1e300, 0, 0)), r"\(1e\+300, 0, 0\) mm lies outside the volume"),
    (lambda v: v.level_for("a"), "spacing_mm is a number, not 'a'"),
    (lambda v: v.level_for(float("nan")), "spacing_mm is a number"),
    (lambda v: v.at_budget(None), "nbytes is a number, not None"),
    (lambda v: v.at_budget(1), "1 bytes hold no voxel"),
    (lambda v: octavo.build(v, "x.8vo", progress=1), "progress is a function, or True, not 1"),
    (lambda v: octavo.Writer("x.8vo", (1, 1, 1), "zzz"), "dtype is a type of numpy, not 'zzz'"),
    (lambda v: v.transform("x.8vo", rotate=5), "rotate is an axis and degrees, .* not 5"),
    (lambda v: v.transform("x.8vo", rotate=("q", 9)), "the axis of rotate .* not 'q'"),
])
def test_what_makes_no_sense_is_an_error_of_octavo(volume, call, text):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(octavo.ArgumentError, match=text):
            call(volume)


def test_levels_are_found_by_spacing_and_by_bytes(volume):
    assert volume.level_for(0.1) == 0
    assert max(volume.levels[volume.level_for(2)].spacing) <= 2
    assert max(volume.levels[volume.level_for(2) + 1].spacing) > 2
    view = volume.at_budget(10000)
    assert view.nbytes <= 10000 < volume.levels[view.level - 1].nbytes
    with pytest.raises(octavo.ArgumentError, match="hold no voxel"):
        volume.at_budget(1)


def test_read_fills_what_it_is_given(volume, voxels):
    dense = np.empty((4, 5, 6), np.int16)
    assert volume.read(((1, 2, 3), (5, 7, 9)), out=dense) is dense
    assert np.array_equal(dense, voxels[1:5, 2:7, 3:9])
    turned = np.empty((6, 5, 4), np.int16).T
    volume.read(((1, 2, 3), (5, 7, 9)), out=turned, threads=2)
    assert np.array_equal(turned, voxels[1:5, 2:7, 3:9])
    assert np.array_equal(volume.read(level=3), volume.levels[3][...])


def test_what_does_not_fit_is_not_filled(volume):
    for out in (np.empty((4, 5, 6), np.uint16), np.empty((4, 5, 7), np.int16), [1, 2]):
        with pytest.raises(octavo.ArgumentError, match="out must be an array"):
            volume.read(((1, 2, 3), (5, 7, 9)), out=out)
    fixed = np.empty((4, 5, 6), np.int16)
    fixed.flags.writeable = False
    with pytest.raises(octavo.ArgumentError, match="cannot be written"):
        volume.read(((1, 2, 3), (5, 7, 9)), out=fixed)
    for box in (((0, 0, 0), (131, 1, 1)), ((1, 1, 1), (1, 2, 2)), ((-1, 0, 0), (1, 1, 1))):
        with pytest.raises(octavo.ArgumentError, match="is empty or not inside"):
            volume.read(box)
    for threads in (-1, 10**9, 1.5):
        with pytest.raises(octavo.ArgumentError, match="threads is a whole number"):
            volume.read(((0, 0, 0), (5, 5, 5)), threads=threads)
    with pytest.raises(octavo.ArgumentError, match="level 99 is not there"):
        volume.read(level=99)


def test_ranges_of_bricks_are_those_of_their_voxels(volume, voxels):
    low, high = volume.brick_ranges()
    side = volume.chunks
    for at in np.ndindex(low.shape):
        brick = voxels[tuple(slice(i * n, (i + 1) * n) for i, n in zip(at, side))]
        assert (low[at], high[at]) == (brick.min(), brick.max())


def test_a_volume_says_what_it_is(volume, voxels, run):
    assert (volume.shape, volume.dtype, volume.ndim) == (voxels.shape, np.int16, 3)
    assert (volume.min, volume.max) == (voxels.min(), voxels.max())
    assert (volume.kind, volume.unit, volume.slope) == ("grey", "[hnsf'U]", 2)
    assert volume.spacing == (2, 0.5, 0.25)
    assert volume.origin == (30, 20, 10)
    assert volume.attrs["unit"] == "[hnsf'U]"
    assert volume.voxels_sha256 in run("info", volume.name, "--json").stdout
    assert "130 x 97 x 150 int16 HU" in repr(volume)
    assert np.array_equal(np.asarray(volume.levels[2]), volume.levels[2][...])
    assert len(volume) == 130


@pytest.mark.parametrize("spacing, said", [((2, 0.5, 0.25), "2 x 0.5 x 0.25 mm"),
                                           (None, "unknown spacing")])
def test_a_volume_shows_its_spacing_where_that_is_known(tmp_path, spacing, said):
    octavo.build(np.zeros((2, 3, 4), np.uint8), tmp_path / "v.8vo", spacing=spacing)
    with octavo.open(tmp_path / "v.8vo") as made:
        shown = repr(made)
    assert said in shown and (" mm" in shown) == (spacing is not None)


def test_a_closed_volume_says_so(path):
    volume = octavo.open(path)
    volume.close()
    volume.close()
    assert volume.closed
    with pytest.raises(octavo.ArgumentError, match="is closed"):
        volume[0]
    assert "closed" in repr(volume)


def test_real_values_are_never_a_view(volume):
    for one in volume, volume.real, volume.levels[1], volume.real.levels[1]:
        with pytest.raises(ValueError, match="always a copy"):
            one.__array__(copy=False)
        assert one.__array__(copy=True).shape == one.shape


def test_an_array_whose_voxels_share_memory_is_not_filled(volume):
    box = ((1, 2, 3), (5, 7, 9))
    held = np.zeros((4, 5, 12), np.int16)
    for strides in ((0, 24, 2), (20, 4, 2), (120, -2, 24)):
        out = np.lib.stride_tricks.as_strided(held[:, 4:], (4, 5, 6), strides)
        with pytest.raises(octavo.ArgumentError, match="several voxels in one place"):
            volume.read(box, out=out)
    assert not held.any()
    for out in (held[:, :, ::2], held[::-1, :, 1::2], np.zeros((6, 5, 4), np.int16).T):
        assert np.array_equal(volume.read(box, out=out), volume[1:5, 2:7, 3:9])


def test_what_asks_servers_is_imported_once_there_is_a_url():
    code = ("import sys, numpy; before = set(sys.modules); import octavo\n"
            "assert 'asyncio' in before or 'asyncio' not in sys.modules")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_modules_that_need_other_packages_are_imported_once_they_are_used():
    code = ("import sys, octavo; before = set(sys.modules)\n"
            "assert 'octavo.dask' not in before and 'numpy' in before\n"
            "assert callable(octavo.dask.build) and 'octavo.dask' in sys.modules\n"
            "assert not hasattr(octavo, 'none') and 'dask' not in octavo.__all__")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
