#include "octavo/codec/grey/grey_codec.h"

#include <algorithm>
#include <cstdlib>
#include <type_traits>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"
#include "octavo/codec/grey/voxel_walk.h"

namespace octavo::grey {

namespace {

std::uint64_t stored_bytes(const SampleScale& scale, const Size3& size) {
  return (static_cast<std::uint64_t>(size.voxel_count()) *
              static_cast<std::uint64_t>(scale.plain_width()) + 7) / 8;
}

/// Samples as plain bits above the smallest one.
template <class Sample>
Bytes encode_plain(const SampleScale& scale, const std::vector<Sample>& samples) {
  Bytes out;
  BitWriter bits(out);
  for (const Sample s : samples) {
    bits.put(static_cast<std::uint64_t>(s - scale.min_sample()), scale.plain_width());
  }
  bits.finish();
  return out;
}

template <class Sample>
std::vector<Sample> decode_plain(const SampleScale& scale, ByteSpan bytes, const Size3& size) {
  if (bytes.size() != stored_bytes(scale, size)) {
    throw Error(ErrorKind::corrupt, "plain samples: " + std::to_string(bytes.size()) + " bytes, " +
                                        std::to_string(stored_bytes(scale, size)) + " expected");
  }
  std::vector<Sample> samples(static_cast<std::size_t>(size.voxel_count()));
  BitReader bits(bytes);
  for (Sample& s : samples) {
    const auto above = static_cast<std::int64_t>(bits.get(scale.plain_width()));
    s = static_cast<Sample>(std::min(scale.min_sample() + above, scale.max_sample()));
  }
  return samples;
}

/// The voxel of a sample, within the brick's range.
struct VoxelScale {
  ValueRange range;
  std::int64_t base;
  CodeScale codes;

  VoxelScale(const SampleScale& scale, const ValueRange& voxels)
      : range(voxels), base(scale.base()), codes(scale.codes) {}
  std::int64_t operator()(std::int64_t sample) const {
    return std::clamp(codes.voxel_of(sample + base), range.min, range.max);
  }
};

/// The segment of in-brick level 1 starts with the cell flags: a varint of their length, then the
/// bytes.
void put_cells(Bytes& segment, const BrickShape& shape, int level, const UniformCells& cells) {
  if (level != 1 || !has_cells(shape)) return;
  const Bytes flags = encode_cells(cells);
  put_varint(segment, flags.size());
  segment.insert(segment.end(), flags.begin(), flags.end());
}

/// Segments of a brick; leaves the samples of level 0, as a decoder will have them, in the thread's
/// work space.
template <class Sample>
std::vector<Bytes> encode_samples(const Model& model, const BrickShape& shape,
                                  const AnalyzedBrick<Sample>& brick) {
  std::vector<Bytes> segments(static_cast<std::size_t>(shape.level_count));
  segments.back() = encode_plain(brick.scale, brick.coarsest);

  const StagePasses<Sample>& passes = stage_functions().of<Sample>();
  Workspace<Sample>& work = thread_workspace<Sample>();
  load_means(work, brick.coarsest.data(),
             shape.size[static_cast<std::size_t>(shape.level_count) - 1]);
  // Kept from brick to brick: fresh memory costs more than filling it.
  static thread_local std::vector<Symbol> symbols;
  for (int level = shape.level_count - 2; level >= 0; --level) {
    const auto slot = static_cast<std::size_t>(level);
    // Edges and residuals of all splits of the level
    symbols.clear();
    run_level(work, shape, brick.scale, model.parameters, level, brick.hints(model.parameters),
              [&](const Stage& stage, const Split& split) {
                const auto& samples = brick.steps[slot][static_cast<std::size_t>(split.axis)];
                load_details(work, stage, Target<Sample>{samples.data(), split.fine_size});
                if (stage.has_edges) {
                  mark_edges(stage, work);
                  symbols.insert(symbols.end(), work.edge_symbols.begin(),
                                 work.edge_symbols.end());
                }
                passes.encode(model.parameters, stage, work, symbols);
              });
    // The segment: flagged cells, then edges and residuals
    put_cells(segments[slot], shape, level, brick.cells);
    if (symbols.empty()) continue;
    const std::int64_t details =
        level_detail_count(shape, level, brick.hints(model.parameters).cells);
    const Bytes coded =
        encode_symbols(model, table_set(level), symbols, details, brick.scale.shift());
    segments[slot].insert(segments[slot].end(), coded.begin(), coded.end());
  }
  return segments;
}

/// Puts the corrections that a quantized brick needs before its segment 0 and notes the error that
/// is left; false when a correction would be too large.
template <class Sample>
bool put_corrections(EncodedBrick& encoded, const BrickView& view, const SampleScale& scale,
                     const Parameters& p) {
  const SampleGrid<Sample>& grid = thread_workspace<Sample>().means;
  const std::int64_t step = p.quantizer.correction_step;
  const VoxelScale voxel_of(scale, encoded.range);
  const Size3& size = view.size;
  Corrections corrections;
  corrections.reserve(static_cast<std::size_t>(size.voxel_count()));
  Index3 at{0, 0, 0};
  bool fits = true;
  for_each_voxel(view, [&](std::int64_t voxel) {
    const auto in = [&](int axis) { return at[p.axis_order[static_cast<std::size_t>(axis)]]; };
    const std::int64_t decoded = voxel_of(grid.row(in(1), in(2))[in(0)]);
    const std::int64_t correction = CodeScale{step}.code_of(voxel - decoded);
    fits = fits && correction >= -kMaxCorrection && correction <= kMaxCorrection;
    corrections.push_back(static_cast<std::int8_t>(correction));
    const std::int64_t corrected =
        std::clamp(decoded + correction * step, encoded.range.min, encoded.range.max);
    encoded.max_error = std::max(encoded.max_error, std::abs(voxel - corrected));
    if (++at.x == size.x) at = {0, at.y + 1, at.z};
    if (at.y == size.y) at = {0, 0, at.z + 1};
  });
  Bytes segment;
  const Bytes coded = encode_corrections(corrections, size);
  put_varint(segment, coded.size());
  segment.insert(segment.end(), coded.begin(), coded.end());
  Bytes& finest = encoded.segments[0];
  finest.insert(finest.begin(), segment.begin(), segment.end());
  return fits;
}

/// The largest error that rounding to the voxel step leaves.
std::int64_t rounding_error(const BrickView& view, const SampleScale& scale,
                            const ValueRange& range) {
  if (scale.codes.step == 1) return 0;
  std::int64_t most = 0;
  for_each_voxel(view, [&](std::int64_t voxel) {
    const std::int64_t decoded =
        std::clamp(scale.codes.voxel_of(scale.codes.code_of(voxel)), range.min, range.max);
    most = std::max(most, std::abs(voxel - decoded));
  });
  return most;
}

/// A brick that coding would enlarge is stored: all voxels plain in segment 0, the other segments
/// empty.
template <class Sample>
void store(EncodedBrick& encoded, const BrickShape& shape, const BrickView& view,
           const SampleScale& scale, const AxisOrder& order) {
  BrickShape flat = shape;
  flat.level_count = 1;
  for (Bytes& segment : encoded.segments) segment.clear();
  encoded.segments[0] = encode_plain(scale, analyze<Sample>(flat, view, scale, order).coarsest);
  encoded.max_error = rounding_error(view, scale, encoded.range);
}

template <class Sample>
EncodedBrick encode_brick(const Model& model, const BrickShape& shape, const BrickView& view,
                          const ValueRange& voxels, const SampleScale& scale,
                          const BrickMap& map) {
  const AxisOrder& order = model.parameters.axis_order;
  auto brick = analyze<Sample>(shape, view, scale, order);
  brick.gaps = gaps_of(model.parameters.value_map, map, shape, scale);
  const Quantizer& quantizer = model.parameters.quantizer;
  EncodedBrick encoded;
  encoded.range = voxels;
  encoded.parent = std::clamp(scale.codes.voxel_of(brick.parent), encoded.range.min,
                              encoded.range.max);
  encoded.segments = encode_samples(model, shape, brick);
  bool is_possible = true;
  if (quantizer.correction_step > 0 && shape.level_count > 1) {
    is_possible = put_corrections<Sample>(encoded, view, scale, model.parameters);
  } else {
    encoded.max_error = rounding_error(view, scale, encoded.range);
  }
  std::uint64_t coded = 0;
  for (const Bytes& segment : encoded.segments) coded += segment.size();
  const bool is_larger = shape.level_count > 1 && coded >= stored_bytes(scale, shape.size[0]);
  if (is_larger || !is_possible) store<Sample>(encoded, shape, view, scale, order);
  if (!model.parameters.value_map.is_empty()) {
    Bytes& plain = encoded.segments.back().empty() ? encoded.segments.front()
                                                   : encoded.segments.back();
    Bytes start;
    put_brick_map(start, map);
    plain.insert(plain.begin(), start.begin(), start.end());
  }
  return encoded;
}

/// Voxels of a row of samples.
template <class T, class Sample>
void write_out(const Sample* samples, std::int64_t count, const SampleScale& scale,
               const VoxelScale* clamping, T* out) {
  if (clamping != nullptr) {
    for (std::int64_t i = 0; i < count; ++i) out[i] = static_cast<T>((*clamping)(samples[i]));
  } else if (scale.codes.step > 1) {
    // Voxels are sums modulo their type.
    static_assert(sizeof(T) <= sizeof(std::uint32_t));
    const auto factor = static_cast<std::uint32_t>(scale.codes.step);
    const auto base = static_cast<std::uint32_t>(scale.codes.voxel_of(scale.base()));
    for (std::int64_t i = 0; i < count; ++i) {
      out[i] = static_cast<T>(static_cast<std::uint32_t>(samples[i]) * factor + base);
    }
  } else if constexpr (std::is_integral_v<T> && sizeof(T) <= sizeof(Sample)) {
    // Voxels are sums modulo their type.
    using Unsigned = std::make_unsigned_t<T>;
    const auto base = static_cast<Unsigned>(scale.base());
    for (std::int64_t i = 0; i < count; ++i) {
      out[i] = static_cast<T>(static_cast<Unsigned>(static_cast<Unsigned>(samples[i]) + base));
    }
  } else {
    const std::int64_t base = scale.base();
    for (std::int64_t i = 0; i < count; ++i) out[i] = static_cast<T>(samples[i] + base);
  }
}

/// What a decoder needs to know of a brick.
struct Source {
  const Model& model;
  const BrickShape& shape;  ///< in the codec's axes
  const Size3& brick_size;  ///< of level 0, in the brick's
  VoxelType type;
  ValueRange range;
  SampleScale scale;
  BrickMap map;
  std::span<const ByteSpan> segments;
  int level;

  bool is_lossless() const { return model.parameters.quantizer.is_lossless(); }
};

/// Writes the voxels of a level in the brick's own axes; `row_of(y, z)` gives rows of samples in
/// the codec's.
template <class Sample, class RowOf>
void write_level(const Source& source, RowOf&& row_of, void* out) {
  const AxisOrder& order = source.model.parameters.axis_order;
  const VoxelScale voxel_of(source.scale, source.range);
  const VoxelScale* const clamping = source.is_lossless() ? nullptr : &voxel_of;
  const Size3& size = source.shape.size[static_cast<std::size_t>(source.level)];
  // Steps of the dense result along the codec's axes.
  Size3 dense{1, 1, 1};
  std::int64_t step = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = std::find(order.begin(), order.end(), axis) - order.begin();
    dense[static_cast<int>(at)] = step;
    step *= size[static_cast<int>(at)];
  }
  with_voxel_type(source.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    T* const voxels = static_cast<T*>(out);
    for_each_tile(size, dense, [&](std::int64_t y, std::int64_t z, int axis, int count) {
      T* const first = voxels + y * dense.y + z * dense.z;
      if (dense.x == 1) {
        write_out(row_of(y, z), size.x, source.scale, clamping, first);
        return;
      }
      T tile[kTileRows][kBrickSide];
      for (int k = 0; k < count; ++k) {
        write_out(row_of(y + (axis == 1 ? k : 0), z + (axis == 2 ? k : 0)), size.x, source.scale,
                  clamping, tile[k]);
      }
      for (std::int64_t x = 0; x < size.x; ++x) {
        for (int k = 0; k < count; ++k) first[x * dense.x + k] = tile[k][x];
      }
    });
  });
}

template <class Sample>
void decode_stored(const Source& source, void* out) {
  const BrickShape& shape = source.shape;
  std::vector<Sample> samples =
      decode_plain<Sample>(source.scale, source.segments[0], shape.size[0]);
  for (int i = 0; i < source.level; ++i) {
    samples = coarser_level(std::move(samples), shape, i);
  }
  const Size3& size = shape.size[static_cast<std::size_t>(source.level)];
  write_level<Sample>(
      source,
      [&](std::int64_t y, std::int64_t z) { return samples.data() + (z * size.y + y) * size.x; },
      out);
}

/// Takes the corrections off the front of segment 0.
Corrections take_corrections(ByteSpan& segment, const Size3& size) {
  const std::uint64_t length = take_varint(segment);
  return decode_corrections(take_bytes(segment, length), size);
}

void apply(const Corrections& corrections, std::int64_t step, VoxelType type,
           const ValueRange& range, void* out) {
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    T* const voxels = static_cast<T*>(out);
    for (std::size_t i = 0; i < corrections.size(); ++i) {
      if (corrections[i] == 0) continue;
      const auto moved = static_cast<std::int64_t>(voxels[i]) + corrections[i] * step;
      voxels[i] = static_cast<T>(std::clamp(moved, range.min, range.max));
    }
  });
}

template <class Sample>
void decode_samples(const Source& source, void* out) {
  const BrickShape& shape = source.shape;
  const Parameters& parameters = source.model.parameters;
  const auto last = static_cast<std::size_t>(shape.level_count) - 1;
  const std::vector<Sample> coarsest =
      decode_plain<Sample>(source.scale, source.segments[last], shape.size[last]);
  Workspace<Sample>& work = thread_workspace<Sample>();
  load_means(work, coarsest.data(), shape.size[last]);
  std::unique_ptr<const ValueGaps> gaps;
  if (source.level == 0) gaps = gaps_of(parameters.value_map, source.map, shape, source.scale);
  UniformCells cells;
  Corrections corrections;
  for (int at = static_cast<int>(last) - 1; at >= source.level; --at) {
    // What stands before the details: corrections, flagged cells
    ByteSpan segment = source.segments[static_cast<std::size_t>(at)];
    if (at == 0 && parameters.quantizer.correction_step > 0) {
      corrections = take_corrections(segment, source.brick_size);
    }
    if (at == 1 && has_cells(shape)) {
      const std::uint64_t length = take_varint(segment);
      cells = decode_cells(take_bytes(segment, length), shape.size[2]);
    }
    // A level without details repeats its means
    const BrickHints hints{cells.flags.empty() ? nullptr : &cells, gaps.get(),
                           parameters.has_edges};
    const std::int64_t details = level_detail_count(shape, at, hints.cells);
    if (details == 0) {
      if (!segment.empty())
        throw Error(ErrorKind::corrupt, "a segment without details is not empty");
      static const Parameters kRepeating{};
      run_level(work, shape, source.scale, kRepeating, at, hints,
                [&](const Stage&, const Split&) {});
      continue;
    }
    // Edges, then residuals, split by split
    SymbolReader symbols(source.model, table_set(at), segment, details, source.scale.shift());
    run_level(work, shape, source.scale, parameters, at, hints,
              [&](const Stage& stage, const Split&) {
                if (stage.has_edges) take_edges(stage, work, symbols);
                stage_functions().of<Sample>().decode(parameters, stage, work, symbols);
              });
    symbols.finish();
  }
  write_level<Sample>(
      source, [&](std::int64_t y, std::int64_t z) { return work.means.row(y, z); }, out);
  if (source.level == 0) {
    apply(corrections, parameters.quantizer.correction_step, source.type, source.range, out);
  }
}

}  // namespace

GreyCodec::GreyCodec(const Parameters& parameters) {
  auto model = std::make_unique<Model>();
  model->parameters = parameters;
  build_tables(*model);
  model_ = std::move(model);
}

EncodedBrick GreyCodec::encode(const BrickShape& shape, const BrickView& view) const {
  const Quantizer& quantizer = model_->parameters.quantizer;
  const ValueRange voxels = range_of(view);
  const std::int64_t allowed =
      (std::max<std::int64_t>({quantizer.voxel_step, quantizer.correction_step, 1}) - 1) / 2;
  if (voxels.max - voxels.min <= 2 * allowed) {
    const std::int64_t middle = voxels.min + (voxels.max - voxels.min) / 2;
    return {{middle, middle}, middle, voxels.max - middle,
            std::vector<Bytes>(static_cast<std::size_t>(shape.level_count))};
  }
  const Parameters& parameters = model_->parameters;
  const BrickMap map = map_brick(parameters.value_map, view, voxels, shape.first_level == 0);
  const SampleScale scale = SampleScale::of_voxels(voxels, code_scale(parameters, map));
  const BrickShape inner = in_order(shape, parameters.axis_order);
  return with_sample_type(scale, [&](auto sample) {
    return encode_brick<decltype(sample)>(*model_, inner, view, voxels, scale, map);
  });
}

void GreyCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                       std::span<const ByteSpan> segments, int level, void* out) const {
  const std::int64_t count = shape.size[static_cast<std::size_t>(level)].voxel_count();
  if (range.min == range.max) {
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      std::fill_n(static_cast<T*>(out), count, static_cast<T>(range.min));
    });
    return;
  }
  const bool is_stored = shape.level_count > 1 && segments.back().empty();
  const auto holds_bytes = [](ByteSpan segment) { return !segment.empty(); };
  if (is_stored && std::any_of(segments.begin() + 1, segments.end(), holds_bytes)) {
    throw Error(ErrorKind::corrupt, "a stored brick has more than one segment");
  }
  const Parameters& parameters = model_->parameters;
  std::vector<ByteSpan> parts(segments.begin(), segments.end());
  BrickMap map;
  if (!parameters.value_map.is_empty()) {
    map = take_brick_map(parameters.value_map, range, is_stored ? parts.front() : parts.back());
    if (map.has_gaps && shape.first_level > 0) {
      throw Error(ErrorKind::corrupt, "a brick of means has gaps between its values");
    }
  }
  const BrickShape inner = in_order(shape, parameters.axis_order);
  const SampleScale scale = SampleScale::of_voxels(range, code_scale(parameters, map));
  const Source source{*model_, inner, shape.size[0], type, range, scale, map, parts, level};
  with_sample_type(source.scale, [&](auto sample) {
    using Sample = decltype(sample);
    if (is_stored) decode_stored<Sample>(source, out);
    else decode_samples<Sample>(source, out);
  });
}

}  // namespace octavo::grey

namespace octavo {

std::unique_ptr<BrickCodec> parse_grey_model(VoxelType type, ByteSpan bytes) {
  if (!is_integer(type)) throw Error(ErrorKind::corrupt, "a grey model for float voxels");
  return std::make_unique<grey::GreyCodec>(grey::parse_parameters(bytes));
}

}  // namespace octavo
