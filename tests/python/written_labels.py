"""Codes label bricks as docs/format-labels.md has them.

Written from that text alone and sharing nothing with the two readers, so that the tests tell what
the text leaves open. Arrays are indexed [z][y][x].
"""

import pathlib

import numpy as np

from written_files import File, pack, varint
from written_grey import AdaptiveBit, AdaptiveNumber, BinaryEncoder

START = (pathlib.Path(__file__).resolve().parents[2]
         / "src/octavo/codec/label/label_start_weights.inc")
NETWORK_WEIGHTS = 3792
LOGISTIC = [int(word) for word in """
    1 2 3 5 8 13 22 36 60 98 162 267 439 720 1179 1921 3108 4971 7812 11955 17625 24743 32768 40793
    47911 53581 57724 60565 62428 63615 64357 64816 65097 65269 65374 65438 65476 65500 65514 65523
    65528 65531 65533 65534 65535""".split()]
# Section 5, as (x, y, z); 1 is away from the siblings.
NEIGHBORS = [(x, y, z) for z, y in ((-1, -1), (-1, 0), (-1, 1), (0, -1)) for x in (-1, 0, 1)]
NEIGHBORS += [(x, 0, 0) for x in (-2, -1, 1, 2)]
NEIGHBORS += [(x, y, z) for z, y in ((0, 1), (1, -1), (1, 0), (1, 1)) for x in (-1, 0, 1)]
NEIGHBORS += [(0, -2, 0), (0, 2, 0), (0, 0, -2), (0, 0, 2)]
OUTSIDE, WAITING, MIXED, UNIFORM = range(4)


class Coder(BinaryEncoder):
    """Section 3, with an end that is as short as it can be."""

    def end(self):
        most = self.low + self.range - 1
        zeros = next(k for k in range(most.bit_length() + 1, -1, -1)
                     if most >> k << k >= self.low)
        data = (most >> zeros << zeros).to_bytes(4 + self.shifts, "big")
        return data[:-4] + data[-4:].rstrip(b"\0")

    def put_uniform(self, value, count):
        low = 0
        while count > 1:
            half = count >> 1
            is_above = value >= low + half
            self.put(is_above, ((count - half) << 16) // count)
            low, count = (low + half, count - half) if is_above else (low, half)


class Model:
    """Section 4. `palette` rises; some weights are other than at the start."""

    def __init__(self, palette, lowest):
        start = [int(word) for word in START.read_text().replace(",", " ").split()]
        coder = Coder()
        AdaptiveNumber(33).put(coder, len(palette))
        distances = AdaptiveNumber(33)
        for label, before in zip(palette, [lowest - 1, *palette]):
            distances.put(coder, label - before - 1)
        self.palette, self.weights = palette, []
        for network in range(3):
            changed, negative, size = AdaptiveBit(2000), AdaptiveBit(), AdaptiveNumber(33)
            own = start[network * NETWORK_WEIGHTS:(network + 1) * NETWORK_WEIGHTS]
            for i, weight in enumerate(own):
                step = (0, 2, -6)[i % 3] if i % 41 == network else 0
                is_changed = step != 0 and abs(weight + step) <= 127
                changed.put(coder, is_changed)
                if is_changed:
                    negative.put(coder, step < 0)
                    size.put(coder, abs(step) // 2 - 1)
                    own[i] += step
            self.weights.append(np.array(own, np.int64).reshape(-1, 16))
        self.data = coder.end()

    def chance(self, network, around, first, second):
        """around: of each neighbor its state, and whether it is equal."""
        rows = self.weights[network]
        used = [6 * k + 2 * (state - 1) + equal for k, (state, equal) in enumerate(around) if state]
        sums = rows[192 + first] + rows[232 + second] + rows[used].sum(axis=0)
        logit = min(max(int((np.maximum(sums, 0) * rows[236]).sum()), -2816), 2816)
        i = min((logit + 2816) // 128, 43)
        step = (LOGISTIC[i + 1] - LOGISTIC[i]) * (logit + 2816 - 128 * i) // 128
        return min(max(LOGISTIC[i] + step, 16), 65520)


def children_of(place, shape, mask):
    """(digit, place) of the children, places as (x, y, z)."""
    for digit in range(8):
        bits = digit >> 1 & 1, digit & 1, digit >> 2 & 1
        if any(bits[a] and not mask >> a & 1 for a in range(3)):
            continue
        child = tuple(2 * p + bit if mask >> a & 1 else p
                      for a, (p, bit) in enumerate(zip(place, bits)))
        if all(c < n for c, n in zip(child, shape[::-1])):
            yield digit, child


class Pyramid:
    """The labels, votes and uniform samples of the levels of a brick, its root the last."""

    def __init__(self, samples, steps, weights):
        _, each, last = weights
        axes = [np.full(n, w, np.int64) for n, w in zip(samples.shape[::-1], each)]
        for own, weight in zip(axes, last):
            own[-1] = weight
        self.steps = steps
        self.labels, self.uniform = [samples], [np.ones(samples.shape, bool)]
        self.votes = [np.einsum("z,y,x->zyx", axes[2], axes[1], axes[0])]
        for mask in steps:
            self._add_level(mask)

    def _add_level(self, mask):
        labels, votes, uniform = self.labels[-1], self.votes[-1], self.uniform[-1]
        shape = tuple((n + 1) // 2 if mask >> a & 1 else n
                      for a, n in zip((2, 1, 0), labels.shape))
        made = np.empty(shape, np.int64), np.empty(shape, np.int64), np.empty(shape, bool)
        for z, y, x in np.ndindex(shape):
            own = [child[::-1] for _, child in children_of((x, y, z), labels.shape, mask)]
            counts = {}
            for child in own:
                counts[labels[child]] = counts.get(labels[child], 0) + votes[child]
            made[0][z, y, x] = min(counts, key=lambda label: (-counts[label], label))
            made[1][z, y, x] = sum(counts.values())
            made[2][z, y, x] = len(counts) == 1 and all(uniform[child] for child in own)
        for levels, level in zip((self.labels, self.votes, self.uniform), made):
            levels.append(level)


class BrickEncoder:
    """Section 6. The questions whose answers follow from others are not asked."""

    def __init__(self, model, pyramid):
        self.model, self.pyramid = model, pyramid
        self.in_palette, self.is_fresh = AdaptiveBit(65000), AdaptiveBit()
        present = np.unique(pyramid.labels[0]).tolist()
        self.smallest, self.largest = present[0], present[-1]
        self.is_pair = len(present) == 2
        self.slots, self.places = [], {}

    def segments(self, count):
        """Of `count` levels, finest first."""
        found = []
        for i in range(count - 1, -1, -1):
            self.coder = Coder()
            if i == count - 1:
                self._put_root(count)
            self._put_level(i)
            found.append(self.coder.end())
        found[0] = found[0] or b"\0"
        return found[::-1]

    def _add_slot(self, label):
        self.places[label] = len(self.slots)
        self.slots.append(label)

    def _put_root(self, count):
        root = int(self.pyramid.labels[count].item())
        self.coder.put(self.is_pair)
        if self.is_pair:
            self.coder.put(root == self.smallest)
            for label in sorted([self.smallest, self.largest], reverse=root != self.smallest):
                self._add_slot(label)
        else:
            self._put_fresh(root)
        self.slot, self.state = np.zeros((1, 1, 1), int), np.full((1, 1, 1), MIXED)

    def _put_fresh(self, label):
        inside = [entry for entry in self.model.palette if self.smallest <= entry <= self.largest]
        if inside:
            self.in_palette.put(self.coder, label in inside)
        if label in inside:
            self.coder.put_uniform(inside.index(label), len(inside))
        else:
            self.coder.put_uniform(label - self.smallest, self.largest - self.smallest + 1)
        self._add_slot(label)

    def _put_level(self, i):
        labels, votes = self.pyramid.labels[i], self.pyramid.votes[i]
        mask = self.pyramid.steps[i]
        where = np.ix_(*[np.arange(n) >> (mask >> a & 1)
                         for a, n in zip((2, 1, 0), labels.shape)])
        parents, states = self.slot, self.state
        self.slot = parents[where]
        self.state = np.where(states[where] == UNIFORM, UNIFORM, WAITING)
        for z, y, x in zip(*np.nonzero(states == MIXED)):
            self._put_children(i, list(children_of((x, y, z), labels.shape, mask)),
                               parents[z, y, x], labels, votes)

    def _put_children(self, i, children, parent, labels, votes):
        left = len(children)
        most = sum(int(votes[child[::-1]]) for _, child in children)
        others, count, one = {}, 0, True
        for digit, child in children:
            at = child[::-1]
            own, label = int(votes[at]), int(labels[at])
            left, most = left - 1, most - own
            around = self._around(digit, child)

            def wins(number, slot):
                is_smaller = self.slots[slot] < self.slots[parent]
                return number > most or (number == most and is_smaller)

            slot = self.places.get(label)
            if not self._follows_same(i, left, one, most, others, parent, own, wins):
                self.coder.put(slot == parent, self.model.chance(
                    0, self._equal(around, parent), 5 * digit + min(count, 4), min(i, 3)))
            if slot != parent:
                slot = self._put_other(digit, around, parent, own, others, wins, label)
                others[slot] = others.get(slot, 0) + own
                count += 1
            else:
                most += own
            is_uniform = i == 0 or bool(self.pyramid.uniform[i][at])
            if i > 0 and not (left == 0 and one and slot == parent):
                kind = 0 if slot != parent else 1 if one else 2
                self.coder.put(is_uniform, self.model.chance(
                    1, self._equal(around, slot), 5 * digit + kind, min(i, 3)))
            one = one and is_uniform and slot == parent
            self.slot[at], self.state[at] = slot, UNIFORM if is_uniform else MIXED

    def _follows_same(self, i, left, one, most, others, parent, own, wins):
        if i == 0 and left == 0 and one and most > 0:
            return True
        if most == 0 or any(wins(number, slot) for slot, number in others.items()):
            return True
        return self.is_pair and wins(others.get(1 - parent, 0) + own, 1 - parent)

    def _around(self, digit, child):
        """State and slot of each neighbor."""
        signs = [1 if bit else -1 for bit in (digit >> 1 & 1, digit & 1, digit >> 2 & 1)]
        found = []
        for step in NEIGHBORS:
            place = tuple(c + sign * s for c, sign, s in zip(child, signs, step))[::-1]
            is_inside = all(0 <= p < n for p, n in zip(place, self.slot.shape))
            found.append((int(self.state[place]), int(self.slot[place])) if is_inside
                         else (OUTSIDE, -1))
        return found

    @staticmethod
    def _equal(around, slot):
        return [(state, int(other == slot)) for state, other in around]

    def _put_other(self, digit, around, parent, own, others, wins, label):
        if self.is_pair:
            return 1 - parent
        slot = self.places.get(label)
        votes = {}
        for step, (state, other) in zip(NEIGHBORS, around):
            if state == OUTSIDE or other == parent:
                continue
            number = 2 if 2 in step or -2 in step else (12, 5, 3)[sum(map(abs, step)) - 1]
            votes[other] = votes.get(other, 0) + ((number + 1) // 2 if state == WAITING else number)
        candidates = [other for other in votes if not wins(others.get(other, 0) + own, other)]
        candidates.sort(key=lambda other: (-votes[other], other))
        for j, other in enumerate(candidates):
            share = 8 * votes[other] // sum(votes[c] for c in candidates[j:])
            self.coder.put(slot == other, self.model.chance(
                2, self._equal(around, other), 8 * min(j, 3) + min(share, 7),
                min(len(candidates) - 1 - j, 3)))
            if slot == other:
                return slot
        self.is_fresh.put(self.coder, slot is None)
        if slot is None:
            self._put_fresh(label)
            return self.places[label]
        self.coder.put_uniform(slot, len(self.slots))
        return slot


def stored(samples, smallest, has_list):
    """Section 2."""
    labels = np.unique(samples).tolist()
    data = varint(len(labels) if has_list else 0)
    if has_list:
        data += b"".join(varint(label - before - 1)
                         for label, before in zip(labels, [smallest - 1, *labels]))
        values = [labels.index(label) for label in samples.flat]
        most = len(labels) - 1
    else:
        values, most = samples.flat - np.int64(smallest), labels[-1] - smallest
    return data + pack(values, most.bit_length())


class LabelFile(File):
    """Of uint16, with a palette; bricks at `stored_at` of tier 0 are stored."""

    KIND, TYPE, DTYPE = 2, 4, "<u2"

    def __init__(self, voxels, masks, palette=(), stored_at=()):
        self.palette, self.stored_at, self.pyramids = list(palette), stored_at, {}
        super().__init__(voxels, masks)

    def analyze(self, brick, samples, steps, weights, count):
        self.pyramids[id(brick)] = Pyramid(samples, steps[:count], weights), count
        brick.root = int(self.pyramids[id(brick)][0].labels[-1].item())

    def code_all(self, bricks):
        model = Model(self.palette, 0)
        for number, brick in enumerate(bricks):
            if brick.is_uniform():
                continue
            pyramid, count = self.pyramids[id(brick)]
            if number in self.stored_at:
                data = stored(pyramid.labels[0], brick.smallest, number % 2 == 0)
                brick.segments = [data] + [b""] * (count - 1)
            else:
                brick.segments = BrickEncoder(model, pyramid).segments(count)
        return model.data
