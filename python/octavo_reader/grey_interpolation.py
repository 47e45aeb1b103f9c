"""Levels of grey bricks without details: docs/format-grey.md, section 17.

Arrays are indexed [z][y][x]; x, y, z are axes 0, 1, 2, so that array axis = 2 - axis.
"""

import numpy as np

from .grey_details import Lifting


def interpolated_split(means: np.ndarray, array_axis: int, length: int, lifting: Lifting,
                       low: int, high: int) -> np.ndarray:
    """The samples along one axis whose means these are, `length` of them.

    low, high  the samples of the smallest and the largest voxel of the brick
    """
    lines = np.moveaxis(means, array_axis, 0)
    count = len(lines)
    around = np.concatenate([lines[:1], lines[:1], lines, lines[-1:], lines[-1:]])
    steps = [around[2 - far : 2 - far + count] - around[2 + far : 2 + far + count]
             for far in (1, 2)]
    pairs = length // 2
    middle = lines[:pairs]
    limits = np.minimum(2 * (middle - low) + 1 - lifting.rounding,
                        2 * (high - middle) + lifting.rounding)
    if lifting.is_weighted:
        limits[-1] = high - low
    details = ((14 * steps[0] - 3 * steps[1] + 16) >> 5)[:pairs].clip(-limits, limits)
    samples = np.empty((length, *lines.shape[1:]), np.int64)
    second = middle - lifting.above_second(details)
    samples[0 : 2 * pairs : 2] = second + details
    samples[1 : 2 * pairs : 2] = second
    samples[2 * pairs :] = lines[pairs:]
    if lifting.is_weighted:
        samples[-2:] = samples[-2:].clip(low, high)
    return np.moveaxis(samples, 0, array_axis)
