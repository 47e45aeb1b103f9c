"""The binary coder and its adaptive numbers.

Source  docs/format-grey.md, sections 9 and 10; docs/format-labels.md, section 3
"""


class AdaptiveBit:
    """A probability of 1, in 65536ths, that follows the decisions made with it."""

    __slots__ = ("p", "count", "most")

    def __init__(self, p: int = 32768, most: int = 5) -> None:
        self.p = p
        self.count = 0
        self.most = most

    def learn(self, bit: int) -> None:
        if self.count < self.most:
            self.count += 1
        if bit:
            self.p += _divide(65504 - self.p, self.count)
        else:
            self.p += _divide(32 - self.p, self.count)


def _divide(value: int, shift: int) -> int:
    """value / 2^shift, truncated towards zero."""
    return value >> shift if value >= 0 else -(-value >> shift)


class BinaryDecoder:
    """Decodes decisions from `data`; bytes beyond the end are 0. `at` counts the bytes taken."""

    def __init__(self, data: bytes) -> None:
        self._data = data + bytes(4)
        self._length = len(data)
        self._range = 0xFFFFFFFF
        self._code = int.from_bytes(self._data[:4], "big")
        self.at = 4

    def get(self, p: int) -> int:
        """A decision that is 1 with probability p / 65536."""
        bound = (self._range >> 16) * p
        if self._code < bound:
            bit = 1
            self._range = bound
        else:
            bit = 0
            self._code -= bound
            self._range -= bound
        while self._range < 1 << 24:
            self._range <<= 8
            byte = self._data[self.at] if self.at < self._length else 0
            self._code = self._code << 8 | byte
            self.at += 1
        return bit

    def adaptive(self, state: AdaptiveBit) -> int:
        """A decision with the probability that `state` has learned; `state` learns it."""
        bit = self.get(state.p)
        state.learn(bit)
        return bit

    def even_bits(self, count: int) -> int:
        """A number of `count` bits, highest first, each 0 or 1 at even odds."""
        value = 0
        for _ in range(count):
            value = value << 1 | self.get(32768)
        return value

    def uniform(self, count: int) -> int:
        """One of `count` equally likely numbers, counted from 0."""
        low = 0
        while count > 1:
            half = count >> 1
            if self.get(((count - half) << 16) // count):
                low += half
                count -= half
            else:
                count = half
        return low

    def number(self, states: "AdaptiveNumber") -> int:
        """A number >= 0: its bit length in unary, its second bit, the others at even odds."""
        length = 0
        while length < states.most and not self.adaptive(states.length[length]):
            length += 1
        if length < 2:
            return length
        value = 2 | self.adaptive(states.second[length])
        return value << (length - 2) | self.even_bits(length - 2)

    def signed(self, states: "AdaptiveNumber") -> int:
        """0, -1, 1, -2, ..: coded as 0, 1, 2, 3, .."""
        value = self.number(states)
        return value >> 1 if value & 1 == 0 else -(value >> 1) - 1


class AdaptiveNumber:
    """Adaptive bits of numbers of at most `most` bits."""

    def __init__(self, most: int) -> None:
        self.most = most
        self.length = [AdaptiveBit() for _ in range(most + 1)]
        self.second = [AdaptiveBit() for _ in range(most + 1)]
