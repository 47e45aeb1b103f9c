#include "octavo/codec/grey/grey_decoder.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_corrections.h"
#include "octavo/codec/grey/grey_interpolation.h"
#include "octavo/codec/grey/grey_level_run.h"
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

/// Decodes the splits of a level, or of a part of it, from its edges and residuals; its means stand
/// in the work space.
/// box  of the result that is looked at
template <class Sample>
void decode_details(const Source& source, const Part& part, int level, ByteSpan segment,
                    const BrickHints& hints, int most_states, const Box& box,
                    Workspace<Sample>& work) {
  // A level without details repeats its means
  if (level_detail_count(part.shape, level, hints.cells) == 0) {
    if (!segment.empty()) throw Error(ErrorKind::corrupt, "a segment without details has bytes");
    static const Parameters kRepeating{};
    run_level(work, part, source.scale, kRepeating, level, hints, Margins::all,
              [](const Stage&, const Split&) {});
    return;
  }
  LevelRun<Sample> run({source.model, source.scale, level, most_states}, part, segment, hints, box,
                       work);
  LevelRun<Sample>* const only = &run;
  run_together<Sample>(std::span(&only, 1));
}

/// A brick whose levels above 0 are decoded.
template <class Sample>
struct CoarserLevels {
  const Source& source;
  std::span<const ByteSpan> segments;
  Workspace<Sample>& work;
  LevelState state = {};

  /// The samples of the last level.
  void load_coarsest() {
    const auto last = static_cast<std::size_t>(source.shape.level_count) - 1;
    const Size3& size = source.shape.size[last];
    load_means(work, decode_plain<Sample>(source.scale, segments[last], size).data(), size);
  }
  /// The bytes of the details of a level, behind what its segment tells of finer ones.
  ByteSpan take_hints(int level) {
    const Parameters& p = source.parameters();
    const BrickShape& shape = source.shape;
    ByteSpan segment = segments[static_cast<std::size_t>(level)];
    if (level == 1 && has_parts(shape, p.cut_axes)) {
      state.entries = take_part_list(segment, parts_of(shape, p.cut_axes).size());
    }
    if (level == 1 && has_cells(shape)) {
      state.cells = decode_cells(take_counted(segment), shape.size[2]);
    }
    return segment;
  }
};

/// Decodes a level of some bricks of one model, at the same time those that have details and are
/// split alike.
/// details  the bytes of each
template <class Sample>
void decode_level(std::span<CoarserLevels<Sample>> bricks, std::span<const ByteSpan> details,
                  int level, const Box& box) {
  std::vector<Part> parts;
  std::vector<BrickHints> hints;
  for (const CoarserLevels<Sample>& brick : bricks) {
    parts.push_back({brick.source.shape, {}, {}, kAllFaces});
    hints.push_back(brick.state.hints(brick.source.parameters()));
  }
  std::vector<bool> is_done(bricks.size());
  for (std::size_t first = 0; first < bricks.size(); ++first) {
    std::vector<std::unique_ptr<LevelRun<Sample>>> runs;
    std::vector<LevelRun<Sample>*> together;
    for (std::size_t i = first; i < bricks.size(); ++i) {
      const Source& source = bricks[i].source;
      if (is_done[i] || !are_split_alike(source.shape, bricks[first].source.shape, level) ||
          level_detail_count(source.shape, level, hints[i].cells) == 0) {
        continue;
      }
      runs.push_back(std::make_unique<LevelRun<Sample>>(
          typename LevelRun<Sample>::Setting{source.model, source.scale, level, kMaxStates},
          parts[i], details[i], hints[i], box, bricks[i].work));
      together.push_back(runs.back().get());
      is_done[i] = true;
    }
    if (!together.empty()) run_together<Sample>(together);
    if (is_done[first]) continue;
    decode_details(bricks[first].source, parts[first], level, details[first], hints[first],
                   kMaxStates, box, bricks[first].work);
  }
}

/// Decodes the levels from the coarsest to `level`, but not level 0, into the work spaces: of up to
/// kMostTogether bricks of one model that have as many levels.
/// box  of `level` that is looked at
template <class Sample>
void decode_coarser(std::span<CoarserLevels<Sample>> bricks, int level,
                    const Box& box = kAllSamples) {
  for (CoarserLevels<Sample>& brick : bricks) brick.load_coarsest();
  const int last = bricks.front().source.shape.level_count - 1;
  for (int at = last - 1; at >= std::max(level, 1); --at) {
    std::vector<ByteSpan> details;
    for (CoarserLevels<Sample>& brick : bricks) details.push_back(brick.take_hints(at));
    decode_level<Sample>(bricks, details, at, at == level ? box : kAllSamples);
  }
  if (level > 0) return;
  for (CoarserLevels<Sample>& brick : bricks) {
    const Source& source = brick.source;
    brick.state.gaps =
        gaps_of(source.parameters().value_map, source.map, source.shape, source.scale);
  }
}

/// The same of one brick.
template <class Sample>
LevelState decode_coarser(const Source& source, std::span<const ByteSpan> segments, int level,
                          const Box& box = kAllSamples) {
  CoarserLevels<Sample> brick{source, segments, thread_workspace<Sample>()};
  decode_coarser<Sample>(std::span(&brick, 1), level, box);
  return std::move(brick.state);
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
  decode_details(source, part, 0, segment, hints, most_states, samples,
                 thread_workspace<Sample>());
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
    const PartDecoder* decoder;  ///< of its brick
    const Part& part;
    ByteSpan bytes;
    WantedBox wanted;
  };

  /// Decodes parts of bricks one after the other, or some at the same time.
  static void decode(std::span<const Task> all) {
    std::vector<const Task*> tasks;
    for (const Task& task : all) tasks.push_back(&task);
    // Those of as many planes go in step to their end.
    std::stable_sort(tasks.begin(), tasks.end(), [](const Task* a, const Task* b) {
      return a->part.shape.size[0].z > b->part.shape.size[0].z;
    });
    for (auto first = tasks.begin(); first != tasks.end();) {
      auto end = first + 1;
      const auto most = std::ptrdiff_t{kMostTogether};
      for (auto other = end; other != tasks.end() && end - first < most; ++other) {
        if (!go_in_step(**first, **other)) continue;
        std::rotate(end, other, other + 1);
        ++end;
      }
      decode_some({&*first, static_cast<std::size_t>(end - first)});
      first = end;
    }
  }

 private:
  void decode_one(const Task& task) const {
    coarse_.put(task.part, thread_workspace<Sample>().means);
    const PartHints own(task.part, hints_);
    decode_finest<Sample>(source_, task.part, task.bytes, own.hints, most_states_, task.wanted);
  }

  /// Parts that go in step, or a single one.
  static void decode_some(std::span<const Task* const> tasks) {
    if (tasks.size() > 1) {
      try {
        decode_in_step(tasks);
        return;
      } catch (const Error&) {
        // What is wrong with the first one is said before what is wrong with the others.
      }
    }
    for (const Task* const task : tasks) task->decoder->decode_one(*task);
  }

  /// A part on its way, and where it ends.
  struct Running {
    Running(const Task& own, Workspace<Sample>& space)
        : Running(*own.decoder, own, space) {}
    Running(const PartDecoder& decoder, const Task& own, Workspace<Sample>& space)
        : task(own),
          hints(own.part, decoder.hints_),
          work(space),
          box(in_order(own.wanted.box, decoder.source_.parameters().axis_order)),
          run({decoder.source_.model, decoder.source_.scale, 0, decoder.most_states_}, own.part,
              own.bytes, hints.hints, box, space) {
      decoder.coarse_.put(task.part, work.means);
    }

    const Task& task;
    PartHints hints;
    Workspace<Sample>& work;
    Box box;  ///< of the samples that are wanted
    LevelRun<Sample> run;
  };

  /// Predicted from neighbors, a part keeps the machine busy by itself. Where rows are short, as
  /// pairs are left out or edges, more work spaces cost more than more streams bring.
  bool goes_in_step(const Task& task) const {
    const bool has_whole_rows = hints_.cells == nullptr && !hints_.has_edges;
    return source_.parameters().predictor == Predictor::means && has_whole_rows &&
           !source_.is_corrected() && !task.bytes.empty();
  }
  static bool go_in_step(const Task& a, const Task& b) {
    return &a.decoder->source_.model == &b.decoder->source_.model &&
           are_split_alike(a.part.shape, b.part.shape, 0) && a.decoder->goes_in_step(a) &&
           b.decoder->goes_in_step(b);
  }

  static void decode_in_step(std::span<const Task* const> tasks) {
    std::vector<std::unique_ptr<Running>> running;
    std::vector<LevelRun<Sample>*> together;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      running.push_back(std::make_unique<Running>(*tasks[i], thread_workspace<Sample>(i)));
      together.push_back(&running.back()->run);
    }
    run_together<Sample>(together);
    for (const auto& part : running) {
      part->task.decoder->source_.writer().write(part->work.means, part->box,
                                                 part->task.wanted.out);
    }
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
    tasks.push_back({&decoder, parts[i], bytes[i],
                     {moved(shared, {-own.lo.x, -own.lo.y, -own.lo.z}),
                      target_from(wanted.out, at, source.type)}});
  }
  PartDecoder<Sample>::decode(tasks);
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
                             state.hints(source.parameters()), kMaxStates, kAllSamples, work);
    }
  }
  interpolate_levels(work, whole, source.scale, whole.level_count - shape.level_count, level);
  source.writer().write(work.means, in_order(wanted.box, source.parameters().axis_order),
                        wanted.out);
}

template <class Sample>
class GreyParts final : public BrickParts {
 public:
  /// means  the samples of level 1
  GreyParts(const Source& source, LevelState state, SampleGrid<Sample>& means)
      : source_(source),
        state_(std::move(state)),
        coarse_(means),
        decoder_(source_, state_, coarse_),
        parts_(parts_of(source.shape, source.parameters().cut_axes)),
        own_parts_(placed_parts(parts_, state_.entries, source.parameters().axis_order)) {}

  const std::vector<BrickParts::Part>& parts() const noexcept override { return own_parts_; }

  void decode_together(std::span<const WantedOf> wanted) const override {
    std::vector<typename PartDecoder<Sample>::Task> tasks;
    for (const auto& [brick, own] : wanted) {
      const auto* const parts = dynamic_cast<const GreyParts*>(brick);
      // Samples of another width are not decoded with these.
      if (parts != nullptr) tasks.push_back(parts->task(own));
      else brick->decode(std::span(&own, 1));
    }
    PartDecoder<Sample>::decode(tasks);
  }

 private:
  typename PartDecoder<Sample>::Task task(const Wanted& wanted) const {
    prove_part(wanted.bytes, state_.entries[wanted.number]);
    const Index3& at = own_parts_[wanted.number].box.lo;
    return {&decoder_, parts_[wanted.number], wanted.bytes,
            {moved(wanted.box, {-at.x, -at.y, -at.z}), wanted.out}};
  }

  Source source_;
  LevelState state_;
  CoarseSamples<Sample> coarse_;
  PartDecoder<Sample> decoder_;
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

/// A brick to open, one of several.
struct OpeningBrick {
  std::size_t number;
  Source source;
  std::vector<ByteSpan> segments;
};

/// Whether the levels above 0 of two bricks gain from being decoded at the same time: predicted
/// from neighbors, each keeps the machine busy by itself.
bool go_together(const Source& a, const Source& b) {
  return a.parameters().predictor == Predictor::means &&
         a.scale.is_wide() == b.scale.is_wide() && a.shape.level_count == b.shape.level_count;
}

template <class Sample>
void open_together(std::span<const OpeningBrick> bricks,
                   std::vector<std::unique_ptr<BrickParts>>& opened) {
  std::vector<CoarserLevels<Sample>> levels;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    levels.push_back({bricks[i].source, bricks[i].segments, thread_workspace<Sample>(i)});
  }
  decode_coarser<Sample>(std::span(levels), 0);
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    opened[bricks[i].number] = std::make_unique<GreyParts<Sample>>(
        bricks[i].source, std::move(levels[i].state), levels[i].work.means);
  }
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

std::vector<std::unique_ptr<BrickParts>> open_parts(const Model& model, VoxelType type,
                                                    std::span<const CodedBrick> bricks) {
  std::vector<std::unique_ptr<BrickParts>> opened(bricks.size());
  std::vector<OpeningBrick> opening;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const auto& [shape, range, segments] = bricks[i];
    const Parameters& p = model.parameters;
    const bool is_cut = has_parts(in_order(shape, p.axis_order), p.cut_axes);
    if (range.min == range.max || segments.back().empty() || !is_cut) continue;
    std::vector<ByteSpan> bytes(segments.begin(), segments.end());
    const Source source = source_of(model, shape, type, range, bytes.back());
    opening.push_back({i, source, std::move(bytes)});
  }
  for (std::size_t first = 0; first < opening.size();) {
    std::size_t end = first + 1;
    while (end < opening.size() && end - first < kMostTogether &&
           go_together(opening[first].source, opening[end].source)) {
      ++end;
    }
    with_sample_type(opening[first].source.scale, [&](auto sample) {
      open_together<decltype(sample)>(std::span(opening).subspan(first, end - first), opened);
    });
    first = end;
  }
  return opened;
}

}  // namespace octavo::grey
