#include "octavo/codec/grey/grey_codec.h"

#include <algorithm>
#include <cstdlib>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"
#include "octavo/codec/grey/grey_decoder.h"
#include "octavo/codec/grey/grey_interpolation.h"
#include "octavo/codec/grey/grey_parts.h"
#include "octavo/codec/grey/grey_voxels.h"
#include "octavo/codec/grey/plain_samples.h"
#include "octavo/codec/grey/voxel_walk.h"

namespace octavo::grey {

namespace {

/// The segment of in-brick level 1 starts with the cell flags: a varint of their length, then the
/// bytes.
void put_cells(Bytes& segment, const BrickShape& shape, int level, const UniformCells& cells) {
  if (level != 1 || !has_cells(shape)) return;
  put_counted(segment, encode_cells(cells));
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
    Bytes out;
    put_counted(out, encode_corrections(corrections, size));
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
  SymbolWriter writer(model, table_set(level), brick.scale.shift(), stage_functions().push);
  run_level(work, part, brick.scale, p, level, hints, reach_of(p.predictor),
            [&](const Stage& stage, const Split& split) {
              load_details(work, stage, target_of(brick, shape, part, level, split.axis));
              if (stage.has_edges) {
                mark_edges(stage, work);
                writer.add(work.edge_symbols);
              }
              stage_functions().of<Sample>().write(p, stage, work, writer);
            });
  return writer.finish(level_detail_count(part.shape, level, hints.cells), most_states);
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

}  // namespace

GreyCodec::GreyCodec(const Parameters& parameters) {
  // Tables are written below, all that is read of them.
  std::unique_ptr<Model> model(new Model);
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

void GreyCodec::decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
                       std::span<const ByteSpan> segments, int level, void* out) const {
  const Size3& size = shape.size[static_cast<std::size_t>(level)];
  decode_box(shape, type, range, segments, {level, box_of(size), dense_target(out, size)});
}

void GreyCodec::decode_box(const BrickShape& shape, VoxelType type, const ValueRange& range,
                           std::span<const ByteSpan> segments, const LevelBox& wanted) const {
  decode_brick(*model_, shape, type, range, segments, wanted);
}

std::int64_t GreyCodec::decode_parent(const BrickShape& shape, VoxelType type,
                                      const ValueRange& range,
                                      std::span<const ByteSpan> segments) const {
  return grey::decode_parent(*model_, shape, type, range, segments);
}

bool GreyCodec::has_parts(const BrickShape& shape) const noexcept {
  const Parameters& p = model_->parameters;
  return grey::has_parts(in_order(shape, p.axis_order), p.cut_axes);
}

std::vector<BrickParts::Part> GreyCodec::list_parts(const BrickShape& shape,
                                                    ByteSpan front) const {
  if (!has_parts(shape)) return {};
  const Parameters& p = model_->parameters;
  const std::vector<Part> parts = parts_of(in_order(shape, p.axis_order), p.cut_axes);
  return placed_parts(parts, take_part_list(front, parts.size()), p.axis_order);
}

std::vector<std::unique_ptr<BrickParts>> GreyCodec::open_together(
    VoxelType type, std::span<const CodedBrick> bricks) const {
  return grey::open_parts(*model_, type, bricks);
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
