"""Label bricks: docs/format-labels.md, sections 1, 2 and 6. Arrays are indexed [z][y][x]."""

import math

import numpy as np

from .binary_coder import AdaptiveBit, BinaryDecoder
from .byte_cursor import ByteCursor, unpack_bits
from .errors import require
from .header import halved
from .label_model import LabelModel, Network, prove_end
from .weights import SampleWeights

_LABEL_LIMIT = 16384
_OUTSIDE, _NOT_VISITED, _MIXED, _UNIFORM = range(4)
_MARGIN = 2

# Places (x, y, z) of the neighbors; along each axis +1 leads away from the child's siblings.
_NEIGHBORS = tuple(
    [(x, y, -1) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    + [(x, -1, 0) for x in (-1, 0, 1)]
    + [(x, 0, 0) for x in (-2, -1, 1, 2)]
    + [(x, 1, 0) for x in (-1, 0, 1)]
    + [(x, y, 1) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    + [(0, -2, 0), (0, 2, 0), (0, 0, -2), (0, 0, 2)]
)
# By squared distance: face, edge, corner, two steps away.
_VOTES = np.array([{1: 12, 2: 5, 3: 3, 4: 2}[x * x + y * y + z * z] for x, y, z in _NEIGHBORS])


def decode_label_brick(model: LabelModel, smallest: int, largest: int, segments: list[bytes],
                       size: tuple[int, int, int], halvings: list[int], weights: SampleWeights,
                       place: int) -> np.ndarray:
    """The labels of one level of a brick that is not uniform, as int64 of shape [z][y][x].

    segments  one per level of the brick, finest first; those finer than `place` are not looked at
    size      x, y, z of the brick's finest level
    halvings  per level of the brick the mask of axes halved to the next, the last to the root
    weights   of the samples of the brick's finest level
    place     which level of the brick, 0 the finest; behind the last its root
    Raises    OctavoError "corrupt"
    """
    if len(segments) > 1 and not segments[-1]:
        require(not any(segments[1:]), "a stored brick has a second segment")
        labels = _decode_stored(segments[0], smallest, largest, size)
        for mask in halvings[:place]:
            labels = most_frequent(labels, mask, weights)
            weights = weights.halved(size, mask)
            size = halved(size, mask)
        return labels
    sizes, all_weights = [size], [weights]
    for mask in halvings:
        all_weights.append(all_weights[-1].halved(sizes[-1], mask))
        sizes.append(halved(sizes[-1], mask))
    require(sizes[-1] == (1, 1, 1), "a brick has no root")
    walk = _Walk(model, smallest, largest)
    last = len(segments) - 1
    for level in range(last, min(place, last) - 1, -1):
        walk.level(level, segments[level], sizes[level], halvings[level], all_weights[level])
    return walk.labels() if place <= last else walk.root()


def _decode_stored(segment: bytes, smallest: int, largest: int,
                   size: tuple[int, int, int]) -> np.ndarray:
    cursor = ByteCursor(segment, "a stored brick")
    count = cursor.varint()
    voxels = size[0] * size[1] * size[2]
    require(count <= largest - smallest + 1, "a stored brick has too many labels")
    labels = []
    next_label = smallest
    for _ in range(count):
        labels.append(next_label + cursor.varint())
        next_label = labels[-1] + 1
    require(next_label <= largest + 1, "a label lies beyond its brick's largest")
    most = count - 1 if count > 0 else largest - smallest
    fields = unpack_bits(cursor.rest(), most.bit_length(), voxels, "a stored brick")
    require(fields.max() <= most, "a voxel of a stored brick lies beyond the greatest")
    values = np.array(labels, np.int64)[fields] if count > 0 else smallest + fields
    return values.reshape(size[::-1])


def most_frequent(labels: np.ndarray, mask: int, weights: SampleWeights) -> np.ndarray:
    """The next level: of each octant the label of the most votes, of several the smallest."""
    margins = [(0, n & (mask >> (2 - axis)) & 1) for axis, n in enumerate(labels.shape)]
    along = [_votes_along(weights, 2 - axis, n) for axis, n in enumerate(labels.shape)]
    votes = along[0][:, None, None] * along[1][:, None] * along[2]
    children, weighty = [np.pad(labels, margins)], [np.pad(votes, margins)]
    for array_axis in range(3):
        if mask >> (2 - array_axis) & 1:
            parts = [slice(0, None, 2), slice(1, None, 2)]
            at = (slice(None),) * array_axis
            children = [child[at + (part,)] for child in children for part in parts]
            weighty = [child[at + (part,)] for child in weighty for part in parts]
    best, best_count = children[0], np.zeros(children[0].shape, np.int64)
    for label, own in zip(children, weighty):
        count = sum(np.where(other == label, more, 0) for other, more in zip(children, weighty))
        wins = (own > 0) & ((count > best_count) | ((count == best_count) & (label < best)))
        best = np.where(wins, label, best)
        best_count = np.where(wins, count, best_count)
    return best


def _votes_along(weights: SampleWeights, axis: int, count: int) -> np.ndarray:
    """The votes of `count` samples along an axis: voxels of level 0 that they stand for."""
    votes = np.full(count, weights.each[axis], np.int64)
    votes[-1] = weights.last[axis]
    return votes


class _Walk:
    """The octree of a coded brick, from the root to finer levels."""

    def __init__(self, model: LabelModel, smallest: int, largest: int) -> None:
        self._model = model
        self._smallest = smallest
        self._largest = largest
        self._palette = [label for label in model.palette if smallest <= label <= largest]
        self._in_palette = AdaptiveBit(65000)
        self._is_fresh = AdaptiveBit()
        self._slot_labels: list[int] = []
        self._is_pair = False
        self._coder: BinaryDecoder | None = None
        # Slots and states of the level decoded last.
        self._slots = np.zeros((1, 1, 1), np.int64)
        self._states = np.full((1, 1, 1), _MIXED, np.int64)

    def labels(self) -> np.ndarray:
        """The labels of the level decoded last, [z][y][x]."""
        return np.array(self._slot_labels, np.int64)[self._slots]

    def root(self) -> np.ndarray:
        """The label of the root, once a level is decoded."""
        return np.array(self._slot_labels[0], np.int64).reshape(1, 1, 1)

    def level(self, level: int, segment: bytes, size: tuple[int, int, int], mask: int,
              weights: SampleWeights) -> None:
        """Decodes one level of x, y, z samples; `mask` leads to the level decoded last."""
        self._coder = BinaryDecoder(segment)
        if not self._slot_labels:
            self._start()
        parents = [np.arange(n) >> (mask >> axis & 1) for axis, n in enumerate(size)]
        chosen = np.ix_(parents[2], parents[1], parents[0])
        parent_slots, parent_states = self._slots, self._states
        states = np.where(parent_states[chosen] == _UNIFORM, _UNIFORM, _NOT_VISITED)
        self._states = np.pad(states, _MARGIN)
        self._slots = np.pad(parent_slots[chosen], _MARGIN)
        self._flat_states = self._states.reshape(-1)
        self._flat_slots = self._slots.reshape(-1)

        votes = [_votes_along(weights, axis, n).tolist() for axis, n in enumerate(size)]
        strides = (1, self._states.shape[2], self._states.shape[1] * self._states.shape[2])
        digits = [d for d in range(8) if not _bits_of(d) & ~mask]
        around = {d: _neighbor_offsets(d, strides) for d in digits}
        for pz, py, px in np.argwhere(parent_states == _MIXED).tolist():
            corner = [p << (mask >> axis & 1) for axis, p in enumerate((px, py, pz))]
            children = []
            for d in digits:
                bits = _bits_of(d)
                child = [c + (bits >> axis & 1) for axis, c in enumerate(corner)]
                if all(c < n for c, n in zip(child, size)):
                    at = sum((c + _MARGIN) * stride for c, stride in zip(child, strides))
                    weight = math.prod(along[c] for along, c in zip(votes, child))
                    children.append((d, at, at + around[d], weight))
            self._octant(level, int(parent_slots[pz, py, px]), children)
        prove_end(self._coder, segment)
        inside = (slice(_MARGIN, -_MARGIN),) * 3
        self._states, self._slots = self._states[inside], self._slots[inside]

    def _start(self) -> None:
        self._is_pair = bool(self._coder.get(32768))
        if self._is_pair:
            pair = [self._smallest, self._largest]
            self._slot_labels = pair if self._coder.get(32768) else pair[::-1]
        else:
            self._slot_labels = [self._fresh()]

    def _fresh(self) -> int:
        """A label that has no slot yet."""
        palette = self._palette
        if palette and self._coder.adaptive(self._in_palette):
            return palette[self._coder.uniform(len(palette))]
        return self._smallest + self._coder.uniform(self._largest - self._smallest + 1)

    def _octant(self, level: int, parent: int,
                children: list[tuple[int, int, np.ndarray, int]]) -> None:
        """Decodes the children (digit, place, places of neighbors, votes) of a mixed sample."""
        left = len(children)
        octant = _Octant(parent, sum(votes for *_, votes in children))
        one = True
        for digit, at, around, votes in children:
            left -= 1
            octant.enter(votes)
            states, slots = self._flat_states[around], self._flat_slots[around]
            seen = _Neighborhood(states, slots, 5 * digit, min(level, 3))
            known = level == 0 and left == 0 and one and octant.most > 0
            is_same = not known and self._ask_same(octant, seen)
            slot = parent if is_same else self._other(octant, seen)
            octant.leave(slot)
            if level == 0:
                is_uniform = True
            elif left == 0 and one and slot == parent:
                is_uniform = False
            else:
                category = 0 if slot != parent else 1 if one else 2
                is_uniform = self._ask(self._model.uniform, seen, slot, category)
            one = one and is_uniform and slot == parent
            self._flat_slots[at] = slot
            self._flat_states[at] = _UNIFORM if is_uniform else _MIXED

    def _ask(self, network: Network, seen: "_Neighborhood", slot: int, category: int) -> bool:
        p = network.probability(seen.states, seen.slots == slot, seen.first + category, seen.second)
        return bool(self._coder.get(p))

    def _wins(self, votes: int, slot: int, octant: "_Octant") -> bool:
        """True when so many votes would make another label the parent's."""
        labels = self._slot_labels
        return votes > octant.most or (
            votes == octant.most and labels[slot] < labels[octant.parent])

    def _would_win(self, slot: int, octant: "_Octant") -> bool:
        return self._wins(octant.votes.get(slot, 0) + octant.own, slot, octant)

    def _ask_same(self, octant: "_Octant", seen: "_Neighborhood") -> bool:
        if octant.most == 0 or any(self._wins(v, s, octant) for s, v in octant.votes.items()):
            return True
        if self._is_pair and self._would_win(1 - octant.parent, octant):
            return True
        return self._ask(self._model.same, seen, octant.parent, min(octant.other_count, 4))

    def _other(self, octant: "_Octant", seen: "_Neighborhood") -> int:
        """The slot of a child whose label is not the parent's."""
        parent = octant.parent
        if self._is_pair:
            return 1 - parent
        votes: dict[int, int] = {}
        is_candidate = (seen.states > 0) & (seen.slots != parent)
        weights = np.where(seen.states == _NOT_VISITED, (_VOTES + 1) // 2, _VOTES)
        for slot, weight in zip(seen.slots[is_candidate].tolist(), weights[is_candidate].tolist()):
            votes[slot] = votes.get(slot, 0) + weight
        candidates = [slot for slot in sorted(votes, key=lambda slot: (-votes[slot], slot))
                      if not self._would_win(slot, octant)]
        total = sum(votes[slot] for slot in candidates)
        for j, slot in enumerate(candidates):
            first = 8 * min(j, 3) + min(8 * votes[slot] // total, 7)
            p = self._model.candidate.probability(seen.states, seen.slots == slot, first,
                                                  min(len(candidates) - 1 - j, 3))
            if self._coder.get(p):
                return slot
            total -= votes[slot]
        if self._coder.adaptive(self._is_fresh):
            require(len(self._slot_labels) < _LABEL_LIMIT, "a brick has too many labels")
            self._slot_labels.append(self._fresh())
            return len(self._slot_labels) - 1
        return self._coder.uniform(len(self._slot_labels))


class _Octant:
    """The votes of the children of a sample on their way.

    most    votes of children with the parent's label or to come, without the one being decoded
    own     votes of that one
    votes   of the slots met that are not the parent's; other_count: children that have them
    """

    __slots__ = ("parent", "most", "own", "votes", "other_count")

    def __init__(self, parent: int, most: int) -> None:
        self.parent = parent
        self.most = most
        self.own = 0
        self.votes: dict[int, int] = {}
        self.other_count = 0

    def enter(self, votes: int) -> None:
        self.own = votes
        self.most -= votes

    def leave(self, slot: int) -> None:
        if slot == self.parent:
            self.most += self.own
        else:
            self.votes[slot] = self.votes.get(slot, 0) + self.own
            self.other_count += 1


class _Neighborhood:
    """States and slots of a child's neighbors, and the categories that all its questions share."""

    __slots__ = ("states", "slots", "first", "second")

    def __init__(self, states: np.ndarray, slots: np.ndarray, first: int, second: int) -> None:
        self.states = states
        self.slots = slots
        self.first = first
        self.second = second


def _bits_of(digit: int) -> int:
    """The axes (1 x, 2 y, 4 z) along which a digit 4z + 2x + y lies at the larger index."""
    return (digit >> 1 & 1) | (digit & 1) << 1 | (digit & 4)


def _neighbor_offsets(digit: int, strides: tuple[int, int, int]) -> np.ndarray:
    signs = [1 if _bits_of(digit) >> axis & 1 else -1 for axis in range(3)]
    return np.array([sum(sign * step * stride for sign, step, stride in zip(signs, place, strides))
                     for place in _NEIGHBORS])
