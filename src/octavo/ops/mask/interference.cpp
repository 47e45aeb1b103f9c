#include "octavo/ops/mask/interference.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/mask/neighborhood.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

void add(const VoxelExtent& from, VoxelExtent& to) {
  to.voxel_count += from.voxel_count;
  to.box = united(to.box, from.box);
}

// Adds 64 children of `side` voxels, of which those with set bits count.
void add_children(std::uint64_t bits, const Index3& corner, std::int64_t side, VoxelExtent& to) {
  if (bits == 0) return;
  to.voxel_count += static_cast<std::uint64_t>(std::popcount(bits)) *
                    static_cast<std::uint64_t>(side * side * side);
  to.box = united(to.box, box_of_children(bits, corner, side));
}

Interference sum(Interference a, const Interference& b) {
  add(b.overlap, a.overlap);
  add(b.contact_a, a.contact_a);
  add(b.contact_b, a.contact_b);
  for (std::size_t axis = 0; axis < 3; ++axis) a.face_pairs[axis] += b.face_pairs[axis];
  return a;
}

class Meeting {
 public:
  Meeting(const MaskTree& a, const MaskTree& b, Connectivity connectivity)
      : a_(a), b_(b), connectivity_(connectivity) {}

  Interference find() const {
    return meet(a_.rank_count() - 1, {0, 0, 0}, around_root(a_), around_root(b_));
  }

 private:
  // The centers of `a` and `b`, cubes of `rank` at `corner`.
  Interference meet(int rank, const Index3& corner, const CubesAround& a,
                    const CubesAround& b) const {
    // Children with voxels that may be in one of the masks alone.
    WordsAround alone_a;
    WordsAround alone_b;
    for (std::size_t i = 0; i < a.size(); ++i) {
      alone_a[i] = (a[i].full | a[i].mixed) & ~b[i].full;
      alone_b[i] = (b[i].full | b[i].mixed) & ~a[i].full;
    }
    const MaskCube& here_a = a[kCenter];
    const MaskCube& here_b = b[kCenter];
    const std::uint64_t shared = here_a.full & here_b.full;
    const std::uint64_t both = (here_a.full | here_a.mixed) & (here_b.full | here_b.mixed);
    const std::uint64_t entered = (both & ~shared) |
                                  (alone_a[kCenter] & touched_from(alone_b, connectivity_)) |
                                  (alone_b[kCenter] & touched_from(alone_a, connectivity_));
    const std::int64_t side = child_side(rank);
    Interference found;
    add_children(shared, corner, side, found.overlap);
    if (rank == 0) {
      for (std::uint64_t left = entered; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        meet_words(child_box(corner, bit, side).lo, words_around_child(a_, a, bit, connectivity_),
                   words_around_child(b_, b, bit, connectivity_), found);
      }
      return found;
    }
    const auto meet_child = [&](int bit) {
      return meet(rank - 1, child_box(corner, bit, side).lo,
                  cubes_around_child(a_, rank, a, bit, connectivity_),
                  cubes_around_child(b_, rank, b, bit, connectivity_));
    };
    // Cubes of 64^3 are work for one thread.
    if (rank == 1) {
      for (std::uint64_t left = entered; left != 0; left &= left - 1) {
        found = sum(found, meet_child(std::countr_zero(left)));
      }
      return found;
    }
    const Interference below = parallel_reduce(
        0, 64, 1, Interference(),
        [&](int begin, int end, Interference so_far) {
          for (int bit = begin; bit < end; ++bit) {
            if ((entered >> bit & 1) != 0) so_far = sum(so_far, meet_child(bit));
          }
          return so_far;
        },
        sum);
    return sum(found, below);
  }

  void meet_words(const Index3& corner, WordsAround a, WordsAround b, Interference& found) const {
    add_children(a[kCenter] & b[kCenter], corner, 1, found.overlap);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const std::uint64_t both = a[i] & b[i];
      a[i] &= ~both;
      b[i] &= ~both;
    }
    const std::uint64_t here_a = a[kCenter];
    const std::uint64_t here_b = b[kCenter];
    add_children(here_a & touched_from(b, connectivity_), corner, 1, found.contact_a);
    add_children(here_b & touched_from(a, connectivity_), corner, 1, found.contact_b);
    if (here_a == 0) return;
    for (int axis = 0; axis < 3; ++axis) {
      const int pairs = std::popcount(here_a & beside_along(b, axis, 1)) +
                        std::popcount(here_a & beside_along(b, axis, -1));
      found.face_pairs[static_cast<std::size_t>(axis)] += static_cast<std::uint64_t>(pairs);
    }
  }

  const MaskTree& a_;
  const MaskTree& b_;
  Connectivity connectivity_;
};

}  // namespace

Interference interference(const MaskTree& a, const MaskTree& b, Connectivity connectivity) {
  if (a.size() != b.size()) {
    throw Error(ErrorKind::invalid_argument, "masks of volumes that differ in size");
  }
  return Meeting(a, b, connectivity).find();
}

}  // namespace octavo
