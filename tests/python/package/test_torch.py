"""Patches for PyTorch, where it is installed."""

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
