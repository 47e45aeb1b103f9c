#include "octavo/codec/label/label_model.h"

#include <algorithm>

#include "octavo/codec/entropy/golomb.h"

namespace octavo {

namespace {

/// Palette gaps have up to 32 bits.
using NumberBits = GolombModel<33>;

/// Steps between a weight and its start weight, as a sign and a size.
struct StepBits {
  AdaptiveBit is_changed{2000};
  AdaptiveBit is_negative;
  NumberBits size;
};

void put_steps(BinaryEncoder& coder, StepBits& bits, int steps) {
  put_adaptive(coder, bits.is_changed, steps != 0);
  if (steps == 0) return;
  put_adaptive(coder, bits.is_negative, steps < 0);
  put_golomb(coder, bits.size, static_cast<std::uint64_t>(std::abs(steps)) - 1);
}

int get_steps(BinaryDecoder& coder, StepBits& bits) {
  if (!get_adaptive(coder, bits.is_changed)) return 0;
  const bool is_negative = get_adaptive(coder, bits.is_negative);
  const auto size =
      static_cast<int>(std::min<std::uint64_t>(get_golomb(coder, bits.size), 255)) + 1;
  return is_negative ? -size : size;
}

[[noreturn]] void reject(const char* what) {
  throw Error(ErrorKind::corrupt, std::string("label model: ") + what);
}

std::vector<std::int64_t> get_palette(BinaryDecoder& coder, const ValueRange& range) {
  NumberBits count_bits;
  NumberBits bits;
  const std::uint64_t count = get_golomb(coder, count_bits);
  if (count > kMaxPalette) {
    throw Error(ErrorKind::unsupported_version,
                "a label model of a later version of the format");
  }
  std::vector<std::int64_t> palette;
  std::int64_t next = range.min;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t gap = get_golomb(coder, bits);
    if (next > range.max || gap > static_cast<std::uint64_t>(range.max - next)) {
      reject("a palette entry is outside the voxel type");
    }
    palette.push_back(next + static_cast<std::int64_t>(gap));
    next = palette.back() + 1;
  }
  return palette;
}

}  // namespace

LabelModel::LabelModel(std::vector<std::int64_t> labels, const LabelWeightSet& set)
    : palette(std::move(labels)),
      weights(set),
      nets{LabelNet(set[0]), LabelNet(set[1]), LabelNet(set[2])} {}

Bytes serialize(const LabelModel& model, VoxelType type) {
  Bytes bytes;
  BinaryEncoder coder(bytes);
  NumberBits count_bits;
  NumberBits gap_bits;
  put_golomb(coder, count_bits, model.palette.size());
  std::int64_t next = value_range(type).min;
  for (const std::int64_t label : model.palette) {
    put_golomb(coder, gap_bits, static_cast<std::uint64_t>(label - next));
    next = label + 1;
  }
  for (std::size_t net = 0; net < kLabelNets; ++net) {
    StepBits bits;
    const LabelWeights& start = label_start_weights()[net];
    for (std::size_t i = 0; i < kLabelWeights; ++i) {
      put_steps(coder, bits, (model.weights[net][i] - start[i]) / kLabelWeightStep);
    }
  }
  coder.finish_short();
  return bytes;
}

LabelModel parse_label_weights(VoxelType type, ByteSpan bytes) {
  BinaryDecoder coder(bytes);
  std::vector<std::int64_t> palette = get_palette(coder, value_range(type));
  LabelWeightSet set = label_start_weights();
  for (LabelWeights& weights : set) {
    StepBits bits;
    for (std::int8_t& weight : weights) {
      const int value = weight + kLabelWeightStep * get_steps(coder, bits);
      if (value < -127 || value > 127) reject("a weight is outside -127 .. 127");
      weight = static_cast<std::int8_t>(value);
    }
  }
  if (!coder.is_consumed_short()) reject("its length does not fit its contents");
  return LabelModel(std::move(palette), set);
}

LabelPaletteRange::LabelPaletteRange(const std::vector<std::int64_t>& palette,
                                     const ValueRange& range) {
  const auto low = std::lower_bound(palette.begin(), palette.end(), range.min);
  const auto high = std::upper_bound(low, palette.end(), range.max);
  first = palette.data() + (low - palette.begin());
  count = static_cast<std::uint64_t>(high - low);
}

std::int64_t LabelPaletteRange::rank_of(std::int64_t label) const {
  const std::int64_t* last = first + count;
  const std::int64_t* at = std::lower_bound(first, last, label);
  return at != last && *at == label ? at - first : -1;
}

}  // namespace octavo
