// The answers of a pyramid to a label walk: what the encoder and the training share.
#pragma once

#include <algorithm>
#include <vector>

#include "octavo/codec/label_octant.h"
#include "octavo/codec/label_pyramid.h"
#include "octavo/codec/label_walk.h"

namespace octavo {

class LabelTruth {
 public:
  /// Starts at the root.
  explicit LabelTruth(const LabelPyramid& pyramid)
      : pyramid_(pyramid),
        level_(&pyramid.root()),
        slot_of_rank_(pyramid.labels.size(), kNoLabelSlot) {}

  void enter(int level) { level_ = &pyramid_.levels[static_cast<std::size_t>(level)]; }

  bool is_pair() const { return pyramid_.labels.size() == 2; }

  TrueSample truth(const Index3& child) const {
    const std::size_t at = dense_offset(level_->size, child);
    const std::uint32_t rank = level_->rank[at];
    return {pyramid_.labels[rank], slot_of_rank_[rank], level_->is_uniform[at] != 0};
  }

  bool is_plain() const { return is_plain_; }
  void set_plain(bool is_plain) { is_plain_ = is_plain; }

  const std::vector<std::uint32_t>& slots() const { return slot_of_rank_; }
  void restore(const std::vector<std::uint32_t>& slots) { slot_of_rank_ = slots; }

  void met(std::int64_t label, std::uint32_t slot) {
    const auto& labels = pyramid_.labels;
    const auto rank = std::lower_bound(labels.begin(), labels.end(), label) - labels.begin();
    slot_of_rank_[static_cast<std::size_t>(rank)] = slot;
  }

 private:
  const LabelPyramid& pyramid_;
  const LabelPyramid::Level* level_;
  std::vector<std::uint32_t> slot_of_rank_;
  bool is_plain_ = false;
};

}  // namespace octavo
