#include "octavo/codec/grey/grey_codec.h"

#include <algorithm>
#include <cstdlib>
#include <type_traits>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"
#include "octavo/codec/grey/grey_interpolation.h"
#include "octavo/codec/grey/grey_parts.h"
#include "octavo/codec/grey/grey_voxels.h"
#include "octavo/codec/grey/plain_samples.h"
#include "octavo/codec/grey/voxel_walk.h"
#include "octavo/codec/stored_brick.h"
#include "octavo/core/crc32c.h"

namespace octavo::grey {

namespace {

/// The segment of in-brick level 1 starts with the cell flags: a varint of their length, then the
/// bytes.
void put_cells(Bytes& segment, const BrickShape& shape, int level, const UniformCells& cells) {
  if (level != 1 || !has_cells(shape)) return;
  const Bytes flags = encode_cells(cells);
  put_varint(segment, flags.size());
  segment.insert(segment.end(), flags.begin(), flags.end());
}

/// Corrections of the voxels that quantized details would leave beyond the maximum error.
template <class Sample>
class Corrector {
 public:
  Corrector(const Parameters& p, const BrickView& view, const SampleScale& scale,
            const ValueRange& range)
      : order_(p.axis_order),
        step_(p.quantizer.correction_step),
        view_(view),
        range_(range),
        voxel_of_(scale, range) {}

  /// The corrections of a part, with their length, from its samples as a decoder will have them.
  Bytes encode(const Part& part, const SampleGrid<Sample>& grid) {
    const BrickView view = part_of(view_, own_box(part, order_));
    const Size3& size = view.size;
    Corrections corrections;
    corrections.reserve(static_cast<std::size_t>(size.voxel_count()));
    Index3 at{0, 0, 0};
    for_each_voxel(view, [&](std::int64_t voxel) {
      const auto in = [&](int axis) { return at[order_[static_cast<std::size_t>(axis)]]; };
      const std::int64_t decoded = voxel_of_(grid.row(in(1), in(2))[in(0)]);
      const std::int64_t correction = CodeScale{step_}.code_of(voxel - decoded);
      fits_ = fits_ && correction >= -kMaxCorrection && correction <= kMaxCorrection;
      corrections.push_back(static_cast<std::int8_t>(correction));
      const std::int64_t corrected =
          std::clamp(decoded + correction * step_, range_.min, range_.max);
      max_error_ = std::max(max_error_, std::abs(voxel - corrected));
      if (++at.x == size.x) at = {0, at.y + 1, at.z};
      if (at.y == size.y) at = {0, 0, at.z + 1};
    });
    const Bytes coded = encode_corrections(corrections, size);
    Bytes out;
    put_varint(out, coded.size());
    out.insert(out.end(), coded.begin(), coded.end());
    return out;
  }

  /// Whether no correction was too large.
  bool fits() const { return fits_; }
  /// The largest error that is left.
  std::int64_t max_error() const { return max_error_; }

 private:
  static BrickView part_of(const BrickView& view, const Box& box) {
    BrickView part = view;
    part.size = box.size();
    const std::int64_t first =
        box.lo.z * view.plane_stride + box.lo.y * view.row_stride + box.lo.x;
    part.voxels = static_cast<const std::byte*>(view.voxels) + first * bytes_per_voxel(view.type);
    return part;
  }

  AxisOrder order_;
  std::int64_t step_;
  BrickView view_;
  ValueRange range_;
  VoxelScale voxel_of_;
  bool fits_ = true;
  std::int64_t max_error_ = 0;
};

/// Edges and residuals of all splits of a level or of a part of it, whose samples, as a decoder
/// will have them, are left in the work space.
template <class Sample>
Bytes encode_details(const Model& model, const BrickShape& shape,
                     const AnalyzedBrick<Sample>& brick, const Part& part, int level,
                     const BrickHints& hints, int most_states) {
  const Parameters& p = model.parameters;
  Workspace<Sample>& work = thread_workspace<Sample>();
  // Kept from brick to brick: fresh memory costs more than filling it.
  static thread_local std::vector<Symbol> symbols;
  symbols.clear();
  run_level(work, part, brick.scale, p, level, hints, reach_of(p.predictor),
            [&](const Stage& stage, const Split& split) {
              load_details(work, stage, target_of(brick, shape, part, level, split.axis));
              if (stage.has_edges) {
                mark_edges(stage, work);
                symbols.insert(symbols.end(), work.edge_symbols.begin(), work.edge_symbols.end());
              }
              stage_functions().of<Sample>().encode(p, stage, work, symbols);
            });
  if (symbols.empty()) return {};
  const std::int64_t details = level_detail_count(part.shape, level, hints.cells);
  return encode_symbols(model, table_set(level), symbols, details, brick.scale.shift(),
                        most_states);
}

/// Segments of a brick.
/// corrector  null where details are exact
template <class Sample>
std::vector<Bytes> encode_samples(const Model& model, const BrickShape& shape,
                                  const AnalyzedBrick<Sample>& brick,
                                  Corrector<Sample>* corrector) {
  std::vector<Bytes> segments(static_cast<std::size_t>(shape.level_count));
  segments.back() = encode_plain(brick.scale, brick.coarsest);
  const Parameters& p = model.parameters;
  const bool is_cut = has_parts(shape, p.cut_axes);
  Workspace<Sample>& work = thread_workspace<Sample>();
  load_means(work, brick.coarsest.data(),
             shape.size[static_cast<std::size_t>(shape.level_count) - 1]);
  std::vector<PartBytes> entries;
  for (int level = shape.level_count - 2; level >= 0; --level) {
    Bytes& segment = segments[static_cast<std::size_t>(level)];
    put_cells(segment, shape, level, brick.cells);
    const bool has_entries = level == 0 && is_cut;
    const int most_states = has_entries ? most_part_states(p.cut_axes) : kMaxStates;
    for_each_part(work, shape, p.cut_axes, level, brick.hints(p),
                  [&](const Part& part, const BrickHints& hints) {
                    const Bytes details =
                        encode_details(model, shape, brick, part, level, hints, most_states);
                    Bytes bytes;
                    if (level == 0 && corrector != nullptr) {
                      bytes = corrector->encode(part, work.means);
                    }
                    bytes.insert(bytes.end(), details.begin(), details.end());
                    if (has_entries) entries.push_back(PartBytes::of(bytes));
                    segment.insert(segment.end(), bytes.begin(), bytes.end());
                  });
  }
  if (is_cut) {
    Bytes list;
    put_part_list(list, entries);
    segments[1].insert(segments[1].begin(), list.begin(), list.end());
  }
  return segments;
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

/// A brick that coding would enlarge is stored: all its samples plain in segment 0, the other
/// segments empty.
template <class Sample>
void store(EncodedBrick& encoded, const AnalyzedBrick<Sample>& brick, const BrickView& view) {
  for (Bytes& segment : encoded.segments) segment.clear();
  encoded.segments[0] = encode_plain(brick.scale, finest_samples(brick));
  encoded.max_error = rounding_error(view, brick.scale, encoded.range);
}

/// Puts the segments of a brick that begins at in-brick level `first` where the whole brick has
/// them: that of a stored one stays in front.
void move_up(std::vector<Bytes>& segments, int first) {
  const bool is_stored = segments.back().empty();
  const auto place = is_stored ? segments.end() : segments.begin();
  segments.insert(place, static_cast<std::size_t>(first), Bytes{});
}

template <class Sample>
EncodedBrick encode_brick(const Model& model, const BrickShape& whole, const BrickView& view,
                          const ValueRange& voxels, const SampleScale& scale,
                          const BrickMap& map) {
  const AxisOrder& order = model.parameters.axis_order;
  const int first = detailed_level(model.parameters, whole);
  const BrickShape shape = shape_from(whole, first);
  auto brick = analyze<Sample>(whole, view, scale, order, first);
  brick.gaps = gaps_of(model.parameters.value_map, map, shape, scale);
  const Quantizer& quantizer = model.parameters.quantizer;
  EncodedBrick encoded;
  encoded.range = voxels;
  encoded.parent = std::clamp(scale.codes.voxel_of(brick.parent), encoded.range.min,
                              encoded.range.max);
  bool is_possible = true;
  if (quantizer.correction_step > 0 && shape.level_count > 1) {
    Corrector<Sample> corrector(model.parameters, view, scale, voxels);
    encoded.segments = encode_samples(model, shape, brick, &corrector);
    encoded.max_error = corrector.max_error();
    is_possible = corrector.fits();
  } else {
    encoded.segments = encode_samples<Sample>(model, shape, brick, nullptr);
    encoded.max_error = rounding_error(view, scale, encoded.range);
  }
  std::uint64_t coded = 0;
  for (const Bytes& segment : encoded.segments) coded += segment.size();
  const bool is_larger = shape.level_count > 1 && coded >= stored_bytes(scale, shape.size[0]);
  if (is_larger || !is_possible) store(encoded, brick, view);
  if (!model.parameters.value_map.is_empty()) {
    Bytes& plain = encoded.segments.back().empty() ? encoded.segments.front()
                                                   : encoded.segments.back();
    Bytes start;
    put_brick_map(start, map);
    plain.insert(plain.begin(), start.begin(), start.end());
  }
  if (first > 0) {
    encoded.detailed =
        finest_voxels(brick, shape.size[0], {view.type, voxels, scale, order, true});
    move_up(encoded.segments, first);
  }
  return encoded;
}

/// What a decoder needs to know of a brick.
struct Source {
  const Model& model;
  BrickShape shape;  ///< in the codec's axes
  VoxelType type;
  ValueRange range;
  SampleScale scale;
  BrickMap map;

  const Parameters& parameters() const { return model.parameters; }
  bool is_corrected() const { return parameters().quantizer.correction_step > 0; }
  VoxelWriter writer() const {
    return {type, range, scale, parameters().axis_order, parameters().quantizer.is_lossless()};
  }
};

template <class Sample>
void decode_stored(const Source& source, ByteSpan segment, int level, const VoxelTarget& out) {
  const BrickShape& shape = source.shape;
  std::vector<Sample> samples = decode_plain<Sample>(source.scale, segment, shape.size[0]);
  for (int i = 0; i < level; ++i) {
    samples = coarser_level(std::move(samples), shape, i);
  }
  const Size3& size = shape.size[static_cast<std::size_t>(level)];
  source.writer().write(
      size,
      [&](std::int64_t y, std::int64_t z) { return samples.data() + (z * size.y + y) * size.x; },
      out);
}

template <class Sample>
std::int64_t decode_parent_sample(const Source& source, std::span<const ByteSpan> segments,
                                  bool is_stored) {
  const BrickShape& shape = source.shape;
  const int first = is_stored ? 0 : shape.level_count - 1;
  const auto slot = static_cast<std::size_t>(first);
  std::vector<Sample> samples =
      decode_plain<Sample>(source.scale, segments[slot], shape.size[slot]);
  for (int level = first; level < shape.level_count; ++level) {
    samples = coarser_level(std::move(samples), shape, level);
  }
  const std::int64_t code = samples.front() + source.scale.base();
  return std::clamp(source.scale.codes.voxel_of(code), source.range.min, source.range.max);
}

/// Takes the corrections off the front of segment 0, or of a part.
Corrections take_corrections(ByteSpan& segment, const Size3& size) {
  const std::uint64_t length = take_varint(segment);
  return decode_corrections(take_bytes(segment, length), size);
}

void apply(const Corrections& corrections, const Source& source, const Size3& size,
           const VoxelTarget& out) {
  const std::int64_t step = source.parameters().quantizer.correction_step;
  with_voxel_type(source.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const std::int8_t* correction = corrections.data();
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        T* const row = static_cast<T*>(out.voxels) + z * out.plane_stride + y * out.row_stride;
        for (std::int64_t x = 0; x < size.x; ++x, ++correction) {
          if (*correction == 0) continue;
          const auto moved = static_cast<std::int64_t>(row[x]) + *correction * step;
          row[x] = static_cast<T>(std::clamp(moved, source.range.min, source.range.max));
        }
      }
    }
  });
}

/// What the levels of a brick tell of the finer ones.
struct LevelState {
  UniformCells cells;
  std::unique_ptr<const ValueGaps> gaps;  ///< only where level 0 is decoded
  std::vector<PartBytes> entries;  ///< of the parts of level 0; empty when it has none

  BrickHints hints(const Parameters& p) const {
    return {cells.flags.empty() ? nullptr : &cells, gaps.get(), p.has_edges};
  }
};

/// Decodes the splits of a level, or of a part of it, from its edges and residuals; its means stand
/// in the work space.
template <class Sample>
void decode_details(const Source& source, const Part& part, int level, ByteSpan segment,
                    const BrickHints& hints, int most_states) {
  const Parameters& p = source.parameters();
  Workspace<Sample>& work = thread_workspace<Sample>();
  // A level without details repeats its means
  const std::int64_t details = level_detail_count(part.shape, level, hints.cells);
  if (details == 0) {
    if (!segment.empty()) throw Error(ErrorKind::corrupt, "a segment without details has bytes");
    static const Parameters kRepeating{};
    run_level(work, part, source.scale, kRepeating, level, hints, Margins::all,
              [](const Stage&, const Split&) {});
    return;
  }
  // Edges, then residuals, split by split
  SymbolReader symbols(source.model, table_set(level), segment, details, source.scale.shift(),
                       most_states);
  run_level(work, part, source.scale, p, level, hints, reach_of(p.predictor),
            [&](const Stage& stage, const Split&) {
              if (stage.has_edges) take_edges(stage, work, symbols);
              stage_functions().of<Sample>().decode(p, stage, work, symbols);
            });
  symbols.finish();
}

/// Decodes the levels from the coarsest to `level`, but not level 0, into the work space.
template <class Sample>
LevelState decode_coarser(const Source& source, std::span<const ByteSpan> segments, int level) {
  const BrickShape& shape = source.shape;
  const Parameters& p = source.parameters();
  const auto last = static_cast<std::size_t>(shape.level_count) - 1;
  const std::vector<Sample> coarsest =
      decode_plain<Sample>(source.scale, segments[last], shape.size[last]);
  load_means(thread_workspace<Sample>(), coarsest.data(), shape.size[last]);
  LevelState state;
  for (int at = static_cast<int>(last) - 1; at >= std::max(level, 1); --at) {
    ByteSpan segment = segments[static_cast<std::size_t>(at)];
    if (at == 1 && has_parts(shape, p.cut_axes)) {
      state.entries = take_part_list(segment, parts_of(shape, p.cut_axes).size());
    }
    if (at == 1 && has_cells(shape)) {
      const std::uint64_t length = take_varint(segment);
      state.cells = decode_cells(take_bytes(segment, length), shape.size[2]);
    }
    decode_details<Sample>(source, Part{shape, {}, {}, kAllFaces}, at, segment,
                           state.hints(p), kMaxStates);
  }
  if (level == 0) state.gaps = gaps_of(p.value_map, source.map, shape, source.scale);
  return state;
}

/// Decodes level 0 of a brick, or a part of it, to voxels; its means stand in the work space.
template <class Sample>
void decode_finest(const Source& source, const Part& part, ByteSpan segment,
                   const BrickHints& hints, int most_states, const VoxelTarget& out) {
  const Size3 size = own_box(part, source.parameters().axis_order).size();
  Corrections corrections;
  if (source.is_corrected()) corrections = take_corrections(segment, size);
  decode_details<Sample>(source, part, 0, segment, hints, most_states);
  source.writer().write(thread_workspace<Sample>().means, out);
  if (source.is_corrected()) apply(corrections, source, size, out);
}

/// The bytes of the parts in segment 0. Throws Error{corrupt} when the parts do not fill it.
std::vector<ByteSpan> split_segment(ByteSpan segment, const std::vector<PartBytes>& entries) {
  std::vector<ByteSpan> parts;
  for (const PartBytes& entry : entries) parts.push_back(take_bytes(segment, entry.length));
  if (!segment.empty()) throw Error(ErrorKind::corrupt, "bytes behind the parts of a brick");
  return parts;
}

template <class Sample>
void decode_samples(const Source& source, std::span<const ByteSpan> segments, int level,
                    const VoxelTarget& out) {
  const Parameters& p = source.parameters();
  const LevelState state = decode_coarser<Sample>(source, segments, level);
  Workspace<Sample>& work = thread_workspace<Sample>();
  if (level > 0 || source.shape.level_count == 1) {
    source.writer().write(work.means, out);
    return;
  }
  std::vector<ByteSpan> parts{segments[0]};
  if (!state.entries.empty()) parts = split_segment(segments[0], state.entries);
  const int most_states = state.entries.empty() ? kMaxStates : most_part_states(p.cut_axes);
  auto next = parts.begin();
  for_each_part(work, source.shape, p.cut_axes, 0, state.hints(p),
                [&](const Part& part, const BrickHints& hints) {
                  const Index3 at = own_box(part, p.axis_order).lo;
                  decode_finest<Sample>(source, part, *next++, hints, most_states,
                                        target_from(out, at, source.type));
                });
}

/// Decodes a level that has no details.
/// source    of the brick from its first level with details on, and so are segments
/// whole     the shape of all of it, in the codec's axes
template <class Sample>
void decode_interpolated(const Source& source, const BrickShape& whole, bool is_stored,
                         std::span<const ByteSpan> segments, int level, const VoxelTarget& out) {
  const BrickShape& shape = source.shape;
  Workspace<Sample>& work = thread_workspace<Sample>();
  if (is_stored) {
    load_means(work, decode_plain<Sample>(source.scale, segments[0], shape.size[0]).data(),
               shape.size[0]);
  } else {
    const LevelState state = decode_coarser<Sample>(source, segments, 0);
    if (shape.level_count > 1) {
      decode_details<Sample>(source, Part{shape, {}, {}, kAllFaces}, 0, segments[0],
                             state.hints(source.parameters()), kMaxStates);
    }
  }
  interpolate_levels(work, whole, source.scale, whole.level_count - shape.level_count, level);
  source.writer().write(work.means, out);
}

template <class Sample>
class GreyParts final : public BrickParts {
 public:
  GreyParts(const Source& source, std::span<const ByteSpan> segments)
      : source_(source),
        state_(decode_coarser<Sample>(source, segments, 0)),
        coarse_(thread_workspace<Sample>().means),
        parts_(parts_of(source.shape, source.parameters().cut_axes)) {
    std::uint64_t offset = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const std::uint64_t length = state_.entries[i].length;
      const Box box = own_box(parts_[i], source.parameters().axis_order);
      own_parts_.push_back({box, offset, length});
      if (length > kMaxPartBytes) throw Error(ErrorKind::corrupt, "a part is too long");
      offset += length;
    }
  }

  const std::vector<BrickParts::Part>& parts() const noexcept override { return own_parts_; }

  void decode(std::size_t number, ByteSpan bytes, const VoxelTarget& out) const override {
    const PartBytes& entry = state_.entries[number];
    if (bytes.size() != entry.length || !checksum_matches(crc32c(bytes), entry.crc)) {
      throw Error(ErrorKind::corrupt, "a part of a brick has another checksum");
    }
    const Parameters& p = source_.parameters();
    coarse_.put(parts_[number], thread_workspace<Sample>().means);
    const PartHints own(parts_[number], state_.hints(p));
    decode_finest<Sample>(source_, parts_[number], bytes, own.hints,
                          most_part_states(p.cut_axes), out);
  }

 private:
  /// More than any segment may have: sums of lengths do not overflow.
  static constexpr std::uint64_t kMaxPartBytes = std::uint64_t{1} << 32;

  Source source_;
  LevelState state_;
  CoarseSamples<Sample> coarse_;
  std::vector<grey::Part> parts_;
  std::vector<BrickParts::Part> own_parts_;
};

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
  const bool has_voxels = shape.first_level == 0 && detailed_level(parameters, shape) == 0;
  const BrickMap map = map_brick(parameters.value_map, view, voxels, has_voxels);
  const SampleScale scale = SampleScale::of_voxels(voxels, code_scale(parameters, map));
  const BrickShape inner = in_order(shape, parameters.axis_order);
  return with_sample_type(scale, [&](auto sample) {
    return encode_brick<decltype(sample)>(*model_, inner, view, voxels, scale, map);
  });
}

namespace {

/// plain  the segment with the plain samples, off which the brick's map is taken
Source source_of(const Model& model, const BrickShape& shape, VoxelType type,
                 const ValueRange& range, ByteSpan& plain) {
  const Parameters& p = model.parameters;
  BrickMap map;
  if (!p.value_map.is_empty()) map = take_brick_map(p.value_map, range, plain);
  if (map.has_gaps && shape.first_level > 0) {
    throw Error(ErrorKind::corrupt, "a brick of means has gaps between its values");
  }
  return {model, in_order(shape, p.axis_order), type, range,
          SampleScale::of_voxels(range, code_scale(p, map)), map};
}

}  // namespace

void GreyCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                       std::span<const ByteSpan> segments, int level, void* out) const {
  const Size3& size = shape.size[static_cast<std::size_t>(level)];
  if (range.min == range.max) {
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      std::fill_n(static_cast<T*>(out), size.voxel_count(), static_cast<T>(range.min));
    });
    return;
  }
  const int first = detailed_level(model_->parameters, shape);
  const bool stored = is_stored(shape, segments, first);
  std::vector<ByteSpan> bytes(segments.begin() + (stored ? 0 : first), segments.end());
  const Source source = source_of(*model_, shape_from(shape, first), type, range,
                                  stored ? bytes.front() : bytes.back());
  const VoxelTarget target = dense_target(out, size);
  with_sample_type(source.scale, [&](auto sample) {
    using Sample = decltype(sample);
    if (level < first) {
      const BrickShape whole = in_order(shape, model_->parameters.axis_order);
      decode_interpolated<Sample>(source, whole, stored, bytes, level, target);
    } else if (stored) {
      decode_stored<Sample>(source, bytes[0], level - first, target);
    } else {
      decode_samples<Sample>(source, bytes, level - first, target);
    }
  });
}

std::int64_t GreyCodec::decode_parent(const BrickShape& shape, VoxelType type,
                                      const ValueRange& range,
                                      std::span<const ByteSpan> segments) const {
  if (range.min == range.max) return range.min;
  const int first = detailed_level(model_->parameters, shape);
  const bool stored = is_stored(shape, segments, first);
  std::vector<ByteSpan> bytes(segments.begin() + (stored ? 0 : first), segments.end());
  const Source source = source_of(*model_, shape_from(shape, first), type, range,
                                  stored ? bytes.front() : bytes.back());
  return with_sample_type(source.scale, [&](auto sample) {
    return decode_parent_sample<decltype(sample)>(source, bytes, stored);
  });
}

bool GreyCodec::has_parts(const BrickShape& shape) const noexcept {
  const Parameters& p = model_->parameters;
  return grey::has_parts(in_order(shape, p.axis_order), p.cut_axes);
}

std::unique_ptr<BrickParts> GreyCodec::open_parts(const BrickShape& shape, VoxelType type,
                                                  const ValueRange& range,
                                                  std::span<const ByteSpan> segments) const {
  if (range.min == range.max || segments.back().empty() || !has_parts(shape)) return nullptr;
  std::vector<ByteSpan> bytes(segments.begin(), segments.end());
  const Source source = source_of(*model_, shape, type, range, bytes.back());
  return with_sample_type(source.scale, [&](auto sample) -> std::unique_ptr<BrickParts> {
    return std::make_unique<GreyParts<decltype(sample)>>(source, bytes);
  });
}

}  // namespace octavo::grey

namespace octavo {

std::unique_ptr<BrickCodec> parse_grey_model(VoxelType type, ByteSpan bytes, int detail_level) {
  if (!is_integer(type)) throw Error(ErrorKind::corrupt, "a grey model for float voxels");
  grey::Parameters parameters = grey::parse_parameters(bytes);
  parameters.detail_level = detail_level;
  if (detail_level > 0 && (!parameters.quantizer.is_lossless() || parameters.cut_axes != 0)) {
    throw Error(ErrorKind::corrupt, "a model with a max error or parts where details are left out");
  }
  return std::make_unique<grey::GreyCodec>(parameters);
}

}  // namespace octavo
