#include "octavo/codec/grey/grey_model.h"

#include <algorithm>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/codec/entropy/byte_io.h"
#include "octavo/codec/entropy/golomb.h"

namespace octavo::grey {

namespace {

constexpr std::uint8_t kLossyFlag = 2;
constexpr int kOrderShift = 2;
constexpr std::uint8_t kOrderMask = 7;
constexpr std::uint8_t kMapFlag = 32;
constexpr std::uint8_t kEdgesFlag = 64;
constexpr std::uint8_t kUnknownFlags = 128;
constexpr std::uint8_t kCutMask = 7;  ///< in the second byte
using GolombModel = octavo::GolombModel<24>;

void put_signed(BinaryEncoder& coder, GolombModel& model, std::int32_t value) {
  put_golomb(coder, model, static_cast<std::uint32_t>(zigzag(value)));
}

std::int32_t get_signed(BinaryDecoder& coder, GolombModel& model) {
  return static_cast<std::int32_t>(unzigzag(get_golomb(coder, model)));
}

/// One traversal of all parameters, both directions: `code(model, value)` puts or gets a number.
///
/// The center tap is not coded: weights sum to zero, so it is minus the sum of the others. Taps
/// near the center and far from it have models of their own.
template <class Params, class Code>
void walk_weights(Params& p, Code&& code) {
  GolombModel is_used;
  if (p.predictor == Predictor::means) {
    GolombModel share;
    GolombModel behind;
    for (int group = 0; group < kGroups; ++group) {
      for (int axis = 0; axis < 3; ++axis) {
        code.bounded(share, p.far_shares[group][axis], kMaxShare);
        for (int cls = 1; cls < kClasses; ++cls) {
          code.bounded(is_used, p.mean_weights[group][axis][cls], kMaxMeanWeight);
          code.bounded(behind, p.behind_weights[group][axis][cls], kMaxShare);
        }
      }
    }
    return;
  }
  std::array<GolombModel, 3 * 3> near_or_far;
  for (int group = 0; group < kGroups; ++group) {
    for (int axis = 0; axis < 3; ++axis) {
      for (int cls = 1; cls < kClasses; ++cls) {
        auto& weights = p.weights[group][axis][cls];
        GolombModel* const of_axis = near_or_far.data() + std::ptrdiff_t{3} * axis;
        code.weight_set(is_used, of_axis, weights, axis, p.weight_step);
      }
    }
  }
}

int tap_distance(int axis, int tap) {
  // Within a row of 8 the own column stands at offset 3 (rows through the sample itself differ for
  // x).
  const int column = tap % 8 - 3;
  if (axis == 0 && tap < 16) return tap >= 6 && tap < 12 ? 0 : 1;
  return column >= -1 && column <= 1 ? 0 : column >= -2 && column <= 2 ? 1 : 2;
}

struct WeightPutter {
  BinaryEncoder& coder;
  void bounded(GolombModel& model, std::int32_t weight, std::int32_t) {
    put_signed(coder, model, weight);
  }
  void weight_set(GolombModel& is_used, GolombModel* models, const std::int16_t* weights, int axis,
                  int step) {
    bool any = false;
    for (int tap = 0; tap < tap_count(axis); ++tap) any = any || weights[tap] != 0;
    put_golomb(coder, is_used, any ? 1 : 0);
    if (!any) return;
    for (int tap = 0; tap < tap_count(axis); ++tap) {
      if (tap == center_tap(axis)) continue;
      put_signed(coder, models[tap_distance(axis, tap)], weights[tap] >> step);
    }
  }
};

struct WeightGetter {
  BinaryDecoder& coder;
  void bounded(GolombModel& model, std::int32_t& weight, std::int32_t most) {
    weight = get_signed(coder, model);
    if (weight < -most || weight > most) {
      throw Error(ErrorKind::corrupt, "model: bad weight of the means");
    }
  }
  void weight_set(GolombModel& is_used, GolombModel* models, std::int16_t* weights, int axis,
                  int step) {
    if (get_golomb(coder, is_used) == 0) return;
    std::int32_t sum = 0;
    for (int tap = 0; tap < tap_count(axis); ++tap) {
      if (tap == center_tap(axis)) continue;
      const auto scaled =
          static_cast<std::uint32_t>(get_signed(coder, models[tap_distance(axis, tap)]));
      weights[tap] = static_cast<std::int16_t>(scaled << step);
      sum += weights[tap];
    }
    weights[center_tap(axis)] = static_cast<std::int16_t>(-sum);
  }
};

/// Frequencies run from token 0 to the last used one; the escape token takes what is left of 2048.
/// The model of a frequency is chosen by the size of the one before and of the same token one
/// context down.
struct FrequencyModels {
  GolombModel last;
  std::array<std::array<GolombModel, 4>, 12> by_neighbors;
  GolombModel& of(std::uint32_t before, std::uint32_t below) {
    const int below_width = bit_length(below);
    const std::size_t column = below_width == 0  ? 0u
                               : below_width < 4 ? 1u
                               : below_width < 7 ? 2u
                                                 : 3u;
    return by_neighbors[static_cast<std::size_t>(std::min(bit_length(before), 11))][column];
  }
};

using ContextFrequencies = std::array<std::uint16_t, kTokens>;

int last_used_token(const ContextFrequencies& frequencies) {
  int last = -1;
  for (int token = 0; token < kEscapeToken; ++token) {
    if (frequencies[static_cast<std::size_t>(token)] != 0) last = token;
  }
  return last;
}

/// below  the frequencies of the context before in the set, or null
void put_context(BinaryEncoder& coder, FrequencyModels& models, const ContextFrequencies& context,
                 const ContextFrequencies* below) {
  // An unused context repeats the one below it: code 0.
  const bool repeats = below != nullptr && context == *below;
  const int last = last_used_token(context);
  put_golomb(coder, models.last, repeats ? 0u : static_cast<std::uint32_t>(last + 2));
  if (repeats) return;
  std::uint32_t before = 0;
  for (std::size_t token = 0; token <= static_cast<std::size_t>(last) && last >= 0; ++token) {
    GolombModel& model = models.of(before, below ? (*below)[token] : 0u);
    put_golomb(coder, model, context[token]);
    before = context[token];
  }
}

/// What put_context has put. Throws Error{corrupt}.
void get_context(BinaryDecoder& coder, FrequencyModels& models, ContextFrequencies& context,
                 const ContextFrequencies* below) {
  const auto code = static_cast<std::uint32_t>(get_golomb(coder, models.last));
  if (code > kTokens || (code == 0 && below == nullptr)) {
    throw Error(ErrorKind::corrupt, "model: bad table length");
  }
  if (code == 0) {
    context = *below;
    return;
  }
  std::uint32_t left = kTableSize;
  std::uint32_t before = 0;
  for (std::size_t token = 0; token + 1 < code; ++token) {
    const auto value = static_cast<std::uint32_t>(
        get_golomb(coder, models.of(before, below ? (*below)[token] : 0u)));
    if (value >= left) throw Error(ErrorKind::corrupt, "model: a table exceeds its sum");
    context[token] = static_cast<std::uint16_t>(value);
    left -= value;
    before = value;
  }
  context[kEscapeToken] = static_cast<std::uint16_t>(left);
}

/// A context that repeats the one before says so; of others the frequencies of both kinds of edges
/// are put, less 1.
struct EdgeFrequencyModels {
  GolombModel is_own;
  std::array<GolombModel, kEdgeKinds> by_kind;
};

void put_edge_frequencies(BinaryEncoder& coder, const EdgeFrequencies& frequencies) {
  EdgeFrequencyModels models;
  for (std::size_t context = 0; context < kEdgeContexts; ++context) {
    const auto& own = frequencies[context];
    const bool is_own = context == 0 || own != frequencies[context - 1];
    put_golomb(coder, models.is_own, is_own ? 1 : 0);
    if (!is_own) continue;
    for (std::size_t kind = 1; kind < kEdgeKinds; ++kind) {
      put_golomb(coder, models.by_kind[kind], own[kind] - 1u);
    }
  }
}

/// What put_edge_frequencies has put. Throws Error{corrupt}.
void get_edge_frequencies(BinaryDecoder& coder, EdgeFrequencies& frequencies) {
  EdgeFrequencyModels models;
  for (std::size_t context = 0; context < kEdgeContexts; ++context) {
    const auto code = get_golomb(coder, models.is_own);
    if (code > 1 || (code == 0 && context == 0)) {
      throw Error(ErrorKind::corrupt, "model: a table of edges that is not there");
    }
    auto& own = frequencies[context];
    if (code == 0) {
      own = frequencies[context - 1];
      continue;
    }
    std::uint64_t left = kTableSize;
    for (std::size_t kind = 1; kind < kEdgeKinds; ++kind) {
      const std::uint64_t frequency = std::uint64_t{get_golomb(coder, models.by_kind[kind])} + 1;
      if (frequency >= left) throw Error(ErrorKind::corrupt, "model: a table exceeds its sum");
      own[kind] = static_cast<std::uint16_t>(frequency);
      left -= frequency;
    }
    own[0] = static_cast<std::uint16_t>(left);
  }
}

}  // namespace

Parameters default_parameters() {
  Parameters p;
  for (int group = 0; group < kGroups; ++group) {
    for (int axis = 0; axis < 3; ++axis) {
      p.context_weights[group][axis][0] = 64;
      p.context_weights[group][axis][5] = 128;
      p.context_weights[group][axis][8] = 128;
    }
  }
  for (auto& set : p.frequencies) {
    for (auto& context : set) {
      for (int token = 0; token < kEscapeToken; ++token) {
        context[static_cast<std::size_t>(token)] = token < kDirectTokens ? 48 : 16;
      }
      context[kEscapeToken] = kTableSize - 32 * 48 - 31 * 16;
    }
  }
  p.edge_frequencies.fill({kTableSize / 2, kTableSize / 4, kTableSize / 4});
  return p;
}

Encoder encoder_of(std::uint32_t frequency, std::uint32_t start) {
  if (frequency == 0) return {};
  // 2^32 itself has no place in 32 bits.
  const std::uint64_t reciprocal = frequency == 1 ? ~0u : (std::uint64_t{1} << 32) / frequency;
  return {static_cast<std::uint32_t>(reciprocal), static_cast<std::uint16_t>(frequency),
          static_cast<std::uint16_t>(start)};
}

namespace {

void build_edge_tables(Model& model) {
  if (!model.parameters.has_edges) return;
  Tables& tables = model.tables;
  for (std::size_t context = 0; context < kEdgeContexts; ++context) {
    const auto& frequencies = model.parameters.edge_frequencies[context];
    std::uint32_t start = 0;
    for (std::size_t kind = 0; kind < kEdgeKinds; ++kind) {
      tables.edge_starts[context][kind] = static_cast<std::uint16_t>(start);
      for (std::size_t set = 0; set < kTableSets; ++set) {
        tables.encoders[set][encoder_place(kContexts + context, kind)] =
            encoder_of(frequencies[kind], start);
        tables.used[set][kContexts + context] = (1u << kEdgeKinds) - 1;
      }
      start += frequencies[kind];
    }
    tables.edge_starts[context][kEdgeKinds] = static_cast<std::uint16_t>(start);
  }
}

}  // namespace

void build_tables(Model& model) {
  build_edge_tables(model);
  for (std::size_t set = 0; set < kTableSets; ++set) {
    for (std::size_t context = 0; context < kContexts; ++context) {
      const auto& frequencies = model.parameters.frequencies[set][context];
      auto& slots = model.tables.slots[set][context];
      model.tables.used[set][context] = 0;
      std::uint32_t start = 0;
      for (std::uint32_t token = 0; token < kTokens; ++token) {
        const std::uint32_t frequency = frequencies[token];
        if (frequency > 0) model.tables.used[set][context] |= std::uint64_t{1} << token;
        model.tables.encoders[set][encoder_place(context, token)] =
            encoder_of(frequency, start);
        for (std::uint32_t i = 0; i < frequency; ++i) {
          slots[start + i] = token | frequency << 6 | i << 18;
        }
        start += frequency;
      }
    }
  }
}

Bytes serialize(const Parameters& parameters) {
  Bytes out;
  const Quantizer& quantizer = parameters.quantizer;
  const std::uint8_t is_lossy = quantizer.is_lossless() ? 0 : kLossyFlag;
  const auto order =
      std::find(kAxisOrders.begin(), kAxisOrders.end(), parameters.axis_order) -
      kAxisOrders.begin();
  out.push_back(static_cast<std::uint8_t>(static_cast<int>(parameters.predictor) | is_lossy |
                                          (parameters.value_map.is_empty() ? 0 : kMapFlag) |
                                          (parameters.has_edges ? kEdgesFlag : 0) |
                                          static_cast<int>(order) << kOrderShift));
  out.push_back(parameters.cut_axes);
  if (is_lossy != 0) {
    put_varint(out, static_cast<std::uint64_t>(quantizer.voxel_step));
    put_varint(out, static_cast<std::uint64_t>(quantizer.detail_step));
    put_varint(out, static_cast<std::uint64_t>(quantizer.correction_step));
  }
  if (!parameters.value_map.is_empty()) put_value_map(out, parameters.value_map);
  put_varint(out, static_cast<std::uint64_t>(parameters.activity_threshold));
  out.push_back(static_cast<std::uint8_t>(parameters.weight_step));
  BinaryEncoder coder(out);
  walk_weights(parameters, WeightPutter{coder});
  GolombModel context_model;
  for (const auto& group : parameters.context_weights) {
    for (const auto& axis : group) {
      for (const std::int32_t weight : axis) {
        put_golomb(coder, context_model, static_cast<std::uint32_t>(weight));
      }
    }
  }
  FrequencyModels models;
  for (const auto& set : parameters.frequencies) {
    const ContextFrequencies* below = nullptr;
    for (const ContextFrequencies& context : set) {
      put_context(coder, models, context, below);
      below = &context;
    }
  }
  if (parameters.has_edges) put_edge_frequencies(coder, parameters.edge_frequencies);
  coder.finish();
  return out;
}

namespace {

/// A model with a maximum error rounds voxels, or rounds details and corrects voxels.
Quantizer parse_quantizer(ByteSpan& bytes) {
  const std::uint64_t voxel_step = take_varint(bytes);
  const std::uint64_t detail_step = take_varint(bytes);
  const std::uint64_t correction_step = take_varint(bytes);
  const bool rounds_voxels = voxel_step > 1;
  if (voxel_step > kMaxVoxelStep || voxel_step % 2 == 0 || detail_step > kMaxDetailStep ||
      correction_step > kMaxVoxelStep || rounds_voxels == (detail_step > 0) ||
      (correction_step > 0) != (detail_step > 0)) {
    throw Error(ErrorKind::corrupt, "model: bad steps");
  }
  return {static_cast<std::int64_t>(voxel_step), static_cast<std::int32_t>(detail_step),
          static_cast<std::int64_t>(correction_step)};
}

/// The flags in the first two bytes of a model, and what they announce.
/// Throws Error{corrupt, unsupported_version}.
void parse_kind(ByteSpan& bytes, Parameters& p) {
  const std::uint8_t kind = take_bytes(bytes, 1).front();
  p.cut_axes = take_bytes(bytes, 1).front();
  const std::size_t order = kind >> kOrderShift & kOrderMask;
  if (order >= kAxisOrders.size() || (kind & kUnknownFlags) != 0 || p.cut_axes > kCutMask) {
    throw Error(ErrorKind::unsupported_version, "a grey model of a later version of the format");
  }
  if ((kind & kLossyFlag) != 0) p.quantizer = parse_quantizer(bytes);
  if ((kind & kMapFlag) != 0) {
    p.value_map = take_value_map(bytes);
    if (p.value_map.is_empty() || !p.quantizer.is_lossless()) {
      throw Error(ErrorKind::corrupt, "model: a map of values that says nothing");
    }
  }
  p.has_edges = (kind & kEdgesFlag) != 0;
  if (p.has_edges && !p.quantizer.is_lossless()) {
    throw Error(ErrorKind::corrupt, "model: edges in a lossy model");
  }
  p.axis_order = kAxisOrders[order];
  p.predictor = static_cast<Predictor>(kind & 1);
}

void parse_context_weights(BinaryDecoder& coder, Parameters& p) {
  GolombModel model;
  for (auto& group : p.context_weights) {
    for (auto& axis : group) {
      for (std::int32_t& weight : axis) {
        weight = static_cast<std::int32_t>(get_golomb(coder, model));
        if (weight > 8191) throw Error(ErrorKind::corrupt, "model: bad context weight");
      }
    }
  }
}

void parse_frequencies(BinaryDecoder& coder, Parameters& p) {
  FrequencyModels models;
  for (auto& set : p.frequencies) {
    const ContextFrequencies* below = nullptr;
    for (ContextFrequencies& context : set) {
      get_context(coder, models, context, below);
      below = &context;
    }
  }
}

}  // namespace

Parameters parse_parameters(ByteSpan bytes) {
  Parameters p;
  parse_kind(bytes, p);
  const std::uint64_t threshold = take_varint(bytes);
  if (threshold < 1 || threshold > kMaxThreshold)
    throw Error(ErrorKind::corrupt, "model: bad threshold");
  p.activity_threshold = static_cast<std::int32_t>(threshold);
  p.weight_step = take_bytes(bytes, 1).front();
  if (p.weight_step > 8) throw Error(ErrorKind::corrupt, "model: bad weight step");
  BinaryDecoder coder(bytes);
  walk_weights(p, WeightGetter{coder});
  parse_context_weights(coder, p);
  parse_frequencies(coder, p);
  if (p.has_edges) get_edge_frequencies(coder, p.edge_frequencies);
  if (!coder.is_consumed()) throw Error(ErrorKind::corrupt, "model: wrong length");
  return p;
}

}  // namespace octavo::grey
