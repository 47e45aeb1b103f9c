"""Distances, morphometry and poses of masks, against numpy and the program."""

import itertools
import json

import numpy as np
import pytest

import octavo

SPACING = (2.0, 0.5, 0.75)


def ball(shape=(24, 40, 36), middle=(11, 20, 17), radius_mm=7.0):
    at = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1) - np.array(middle)
    return (((at * SPACING) ** 2).sum(-1) <= radius_mm ** 2).astype(np.uint8)


def nearest(voxels, others):
    """mm from the center of each voxel to the nearest of others, one after the other."""
    places = np.argwhere(others) * SPACING
    return np.array([np.sqrt(((places - np.array(at) * SPACING) ** 2).sum(1).min())
                     for at in voxels])


@pytest.fixture(scope="module")
def solid():
    return ball()


@pytest.fixture(scope="module")
def mask(solid, tmp_path_factory):
    path = tmp_path_factory.mktemp("mask") / "ball.8vo"
    return octavo.build(solid, path, kind="labels", spacing=SPACING).mask()


def test_distances_are_those_of_every_pair_of_voxels(mask, solid):
    made = mask.distance(to="centers")
    assert made.dtype == np.float32 and made.shape == solid.shape
    random = np.random.default_rng(3)
    for inside in (True, False):
        voxels = random.permutation(np.argwhere((solid != 0) == inside))[:300]
        expected = nearest(voxels, (solid != 0) != inside) * (-1 if inside else 1)
        assert np.allclose(made[tuple(voxels.T)], expected, rtol=1e-6)


def test_distances_go_into_files_and_are_clipped(mask, tmp_path):
    array = mask.distance(max_mm=1.5)
    assert np.abs(array).max() == 1.5
    volume = mask.distance(tmp_path / "d.8vo", max_mm=1.5)
    assert np.array_equal(volume.real[...], array)
    steps = mask.distance(tmp_path / "s.8vo", max_mm=1.5, step_mm=0.01)
    assert steps.dtype == np.int16 and np.abs(steps.real[...] - array).max() <= 0.005 + 1e-6
    near = mask.distance(tmp_path / "n.8vo", max_mm=1.5, within_mm=0.1)
    assert 0 < np.abs(near.real[...] - array).max() <= 0.1 + 1e-6
    with pytest.raises(octavo.ArgumentError, match="within_mm"):
        mask.distance(within_mm=0.1)
    with pytest.raises(octavo.StorageError, match="overwrite=True"):
        mask.distance(tmp_path / "d.8vo")


def assert_near(made, said, where):
    """Equal texts and shapes, and numbers that are near, in lists and dictionaries as well."""
    if isinstance(said, dict):
        assert set(made) == set(said), where
        for name, value in said.items():
            assert_near(made[name], value, f"{where}.{name}")
    elif isinstance(said, list):
        assert len(made) == len(said), where
        for number, value in enumerate(said):
            assert_near(made[number], value, f"{where}[{number}]")
    else:
        assert made == (pytest.approx(said) if isinstance(said, float) else said), where


def test_numbers_are_those_of_the_program(run, mask, solid, tmp_path):
    mask.save(tmp_path / "m.8vo")
    values = solid.astype(np.int16) * 300 + np.arange(36, dtype=np.int16)
    grey = octavo.build(values, tmp_path / "g.8vo", spacing=SPACING)
    region = np.zeros_like(solid)
    region[4:20, 5:35, 3:30] = 1
    within = octavo.build(region, tmp_path / "r.8vo", kind="labels", spacing=SPACING)
    made = mask.morphometry(region=within, of=grey, calibration=(2, -7), tortuosity=True)
    done = run("morphometry", tmp_path / "m.8vo", "--region", tmp_path / "r.8vo", "--of",
               tmp_path / "g.8vo", "--calibration", "2,-7", "--slices", "--tortuosity",
               "--json")
    said = json.loads(done.stdout)
    for name in set(said) - {"mask", "warnings"}:
        assert_near(json.loads(json.dumps(made[name])), said[name], name)
    assert made["bv_tv"] == pytest.approx(solid[region != 0].mean())
    inside = (solid != 0) & (region != 0)
    assert made["tmd"] == pytest.approx(2 * grey[...][inside].mean() - 7)
    assert made["thickness_map"] is None


def test_maps_of_thickness_are_arrays_or_files(mask, solid, tmp_path):
    made = mask.morphometry(thickness_map=True, spacing_map=tmp_path / "sp.8vo")
    thickness = made["thickness_map"]
    assert np.array_equal(thickness > 0, solid != 0)
    assert thickness[solid != 0].mean() == pytest.approx(made["tb_th_mm"])
    assert np.array_equal(made["spacing_map"].real[...] > 0, solid == 0)


def test_a_pose_is_found_and_takes_the_mask_there(tmp_path):
    shape = (48, 52, 50)
    at = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1)
    solid = np.zeros(shape, np.uint8)
    for low, high in (((8, 8, 8), (40, 20, 14)), ((8, 8, 8), (16, 44, 18)),
                      ((30, 12, 10), (38, 18, 42))):
        solid[tuple(slice(a, b) for a, b in zip(low, high))] = 1
    moved = np.roll(np.transpose(solid[::-1], (0, 2, 1)), (1, -2, 1), (0, 1, 2))
    assert at.shape == (*shape, 3)
    first = octavo.build(solid, tmp_path / "a.8vo", kind="labels", spacing=(1, 1, 1)).mask()
    second = octavo.build(np.ascontiguousarray(moved), tmp_path / "b.8vo", kind="labels",
                          spacing=(1, 1, 1)).mask()
    made = first.align(second)
    assert made["found"] and made["matrix_mm"].shape == (4, 4) and made["why_none"] is None
    there = first.transform(tmp_path / "t.8vo", affine=made["matrix_mm"], grid_of=second)
    assert there.mask().agreement(second)[0]["dice"] > 0.9


@pytest.mark.parametrize("call", [
    lambda m: m.distance(to="edges"), lambda m: m.distance(max_mm=0),
    lambda m: m.distance(max_mm=float("nan")), lambda m: m.distance(step_mm=1),
    lambda m: m.distance("no-volume.nii"), lambda m: m.morphometry(calibration=(1, 2)),
    lambda m: m.morphometry(calibration=3), lambda m: m.morphometry(region=4),
    lambda m: m.morphometry(thickness=False, thickness_map=True), lambda m: m.align("b.8vo"),
    lambda m: m.align(m ^ m), lambda m: (m ^ m).distance(), lambda m: (m | ~m).distance(),
    lambda m: (m ^ m).morphometry()])
def test_what_makes_no_sense_is_rejected(mask, call):
    with pytest.raises(octavo.ArgumentError):
        call(mask)


def test_a_full_mask_has_all_numbers_and_no_thickness(mask):
    some = mask.morphometry()
    full = (mask | ~mask).morphometry()
    assert full.keys() == some.keys()
    for key in ("tb_th_mm", "tb_th_sd_mm", "tb_n_per_mm", "tb_sp_mm", "pore_d50_mm"):
        assert some[key] > 0
        assert full[key] is None


def test_grey_values_are_no_mask(volume):
    for call in (volume.distance, volume.morphometry, lambda: volume.align(volume)):
        with pytest.raises(octavo.ArgumentError, match="grey"):
            call()


def test_label_maps_have_levels_for_zarr_and_dask(mask, solid):
    pytest.importorskip("dask.array")
    array = octavo.as_dask(mask)
    assert np.array_equal(array.compute(), solid) and array.dtype == np.uint8
    coarse = octavo.as_dask(mask, 1)
    assert coarse.shape == tuple(-(-n // 2) if n > 1 else 1 for n in solid.shape) or \
        all(c <= n for c, n in zip(coarse.shape, solid.shape))
    zarr = pytest.importorskip("zarr", minversion="3")
    group = zarr.open_group(octavo.as_zarr(mask), mode="r")
    assert np.array_equal(group["0"][...], solid)
    assert "image-label" in group.attrs["ome"]
    assert list(itertools.islice(group.array_keys(), 1))
