"""Volumes beside one another: what is told of places, real values and stored ones."""

import numpy as np
import pytest

import octavo

VOXELS = np.arange(4096, dtype=np.int16).reshape(16, 16, 16)
GIVEN = dict(slope=1, intercept=-1024, unit="HU", spacing=(1, 1, 1))


@pytest.fixture
def built(tmp_path):
    def built(name, voxels=VOXELS, **given):
        return octavo.build(voxels, tmp_path / f"{name}.8vo", **given)
    return built


@pytest.mark.parametrize("given", [
    {"slope": 1, "intercept": 0}, {"slope": 8.5}, {"slope": None, "intercept": None}])
def test_one_voxel_digest_does_not_make_other_real_values_equal(built, given):
    a, b = built("a", **GIVEN), built("b", **{**GIVEN, **given})
    assert a.voxels_sha256 == b.voxels_sha256
    found = a.compare(b)
    real = np.abs(a.real[...] - b.real[...])
    assert not found["equal"] and not found["same_stored"] and not found["same_rescale"]
    assert found["different_voxels"] == np.count_nonzero(real) > 0
    assert found["max_difference"] == pytest.approx(real.max())
    assert a.compare(b, max_error=real.max() + 1)["equal"]


def test_what_is_decoded_in_counts_against_the_memory_limit(built, run):
    a, b = built("a"), built("b", VOXELS + 1)
    done = run("compare", a.name, b.name, "--max-memory", 4 << 20, "-j", 2)
    assert done.returncode == 6
    with pytest.raises(octavo.LimitError, match="comparing layers of planes") as raised:
        a.compare(b, max_memory=4 << 20, threads=2)
    assert raised.value.detail.partition("; raise")[0] in done.stderr
    assert a.compare(b, max_memory=1 << 30)["different_voxels"] == VOXELS.size


def test_label_maps_of_one_digest_on_other_grids_are_not_equal(built):
    labels = (VOXELS % 3).astype(np.uint8)
    a = built("a", labels, kind="labels", spacing=(1, 1, 1))
    b = built("b", labels, kind="labels", spacing=(1, 1, 2))
    found = a.label_map().compare(b.label_map())
    assert not found["equal"] and not found["same_place"] and found["different_voxels"] == 0
    assert found["shift_mm"] == 15 and found["geometry_known"]
    assert a.label_map().compare(a)["equal"]


def test_what_is_stored_alike_elsewhere_is_not_the_same(built):
    found = built("a", **GIVEN).compare(built("b", **{**GIVEN, "spacing": (1, 1, 2)}))
    assert found["different_voxels"] == 0 and found["same_rescale"] and found["same_dtype"]
    assert not found["same_place"] and not found["same_stored"] and not found["equal"]


def test_no_shift_is_told_where_a_spacing_is_not_known(built):
    other = built("b", **{**GIVEN, "spacing": None, "origin": (9, 9, 9)})
    found = built("a", **GIVEN).compare(other)
    assert found["equal"] and found["same_place"]
    assert found["geometry_known"] is False and found["shift_mm"] is None
