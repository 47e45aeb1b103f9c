#include "octavo/codec/label/label_pyramid.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "octavo/codec/label/label_octant.h"

namespace octavo {

namespace {

void check(const BrickShape& shape, const BrickView& brick) {
  check_label_type(brick.type);
  check_label_shape(shape);
  if (!(brick.size == shape.size[0])) {
    throw Error(ErrorKind::invalid_argument, "the view of a brick has not the size of its shape");
  }
}

/// The distinct labels of a brick and, in `order_met`, the number of each voxel's label in the
/// order in which labels are first met. Open addressing; the table stays at most half full.
class LabelSet {
 public:
  LabelSet() : table_(64, kEmpty) {}

  std::uint32_t number_of(std::int64_t label) {
    std::size_t at = slot(label);
    if (table_[at] == kEmpty) {
      if (2 * (labels_.size() + 1) > table_.size()) {
        grow();
        at = slot(label);
      }
      table_[at] = static_cast<std::uint32_t>(labels_.size());
      labels_.push_back(label);
    }
    return table_[at];
  }

  const std::vector<std::int64_t>& labels() const { return labels_; }

 private:
  static constexpr std::uint32_t kEmpty = 0xffffffffu;

  std::size_t slot(std::int64_t label) const {
    const std::uint64_t hash = static_cast<std::uint64_t>(label) * 0x9e3779b97f4a7c15u;
    std::size_t at = static_cast<std::size_t>(hash >> 32) & (table_.size() - 1);
    while (table_[at] != kEmpty && labels_[table_[at]] != label) {
      at = (at + 1) & (table_.size() - 1);
    }
    return at;
  }

  void grow() {
    table_.assign(2 * table_.size(), kEmpty);
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      table_[slot(labels_[i])] = static_cast<std::uint32_t>(i);
    }
  }

  std::vector<std::uint32_t> table_;
  std::vector<std::int64_t> labels_;
};

template <class T>
void number_voxels(const BrickView& brick, LabelSet& set, std::vector<std::uint32_t>& numbers) {
  const T* voxels = static_cast<const T*>(brick.voxels);
  std::uint32_t* out = numbers.data();
  T last = voxels[0];
  std::uint32_t last_number = set.number_of(static_cast<std::int64_t>(last));
  for (std::int64_t z = 0; z < brick.size.z; ++z) {
    for (std::int64_t y = 0; y < brick.size.y; ++y) {
      const T* row = voxels + z * brick.plane_stride + y * brick.row_stride;
      for (std::int64_t x = 0; x < brick.size.x; ++x) {
        if (row[x] != last) {
          last = row[x];
          last_number = set.number_of(static_cast<std::int64_t>(last));
        }
        *out++ = last_number;
      }
    }
  }
}

/// Turns numbers in the order met into ranks in the order of the labels.
void rank_labels(const LabelSet& set, LabelPyramid& pyramid) {
  const std::vector<std::int64_t>& met = set.labels();
  pyramid.labels = met;
  std::sort(pyramid.labels.begin(), pyramid.labels.end());
  if (pyramid.labels == met) return;
  std::vector<std::uint32_t> rank_of(met.size());
  for (std::size_t i = 0; i < met.size(); ++i) {
    const auto at = std::lower_bound(pyramid.labels.begin(), pyramid.labels.end(), met[i]);
    rank_of[i] = static_cast<std::uint32_t>(at - pyramid.labels.begin());
  }
  for (std::uint32_t& rank : pyramid.levels[0].rank) rank = rank_of[rank];
}

/// The children of an octant, in the order of their digits.
struct Voters {
  std::array<std::uint32_t, 8> rank{};
  ChildWeights weight{};
  std::size_t count = 0;
};

/// The rank that most voxels below have; of those equally frequent, the smallest.
std::uint32_t vote(const Voters& voters) {
  std::uint32_t winner = voters.rank[0];
  std::int64_t most = 0;
  for (std::size_t i = 0; i < voters.count; ++i) {
    const std::uint32_t rank = voters.rank[i];
    std::int64_t votes = 0;
    for (std::size_t j = 0; j < voters.count; ++j) {
      if (voters.rank[j] == rank) votes += voters.weight[j];
    }
    if (votes > most || (votes == most && rank < winner)) {
      most = votes;
      winner = rank;
    }
  }
  return winner;
}

void condense_octant(const LabelPyramid::Level& fine, HalvingMask mask, const ChildWeights& weights,
                     const Index3& parent, std::uint32_t& rank, std::uint8_t& is_uniform) {
  Voters voters;
  bool is_one = true;
  for_each_child(fine.size, mask, parent, [&](int digit, const Index3& child) {
    const std::size_t at = dense_offset(fine.size, child);
    voters.rank[voters.count] = fine.rank[at];
    voters.weight[voters.count++] = weights[static_cast<std::size_t>(digit)];
    is_one = is_one && fine.is_uniform[at] != 0 && fine.rank[at] == voters.rank[0];
  });
  rank = is_one ? voters.rank[0] : vote(voters);
  is_uniform = is_one;
}

/// True when the 2x2x2 block at `at` is uniform with one label.
bool is_block_uniform(const LabelPyramid::Level& fine, std::size_t at) {
  const auto row = static_cast<std::size_t>(fine.size.x);
  const auto plane = row * static_cast<std::size_t>(fine.size.y);
  const std::uint32_t* rank = fine.rank.data() + at;
  const std::uint8_t* uniform = fine.is_uniform.data() + at;
  std::uint32_t differs = 0;
  std::uint32_t all = 1;
  for (const std::size_t i : {std::size_t{0}, row, plane, plane + row}) {
    differs |= (rank[i] ^ rank[0]) | (rank[i + 1] ^ rank[0]);
    all &= uniform[i] & uniform[i + 1];
  }
  return differs == 0 && all != 0;
}

}  // namespace

void condense_labels(const BrickShape& shape, int level, const LabelPyramid::Level& fine,
                     LabelPyramid::Level& coarse) {
  const HalvingMask mask = shape.halving[static_cast<std::size_t>(level)];
  const LevelWeights weights(shape, level);
  coarse.size = halved(fine.size, mask);
  const auto count = static_cast<std::size_t>(coarse.size.voxel_count());
  coarse.rank.resize(count);
  coarse.is_uniform.resize(count);
  std::size_t at = 0;
  for (std::int64_t z = 0; z < coarse.size.z; ++z) {
    for (std::int64_t y = 0; y < coarse.size.y; ++y) {
      for (std::int64_t x = 0; x < coarse.size.x; ++x, ++at) {
        const Index3 first = child_position(mask, {x, y, z}, 0);
        const bool is_block = mask == kHalveAll && first.x + 1 < fine.size.x &&
                              first.y + 1 < fine.size.y && first.z + 1 < fine.size.z;
        const std::size_t from = dense_offset(fine.size, first);
        if (is_block && is_block_uniform(fine, from)) {
          coarse.rank[at] = fine.rank[from];
          coarse.is_uniform[at] = 1;
        } else {
          condense_octant(fine, mask, weights.of({x, y, z}), {x, y, z}, coarse.rank[at],
                          coarse.is_uniform[at]);
        }
      }
    }
  }
}

LabelPyramid build_label_pyramid(const BrickShape& shape, const BrickView& brick) {
  check(shape, brick);
  LabelPyramid pyramid;
  LabelPyramid::Level& finest = pyramid.levels.emplace_back();
  finest.size = shape.size[0];
  const auto count = static_cast<std::size_t>(finest.size.voxel_count());
  finest.rank.resize(count);
  finest.is_uniform.assign(count, 1);
  LabelSet set;
  with_voxel_type(brick.type, [&](auto type) {
    using T = typename decltype(type)::type;
    number_voxels<T>(brick, set, finest.rank);
  });
  rank_labels(set, pyramid);
  for (int i = 0; i < shape.level_count; ++i) {
    LabelPyramid::Level coarse;
    condense_labels(shape, i, pyramid.levels.back(), coarse);
    pyramid.levels.push_back(std::move(coarse));
  }
  return pyramid;
}

}  // namespace octavo
