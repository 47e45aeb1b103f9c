// What the grey codec learns from a scan: prediction weights, context weights, probability tables.
//
// A detail is predicted by a weighted sum of up to 96 neighbors ("taps"), weights in Q12, one set
// per level group (0, 1, coarser), split axis and activity class. The size of the remaining
// residual is predicted by a non-negative weighted sum of 16 features in Q8; its half-octave, and
// whether the value range limits the residual, choose one of 60 contexts. A context says how many
// low bits of a residual are stored plain and how probable the tokens of the rest are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/codec/grey/value_map.h"
#include "octavo/core/bytes.h"

namespace octavo::grey {

inline constexpr int kGroups = 3;
inline constexpr int kClasses = 5;
inline constexpr int kMaxTaps = 96;
inline constexpr int kWeightBits = 12;
inline constexpr int kFeatures = 16;
inline constexpr int kMagnitudes = 30;
inline constexpr int kContexts = 2 * kMagnitudes;
inline constexpr int kTableSets = 2;
inline constexpr int kTokens = 64;
inline constexpr int kDirectTokens = 32;
inline constexpr int kEscapeToken = 63;
inline constexpr int kEscapeBits = 20;
inline constexpr int kTableBits = 11;
inline constexpr int kTableSize = 1 << kTableBits;
/// Fourfold, it fits in 16 bits.
inline constexpr std::int32_t kMaxThreshold = 16383;
inline constexpr std::int32_t kMaxMeanWeight = 8191;
/// Far shares and weights of what is behind are in Q7.
inline constexpr int kShareBits = 7;
inline constexpr std::int32_t kMaxShare = 127;
inline constexpr std::int32_t kMaxFeature = 16383;
inline constexpr std::int32_t kMaxMagnitude = 2047;

/// Taps of a split along an axis come in rows of 8 neighbors: 10 rows for x, 12 for y and z.
constexpr int tap_count(int axis) { return axis == 0 ? 80 : 96; }
/// The tap that stands at the sample itself (the parent's value).
constexpr int center_tap(int axis) { return axis == 0 ? 8 : axis == 1 ? 2 * 8 + 3 : 5 * 8 + 3; }

constexpr int level_group(int in_brick_level) { return in_brick_level < 2 ? in_brick_level : 2; }
constexpr int table_set(int in_brick_level) { return in_brick_level == 0 ? 0 : 1; }

/// Low bits of a residual that a context stores plain, when residuals come in steps of 2^step_bits
/// or more: few enough that tokens from
/// kDirectTokens on are rare, and at most kMaxPlainBits.
inline constexpr int kMaxPlainBits = 7;
constexpr int plain_bits(int context, int step_bits) {
  const int bits = (context % kMagnitudes) / 2 - 6 - step_bits;
  return bits > kMaxPlainBits ? kMaxPlainBits : bits > 0 ? bits : 0;
}

/// Tokens: 0..31 stand for themselves; above, two per octave, followed by plain bits.
struct Token {
  int token;
  int bits;            ///< plain bits that follow
  std::uint32_t base;  ///< value - base fits in them
};
constexpr Token token_shape(int token) {
  if (token < kDirectTokens) return {token, 0, static_cast<std::uint32_t>(token)};
  if (token == kEscapeToken) return {token, kEscapeBits, 0};
  const int bits = 4 + ((token - kDirectTokens) >> 1);
  return {token, bits, (2u + (static_cast<std::uint32_t>(token) & 1)) << bits};
}
constexpr int token_of(std::uint32_t value) {
  if (value < kDirectTokens) return static_cast<int>(value);
  const int octave = 31 - __builtin_clz(value);
  return kDirectTokens + (octave - 5) * 2 + static_cast<int>(value >> (octave - 1) & 1);
}

/// What a pair beside background is (edge_pairs.h): no edge, or which of its samples is background.
enum class EdgeKind : std::uint8_t { none, first, second };
inline constexpr int kEdgeKinds = 3;
inline constexpr int kEdgeContexts = 360;

/// Frequencies of the kinds in every context of a pair beside background; each at least 1, each
/// context's sum to 2048.
using EdgeFrequencies = std::array<std::array<std::uint16_t, kEdgeKinds>, kEdgeContexts>;

/// Token frequencies of every context; each context's sum to 2048, the escape token has at least 1.
using Frequencies =
    std::array<std::array<std::array<std::uint16_t, kTokens>, kContexts>, kTableSets>;

/// Every order of the axes, by its number in a file.
inline constexpr std::array<AxisOrder, 6> kAxisOrders = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// What a detail is predicted from.
enum class Predictor : std::uint8_t {
  neighbors = 0,  ///< up to 96 taps, decoded samples among them
  means = 1        ///< the slope of the means beside the pair, and the detail behind it
};

/// How a model with a maximum error leaves out precision. All off: lossless.
struct Quantizer {
  /// Voxels are first brought to the nearest multiple of this odd number.
  std::int64_t voxel_step = 1;
  /// Step of a coefficient of the orthonormal transform, Q8; 0: details are exact.
  std::int32_t detail_step = 0;
  /// Decoded voxels are corrected by multiples of this; 0: never.
  std::int64_t correction_step = 0;

  bool is_lossless() const { return voxel_step == 1 && detail_step == 0; }
};
inline constexpr std::int64_t kMaxVoxelStep = (std::int64_t{1} << 32) - 1;
inline constexpr std::int32_t kMaxDetailStep = 1 << 23;

/// The step of details of the split along `axis` at an in-brick level: a detail is sqrt(2) times
/// its coefficient, which weighs sqrt(2) more with every split from the finest on.
constexpr std::int32_t detail_step_of(const Quantizer& quantizer, int in_brick_level, int axis) {
  const int split = 3 * in_brick_level + axis;
  const std::int64_t factor = (split % 2 == 0 ? 46341 : 32768) >> split / 2;  // Q15
  const std::int64_t step = (quantizer.detail_step * factor + (1 << 22)) >> 23;
  return step < 1 ? 1 : static_cast<std::int32_t>(step);
}

struct Parameters {
  Predictor predictor = Predictor::neighbors;
  Quantizer quantizer;
  bool has_edges = false;  ///< pairs at the edge of the background are told apart (edge_pairs.h)
  ValueMap value_map;  ///< empty when the quantizer leaves out precision
  AxisOrder axis_order = kStraightOrder;
  /// The axes, of that order, along which level 0 is cut into parts (grey_parts.h): bits as in a
  /// HalvingMask.
  std::uint8_t cut_axes = 0;
  /// As CodecSettings::detail_level; the model's form in a file does not hold it.
  int detail_level = 0;
  std::int32_t activity_threshold = 8;
  /// Weights are multiples of 2^weight_step.
  int weight_step = 3;
  alignas(64) std::int16_t weights[kGroups][3][kClasses][kMaxTaps] = {};
  /// Of the slope of the means, Q12.
  std::int32_t mean_weights[kGroups][3][kClasses] = {};
  /// The slope is the step between the means before and after the pair, and this much, Q7, of the
  /// step between those two away.
  std::int32_t far_shares[kGroups][3] = {};
  /// Of what the detail behind, in the plane before, was beyond the prediction from its slope, Q7.
  std::int32_t behind_weights[kGroups][3][kClasses] = {};
  std::int32_t context_weights[kGroups][3][kFeatures] = {};
  Frequencies frequencies = {};
  EdgeFrequencies edge_frequencies = {};  ///< only of a model that tells edges apart
};

/// How a token of a context is pushed onto a rANS state.
struct alignas(8) Encoder {
  std::uint32_t reciprocal = 0;  ///< 2^32 / frequency, rounded down
  std::uint16_t frequency = 0;
  std::uint16_t start = 0;       ///< first slot

  /// (x / frequency << 11) + x % frequency + first slot, without a division: of an x below 2^21
  /// times frequency the quotient comes out right or 1 too low.
  std::uint32_t pushed(std::uint32_t x) const {
    auto quotient = static_cast<std::uint32_t>(std::uint64_t{reciprocal} * x >> 32);
    quotient += x - quotient * frequency >= frequency ? 1 : 0;
    return x + start + quotient * (std::uint32_t{kTableSize} - frequency);
  }
};

/// Of a token with that frequency, 1 .. 2048 or 0 where it has no slots, and first slot.
Encoder encoder_of(std::uint32_t frequency, std::uint32_t start);

/// Contexts of residuals, then those of edges, whose tokens are the kinds.
inline constexpr std::size_t kAllContexts = kContexts + kEdgeContexts;

/// The place of a token's encoder among those of a table set.
constexpr std::size_t encoder_place(std::size_t context, std::size_t token) {
  return context < kContexts
             ? context * kTokens + token
             : std::size_t{kContexts} * kTokens + (context - kContexts) * kEdgeKinds + token;
}
inline constexpr std::size_t kEncoders = encoder_place(kAllContexts, 0);

/// Tables derived from the frequencies.
struct Tables {
  /// By context and slot: token | frequency << 6 | (slot - first slot of the token) << 18.
  std::array<std::array<std::array<std::uint32_t, kTableSize>, kContexts>, kTableSets> slots;
  /// By context: bit t tells whether token t has slots.
  std::array<std::array<std::uint64_t, kAllContexts>, kTableSets> used;
  std::array<std::array<Encoder, kEncoders>, kTableSets> encoders;
  /// By context of an edge: the first slot of each kind, and 2048.
  std::array<std::array<std::uint16_t, kEdgeKinds + 1>, kEdgeContexts> edge_starts;
};

struct Model {
  Parameters parameters;
  Tables tables;
};

/// Parameters that suit anything a little: parents' gradients predict the residual, flat tables.
Parameters default_parameters();

/// Fills the derived tables. Requires frequencies that sum to 2048 in every context.
void build_tables(Model& model);

/// Both directions of the model's form in a file (docs/format-grey.md, section 11).
Bytes serialize(const Parameters& parameters);
/// Throws Error{corrupt}.
Parameters parse_parameters(ByteSpan bytes);

}  // namespace octavo::grey
