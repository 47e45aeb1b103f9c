#include "octavo/ops/label/missing_labels.h"

#include <algorithm>
#include <atomic>

#include "octavo/core/error.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// Looks for labels brick by brick.
class LabelSearch {
 public:
  LabelSearch(const FileReader& reader, int level, std::span<const std::int64_t> labels)
      : reader_(reader), level_(level), labels_(labels), is_found_(labels.size()) {}

  std::vector<std::int64_t> missing(const Progress& watcher) {
    std::vector<Index3> bricks;
    visit_cells(box_of(reader_.levels().size(level_)), brick_side_at(reader_.levels(), level_),
                [&](const Index3& brick) {
                  bricks.push_back(brick);
                  return true;
                });
    with_voxel_type(reader_.description().type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      PerThread<std::vector<T>> spaces;
      parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
        if (watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
        search<T>(bricks[i], spaces.local());
      });
    });
    std::vector<std::int64_t> left;
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      if (!is_found_[i]) left.push_back(labels_[i]);
    }
    return left;
  }

 private:
  template <class T>
  void search(const Index3& brick, std::vector<T>& voxels) {
    const ValueRange range = reader_.brick(Levels::tier_of(level_), brick).range;
    const auto lowest = static_cast<std::int64_t>(reader_.description().voxel_of(range.min));
    const auto highest = static_cast<std::int64_t>(reader_.description().voxel_of(range.max));
    const auto begin = std::lower_bound(labels_.begin(), labels_.end(), lowest);
    const auto end = std::upper_bound(begin, labels_.end(), highest);
    bool is_read = false;
    for (auto label = begin; label != end; ++label) {
      std::atomic<bool>& is_found = is_found_[static_cast<std::size_t>(label - labels_.begin())];
      if (is_found) continue;
      if (lowest != highest && !is_read) {
        const Box box = brick_box_at(reader_.levels(), level_, brick);
        voxels.resize(static_cast<std::size_t>(box.size().voxel_count()));
        reader_.read(box, level_, voxels.data());
        is_read = true;
      }
      if (!is_read || std::ranges::find(voxels, static_cast<T>(*label)) != voxels.end()) {
        is_found = true;
      }
    }
  }

  const FileReader& reader_;
  int level_;
  std::span<const std::int64_t> labels_;
  std::vector<std::atomic<bool>> is_found_;
};

}  // namespace

std::vector<std::int64_t> missing_labels(const FileReader& reader, int level,
                                         std::span<const std::int64_t> labels,
                                         const Progress& watcher) {
  return LabelSearch(reader, level, labels).missing(watcher);
}

}  // namespace octavo
