"""Patches for PyTorch, where it is installed."""

import os
import resource

import numpy as np
import pytest

import octavo

torch = pytest.importorskip("torch")


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    random = np.random.default_rng(2)
    voxels = random.integers(-30, 31, (40, 70, 90)).cumsum(2).astype(np.int16)
    return octavo.build(voxels, tmp_path_factory.mktemp("torch") / "scan.8vo",
                        spacing=(3, 0.7, 0.5), slope=2, intercept=-1000, unit="HU")


def test_patches_for_pytorch_are_those_of_the_scan(scan, tmp_path):
    from octavo.torch import PatchDataset
    mask = scan.threshold(0).save(tmp_path / "mask.8vo", overwrite=True)
    patches = PatchDataset([(scan.name, mask.name)], (16, 32, 24), 6, seed=3)
    image, labels = patches[2]
    assert image.shape == labels.shape == (1, 16, 32, 24)
    assert image.dtype == torch.float32 and labels.dtype == torch.int64
    assert torch.equal(labels > 0, image >= 0)
    assert torch.equal(image, patches[2][0]) and not torch.equal(image, patches[3][0])
    loader = torch.utils.data.DataLoader(patches, batch_size=3, num_workers=2)
    assert [batch[0].shape[0] for batch in loader] == [3, 3]
    assert torch.equal(next(iter(loader))[0][2], image)
    patches.set_epoch(1)
    assert not torch.equal(image, patches[2][0])
    large = PatchDataset([scan.name], (64, 8, 8), 1)[0]
    assert large.shape == (1, 64, 8, 8) and (large[0, 40:] == large[0, 63]).all()


def test_any_number_of_files_is_read(scan, tmp_path):
    from octavo.torch import PatchDataset
    octavo.build(scan[:8, :8, :8], tmp_path / "0.8vo").close()
    paths = [tmp_path / f"{i}.8vo" for i in range(150)]
    for path in paths[1:]:
        os.link(paths[0], path)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    patches = PatchDataset(paths * 2, (4, 4, 4), 900)
    first = patches[0]
    assert patches._cache_bytes * len(set(paths)) <= octavo.DEFAULT_CACHE_BYTES
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (len(os.listdir("/proc/self/fd")) + 80, hard))
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr("octavo.torch._MOST_OPEN", 64)
            assert all(patch.shape == (1, 4, 4, 4) for patch in patches)
        assert torch.equal(patches[0], first)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.fixture
def elsewhere(scan, tmp_path):
    """Builds labels in the place of those of the scan."""
    def built(shape=scan.shape, kind="labels", **given):
        path = tmp_path / "other.8vo"
        octavo.build(np.zeros(shape, np.uint8), path, kind=kind, overwrite=True,
                     **{"spacing": scan.spacing, **given}).close()
        return path
    return built


def test_a_pair_lies_on_one_grid(scan, elsewhere):
    from octavo.torch import PatchDataset
    assert len(PatchDataset([(scan.name, elsewhere())], (4, 4, 4), 9)) == 9
    for other, said in (({"origin": (10, 0, 0)}, "mm from .*scan.8vo: origin"),
                        ({"spacing": (3, 0.7, 0.6)}, "spacing"),
                        ({"shape": (80, 70, 90)}, "has 80 x 70 x 90 voxels"),
                        ({"kind": "grey"}, "other.8vo: holds grey values")):
        with pytest.raises(octavo.ArgumentError, match=said):
            PatchDataset([(scan.name, scan.threshold(0).save(scan.name + ".mask.8vo",
                                                             overwrite=True).name),
                          (scan.name, elsewhere(**other))], (4, 4, 4), 9)
    with pytest.raises(octavo.ArgumentError, match="scan.8vo: holds grey values"):
        PatchDataset([(elsewhere(), scan.name)], (4, 4, 4), 9)


def test_what_is_no_data_set_is_said_when_it_is_made(scan, elsewhere):
    from octavo.torch import PatchDataset
    assert PatchDataset(scan.name, (4, 4, 4), 9)[0].shape == (1, 4, 4, 4)
    for wrong, said in (({"level": 20}, "level 20 is not there"), ({"level": -1}, "level"),
                        ({"paths": [(scan.name, elsewhere()), scan.name]}, "not both"),
                        ({"paths": [(scan.name,) * 3]}, "pairs"), ({"paths": []}, "one file"),
                        ({"paths": 7}, "paths"), ({"shape": 4}, "sides"),
                        ({"seed": -1}, "seed"), ({"seed": None}, "seed")):
        with pytest.raises(octavo.ArgumentError, match=said):
            PatchDataset(**{"paths": [scan.name], "shape": (4, 4, 4), "length": 9, **wrong})
