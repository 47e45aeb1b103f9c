#include "octavo/codec/label_codec.h"
#include "octavo/codec/label_pyramid.h"
#include "octavo/codec/label_truth.h"
#include "octavo/codec/label_walk.h"

namespace octavo {

namespace {

/// Writes what the pyramid says, one segment after the other.
class EncodingIo : public LabelTruth {
 public:
  explicit EncodingIo(const LabelPyramid& pyramid) : LabelTruth(pyramid) {}

  void attach(BinaryEncoder& coder) { coder_ = &coder; }

  bool ask(LabelAsk, bool truth, Probability yes) {
    coder_->put(truth, yes);
    return truth;
  }
  void observe(LabelAsk, const LabelQuestion&, bool) {}

 private:
  BinaryEncoder* coder_ = nullptr;
};

using Walk = LabelWalk<EncodingIo>;

/// Level `level`, below its root when it is the last, as one segment.
Bytes encode_level(Walk& walk, EncodingIo& io, const BrickShape& shape, int level, bool is_plain,
                   LabelGrid& grid) {
  Bytes bytes;
  BinaryEncoder coder(bytes);
  io.attach(coder);
  io.set_plain(is_plain);
  if (level == shape.level_count - 1) {
    io.enter(shape.level_count);
    grid = walk.root();
  }
  io.enter(level);
  grid = walk.descend(grid, shape, level);
  coder.finish_short();
  return bytes;
}

/// More bytes per sample than a level of regions ever has: such a level is also tried plain.
bool is_noisy(const Bytes& bytes, const Size3& size) {
  return 4 * static_cast<std::int64_t>(bytes.size()) > size.voxel_count();
}

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

  EncodingIo io(pyramid);
  Walk walk(model_, result.range, io);
  LabelGrid grid({1, 1, 1});
  for (int level = shape.level_count - 1; level >= 0; --level) {
    const auto i = static_cast<std::size_t>(level);
    const Walk::State state = walk.state();
    const std::vector<std::uint32_t> slots = io.slots();
    const LabelGrid parents = grid;
    Bytes& bytes = result.segments[i];
    bytes = encode_level(walk, io, shape, level, false, grid);
    if (!is_noisy(bytes, shape.size[i])) continue;
    // Take the level back, code it plain, and keep the shorter.
    for (const bool is_plain : {true, false}) {
      walk.restore(level == shape.level_count - 1 ? Walk::State{} : state);
      io.restore(slots);
      grid = parents;
      Bytes other = encode_level(walk, io, shape, level, is_plain, grid);
      if (other.size() < bytes.size() || !is_plain) {
        bytes = std::move(other);
        break;
      }
    }
  }
  return result;
}

}  // namespace octavo
