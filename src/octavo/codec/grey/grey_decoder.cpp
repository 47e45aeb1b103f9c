#include "octavo/codec/grey/grey_decoder.h"

#include <algorithm>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"
#include "octavo/codec/grey/grey_interpolation.h"
#include "octavo/codec/grey/grey_parts.h"
#include "octavo/codec/grey/grey_voxels.h"
#include "octavo/codec/grey/plain_samples.h"
#include "octavo/codec/stored_brick.h"
#include "octavo/core/crc32c.h"

namespace octavo::grey {

namespace {

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

/// A box of the voxels of a level of a brick, or of a part of level 0, along the brick's own axes.
struct WantedBox {
  Box box;
  VoxelTarget out;
};

template <class Sample>
void decode_stored(const Source& source, ByteSpan segment, int level, const WantedBox& wanted) {
  const BrickShape& shape = source.shape;
  std::vector<Sample> samples = decode_plain<Sample>(source.scale, segment, shape.size[0]);
  for (int i = 0; i < level; ++i) {
    samples = coarser_level(std::move(samples), shape, i);
  }
  const Size3& size = shape.size[static_cast<std::size_t>(level)];
  const Box box = in_order(wanted.box, source.parameters().axis_order);
  source.writer().write(
      box.size(),
      [&](std::int64_t y, std::int64_t z) {
        return samples.data() + ((z + box.lo.z) * size.y + y + box.lo.y) * size.x + box.lo.x;
      },
      wanted.out);
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
  return decode_corrections(take_counted(segment), size);
}

/// size  of all that they correct
/// box   of it that is at `out`
void apply(const Corrections& corrections, const Source& source, const Size3& size, const Box& box,
           const VoxelTarget& out) {
  const std::int64_t step = source.parameters().quantizer.correction_step;
  with_voxel_type(source.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        T* const row = static_cast<T*>(out.voxels) + (z - box.lo.z) * out.plane_stride +
                       (y - box.lo.y) * out.row_stride;
        const std::int8_t* const correction =
            corrections.data() + (z * size.y + y) * size.x + box.lo.x;
        for (std::int64_t x = 0; x < box.size().x; ++x) {
          if (correction[x] == 0) continue;
          const auto moved = static_cast<std::int64_t>(row[x]) + correction[x] * step;
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

/// All samples of any level.
inline constexpr Box kAllSamples{{0, 0, 0}, {kBrickSide, kBrickSide, kBrickSide}};

/// A split of a level of which a box is looked at. The last split needs all samples of those before
/// it: its contexts look around their pairs.
Stage needed_of(Stage stage, const Split& split, const BrickShape& shape, int level,
                const Box& box) {
  if (split.fine_size != shape.size[static_cast<std::size_t>(level)]) return stage;
  // Nothing in the first planes of the last split looks at later ones.
  stage.first_row = stage.axis == 1 ? box.lo.y / 2 : box.lo.y;
  stage.last_row = stage.axis == 1 ? (box.hi.y + 1) / 2 : box.hi.y;
  const std::int64_t pairs = stage.axis == 2 ? (box.hi.z + 1) / 2 : box.hi.z;
  if (pairs >= stage.pairs.z) return stage;
  stage.pairs.z = pairs;
  // The last pair of all is left out.
  if (stage.axis == 2) stage.last_pair = {};
  return stage;
}

/// Decodes the splits of a level, or of a part of it, from its edges and residuals; its means stand
/// in the work space.
/// box  of the result that is looked at
template <class Sample>
void decode_details(const Source& source, const Part& part, int level, ByteSpan segment,
                    const BrickHints& hints, int most_states, const Box& box = kAllSamples) {
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
  bool is_whole = true;
  run_level(work, part, source.scale, p, level, hints, reach_of(p.predictor),
            [&](const Stage& stage, const Split& split) {
              if (stage.has_edges) take_edges(stage, work, symbols);
              const Stage own = needed_of(stage, split, part.shape, level, box);
              is_whole = is_whole && own.pairs == stage.pairs;
              stage_functions().of<Sample>().decode(p, {own, work, symbols});
            });
  if (is_whole) symbols.finish();
}

/// Decodes the levels from the coarsest to `level`, but not level 0, into the work space.
/// box  of `level` that is looked at
template <class Sample>
LevelState decode_coarser(const Source& source, std::span<const ByteSpan> segments, int level,
                          const Box& box = kAllSamples) {
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
      state.cells = decode_cells(take_counted(segment), shape.size[2]);
    }
    decode_details<Sample>(source, Part{shape, {}, {}, kAllFaces}, at, segment, state.hints(p),
                           kMaxStates, at == level ? box : kAllSamples);
  }
  if (level == 0) state.gaps = gaps_of(p.value_map, source.map, shape, source.scale);
  return state;
}

/// Decodes level 0 of a brick, or a part of it, to voxels; its means stand in the work space.
template <class Sample>
void decode_finest(const Source& source, const Part& part, ByteSpan segment,
                   const BrickHints& hints, int most_states, const WantedBox& wanted) {
  const AxisOrder& order = source.parameters().axis_order;
  Corrections corrections;
  const Size3 size = own_box(part, order).size();
  if (source.is_corrected()) corrections = take_corrections(segment, size);
  const Box samples = in_order(wanted.box, order);
  decode_details<Sample>(source, part, 0, segment, hints, most_states, samples);
  source.writer().write(thread_workspace<Sample>().means, samples, wanted.out);
  if (source.is_corrected()) apply(corrections, source, size, wanted.box, wanted.out);
}

/// Decodes parts of level 0, given the samples of level 1.
template <class Sample>
class PartDecoder {
 public:
  PartDecoder(const Source& source, const LevelState& state, const CoarseSamples<Sample>& coarse)
      : source_(source),
        hints_(state.hints(source.parameters())),
        most_states_(most_part_states(source.parameters().cut_axes)),
        coarse_(coarse) {}

  struct Task {
    const Part& part;
    ByteSpan bytes;
    WantedBox wanted;
  };

  /// Decodes parts one after the other, or two by two.
  void decode(std::span<const Task> tasks) const {
    for (; tasks.size() > 1; tasks = tasks.subspan(2)) decode_two(tasks[0], tasks[1]);
    if (!tasks.empty()) decode(tasks[0]);
  }

 private:
  void decode(const Task& task) const {
    coarse_.put(task.part, thread_workspace<Sample>().means);
    const PartHints own(task.part, hints_);
    decode_finest<Sample>(source_, task.part, task.bytes, own.hints, most_states_, task.wanted);
  }

  /// Two parts at the same time where that is faster.
  void decode_two(const Task& first, const Task& second) const {
    if (goes_in_step(first) && goes_in_step(second)) {
      try {
        decode_in_step(first, second);
        return;
      } catch (const Error&) {
        // What is wrong with the first one is said before what is wrong with the second.
      }
    }
    decode(first);
    decode(second);
  }

  /// A part whose splits are run one by one.
  struct Running {
    Running(const PartDecoder& decoder, const Task& own, Workspace<Sample>& space)
        : task(own),
          hints(own.part, decoder.hints_),
          work(space),
          symbols(decoder.source_.model, table_set(0), own.bytes,
                  level_detail_count(own.part.shape, 0, hints.hints.cells),
                  decoder.source_.scale.shift(), decoder.most_states_),
          splits(splits_of(own.part.shape, 0)),
          box(in_order(own.wanted.box, decoder.source_.parameters().axis_order)) {
      decoder.coarse_.put(task.part, work.means);
      for (auto& grid : work.magnitudes) grid.set_size({0, 0, 0});
    }

    const Task& task;
    PartHints hints;
    Workspace<Sample>& work;
    SymbolReader symbols;
    std::vector<Split> splits;
    Box box;  ///< of the samples that are wanted
    bool is_whole = true;  ///< all symbols are taken
  };

  /// Predicted from neighbors, a part keeps the machine busy by itself. Where rows are short, as
  /// pairs are left out or edges, two work spaces cost more than two streams bring.
  bool goes_in_step(const Task& task) const {
    const bool has_whole_rows = hints_.cells == nullptr && !hints_.has_edges;
    return source_.parameters().predictor == Predictor::means && has_whole_rows &&
           !source_.is_corrected() && !task.bytes.empty();
  }

  void decode_in_step(const Task& first, const Task& second) const {
    const Parameters& p = source_.parameters();
    Running a(*this, first, thread_workspace<Sample>());
    Running b(*this, second, thread_workspace<Sample, 1>());
    for (std::size_t i = 0; i < a.splits.size(); ++i) {
      const Stage stage_of_a = begun(a, i);
      const Stage stage_of_b = begun(b, i);
      stage_functions().of<Sample>().decode_two(p, {stage_of_a, a.work, a.symbols},
                                                {stage_of_b, b.work, b.symbols});
      for (Running* part : {&a, &b}) {
        end_split(part->work, part->task.part, p, part->splits[i], reach_of(p.predictor),
                  i + 1 == a.splits.size());
      }
    }
    for (Running* part : {&a, &b}) {
      if (part->is_whole) part->symbols.finish();
      source_.writer().write(part->work.means, part->box, part->task.wanted.out);
    }
  }

  /// What is needed of the i-th split of a part.
  Stage begun(Running& part, std::size_t i) const {
    const Split& split = part.splits[i];
    const Stage all = begin_split(part.work, part.task.part, source_.scale, source_.parameters(), 0,
                                  part.hints.hints, split);
    const Stage own = needed_of(all, split, part.task.part.shape, 0, part.box);
    part.is_whole = part.is_whole && own.pairs == all.pairs;
    return own;
  }

  const Source& source_;
  BrickHints hints_;
  int most_states_;
  const CoarseSamples<Sample>& coarse_;
};

void prove_part(ByteSpan bytes, const PartBytes& entry) {
  if (bytes.size() != entry.length || !checksum_matches(crc32c(bytes), entry.crc)) {
    throw Error(ErrorKind::corrupt, "a part of a brick has another checksum");
  }
}

/// The bytes of the parts in segment 0. Throws Error{corrupt} when the parts do not fill it, or
/// have other checksums.
std::vector<ByteSpan> split_segment(ByteSpan segment, const std::vector<PartBytes>& entries) {
  std::vector<ByteSpan> parts;
  for (const PartBytes& entry : entries) {
    parts.push_back(take_bytes(segment, entry.length));
    prove_part(parts.back(), entry);
  }
  if (!segment.empty()) throw Error(ErrorKind::corrupt, "bytes behind the parts of a brick");
  return parts;
}

template <class Sample>
void decode_samples(const Source& source, std::span<const ByteSpan> segments, int level,
                    const WantedBox& wanted) {
  const Parameters& p = source.parameters();
  const Box samples = in_order(wanted.box, p.axis_order);
  const LevelState state = decode_coarser<Sample>(source, segments, level, samples);
  Workspace<Sample>& work = thread_workspace<Sample>();
  if (level > 0 || source.shape.level_count == 1) {
    source.writer().write(work.means, samples, wanted.out);
    return;
  }
  if (state.entries.empty()) {
    const Part all{source.shape, {}, {}, kAllFaces};
    decode_finest<Sample>(source, all, segments[0], state.hints(p), kMaxStates, wanted);
    return;
  }
  const std::vector<ByteSpan> bytes = split_segment(segments[0], state.entries);
  const std::vector<Part> parts = parts_of(source.shape, p.cut_axes);
  const CoarseSamples<Sample> coarse(work.means);
  const PartDecoder<Sample> decoder(source, state, coarse);
  std::vector<typename PartDecoder<Sample>::Task> tasks;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Box own = own_box(parts[i], p.axis_order);
    const Box shared = intersection(own, wanted.box);
    if (shared.is_empty()) continue;
    const Index3& lo = wanted.box.lo;
    const Index3 at{shared.lo.x - lo.x, shared.lo.y - lo.y, shared.lo.z - lo.z};
    tasks.push_back({parts[i], bytes[i],
                     {moved(shared, {-own.lo.x, -own.lo.y, -own.lo.z}),
                      target_from(wanted.out, at, source.type)}});
  }
  decoder.decode(tasks);
}

/// Decodes a level that has no details.
/// source    of the brick from its first level with details on, and so are segments
/// whole     the shape of all of it, in the codec's axes
template <class Sample>
void decode_interpolated(const Source& source, const BrickShape& whole, bool is_stored,
                         std::span<const ByteSpan> segments, int level, const WantedBox& wanted) {
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
  source.writer().write(work.means, in_order(wanted.box, source.parameters().axis_order),
                        wanted.out);
}

template <class Sample>
class GreyParts final : public BrickParts {
 public:
  GreyParts(const Source& source, std::span<const ByteSpan> segments)
      : source_(source),
        state_(decode_coarser<Sample>(source, segments, 0)),
        coarse_(thread_workspace<Sample>().means),
        parts_(parts_of(source.shape, source.parameters().cut_axes)),
        own_parts_(placed_parts(parts_, state_.entries, source.parameters().axis_order)) {}

  const std::vector<BrickParts::Part>& parts() const noexcept override { return own_parts_; }

  void decode(std::span<const Wanted> wanted) const override {
    for (const Wanted& one : wanted) prove_part(one.bytes, state_.entries[one.number]);
    std::vector<typename PartDecoder<Sample>::Task> tasks;
    for (const Wanted& one : wanted) {
      const Index3& at = own_parts_[one.number].box.lo;
      tasks.push_back({parts_[one.number], one.bytes,
                       {moved(one.box, {-at.x, -at.y, -at.z}), one.out}});
    }
    PartDecoder<Sample>(source_, state_, coarse_).decode(tasks);
  }

 private:
  Source source_;
  LevelState state_;
  CoarseSamples<Sample> coarse_;
  std::vector<grey::Part> parts_;
  std::vector<BrickParts::Part> own_parts_;
};

/// Voxels of one value.
void fill(VoxelType type, std::int64_t value, const WantedBox& wanted) {
  const Size3 size = wanted.box.size();
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    T* const out = static_cast<T*>(wanted.out.voxels);
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        std::fill_n(out + z * wanted.out.plane_stride + y * wanted.out.row_stride, size.x,
                    static_cast<T>(value));
      }
    }
  });
}

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

void decode_brick(const Model& model, const BrickShape& shape, VoxelType type,
                  const ValueRange& range, std::span<const ByteSpan> segments,
                  const LevelBox& wanted) {
  const WantedBox own{wanted.box, wanted.out};
  if (range.min == range.max) {
    fill(type, range.min, own);
    return;
  }
  const int first = detailed_level(model.parameters, shape);
  const bool stored = is_stored(shape, segments, first);
  std::vector<ByteSpan> bytes(segments.begin() + (stored ? 0 : first), segments.end());
  const Source source = source_of(model, shape_from(shape, first), type, range,
                                  stored ? bytes.front() : bytes.back());
  const int level = wanted.level;
  with_sample_type(source.scale, [&](auto sample) {
    using Sample = decltype(sample);
    if (level < first) {
      const BrickShape whole = in_order(shape, model.parameters.axis_order);
      decode_interpolated<Sample>(source, whole, stored, bytes, level, own);
    } else if (stored) {
      decode_stored<Sample>(source, bytes[0], level - first, own);
    } else {
      decode_samples<Sample>(source, bytes, level - first, own);
    }
  });
}

std::int64_t decode_parent(const Model& model, const BrickShape& shape, VoxelType type,
                           const ValueRange& range, std::span<const ByteSpan> segments) {
  if (range.min == range.max) return range.min;
  const int first = detailed_level(model.parameters, shape);
  const bool stored = is_stored(shape, segments, first);
  std::vector<ByteSpan> bytes(segments.begin() + (stored ? 0 : first), segments.end());
  const Source source = source_of(model, shape_from(shape, first), type, range,
                                  stored ? bytes.front() : bytes.back());
  return with_sample_type(source.scale, [&](auto sample) {
    return decode_parent_sample<decltype(sample)>(source, bytes, stored);
  });
}

std::unique_ptr<BrickParts> open_parts(const Model& model, const BrickShape& shape,
                                       VoxelType type, const ValueRange& range,
                                       std::span<const ByteSpan> segments) {
  const Parameters& p = model.parameters;
  const bool is_cut = has_parts(in_order(shape, p.axis_order), p.cut_axes);
  if (range.min == range.max || segments.back().empty() || !is_cut) return nullptr;
  std::vector<ByteSpan> bytes(segments.begin(), segments.end());
  const Source source = source_of(model, shape, type, range, bytes.back());
  return with_sample_type(source.scale, [&](auto sample) -> std::unique_ptr<BrickParts> {
    return std::make_unique<GreyParts<decltype(sample)>>(source, bytes);
  });
}

}  // namespace octavo::grey
