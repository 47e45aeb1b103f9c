"""Samples of a level with what neighborhoods see around them: docs/format-grey.md, 6, 7 and 16.

Arrays are indexed [z][y][x].
"""

import numpy as np

# Samples of margin along z, y and x.
MARGINS = (2, 2, 8)


class PaddedSamples:
    """Samples of a level, or of a part of it, with margins.

    faces  per array axis whether the faces at its low and high end are at the border of the brick;
           beyond those the nearest sample repeats
    """

    def __init__(self, padded: np.ndarray, faces: tuple[tuple[bool, bool], ...]) -> None:
        self._padded = padded
        self._faces = faces

    @classmethod
    def of_level(cls, samples: np.ndarray) -> "PaddedSamples":
        """All samples of a level."""
        margins = [(margin, margin) for margin in MARGINS]
        return cls(np.pad(samples, margins, mode="edge"), ((True, True),) * 3)

    def part(self, first: tuple[int, int, int], shape: tuple[int, int, int]) -> "PaddedSamples":
        """The box of samples from `first` on, in the midst of the others."""
        ends = [at + n for at, n in zip(first, shape)]
        around = tuple(slice(at, end + 2 * m) for at, end, m in zip(first, ends, MARGINS))
        faces = tuple((at == 0, end == n)
                      for at, end, n in zip(first, ends, self.samples.shape))
        return PaddedSamples(self._padded[around], faces)

    @property
    def samples(self) -> np.ndarray:
        return self.with_margins(0)

    def with_margins(self, width: int | None = None) -> np.ndarray:
        """The samples and `width` of margin around; all of the margins without it."""
        if width is None:
            return self._padded
        return self._padded[tuple(slice(m - width, n - m + width)
                                  for m, n in zip(MARGINS, self._padded.shape))]

    def repeated(self, array_axis: int, length: int) -> "PaddedSamples":
        """Each sample twice along an axis, `length` in all; so are those around."""
        margin = MARGINS[array_axis]
        places = (np.arange(-margin, length + margin) >> 1) + margin
        return PaddedSamples(self._padded.take(places, array_axis), self._faces)

    def replaced(self, samples: np.ndarray) -> "PaddedSamples":
        """Other samples in the same place, repeated beyond the border of the brick."""
        padded = self._padded.copy()
        padded[tuple(slice(m, n - m) for m, n in zip(MARGINS, padded.shape))] = samples
        for axis in (2, 1, 0):
            margin, length = MARGINS[axis], samples.shape[axis]
            low, high = self._faces[axis]
            places = np.arange(-margin, length + margin).clip(
                0 if low else -margin, length - 1 if high else length + margin - 1)
            padded = padded.take(places + margin, axis)
        return PaddedSamples(padded, self._faces)
