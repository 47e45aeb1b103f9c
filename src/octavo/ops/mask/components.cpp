#include "octavo/ops/mask/components.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr const char* kSubject = "the components";

constexpr std::int64_t kGrain = 256;

// The children of a cube that touch others one step in `direction`: those at `from`, and where the
// others stand, by bit, in their own cube.
struct Touch {
  Direction direction;
  std::uint64_t from = 0;
  std::array<std::uint8_t, 64> to{};
};

// Where children touch inside one cube, or from one cube to the next in a direction.
class Touches {
 public:
  explicit Touches(Connectivity connectivity) {
    for (int i = 0; i < static_cast<int>(connectivity); ++i) {
      const Direction direction = kDirections[static_cast<std::size_t>(i)];
      for (int bit = 0; bit < 64; ++bit) add(bit, direction);
    }
  }

  /// Both ways round.
  const std::vector<Touch>& inside() const { return lists_[index({0, 0, 0})]; }
  const std::vector<Touch>& across(const Direction& border) const { return lists_[index(border)]; }

 private:
  static std::size_t index(const Direction& d) {
    return static_cast<std::size_t>(9 * (d.z + 1) + 3 * (d.y + 1) + d.x + 1);
  }
  static int side(std::int64_t at) { return at < 0 ? -1 : at > 3 ? 1 : 0; }

  void add(int bit, const Direction& direction) {
    const Index3 at = deinterleave(static_cast<std::uint64_t>(bit));
    const Index3 to{at.x + direction.x, at.y + direction.y, at.z + direction.z};
    std::vector<Touch>& list = lists_[index({side(to.x), side(to.y), side(to.z)})];
    if (list.empty() || list.back().direction != direction) list.push_back({direction});
    list.back().from |= std::uint64_t{1} << bit;
    list.back().to[static_cast<std::size_t>(bit)] =
        static_cast<std::uint8_t>(interleave({to.x & 3, to.y & 3, to.z & 3}));
  }

  std::array<std::vector<Touch>, 27> lists_;
};

// A word one step in `direction`; what leaves it on one side comes back on the other.
std::uint64_t turned(std::uint64_t word, const Direction& direction) {
  const std::array<int, 3> steps = {direction.x, direction.y, direction.z};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (steps[a] > 0) {
      word = step_up(word, axis) | (word & slab_of(axis, 3)) >> word_detail::kWhole[a];
    } else if (steps[a] < 0) {
      word = step_down(word, axis) | (word & slab_of(axis, 0)) << word_detail::kWhole[a];
    }
  }
  return word;
}

// Calls visit(bit, bit of the other) where a child out of `from` touches one out of `to`, which are
// turned back already.
template <class Visit>
void for_each_touch(const Touch& touch, std::uint64_t from, std::uint64_t to, Visit visit) {
  for (std::uint64_t left = from & to & touch.from; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    visit(bit, static_cast<int>(touch.to[static_cast<std::size_t>(bit)]));
  }
}

// The bits on the border of a word in a direction.
std::uint64_t border_of(const Direction& direction) {
  const std::array<int, 3> steps = {direction.x, direction.y, direction.z};
  std::uint64_t border = kFullWord;
  for (int axis = 0; axis < 3; ++axis) {
    const int step = steps[static_cast<std::size_t>(axis)];
    if (step != 0) border &= slab_of(axis, step > 0 ? 3 : 0);
  }
  return border;
}

// The parts of a word, the one with its lowest bit first.
template <class Take>
void for_each_part(std::uint64_t word, Connectivity connectivity, Take take) {
  while (word != 0) {
    const std::uint64_t part = flood(word, word & (~word + 1), connectivity);
    take(part);
    word &= ~part;
  }
}

template <class F>
void in_parallel(std::size_t count, F&& f, std::int64_t grain = kGrain) {
  parallel_parts(std::size_t{0}, count, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

}  // namespace

// Joins parts that touch. Links only ever lead to smaller numbers, so that the smallest part of a
// component is its root whatever the order of the joins.
class Components::Linker {
 public:
  explicit Linker(Components& all)
      : all_(all), mask_(all.mask_), connectivity_(all.connectivity_), touches_(connectivity_) {
    all_.labels_.resize(all_.parts_.size());
    std::iota(all_.labels_.begin(), all_.labels_.end(), 0);
  }

  void link_all() {
    for (int rank = 0; rank < mask_.rank_count(); ++rank) {
      // All that touches across the borders of their children: of large cubes a few are much work.
      in_parallel(
          mask_.cubes(rank).size(), [&](std::size_t place) { link_inside(rank, place); },
          rank == 0 ? kGrain : 1);
    }
  }

 private:
  // A stored item: a cube, or a word at rank -1.
  struct Item {
    int rank;
    std::uint64_t place;
  };

  const MaskCube& cube(const Item& item) const {
    return mask_.cubes(item.rank)[item.place];
  }
  Item child(const Item& item, int bit) const {
    return {item.rank - 1, cube(item).place_of(bit)};
  }
  std::uint32_t full_part(const Item& item, int bit) const {
    return all_.part_at(item.rank, item.place, bit);
  }

  void link_inside(int rank, std::uint64_t place) {
    const Item item{rank, place};
    const MaskCube here = cube(item);
    if (here.mixed == 0) return;
    for (const Touch& touch : touches_.inside()) {
      const Direction back = touch.direction.reversed();
      for_each_touch(touch, here.mixed, turned(here.full, back), [&](int from, int to) {
        join_full(full_part(item, to), child(item, from), touch.direction);
      });
      if (!touch.direction.is_forward()) continue;
      for_each_touch(touch, here.mixed, turned(here.mixed, back), [&](int from, int to) {
        link(child(item, from), child(item, to), touch.direction);
      });
    }
  }

  // `b` lies beside `a` in `direction`; both have the same rank.
  void link(const Item& a, const Item& b, const Direction& direction) {
    if (a.rank < 0) {
      link_words(a, b, direction);
      return;
    }
    const MaskCube in_a = cube(a);
    const MaskCube in_b = cube(b);
    for (const Touch& touch : touches_.across(direction)) {
      const Direction back = touch.direction.reversed();
      const std::uint64_t full_b = turned(in_b.full, back);
      const std::uint64_t mixed_b = turned(in_b.mixed, back);
      for_each_touch(touch, in_a.full, full_b, [&](int from, int to) {
        join(full_part(a, from), full_part(b, to));
      });
      for_each_touch(touch, in_a.full, mixed_b, [&](int from, int to) {
        join_full(full_part(a, from), child(b, to), back);
      });
      for_each_touch(touch, in_a.mixed, full_b, [&](int from, int to) {
        join_full(full_part(b, to), child(a, from), touch.direction);
      });
      for_each_touch(touch, in_a.mixed, mixed_b, [&](int from, int to) {
        link(child(a, from), child(b, to), touch.direction);
      });
    }
  }

  void link_words(const Item& a, const Item& b, const Direction& direction) {
    for (std::uint32_t in_a = begin(a); in_a < end(a); ++in_a) {
      std::uint64_t beyond = 0;  // is not asked for where all are joined already, as most are
      bool has_beyond = false;
      for (std::uint32_t in_b = begin(b); in_b < end(b); ++in_b) {
        if (is_linked(in_a, in_b)) continue;
        if (!std::exchange(has_beyond, true)) {
          beyond = touched_beyond(all_.parts_[in_a], direction, connectivity_);
        }
        if ((beyond & all_.parts_[in_b]) != 0) join(in_a, in_b);
      }
    }
  }

  // What lies beside `item` in `direction` is full and belongs to `part`.
  void join_full(std::uint32_t part, const Item& item, const Direction& direction) {
    const std::uint64_t border = border_of(direction);
    for (std::uint32_t own = begin(item); own < end(item); ++own) {
      if ((all_.parts_[own] & border) != 0) join(part, own);
    }
    if (item.rank < 0) return;
    for (std::uint64_t left = cube(item).mixed & border; left != 0; left &= left - 1) {
      join_full(part, child(item, std::countr_zero(left)), direction);
    }
  }

  std::uint32_t begin(const Item& item) const { return all_.first_part(item.rank, item.place); }
  std::uint32_t end(const Item& item) const { return all_.first_part(item.rank, item.place + 1); }

  std::uint32_t root_of(std::uint32_t part) {
    for (;;) {
      const std::uint32_t next = link_of(part).load(std::memory_order_relaxed);
      if (next == part) return part;
      const std::uint32_t after = link_of(next).load(std::memory_order_relaxed);
      // Shortens the way for the next one; a link that became smaller meanwhile is left alone.
      std::uint32_t seen = next;
      if (after != next)
        link_of(part).compare_exchange_weak(seen, after, std::memory_order_relaxed);
      part = after;
    }
  }

  void join(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = root_of(a);
      b = root_of(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      std::uint32_t seen = a;
      if (link_of(a).compare_exchange_strong(seen, b, std::memory_order_relaxed)) return;
    }
  }

  // Whether links of two parts lead to the same one. They may be joined without it.
  bool is_linked(std::uint32_t a, std::uint32_t b) {
    return link_of(a).load(std::memory_order_relaxed) == link_of(b).load(std::memory_order_relaxed);
  }

  std::atomic_ref<std::uint32_t> link_of(std::uint32_t part) {
    return std::atomic_ref(all_.labels_[part]);
  }

  Components& all_;
  const MaskTree& mask_;
  Connectivity connectivity_;
  Touches touches_;
};

// Sums over the parts of every component, in a traversal of the tree.
class Components::Census {
 public:
  explicit Census(Components& all) : all_(all) {}

  void take(std::uint64_t max_bytes) {
    count_roots(max_bytes);
    number_roots();
    const MaskTree& mask = all_.mask_;
    visit(mask.rank_count() - 1, 0, 0);
    for (Tally& tally : tallies_) {
      tally.component.centroid = tally.sums.centroid(tally.component.voxel_count);
    }
    sort();
  }

 private:
  struct Tally {
    Component component;
    ComponentSums sums;
  };

  // Before there is a tally for each.
  void count_roots(std::uint64_t max_bytes) {
    std::uint64_t count = 0;
    for (std::uint32_t part = 0; part < all_.labels_.size(); ++part) {
      count += all_.labels_[part] == part ? 1u : 0u;
    }
    // Those of the result, those that are counted, and their order.
    constexpr std::uint64_t kBytes = sizeof(Component) + sizeof(ComponentSums) + sizeof(Tally) +
                                     2 * sizeof(std::uint32_t);
    require_memory_within(all_.memory_bytes() + count * kBytes, max_bytes, kSubject);
    tallies_.reserve(count);
    all_.components_.reserve(count);
    all_.sums_.reserve(count);
  }

  // A part's link leads to a smaller one, which has its number by then.
  void number_roots() {
    for (std::uint32_t part = 0; part < all_.labels_.size(); ++part) {
      std::uint32_t& link = all_.labels_[part];
      if (link == part) {
        link = static_cast<std::uint32_t>(tallies_.size());
        tallies_.emplace_back();
      } else {
        link = all_.labels_[link];
      }
    }
  }

  void visit(int rank, std::uint64_t place, std::uint64_t code) {
    add_parts(rank, place, code);
    if (rank < 0) return;
    const MaskCube& cube = all_.mask_.cubes(rank)[place];
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      visit(rank - 1, cube.place_of(bit), code << 6 | static_cast<std::uint64_t>(bit));
    }
  }

  void add_parts(int rank, std::uint64_t place, std::uint64_t code) {
    const std::uint32_t end = all_.first_part(rank, place + 1);
    for (std::uint32_t i = all_.first_part(rank, place); i < end; ++i) {
      add(all_.parts_[i], rank, code, tallies_[all_.labels_[i]]);
    }
  }

  // The children of an item at `code` that are in `part`.
  static void add(std::uint64_t part, int rank, std::uint64_t code, Tally& tally) {
    const int shift = 2 * (rank + 1);
    const Index3 corner = corner_of({shift + 2, code});
    const auto count = static_cast<std::uint64_t>(std::popcount(part));
    const std::uint64_t volume = std::uint64_t{1} << 3 * shift;
    Component& to = tally.component;
    const bool is_first = to.voxel_count == 0;
    to.voxel_count += count * volume;
    const auto low_bit = static_cast<std::uint64_t>(std::countr_zero(part));
    ComponentSums& sums = tally.sums;
    sums.first_code = std::min(sums.first_code, (code << 6 | low_bit) << 3 * shift);
    const std::int64_t side = std::int64_t{4} << shift;
    const Box all{corner, {corner.x + side, corner.y + side, corner.z + side}};
    if (is_first || !to.box.contains(all)) add_to_box(part, shift, corner, is_first, to.box);
    for (int axis = 0; axis < 3; ++axis) {
      // Steps of the children from the corner: one at 1 and 3, two more at 2 and 3
      const std::uint64_t odd = slab_of(axis, 1) | slab_of(axis, 3);
      const std::uint64_t high = slab_of(axis, 2) | slab_of(axis, 3);
      const std::int64_t steps = std::popcount(part & odd) + 2 * std::popcount(part & high);
      // Of one voxel at the middle of all children, and of all voxels
      const std::int64_t ends = 2 * corner[axis] + (std::int64_t{1} << shift) - 1;
      const std::int64_t of_children =
          static_cast<std::int64_t>(count) * ends + 2 * (steps << shift);
      sums.doubled[static_cast<std::size_t>(axis)] += static_cast<__int128>(of_children) *
                                                      static_cast<__int128>(volume);
    }
  }

  static void add_to_box(std::uint64_t part, int shift, const Index3& corner, bool is_first,
                         Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
      int lowest = 0;
      int highest = 3;
      while ((part & slab_of(axis, lowest)) == 0) ++lowest;
      while ((part & slab_of(axis, highest)) == 0) --highest;
      const std::int64_t lo = corner[axis] + (std::int64_t{lowest} << shift);
      const std::int64_t hi = corner[axis] + ((std::int64_t{highest} + 1) << shift);
      box.lo[axis] = is_first ? lo : std::min(box.lo[axis], lo);
      box.hi[axis] = is_first ? hi : std::max(box.hi[axis], hi);
    }
  }

  void sort() {
    std::vector<std::uint32_t> order(tallies_.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const std::uint64_t of_a = tallies_[a].component.voxel_count;
      const std::uint64_t of_b = tallies_[b].component.voxel_count;
      return of_a != of_b ? of_a > of_b : tallies_[a].sums.first_code < tallies_[b].sums.first_code;
    });
    std::vector<std::uint32_t> label_of(order.size());
    for (std::uint32_t place = 0; place < order.size(); ++place) {
      label_of[order[place]] = place + 1;
      all_.components_.push_back(tallies_[order[place]].component);
      all_.sums_.push_back(tallies_[order[place]].sums);
    }
    for (std::uint32_t& label : all_.labels_) label = label_of[label];
  }

  Components& all_;
  std::vector<Tally> tallies_;
};

Components::Components(const MaskTree& mask, Connectivity connectivity, std::uint64_t max_bytes)
    : mask_(mask), connectivity_(connectivity) {
  find_parts(max_bytes);
  Linker(*this).link_all();
  Census(*this).take(max_bytes);
}

std::uint64_t Components::memory_bytes() const noexcept {
  std::uint64_t bytes = parts_.capacity() * sizeof(std::uint64_t) +
                        labels_.capacity() * sizeof(std::uint32_t) +
                        components_.capacity() * sizeof(Component) +
                        sums_.capacity() * sizeof(ComponentSums);
  for (const auto& firsts : first_parts_) bytes += firsts.capacity() * sizeof(std::uint32_t);
  return bytes;
}

void Components::find_parts(std::uint64_t max_bytes) {
  const auto bits_at = [&](std::size_t list, std::size_t place) {
    return list == 0 ? mask_.words()[place] : mask_.cubes(static_cast<int>(list) - 1)[place].full;
  };
  std::uint64_t part_count = 0;
  first_parts_.resize(static_cast<std::size_t>(mask_.rank_count()) + 1);
  for (std::size_t list = 0; list < first_parts_.size(); ++list) {
    std::vector<std::uint32_t>& firsts = first_parts_[list];
    const std::size_t count =
        list == 0 ? mask_.words().size() : mask_.cubes(static_cast<int>(list) - 1).size();
    firsts.resize(count + 1);
    in_parallel(count, [&](std::size_t place) {
      for_each_part(bits_at(list, place), connectivity_, [&](std::uint64_t) { ++firsts[place]; });
    });
    for (std::uint32_t& first : firsts) {
      const std::uint64_t own = first;
      first = static_cast<std::uint32_t>(part_count);
      part_count += own;
    }
    if (part_count > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(ErrorKind::limit_exceeded, "the mask falls into more than 2^32 pieces");
    }
  }
  require_memory_within(memory_bytes() + part_count * (sizeof(std::uint64_t) +
                                                       sizeof(std::uint32_t)),
                        max_bytes, kSubject);
  parts_.resize(part_count);
  for (std::size_t list = 0; list < first_parts_.size(); ++list) {
    const std::vector<std::uint32_t>& firsts = first_parts_[list];
    in_parallel(firsts.size() - 1, [&](std::size_t place) {
      std::uint32_t next = firsts[place];
      const std::uint64_t bits = bits_at(list, place);
      if (firsts[place + 1] - next == 1) {
        parts_[next] = bits;
        return;
      }
      for_each_part(bits, connectivity_, [&](std::uint64_t part) { parts_[next++] = part; });
    });
  }
}

std::uint32_t Components::part_at(int rank, std::uint64_t place, int bit) const noexcept {
  std::uint32_t part = first_part(rank, place);
  while ((parts_[part] >> bit & 1) == 0) ++part;
  return part;
}

std::uint32_t Components::label_of(const Index3& voxel) const noexcept {
  if (!mask_.contains(voxel)) return 0;
  const std::uint64_t code = interleave(voxel);
  std::uint64_t place = 0;
  for (int rank = mask_.rank_count() - 1; rank >= 0; --rank) {
    const auto bit = static_cast<int>(code >> 6 * (rank + 1) & 63);
    const MaskCube& cube = mask_.cubes(rank)[place];
    if ((cube.full >> bit & 1) != 0) return labels_[part_at(rank, place, bit)];
    place = cube.place_of(bit);
  }
  return labels_[part_at(-1, place, static_cast<int>(code & 63))];
}

// Copies the tree without the parts that are not kept.
class Components::Selection {
 public:
  Selection(const Components& all, const std::vector<bool>& keep)
      : all_(all), keep_(keep), out_(arrays_below(all.mask_.rank_count())) {}

  MaskTree make() {
    const MaskCube root = cube(all_.mask_.rank_count() - 1, 0);
    out_.cubes.back().push_back(root);
    return {all_.mask_.size(), std::move(out_)};
  }

 private:
  std::uint64_t kept_bits(int rank, std::uint64_t place) const {
    std::uint64_t kept = 0;
    all_.visit_parts(rank, place, [&](std::uint32_t label, std::uint64_t bits) {
      if (keep_[label - 1]) kept |= bits;
    });
    return kept;
  }

  MaskCube cube(int rank, std::uint64_t place) {
    const MaskCube& from = all_.mask_.cubes(rank)[place];
    if (rank == 0) {
      WordCube words;
      for (std::uint64_t left = from.mixed; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        words.add(bit, kept_bits(-1, from.place_of(bit)));
      }
      MaskCube made = words.finish(out_.words);
      made.full |= kept_bits(0, place);
      return made;
    }
    std::vector<MaskCube>& below = out_.cubes[static_cast<std::size_t>(rank) - 1];
    MaskCube made{kept_bits(rank, place), 0, below.size()};
    for (std::uint64_t left = from.mixed; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const MaskCube child = cube(rank - 1, from.place_of(bit));
      add_child(child, bit, made, below);
    }
    return made;
  }

  const Components& all_;
  const std::vector<bool>& keep_;
  MaskArrays out_;
};

MaskTree Components::select(const std::vector<bool>& keep) const {
  return Selection(*this, keep).make();
}

void Components::fill_labels(const Box& box, std::uint32_t* labels) const {
  std::fill_n(labels, box.size().voxel_count(), 0);
  visit_items(mask_, box, [&](int rank, std::uint64_t place, const Index3& corner) {
    visit_parts(rank, place, [&](std::uint32_t label, std::uint64_t bits) {
      fill_children(bits, rank, corner, box, label, labels);
    });
  });
}

}  // namespace octavo
