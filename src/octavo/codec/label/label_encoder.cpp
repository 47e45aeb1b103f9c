#include "octavo/codec/label/label_codec.h"
#include "octavo/codec/label/label_octant.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label/label_stored.h"
#include "octavo/codec/label/label_walk.h"
#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

std::uint64_t total_bytes(const std::vector<Bytes>& segments) {
  std::uint64_t total = 0;
  for (const Bytes& segment : segments) total += segment.size();
  return total;
}

/// A single level is never stored: its last segment is its only one.
bool is_storable(const BrickShape& shape) { return shape.level_count > 1; }

// The pyramid of this thread's last brick of words.
LabelPyramid& thread_pyramid() {
  thread_local LabelPyramid pyramid;
  return pyramid;
}

void check_labels(const LabelWords& words, VoxelType type) {
  const ValueRange all = value_range(type);
  if (!words.labels.empty() && words.labels.front() >= all.min && words.labels.back() <= all.max) {
    return;
  }
  throw Error(ErrorKind::invalid_argument, "a label that the voxel type does not have");
}

}  // namespace

template <class Complete>
EncodedBrick LabelCodec::encode_pyramid(const BrickShape& shape, LabelPyramid& pyramid,
                                        Complete complete) const {
  EncodedBrick result;
  result.range = {pyramid.labels.front(), pyramid.labels.back()};
  result.parent = pyramid.labels[pyramid.root().rank[0]];
  result.segments.resize(static_cast<std::size_t>(shape.level_count));
  if (pyramid.is_uniform()) return result;

  const bool is_codable = pyramid.labels.size() <= kMaxLabelSlots;
  if (is_codable) {
    label_walk_functions().encode(model_, shape, pyramid, result.segments, thread_label_work());
    // An empty last segment would say that the brick is stored; a decoder allows for zeros.
    if (result.segments.back().empty()) result.segments.back().push_back(0);
  }
  if (is_storable(shape) &&
      (!is_codable || total_bytes(result.segments) > stored_label_bytes(pyramid))) {
    for (Bytes& segment : result.segments) segment.clear();
    complete(pyramid);
    result.segments[0] = encode_stored_labels(pyramid);
  }
  return result;
}

EncodedBrick LabelCodec::encode(const BrickShape& shape, const BrickView& brick) const {
  if (brick.type != type_) {
    throw Error(ErrorKind::invalid_argument, "a label model was made for another voxel type");
  }
  LabelPyramid pyramid = build_label_pyramid(shape, brick);
  return encode_pyramid(shape, pyramid, [](LabelPyramid&) {});
}

EncodedBrick LabelCodec::encode_words(const BrickShape& shape, const LabelWords& words) const {
  check_labels(words, type_);
  if (words.is_uniform()) {
    check_label_shape(shape);
    EncodedBrick result;
    result.range = {words.labels.front(), words.labels.front()};
    result.parent = words.labels.front();
    result.segments.resize(static_cast<std::size_t>(shape.level_count));
    return result;
  }
  LabelPyramid& pyramid = thread_pyramid();
  build_label_pyramid(shape, words, pyramid);
  return encode_pyramid(shape, pyramid,
                        [&](LabelPyramid& made) { complete_voxels(words, made); });
}

const LabelBrickCodec& as_label_codec(const BrickCodec& codec) {
  if (const auto* const labels = dynamic_cast<const LabelBrickCodec*>(&codec)) return *labels;
  throw Error(ErrorKind::invalid_argument, "a codec of grey values, not of labels");
}

}  // namespace octavo
