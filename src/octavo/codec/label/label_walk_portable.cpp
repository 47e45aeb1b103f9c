#include "octavo/codec/label/label_portable.h"

namespace octavo {

namespace portable {

#include "octavo/codec/label/label_walk-inl.h"

}  // namespace portable

void LabelWork::start() {
  labels.clear();
  is_pair = false;
  is_fresh = AdaptiveBit();
  in_palette = AdaptiveBit(65000);
}

const LabelNeighborhood& LabelWork::neighborhood(int level) {
  const auto i = static_cast<std::size_t>(level);
  if (neighborhoods_.size() <= i) neighborhoods_.resize(i + 1);
  auto& [row_stride, plane_stride, offsets] = neighborhoods_[i];
  if (row_stride != grid.row_stride() || plane_stride != grid.plane_stride()) {
    row_stride = grid.row_stride();
    plane_stride = grid.plane_stride();
    offsets = label_neighborhood(row_stride, plane_stride);
  }
  return offsets;
}

LabelWork& thread_label_work() {
  thread_local LabelWork work;
  return work;
}

const LabelWalkFunctions& portable_label_walk_functions() {
  static constexpr LabelWalkFunctions kFunctions = {
      portable::decode_labels, portable::encode_labels, portable::observe_labels};
  return kFunctions;
}

}  // namespace octavo
