"""Patches of volumes for PyTorch."""

import contextlib
import os

import numpy as np
import torch

from . import _octavo
from ._errors import ArgumentError
from ._volume import DEFAULT_CACHE_BYTES, Volume
from ._work import level_of, several_of, whole_number


_MOST_OPEN = 256  # files at a time, of the 1024 that systems commonly allow a process


class PatchDataset(torch.utils.data.Dataset):
    """Random patches of volumes, each read alone and decoded where it lies.

    Item i is the same whatever worker reads it, and another one in another epoch (`set_epoch`).
    Files are opened by each worker for itself, and once by the data set, which looks whether they
    fit. Of a worker those 256 stay open that were read last, and together keep as many bytes of
    decoded bricks as one volume does.

    Parameters
    ----------
    paths : path or sequence of path
        Images; or pairs (image, label map), each of one grid.
    shape : (z, y, x)
        Of a patch, in voxels of the level.
    length : int
        Patches of an epoch.
    level : int
    real : bool
        Real values as float32; stored ones otherwise.
    seed : int
        0 or more.

    Notes
    -----
    An item is a tensor [1, z, y, x]; of pairs a tuple of it and a tensor of int64 of the same
    shape. A volume smaller than a patch is continued with its smallest value, and label 0.

    Raises
    ------
    octavo.ArgumentError
        For pairs on different grids, grey values in the place of labels, pairs among single images,
        and a level that a file has not.
    """

    def __init__(self, paths, shape, length, *, level=0, real=True, seed=0):
        self._paths = _cases_of(paths)
        self._shape = tuple(whole_number(n, "a side of a patch", 1)
                            for n in several_of(shape, "the sides of a patch"))
        if len(self._shape) != 3:
            raise ArgumentError("a patch has three sides, z, y, x")
        self._length = whole_number(length, "length", 1)
        self._level = level_of(level)
        self._real = real
        self._seed = whole_number(seed, "seed", 0)
        self._epoch = 0
        self._opened = {}  # that was read last stands last
        files = len({path for case in self._paths for path in case})
        self._cache_bytes = DEFAULT_CACHE_BYTES // min(files, _MOST_OPEN)
        for case in self._paths:
            _require_fitting(case, self._level)

    def set_epoch(self, epoch):
        """Other patches from now on; to be called before workers start."""
        self._epoch = whole_number(epoch, "epoch", 0)

    def __len__(self):
        return self._length

    def __getitem__(self, index):
        if not 0 <= index < self._length:
            raise IndexError(index)
        random = np.random.default_rng((self._seed, self._epoch, index))
        case = self._paths[random.integers(len(self._paths))]
        image = self._volume(case[0])
        start = [int(random.integers(max(n - side, 0) + 1))
                 for n, side in zip(image.levels[self._level].shape, self._shape)]
        patch = self._patch(image, start, image.min)
        if self._real:
            patch = (patch.astype(np.float64) * image.slope + image.intercept).astype(np.float32)
        tensor = torch.from_numpy(_known_to_torch(patch)[None])
        if len(case) == 1:
            return tensor
        labels = self._patch(self._volume(case[1]), start, 0).astype(np.int64)
        return tensor, torch.from_numpy(labels[None])

    def __getstate__(self):
        return {**self.__dict__, "_opened": {}}

    def _volume(self, path):
        volume = self._opened.pop(path, None)
        if volume is None:
            volume = Volume(path, self._cache_bytes)
        self._opened[path] = volume
        if len(self._opened) > _MOST_OPEN:
            self._opened.pop(next(iter(self._opened)), None)
        return volume

    def _patch(self, volume, start, outside):
        view = volume.levels[self._level]
        stop = [min(a + side, n) for a, side, n in zip(start, self._shape, view.shape)]
        patch = np.full(self._shape, outside, view.dtype)
        part = tuple(slice(0, b - a) for a, b in zip(start, stop))
        # Loaders bring their own workers.
        view.read((start, stop), out=patch[part], threads=1)
        return patch


def _cases_of(paths):
    """Tuples of an image, or of an image and a label map; the same for all."""
    if isinstance(paths, (str, os.PathLike)):
        paths = [paths]
    cases = [tuple(case) if isinstance(case, (tuple, list)) else (case,)
             for case in several_of(paths, "paths")]
    if not cases:
        raise ArgumentError("a data set has one file or more")
    for case in cases:
        if len(case) not in (1, 2):
            raise ArgumentError(f"give paths, or pairs (image, label map), not {case!r}")
        if len(case) != len(cases[0]):
            raise ArgumentError("give pairs (image, label map) or images alone, not both")
    return cases


def _require_fitting(case, level):
    with contextlib.ExitStack() as opened:
        image, *rest = volumes = [opened.enter_context(Volume(path)) for path in case]
        for volume in volumes:
            volume._level(level)
        for labels in rest:
            if labels.kind != "labels":
                raise ArgumentError(f"{labels.name}: holds grey values, no labels of "
                                    f"{image.name}", path=labels.name)
            _octavo.require_same_grid(image._opened_file()[1], image.name,
                                      labels._opened_file()[1], labels.name)


def _known_to_torch(array):
    """PyTorch has no unsigned integers above 8 bits everywhere."""
    wider = {"uint16": np.int32, "uint32": np.int64}.get(array.dtype.name)
    return array.astype(wider) if wider else array
