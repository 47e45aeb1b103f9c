#include <algorithm>

#include "octavo/codec/label_codec.h"
#include "octavo/codec/label_walk.h"

namespace octavo {

namespace {

/// Reads the answers; knows no truth.
class DecodingIo {
 public:
  void attach(BinaryDecoder& coder) { coder_ = &coder; }

  bool ask(LabelAsk, bool, Probability yes) { return coder_->get(yes); }
  void observe(LabelAsk, const LabelQuestion&, bool) {}
  bool is_plain() const { return false; }
  bool is_pair() const { return false; }
  TrueSample truth(const Index3&) const { return {}; }
  void met(std::int64_t, std::uint32_t) {}

 private:
  BinaryDecoder* coder_ = nullptr;
};

template <class T>
void fill(const Size3& size, std::int64_t value, void* out) {
  std::fill_n(static_cast<T*>(out), size.voxel_count(), static_cast<T>(value));
}

template <class T>
void write_labels(const LabelGrid& grid, const std::vector<std::int64_t>& labels, void* out) {
  std::vector<T> value(labels.size());
  std::transform(labels.begin(), labels.end(), value.begin(),
                 [](std::int64_t label) { return static_cast<T>(label); });
  const Size3& size = grid.size();
  T* to = static_cast<T*>(out);
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      const LabelCell* row = grid.at({0, y, z});
      for (std::int64_t x = 0; x < size.x; ++x) *to++ = value[slot_of(row[x])];
    }
  }
}

void check(const BrickShape& shape, VoxelType type, const ValueRange& range,
           std::span<const ByteSpan> segments, int level) {
  check_label_shape(shape);
  if (level < 0 || level >= shape.level_count ||
      segments.size() != static_cast<std::size_t>(shape.level_count)) {
    throw Error(ErrorKind::invalid_argument, "a brick has one segment per level, found " +
                                                 std::to_string(segments.size()));
  }
  const ValueRange all = value_range(type);
  if (range.min > range.max || range.min < all.min || range.max > all.max) {
    throw Error(ErrorKind::corrupt, "brick: its range of labels does not fit its voxel type");
  }
}

}  // namespace

void LabelCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                        std::span<const ByteSpan> segments, int level, void* out) const {
  if (type != type_) {
    throw Error(ErrorKind::invalid_argument, "a label model was made for another voxel type");
  }
  check(shape, type, range, segments, level);
  if (range.min == range.max) {
    with_voxel_type(type, [&](auto t) {
      fill<typename decltype(t)::type>(shape.size[static_cast<std::size_t>(level)], range.min, out);
    });
    return;
  }
  DecodingIo io;
  LabelWalk<DecodingIo> walk(model_, range, io);
  LabelGrid grid({1, 1, 1});
  for (int i = shape.level_count - 1; i >= level; --i) {
    BinaryDecoder coder(segments[static_cast<std::size_t>(i)]);
    io.attach(coder);
    if (i == shape.level_count - 1) grid = walk.root();
    grid = walk.descend(grid, shape, i);
    if (!coder.is_consumed_short()) {
      throw Error(ErrorKind::corrupt, "brick: the length of level " + std::to_string(i) +
                                          " does not fit its labels");
    }
  }
  with_voxel_type(type, [&](auto t) {
    write_labels<typename decltype(t)::type>(grid, walk.labels(), out);
  });
}

std::unique_ptr<BrickCodec> parse_label_model(VoxelType type, ByteSpan bytes) {
  if (!is_integer(type)) throw Error(ErrorKind::corrupt, "a label model for float voxels");
  return std::make_unique<LabelCodec>(type, parse_label_weights(type, bytes));
}

}  // namespace octavo
