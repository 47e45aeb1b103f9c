#include "octavo/ops/label/label_adjacency.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/label/label_block.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

struct Counts {
  std::array<std::uint64_t, 3> face_pairs{};
  std::uint64_t voxel_pairs = 0;
};

using CountsByPair = std::map<std::pair<std::int64_t, std::int64_t>, Counts>;

// A pair that is met often in a row is looked up once.
class PairCounter {
 public:
  explicit PairCounter(CountsByPair& counts) : counts_(counts) {}

  Counts& of(std::int64_t a, std::int64_t b) {
    const auto [first, second] = std::minmax(a, b);
    if (last_ == nullptr || first != first_ || second != second_) {
      last_ = &counts_[{first, second}];
      first_ = first;
      second_ = second;
    }
    return *last_;
  }

 private:
  CountsByPair& counts_;
  Counts* last_ = nullptr;
  std::int64_t first_ = 0;
  std::int64_t second_ = 0;
};

class Adjacency {
 public:
  Adjacency(const FileReader& labels, Connectivity connectivity)
      : labels_(labels),
        connectivity_(connectivity),
        grid_(labels.levels().brick_grid(0)) {}

  void count_brick(const Index3& brick, CountsByPair& counts) const {
    if (is_settled(brick)) return;
    const Box box = labels_.levels().brick_box(0, brick);
    LabelBlock block(labels_, box);
    PairCounter counter(counts);
    for (std::size_t i = 0; i < static_cast<std::size_t>(connectivity_); ++i) {
      if (kDirections[i].is_forward()) count_along(kDirections[i], box.size(), block, counter);
    }
  }

 private:
  std::optional<std::int64_t> single_label(const Index3& brick) const {
    const BrickEntry entry = labels_.brick(0, brick);
    if (!entry.is_uniform()) return std::nullopt;
    return entry.range.min;
  }

  // Whether the index tells that no voxel of a brick has another label in front of it.
  bool is_settled(const Index3& brick) const {
    const auto label = single_label(brick);
    if (!label) return false;
    if (*label == 0) return true;
    for (std::size_t i = 0; i < static_cast<std::size_t>(connectivity_); ++i) {
      const Direction& d = kDirections[i];
      const Index3 beside{brick.x + d.x, brick.y + d.y, brick.z + d.z};
      if (!box_of(grid_).contains(beside)) continue;
      const auto other = single_label(beside);
      if (other != label && other != 0) return false;
    }
    return true;
  }

  // The voxels of a block against those one step in `direction`, row by row.
  static void count_along(const Direction& direction, const Size3& size, LabelBlock& block,
                          PairCounter& counter) {
    const std::int64_t step = block.step_to(direction);
    const int axis = direction.x != 0 ? 0 : direction.y != 0 ? 1 : 2;
    const bool is_face = direction.x * direction.x + direction.y * direction.y +
                             direction.z * direction.z == 1;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        const std::int64_t* const here = block.row(y, z);
        for (std::int64_t x = 0; x < size.x; ++x) {
          const std::int64_t a = here[x];
          const std::int64_t b = here[x + step];
          if (a == b || a == 0 || b == 0 || b == LabelBlock::kOutside) continue;
          Counts& counts = counter.of(a, b);
          ++counts.voxel_pairs;
          if (is_face) ++counts.face_pairs[static_cast<std::size_t>(axis)];
        }
      }
    }
  }

  const FileReader& labels_;
  Connectivity connectivity_;
  Size3 grid_;
};

}  // namespace

std::vector<LabelContact> label_contacts(const FileReader& labels, Connectivity connectivity,
                                         Progress& progress) {
  if (labels.description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, not labels",
                labels.source().name());
  }
  const Adjacency adjacency(labels, connectivity);
  const Size3 grid = labels.levels().brick_grid(0);
  const ProgressScope scope(progress, "touch", grid.voxel_count(), "bricks");
  PerThread<CountsByPair> of_threads;
  parallel_for(std::int64_t{0}, grid.voxel_count(), [&](std::int64_t i) {
    if (progress.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while comparing labels");
    }
    adjacency.count_brick({i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)},
                          of_threads.local());
    progress.advance(1);
  });
  CountsByPair all;
  for (const CountsByPair& counts : of_threads) {
    for (const auto& [pair, from] : counts) {
      Counts& to = all[pair];
      to.voxel_pairs += from.voxel_pairs;
      for (std::size_t axis = 0; axis < 3; ++axis) to.face_pairs[axis] += from.face_pairs[axis];
    }
  }
  std::vector<LabelContact> contacts;
  contacts.reserve(all.size());
  for (const auto& [pair, counts] : all) {
    contacts.push_back({pair.first, pair.second, counts.face_pairs, counts.voxel_pairs});
  }
  return contacts;
}

}  // namespace octavo
