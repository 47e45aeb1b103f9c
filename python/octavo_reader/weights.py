"""How many voxels samples stand for: docs/format.md, section 2."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SampleWeights:
    """Voxels of level 0 that the samples of a level stand for, along three axes.

    each  all samples but the last; powers of 2
    last  the last one, which may reach beyond the volume
    """

    each: tuple[int, int, int]
    last: tuple[int, int, int]

    def halved(self, size: tuple[int, int, int], mask: int) -> "SampleWeights":
        """The weights of the next level, of `size` samples before the axes of `mask` are halved."""
        each, last = list(self.each), list(self.last)
        for axis in range(3):
            if mask >> axis & 1:
                last[axis] += 0 if size[axis] % 2 else each[axis]
                each[axis] *= 2
        return SampleWeights(tuple(each), tuple(last))

    def ordered(self, order: tuple[int, int, int]) -> "SampleWeights":
        return SampleWeights(tuple(self.each[axis] for axis in order),
                             tuple(self.last[axis] for axis in order))

    def last_pair(self, axis: int, count: int) -> tuple[int, int]:
        """Of the last pair among `count` samples; the samples of other pairs weigh alike."""
        each, last = self.each[axis], self.last[axis]
        return (each, last) if count % 2 == 0 and last < each else (1, 1)
