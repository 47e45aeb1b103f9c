"""Models of label bricks: docs/format-labels.md, sections 4 and 5."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from .binary_coder import AdaptiveBit, AdaptiveNumber, BinaryDecoder
from .errors import require, require_known

NEIGHBORS = 32
_WIDTH = 16
_FIRST_ROWS = 40
_SECOND_ROWS = 4
_ROWS = 6 * NEIGHBORS + _FIRST_ROWS + _SECOND_ROWS + 1
_WEIGHTS = _ROWS * _WIDTH
_PALETTE_LIMIT = 4096

# 65536 / (1 + exp(-x)) for x = -11, -10.5 .. 11.
_LOGISTIC = (
    1, 2, 3, 5, 8, 13, 22, 36, 60, 98, 162, 267, 439, 720, 1179, 1921, 3108, 4971, 7812, 11955,
    17625, 24743, 32768, 40793, 47911, 53581, 57724, 60565, 62428, 63615, 64357, 64816, 65097,
    65269, 65374, 65438, 65476, 65500, 65514, 65523, 65528, 65531, 65533, 65534, 65535,
)


class Network:
    """Gives the probability of an answer; `weights` has the shape (237, 16)."""

    def __init__(self, weights: np.ndarray) -> None:
        # Eight rows a neighbor, by 2 * state + equal; those of state 0 are zero.
        self._neighbor_rows = np.zeros((NEIGHBORS, 8, _WIDTH), np.int64)
        self._neighbor_rows[:, 2:] = weights[: 6 * NEIGHBORS].reshape(NEIGHBORS, 6, _WIDTH)
        self._neighbor_rows = self._neighbor_rows.reshape(-1, _WIDTH)
        self._first = weights[6 * NEIGHBORS : 6 * NEIGHBORS + _FIRST_ROWS]
        self._second = weights[6 * NEIGHBORS + _FIRST_ROWS : _ROWS - 1]
        self._out = weights[_ROWS - 1]
        self._offsets = 8 * np.arange(NEIGHBORS)

    def probability(self, states: np.ndarray, equal: np.ndarray, first: int, second: int) -> int:
        """Probability of 1 in 65536ths; `states` and `equal` have one entry per neighbor."""
        rows = self._neighbor_rows[self._offsets + 2 * states + equal]
        sums = rows.sum(axis=0) + self._first[first] + self._second[second]
        logit = max(-2816, min(2816, int(np.maximum(sums, 0) @ self._out)))
        i = min((logit + 2816) // 128, 43)
        low, high = _LOGISTIC[i], _LOGISTIC[i + 1]
        return max(16, min(65520, low + (high - low) * (logit + 2816 - 128 * i) // 128))


@dataclass(frozen=True)
class LabelModel:
    """What the label bricks of some layers share: a rising palette and three networks."""

    palette: list[int]
    same: Network
    uniform: Network
    candidate: Network


@cache
def _start_weights() -> np.ndarray:
    """The weights that every model starts from, of shape (3, 3792)."""
    text = Path(__file__).with_name("label_start_weights.inc").read_text()
    numbers = [int(number) for number in text.replace("\n", "").split(",") if number]
    return np.array(numbers, np.int64).reshape(3, _WEIGHTS)


def parse_label_model(data: bytes, voxel_type: str) -> LabelModel:
    """Reads a model of a file whose voxels have this NumPy type.

    Raises  OctavoError "corrupt", "unsupported_version"
    """
    decoder = BinaryDecoder(data)
    limits = np.iinfo(voxel_type)
    length = decoder.number(AdaptiveNumber(33))
    require_known(length <= _PALETTE_LIMIT, "a label model of a later version")
    steps = AdaptiveNumber(33)
    palette = []
    next_label = int(limits.min)
    for _ in range(length):
        palette.append(next_label + decoder.number(steps))
        next_label = palette[-1] + 1
    require(next_label <= limits.max + 1, "a palette leaves the voxel type")

    networks = []
    for start in _start_weights():
        changed, negative, sizes = AdaptiveBit(2000), AdaptiveBit(), AdaptiveNumber(33)
        weights = start.copy()
        for i in range(_WEIGHTS):
            if decoder.adaptive(changed):
                sign = -1 if decoder.adaptive(negative) else 1
                weights[i] += 2 * sign * min(decoder.number(sizes) + 1, 256)
        require(np.abs(weights).max() <= 127, "a weight of a network is too large")
        networks.append(Network(weights.reshape(_ROWS, _WIDTH)))
    prove_end(decoder, data)
    return LabelModel(palette, *networks)


def prove_end(decoder: BinaryDecoder, data: bytes) -> None:
    """Raises OctavoError "corrupt" unless the decoder has ended where `data` does."""
    require(len(data) <= decoder.at <= len(data) + 4, "a label stream does not end where it should")
