#include "octavo/codec/label/label_codec.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label/label_stored.h"
#include "octavo/codec/label/label_walk.h"

namespace octavo {

namespace {

std::uint64_t total_bytes(const std::vector<Bytes>& segments) {
  std::uint64_t total = 0;
  for (const Bytes& segment : segments) total += segment.size();
  return total;
}

/// A single level is never stored: its last segment is its only one.
bool is_storable(const BrickShape& shape) { return shape.level_count > 1; }

}  // namespace

EncodedBrick LabelCodec::encode(const BrickShape& shape, const BrickView& brick) const {
  if (brick.type != type_) {
    throw Error(ErrorKind::invalid_argument, "a label model was made for another voxel type");
  }
  const LabelPyramid pyramid = build_label_pyramid(shape, brick);
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
    result.segments[0] = encode_stored_labels(pyramid);
  }
  return result;
}

}  // namespace octavo
