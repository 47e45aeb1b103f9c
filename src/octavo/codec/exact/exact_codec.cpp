// Float32 voxels bit by bit: codes by a codec of their own, then which float of its bin each is.
//
// A brick starts with a byte of flags. Where samples are absent every level says which; level 0
// says which floats they are. What takes more than the floats themselves stands plain.

#include <algorithm>
#include <cstring>
#include <optional>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/entropy/byte_io.h"
#include "octavo/codec/exact/absent_samples.h"
#include "octavo/codec/exact/float_bins.h"
#include "octavo/codec/exact/float_codes.h"
#include "octavo/codec/exact/float_places.h"
#include "octavo/codec/exact/plain_floats.h"
#include "octavo/codec/stored_brick.h"

namespace octavo::exact {

namespace {

const float kAbsent = float_of_bits(kUsualNan);

/// What stands at the start of the segment that holds a brick's plain samples.
struct Head {
  static constexpr unsigned kHasAbsent = 1;   ///< samples without a value
  static constexpr unsigned kHasPlaces = 2;   ///< voxels that are not those of their codes
  static constexpr unsigned kMinIsAbove = 4;  ///< the smallest code is that of the index plus 1
  static constexpr unsigned kMaxIsBelow = 8;  ///< the largest code is that of the index less 1
  static constexpr unsigned kIsPlain = 16;    ///< the voxels follow as they are, and nothing else

  unsigned flags = 0;

  bool has(unsigned flag) const { return (flags & flag) != 0; }

  static Head take(ByteSpan& segment) {
    Head head;
    head.flags = take_bytes(segment, 1).front();
    if (head.flags >= 2 * kIsPlain) {
      throw Error(ErrorKind::unsupported_version,
                  "a float brick of a later version of the format");
    }
    return head;
  }
};

/// A brick that is not uniform, its head taken off.
struct OpenedBrick {
  std::vector<ByteSpan> parts;  ///< what is left of the segments
  bool is_stored = false;
  Head head;
  ValueRange codes;
};

/// The flags of all levels of a brick, finest first; none where all samples are present.
std::vector<AbsentFlags> flags_of_levels(const BrickShape& shape, const AbsentFlags& finest) {
  std::vector<AbsentFlags> levels;
  if (finest.empty()) return levels;
  levels.push_back(finest);
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(shape.level_count); ++i) {
    levels.push_back(coarser_flags(levels[i], shape.size[i], shape.halving[i]));
  }
  return levels;
}

std::vector<std::uint32_t> bits_of_all(std::span<const float> voxels) {
  std::vector<std::uint32_t> bits(voxels.size());
  std::memcpy(bits.data(), voxels.data(), voxels.size_bytes());
  return bits;
}

/// Takes the flags off the fronts of the segments; returns those of `level`, none where no sample
/// is absent.
/// bits  of the voxels of level 0 of the file, if its flags are among them
AbsentFlags take_absent(OpenedBrick& brick, const BrickShape& shape, int level,
                        std::vector<std::uint32_t>& bits) {
  AbsentFlags flags;
  if (!brick.head.has(Head::kHasAbsent)) return flags;
  const int first = brick.is_stored ? 0 : level;
  for (int i = brick.is_stored ? 0 : shape.level_count - 1; i >= first; --i) {
    const auto slot = static_cast<std::size_t>(i);
    const bool is_finest = shape.first_level + i == 0;
    if (is_finest) bits.resize(static_cast<std::size_t>(shape.size[0].voxel_count()));
    flags = decode_absent(take_counted(brick.parts[slot]), shape.size[slot], flags,
                          shape.halving[slot], bits);
  }
  for (int i = first; i < level; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    flags = coarser_flags(flags, shape.size[slot], shape.halving[slot]);
  }
  return flags;
}

/// Proves that the coarsest codes of a coded brick are there, all before them being taken: without
/// them the codec of codes would read a stored brick.
void require_coarsest_codes(const OpenedBrick& brick) {
  if (brick.codes.min == brick.codes.max || brick.is_stored || !brick.parts.back().empty()) return;
  throw Error(ErrorKind::corrupt, "a coded float brick has no coarsest codes");
}

class ExactCodec final : public BrickCodec {
 public:
  ExactCodec(std::unique_ptr<BrickCodec> codes, const SampleCoding& coding)
      : codes_(std::move(codes)), coding_(coding), bins_(coding) {}

  VolumeKind kind() const noexcept override { return codes_->kind(); }
  AxisOrder axis_order() const noexcept override { return codes_->axis_order(); }
  bool is_lossless() const noexcept override { return codes_->is_lossless(); }
  Bytes serialized() const override { return codes_->serialized(); }
  EncodedBrick encode(const BrickShape& shape, const BrickView& view) const override;
  void decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
              std::span<const ByteSpan> segments, int level, void* out) const override;
  std::int64_t decode_parent(const BrickShape& shape, VoxelType type, const ValueRange& range,
                             std::span<const ByteSpan> segments) const override;

 private:
  Head widen(EncodedBrick& encoded, const QuantizedBrick& brick) const;
  std::vector<Bytes> parts_of(const BrickShape& shape, const QuantizedBrick& brick,
                              const Head& head, bool is_stored) const;
  OpenedBrick open(const BrickShape& shape, VoxelType type, const ValueRange& range,
                   std::span<const ByteSpan> segments) const;
  void make_plain(EncodedBrick& encoded, const BrickShape& shape, const QuantizedBrick& brick,
                  Head head) const;
  void decode_plain(const BrickShape& shape, const OpenedBrick& brick, int level,
                    std::span<float> samples) const;

  std::unique_ptr<BrickCodec> codes_;
  SampleCoding coding_;
  FloatBins bins_;
};

/// Widens the range of the codes to bounds of the voxels, so far that a brick whose codes do not
/// say all is not uniform; returns the head that tells what was done.
Head ExactCodec::widen(EncodedBrick& encoded, const QuantizedBrick& brick) const {
  Head head;
  if (!brick.absent.empty()) head.flags |= Head::kHasAbsent;
  ValueRange& range = encoded.range;
  const ValueRange codes = range;
  if (brick.has_places) {
    head.flags |= Head::kHasPlaces;
    if (coding_.voxel_of(range.min) > brick.min) --range.min;
    if (coding_.voxel_of(range.max) < brick.max) ++range.max;
  }
  if (head.flags != 0 && range.min == range.max) ++range.max;
  if (range.min < codes.min) head.flags |= Head::kMinIsAbove;
  if (range.max > codes.max) head.flags |= Head::kMaxIsBelow;
  return head;
}

/// What stands before the segments of the codes.
std::vector<Bytes> ExactCodec::parts_of(const BrickShape& shape, const QuantizedBrick& brick,
                                        const Head& head, bool is_stored) const {
  std::vector<Bytes> parts(static_cast<std::size_t>(shape.level_count));
  (is_stored ? parts.front() : parts.back()).push_back(static_cast<std::uint8_t>(head.flags));
  const std::vector<AbsentFlags> flags = flags_of_levels(shape, brick.absent);
  const std::size_t flagged_levels = is_stored ? std::min<std::size_t>(1, flags.size())
                                               : flags.size();
  for (std::size_t i = 0; i < flagged_levels; ++i) {
    const bool has_coarser = i + 1 < flagged_levels;
    const bool is_finest = shape.first_level + static_cast<int>(i) == 0;
    const Bytes coded = encode_absent(
        flags[i], shape.size[i], has_coarser ? flags[i + 1] : AbsentFlags{}, shape.halving[i],
        is_finest ? bits_of_all(brick.voxels) : std::vector<std::uint32_t>{});
    put_counted(parts[i], coded);
  }
  if (brick.has_places) {
    const Bytes places =
        encode_places(bins_, {shape.size[0], brick.codes, brick.absent}, brick.voxels);
    parts[0].insert(parts[0].end(), places.begin(), places.end());
  }
  return parts;
}

EncodedBrick ExactCodec::encode(const BrickShape& shape, const BrickView& view) const {
  const QuantizedBrick brick = quantized(coding_, shape, view);
  EncodedBrick encoded = codes_->encode(shape, code_view(brick, view.size));
  const bool is_empty = std::count(brick.absent.begin(), brick.absent.end(), 0) == 0;
  const float parent =
      !brick.absent.empty() && is_empty ? kAbsent : coding_.voxel_of(encoded.parent);
  encoded.parent = bits_of(parent);

  const bool is_stored = encoded.range.min != encoded.range.max && shape.level_count > 1 &&
                         encoded.segments.back().empty();
  const Head head = widen(encoded, brick);
  if (encoded.range.min == encoded.range.max) return encoded;
  const std::vector<Bytes> parts = parts_of(shape, brick, head, is_stored);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Bytes& segment = encoded.segments[i];
    segment.insert(segment.begin(), parts[i].begin(), parts[i].end());
  }
  if (shape.first_level == 0) {
    std::size_t coded = 0;
    for (const Bytes& segment : encoded.segments) coded += segment.size();
    if (coded > 1 + sizeof(float) * brick.voxels.size()) make_plain(encoded, shape, brick, head);
  }
  return encoded;
}

/// Puts the voxels as they are in the place of the segments.
/// head  of the brick as it was coded
void ExactCodec::make_plain(EncodedBrick& encoded, const BrickShape& shape,
                            const QuantizedBrick& brick, Head head) const {
  head.flags = (head.flags & (Head::kMinIsAbove | Head::kMaxIsBelow)) | Head::kIsPlain;
  for (Bytes& segment : encoded.segments) segment.clear();
  Bytes& segment = encoded.segments.front();
  segment = encode_plain_floats(brick.voxels);
  segment.insert(segment.begin(), static_cast<std::uint8_t>(head.flags));
  const CodedLevel above = level_of(brick, shape, shape.level_count, codes_->axis_order());
  const bool is_absent = !above.absent.empty() && above.absent.front() != 0;
  encoded.parent = bits_of(is_absent ? kAbsent : coding_.voxel_of(above.codes.front()));
}

OpenedBrick ExactCodec::open(const BrickShape& shape, VoxelType type, const ValueRange& range,
                             std::span<const ByteSpan> segments) const {
  if (type != VoxelType::float32) {
    throw Error(ErrorKind::invalid_argument, "exact float voxels are of type float32");
  }
  OpenedBrick brick;
  brick.parts.assign(segments.begin(), segments.end());
  brick.is_stored = is_stored(shape, segments);
  brick.head = Head::take(brick.is_stored ? brick.parts.front() : brick.parts.back());
  brick.codes = {range.min + (brick.head.has(Head::kMinIsAbove) ? 1 : 0),
                 range.max - (brick.head.has(Head::kMaxIsBelow) ? 1 : 0)};
  if (brick.codes.min > brick.codes.max || brick.codes.min < -kLargestBin ||
      brick.codes.max > kLargestBin) {
    throw Error(ErrorKind::corrupt, "a float brick has no codes");
  }
  if (brick.head.has(Head::kHasPlaces) && shape.first_level > 0) {
    throw Error(ErrorKind::corrupt, "a coarse float brick has places");
  }
  if (brick.head.has(Head::kIsPlain)) {
    const bool is_alone = brick.is_stored || shape.level_count == 1;
    const bool has_more = brick.head.has(Head::kHasAbsent) || brick.head.has(Head::kHasPlaces);
    if (!is_alone || has_more || shape.first_level > 0) {
      throw Error(ErrorKind::corrupt, "a brick of plain floats has something beside them");
    }
  }
  return brick;
}

/// The samples of a level of a brick whose voxels stand as they are, of its parent at the level
/// behind the last.
void ExactCodec::decode_plain(const BrickShape& shape, const OpenedBrick& brick, int level,
                              std::span<float> samples) const {
  const ByteSpan bytes = brick.parts.front();
  if (level == 0) return decode_plain_floats(bytes, bins_, brick.codes, samples);
  const Size3& size = shape.size[0];
  std::vector<float> voxels(static_cast<std::size_t>(size.voxel_count()));
  decode_plain_floats(bytes, bins_, brick.codes, voxels);
  const BrickView view{voxels.data(), VoxelType::float32, size, size.x, size.x * size.y};
  const CodedLevel found =
      level_of(quantized(coding_, shape, view), shape, level, codes_->axis_order());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool is_absent = !found.absent.empty() && found.absent[i] != 0;
    samples[i] = is_absent ? kAbsent : coding_.voxel_of(found.codes[i]);
  }
}

void ExactCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                        std::span<const ByteSpan> segments, int level, void* out) const {
  const Size3& size = shape.size[static_cast<std::size_t>(level)];
  const auto count = static_cast<std::size_t>(size.voxel_count());
  const std::span<float> voxels(static_cast<float*>(out), count);
  if (range.min == range.max) {
    std::fill(voxels.begin(), voxels.end(), coding_.voxel_of(range.min));
    return;
  }
  OpenedBrick brick = open(shape, type, range, segments);
  const Head& head = brick.head;
  if (head.has(Head::kIsPlain)) return decode_plain(shape, brick, level, voxels);
  // Which samples are absent; their bits where level 0 is read
  std::vector<std::uint32_t> bits;
  const AbsentFlags absent = take_absent(brick, shape, level, bits);
  // The places, whose codes are not there yet
  std::vector<ByteSpan>& parts = brick.parts;
  ByteSpan places = brick.is_stored || level == 0 ? parts.front() : ByteSpan{};
  if (head.has(Head::kHasPlaces) && (brick.is_stored || level == 0)) skip_places(parts.front());

  // The codes
  require_coarsest_codes(brick);
  std::vector<std::int32_t> found(count, static_cast<std::int32_t>(brick.codes.min));
  if (brick.codes.min != brick.codes.max) {
    codes_->decode(shape, VoxelType::int32, brick.codes, parts, level, found.data());
  } else if (std::any_of(parts.begin() + level, parts.end(),
                         [](ByteSpan part) { return !part.empty(); })) {
    throw Error(ErrorKind::corrupt, "a float brick of one code holds several");
  }
  // The voxels
  if (level == 0 && head.has(Head::kHasPlaces)) {
    decode_places(bins_, {size, found, absent}, places, voxels);
  } else {
    std::transform(found.begin(), found.end(), voxels.begin(),
                   [&](std::int32_t code) { return coding_.voxel_of(code); });
  }
  const bool has_bits = level == 0 && !bits.empty();
  for (std::size_t i = 0; i < absent.size(); ++i) {
    if (absent[i] != 0) voxels[i] = has_bits ? float_of_bits(bits[i]) : kAbsent;
  }
}

std::int64_t ExactCodec::decode_parent(const BrickShape& shape, VoxelType type,
                                       const ValueRange& range,
                                       std::span<const ByteSpan> segments) const {
  if (range.min == range.max) return bits_of(coding_.voxel_of(range.min));
  OpenedBrick brick = open(shape, type, range, segments);
  if (brick.head.has(Head::kIsPlain)) {
    float parent = 0;
    decode_plain(shape, brick, shape.level_count, {&parent, 1});
    return bits_of(parent);
  }
  std::vector<std::uint32_t> bits;
  const AbsentFlags absent = take_absent(brick, shape, shape.level_count - 1, bits);
  const auto is_absent = [](std::uint8_t flag) { return flag != 0; };
  if (!absent.empty() && std::all_of(absent.begin(), absent.end(), is_absent)) {
    return bits_of(kAbsent);
  }
  if (brick.codes.min == brick.codes.max) return bits_of(coding_.voxel_of(brick.codes.min));
  require_coarsest_codes(brick);
  if (brick.is_stored && brick.head.has(Head::kHasPlaces)) skip_places(brick.parts.front());
  return bits_of(coding_.voxel_of(
      codes_->decode_parent(shape, VoxelType::int32, brick.codes, brick.parts)));
}

/// Whether any axis is cut: then a whole brick has parts.
bool cuts_axes(const BrickCodec& codec) {
  const Size3 size{64, 64, 64};
  const Levels levels(size, choose_halvings(size, {1, 1, 1}));
  return codec.has_parts(brick_shape(levels, 0, {0, 0, 0}));
}

}  // namespace

}  // namespace octavo::exact

namespace octavo {

std::unique_ptr<BrickCodec> make_exact_codec(std::unique_ptr<BrickCodec> codes,
                                             const SampleCoding& coding) {
  return std::make_unique<exact::ExactCodec>(std::move(codes), coding);
}

std::unique_ptr<BrickCodec> parse_model(VolumeKind kind, VoxelType coded_type,
                                        const std::optional<SampleCoding>& coding, ByteSpan bytes,
                                        int detail_level) {
  auto codec = parse_model(kind, coded_type, bytes, detail_level);
  if (!coding || !coding->is_exact) return codec;
  if (exact::cuts_axes(*codec)) {
    throw Error(ErrorKind::corrupt, "a model of exact floats cuts axes");
  }
  return make_exact_codec(std::move(codec), *coding);
}

}  // namespace octavo
