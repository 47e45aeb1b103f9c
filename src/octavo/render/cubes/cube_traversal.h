// The leaves of masks from the farthest to the nearest or the other way round, for any direction of
// view.
//
// Of the eight octants of a cube the farthest is the one whose bits are the complement of the signs
// of the view; its three face neighbors follow, then the three face neighbors of the nearest, then
// the nearest. The three of a group cannot hide each other.
//
//     farthest  000          order of octants (digits 4z + 2x + y), seen from (1, 1, 1):
//     next      001 010 100      0 | 1 2 4 | 3 5 6 | 7
//     then      011 101 110  and from anywhere else the same numbers with the bits of the axes
//     nearest   111          turned over along which the viewer stands on the low side
//
// The same order holds for the leaves: whatever hides a part of a leaf comes after it. Several
// masks that do not overlap are traversed side by side; a cube carries those masks only that are
// mixed in it, so that hundreds cost no more than what lies where they meet.
//
// Source  thesis 4.3
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/octree/mask_tree.h"
#include "octavo/octree/word_steps.h"
#include "octavo/render/view.h"

namespace octavo {

/// Rows of a picture that one traversal of the masks draws.
inline constexpr std::int64_t kBandRows = 64;

/// The eight octants from the farthest to the nearest; nearness as in View.
constexpr std::array<int, 8> octants_back_to_front(const std::array<int, 3>& nearness) noexcept {
  constexpr std::array<int, 8> kFromHighSide = {0, 1, 2, 4, 3, 5, 6, 7};
  const int turned =
      (nearness[0] < 0 ? 2 : 0) | (nearness[1] < 0 ? 1 : 0) | (nearness[2] < 0 ? 4 : 0);
  std::array<int, 8> order{};
  for (std::size_t i = 0; i < 8; ++i) order[i] = kFromHighSide[i] ^ turned;
  return order;
}

enum class TraversalOrder { farthest_first, nearest_first };

/// Takes every leaf of `masks` that a painter does not miss.
///
/// A painter has
///   bool misses(const Place& corner, int level)   whether nothing in this cube is wanted
///   void draw(std::size_t mask, const Place& corner, int level, unsigned faces)   takes a leaf
///
/// where corner is the place of the cube's lowest corner and 2^level its side. Bit a of `faces` is
/// 0 when nearer leaves cover all of the face that is turned to the viewer across axis a, as far as
/// that shows among the 64 children of one cube.
/// Requires masks of one size that do not overlap.
template <class Painter>
class CubeTraversal {
 public:
  CubeTraversal(std::span<const MaskTree* const> masks, const View& view, TraversalOrder order,
                Painter& painter)
      : masks_(masks),
        painter_(painter),
        nearness_(view.nearness),
        order_(octants_back_to_front(view.nearness)) {
    if (order == TraversalOrder::nearest_first) std::reverse(order_.begin(), order_.end());
    for (unsigned byte = 0; byte < 256; ++byte) {
      for (std::size_t i = 0; i < 8; ++i) {
        const unsigned is_set = byte >> order_[i] & 1;
        in_order_[byte] = static_cast<std::uint8_t>(in_order_[byte] | is_set << i);
      }
    }
    if (masks.empty()) return;
    const int rank_count = masks.front()->rank_count();
    for (int rank = -1; rank < rank_count; ++rank) {
      auto& children = children_.emplace_back();
      for (int bit = 0; bit < 64; ++bit) {
        const Index3 at = deinterleave(static_cast<std::uint64_t>(bit));
        const Place place = view.axes[0] * at.x + view.axes[1] * at.y + view.axes[2] * at.z;
        children[static_cast<std::size_t>(bit)] = place * child_side(rank);
      }
    }
    origin_ = view.origin;
  }

  void run() {
    if (masks_.empty()) return;
    const int rank = masks_.front()->rank_count() - 1;
    if (painter_.misses(origin_, level_of_children(rank) + 2)) return;
    for (std::size_t mask = 0; mask < masks_.size(); ++mask) {
      const MaskCube& root = masks_[mask]->root();
      if (root.is_full()) {
        painter_.draw(mask, origin_, level_of_children(rank) + 2, kAllFaces);
        return;
      }
      if (!root.is_empty()) mixed_.push_back({mask, 0});
    }
    visit_mixed(rank, 0, origin_);
  }

 private:
  /// A stored cube of a mask, or a word.
  struct Item {
    std::size_t mask;
    std::uint64_t place;
  };

  static constexpr unsigned kAllFaces = 7;

  /// By axis the children that none of the same cube covers from the viewer's side.
  struct BareFaces {
    std::array<std::uint64_t, 3> bits;

    unsigned of_child(int bit) const {
      return static_cast<unsigned>((bits[0] >> bit & 1) | (bits[1] >> bit & 1) << 1 |
                                   (bits[2] >> bit & 1) << 2);
    }
    unsigned of_octant(int octant) const {
      return (byte_of(bits[0], octant) != 0 ? 1u : 0u) | (byte_of(bits[1], octant) != 0 ? 2u : 0u) |
             (byte_of(bits[2], octant) != 0 ? 4u : 0u);
    }
  };

  BareFaces bare_faces(std::uint64_t full) const {
    BareFaces bare{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      if (nearness_[a] == 0) continue;
      bare.bits[a] = full & ~(nearness_[a] > 0 ? step_down(full, axis) : step_up(full, axis));
    }
    return bare;
  }

  static int level_of_children(int rank) { return 2 * (rank + 1); }
  static unsigned byte_of(std::uint64_t bits, int octant) {
    return static_cast<unsigned>(bits >> 8 * octant & 0xff);
  }
  const Place& child_place(int rank, int bit) const {
    return children_[static_cast<std::size_t>(rank + 1)][static_cast<std::size_t>(bit)];
  }
  const MaskCube& cube(int rank, const Item& item) const {
    return masks_[item.mask]->cubes(rank)[item.place];
  }

  /// Calls f(bit) for the children of an octant in the order of the traversal.
  template <class F>
  void for_each_in_order(unsigned byte, int octant, F f) {
    for (unsigned left = in_order_[byte]; left != 0; left &= left - 1) {
      f(8 * octant + order_[static_cast<std::size_t>(std::countr_zero(left))]);
    }
  }

  /// The items behind `first` on the stack, all of one cube. Takes them off.
  void visit_mixed(int rank, std::size_t first, const Place& corner) {
    if (mixed_.size() == first + 1) {
      const Item item = mixed_.back();
      if (rank < 0) {
        visit_word(item.mask, masks_[item.mask]->words()[item.place], corner);
      } else {
        visit_cube(item.mask, rank, cube(rank, item), corner);
      }
    } else if (mixed_.size() > first) {
      if (rank < 0) {
        visit_words(first, corner);
      } else {
        visit_cubes(rank, first, corner);
      }
    }
    mixed_.resize(first);
  }

  void visit_word(std::size_t mask, std::uint64_t word, const Place& corner) {
    const BareFaces bare = bare_faces(word);
    for (const int octant : order_) {
      const unsigned byte = byte_of(word, octant);
      if (byte == 0xff) {
        painter_.draw(mask, corner + child_place(-1, 8 * octant), 1, bare.of_octant(octant));
        continue;
      }
      for_each_in_order(byte, octant, [&](int bit) {
        painter_.draw(mask, corner + child_place(-1, bit), 0, bare.of_child(bit));
      });
    }
  }

  void visit_cube(std::size_t mask, int rank, const MaskCube& here, const Place& corner) {
    const int level = level_of_children(rank);
    const MaskTree& tree = *masks_[mask];
    const BareFaces bare = bare_faces(here.full);
    for (const int octant : order_) {
      const unsigned full = byte_of(here.full, octant);
      if (full == 0xff) {
        painter_.draw(mask, corner + child_place(rank, 8 * octant), level + 1,
                      bare.of_octant(octant));
        continue;
      }
      for_each_in_order(full | byte_of(here.mixed, octant), octant, [&](int bit) {
        const Place place = corner + child_place(rank, bit);
        if ((here.full >> bit & 1) != 0) {
          painter_.draw(mask, place, level, bare.of_child(bit));
        } else if (!painter_.misses(place, level)) {
          const std::uint64_t below = here.place_of(bit);
          if (rank == 0) {
            visit_word(mask, tree.words()[below], place);
          } else {
            visit_cube(mask, rank - 1, tree.cubes(rank - 1)[below], place);
          }
        }
      });
    }
  }

  void visit_words(std::size_t first, const Place& corner) {
    const std::size_t end = mixed_.size();
    const auto word = [&](std::size_t i) {
      return masks_[mixed_[i].mask]->words()[mixed_[i].place];
    };
    std::uint64_t all = 0;
    for (std::size_t i = first; i < end; ++i) all |= word(i);
    const BareFaces bare = bare_faces(all);
    for (const int octant : order_) {
      unsigned any = 0;
      std::size_t full = end;
      for (std::size_t i = first; i < end; ++i) {
        const unsigned byte = byte_of(word(i), octant);
        any |= byte;
        if (byte == 0xff) full = i;
      }
      if (full != end) {
        painter_.draw(mixed_[full].mask, corner + child_place(-1, 8 * octant), 1,
                      bare.of_octant(octant));
        continue;
      }
      for_each_in_order(any, octant, [&](int bit) {
        std::size_t owner = first;
        while ((word(owner) >> bit & 1) == 0) ++owner;
        painter_.draw(mixed_[owner].mask, corner + child_place(-1, bit), 0, bare.of_child(bit));
      });
    }
  }

  void visit_cubes(int rank, std::size_t first, const Place& corner) {
    const std::size_t end = mixed_.size();
    const int level = level_of_children(rank);
    std::uint64_t all = 0;
    for (std::size_t i = first; i < end; ++i) all |= cube(rank, mixed_[i]).full;
    const BareFaces bare = bare_faces(all);
    for (const int octant : order_) {
      unsigned any = 0;
      std::size_t full = end;
      for (std::size_t i = first; i < end; ++i) {
        const MaskCube& here = cube(rank, mixed_[i]);
        any |= byte_of(here.full | here.mixed, octant);
        if (byte_of(here.full, octant) == 0xff) full = i;
      }
      if (full != end) {
        painter_.draw(mixed_[full].mask, corner + child_place(rank, 8 * octant), level + 1,
                      bare.of_octant(octant));
        continue;
      }
      for_each_in_order(any, octant, [&](int bit) {
        visit_child(rank, first, end, bit, corner + child_place(rank, bit), bare.of_child(bit));
      });
    }
  }

  /// The child at `bit` of the cubes at [first, end) of the stack.
  void visit_child(int rank, std::size_t first, std::size_t end, int bit, const Place& place,
                   unsigned faces) {
    const int level = level_of_children(rank);
    bool is_missed = false;
    for (std::size_t i = first; i < end && !is_missed; ++i) {
      const MaskCube& here = cube(rank, mixed_[i]);
      if ((here.full >> bit & 1) != 0) {
        painter_.draw(mixed_[i].mask, place, level, faces);
        return;
      }
      if ((here.mixed >> bit & 1) == 0) continue;
      is_missed = painter_.misses(place, level);
      mixed_.push_back({mixed_[i].mask, here.place_of(bit)});
    }
    if (is_missed) mixed_.resize(end);
    visit_mixed(rank - 1, end, place);
  }

  std::span<const MaskTree* const> masks_;
  Painter& painter_;
  std::array<int, 3> nearness_;
  std::array<int, 8> order_;
  std::array<std::uint8_t, 256>
      in_order_{};  ///< the bits of a byte, moved into the order of the traversal
  std::vector<std::array<Place, 64>> children_;  ///< [rank + 1]: from the corner of the parent
  Place origin_;
  std::vector<Item> mixed_;  ///< a stack: the masks mixed in each cube on the way down
};

}  // namespace octavo
