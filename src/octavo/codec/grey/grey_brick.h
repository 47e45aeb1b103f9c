// The traversal of a brick that encoding, decoding and training share.
//
// A model's axis order says which axis of the brick is the codec's x, y and z: shapes, samples and
// splits here are in the codec's axes, and only reading voxels in and writing them out knows of the
// brick's. That way one set of kernels serves every order.
//
// Samples of a brick are its voxels less a base, chosen so that the smallest voxel becomes the
// smallest sample: 16-bit samples when the brick's range fits, else 32-bit ones. Levels are decoded
// from the coarsest down; inside a level the splits go z, y, x, along the axes of the level's
// halving mask.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/entropy/byte_io.h"
#include "octavo/codec/grey/grey_parts.h"
#include "octavo/codec/grey/grey_stage.h"
#include "octavo/codec/grey/octant_transform.h"

namespace octavo::grey {

/// How the voxels of a brick become samples: voxels to codes, codes to samples.
struct SampleScale {
  ValueRange range;  ///< of the codes
  CodeScale codes = {};
  /// Samples stand for several codes (training only): a detail of 1 is as good as none.
  bool is_cut = false;

  static SampleScale of_voxels(const ValueRange& voxels, const CodeScale& codes) {
    return {{codes.code_of(voxels.min), codes.code_of(voxels.max)}, codes};
  }

  bool is_wide() const { return range.max - range.min > 0xffff; }
  /// code = sample + base
  std::int64_t base() const {
    return range.min + (is_wide() ? std::int64_t{1} << 31 : std::int64_t{1} << 15);
  }
  std::int64_t min_sample() const { return range.min - base(); }
  std::int64_t max_sample() const { return range.max - base(); }
  /// Magnitudes are measured in units of 2^shift: 0 for 16-bit samples.
  int shift() const {
    const int bits = bit_length(static_cast<std::uint64_t>(range.max - range.min));
    return bits > 16 ? bits - 16 : 0;
  }
  /// Bits of a code stored plain.
  int plain_width() const {
    return bit_length(static_cast<std::uint64_t>(range.max - range.min));
  }
};

/// Calls f(std::int16_t{}) or f(std::int32_t{}): the sample type of the brick.
template <class F>
decltype(auto) with_sample_type(const SampleScale& scale, F&& f) {
  return scale.is_wide() ? f(std::int32_t{}) : f(std::int16_t{});
}

/// A size or a shape in the codec's axes.
inline Size3 in_order(const Size3& size, const AxisOrder& order) {
  return {size[order[0]], size[order[1]], size[order[2]]};
}
inline Box in_order(const Box& box, const AxisOrder& order) {
  return {{box.lo[order[0]], box.lo[order[1]], box.lo[order[2]]},
          {box.hi[order[0]], box.hi[order[1]], box.hi[order[2]]}};
}
BrickShape in_order(const BrickShape& shape, const AxisOrder& order);

inline constexpr int kTileRows = 16;

/// Visits the rows along x of a volume whose voxels are `steps` apart in memory. Calls
/// f(y, z, axis, count) for row (y, z) and the next `count` - 1 along `axis`, the axis whose voxels
/// lie side by side: single rows where that is x, tiles of up to kTileRows rows else, so that
/// memory is met in runs whatever the order of the axes.
template <class F>
void for_each_tile(const Size3& size, const Size3& steps, F&& f) {
  const int axis = steps.x == 1 ? 0 : steps.y == 1 ? 1 : 2;
  const std::int64_t rows_y = axis == 1 ? kTileRows : 1;
  const std::int64_t rows_z = axis == 2 ? kTileRows : 1;
  for (std::int64_t z = 0; z < size.z; z += rows_z) {
    for (std::int64_t y = 0; y < size.y; y += rows_y) {
      const std::int64_t left = axis == 0 ? 1 : axis == 1 ? size.y - y : size.z - z;
      f(y, z, axis, static_cast<int>(std::min<std::int64_t>(left, kTileRows)));
    }
  }
}

/// Cells exist where a brick has three levels or more: one per sample of in-brick level 2.
constexpr bool has_cells(const BrickShape& shape) { return shape.level_count >= 3; }

/// The flags of a brick's cells and their form in the segment of in-brick level 1.
Bytes encode_cells(const UniformCells& cells);
/// Throws Error{corrupt}.
UniformCells decode_cells(ByteSpan bytes, const Size3& size);

/// What is known of a brick's samples before its details are.
struct BrickHints {
  const UniformCells* cells = nullptr;  ///< nullptr when no cell is flagged
  const ValueGaps* gaps = nullptr;      ///< nullptr when all values occur
  bool has_edges = false;
};

/// What is known of the samples of a part.
struct PartHints {
  UniformCells cells;
  BrickHints hints;

  PartHints(const Part& part, const BrickHints& brick) : hints(brick) {
    if (brick.cells == nullptr) return;
    cells = cells_of(part, *brick.cells);
    hints.cells = cells.flags.empty() ? nullptr : &cells;
  }
  PartHints(const PartHints&) = delete;
  PartHints& operator=(const PartHints&) = delete;
};

/// The split along `axis` at in-brick level `level`; `fine_size` is the size of its result.
Stage make_stage(const BrickShape& shape, const SampleScale& scale, const Parameters& p, int level,
                 int axis, const Size3& fine_size, const BrickHints& hints);

/// The gaps between the values of a brick; nothing where its map knows of none.
std::unique_ptr<const ValueGaps> gaps_of(const ValueMap& map, const BrickMap& brick,
                                         const BrickShape& shape, const SampleScale& scale);

/// The axes of the splits that lead from level + 1 to level with the sizes they produce, in
/// decoding order: z, y, x.
struct Split {
  int axis;
  Size3 fine_size;
};
std::vector<Split> splits_of(const BrickShape& shape, int level);

/// A work space of the calling thread, made at first use.
/// number  the others are for what is decoded at the same time
template <class Sample>
Workspace<Sample>& thread_workspace(std::size_t number = 0) {
  static thread_local std::array<std::unique_ptr<Workspace<Sample>>, kMostTogether> workspaces;
  auto& workspace = workspaces[number];
  if (!workspace) workspace = std::make_unique<Workspace<Sample>>();
  return *workspace;
}

/// Puts dense samples into the grid the splits start from.
template <class Sample>
void load_means(Workspace<Sample>& work, const Sample* samples, const Size3& size) {
  work.means.set_size(size);
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y, samples += size.x) {
      std::copy_n(samples, size.x, work.means.row(y, z));
    }
  }
  work.means.fill_margins();
}

/// How far a predictor looks beyond the means of a level.
constexpr Margins reach_of(Predictor predictor) {
  return predictor == Predictor::neighbors ? Margins::all : Margins::near;
}

/// Readies a split of a level or of a part of it, whose means stand in the work space with the
/// margins around them: the fine grid holds them repeated, unless it is written without being read.
template <class Sample>
Stage begin_split(Workspace<Sample>& work, const Part& part, const SampleScale& scale,
                  const Parameters& p, int level, const BrickHints& hints, const Split& split) {
  if (p.predictor == Predictor::means) work.fine.set_size(split.fine_size);
  else repeat_along(work.means, work.fine, split.axis, split.fine_size);
  return make_stage(part.shape, scale, p, level, split.axis, split.fine_size, hints);
}

/// Makes the result of a split the next means.
/// reach    how much of their margins is looked at
/// is_last  they are the samples of level 0: nothing looks beyond them
template <class Sample>
void end_split(Workspace<Sample>& work, const Part& part, const Parameters& p,
               const Split& split, Margins reach, bool is_last) {
  const bool is_from_means = p.predictor == Predictor::means;
  if (is_from_means) copy_lone(work.means, work.fine, split.axis);
  if (is_last) {
    work.means.swap(work.fine);
    return;
  }
  const Faces inner = kAllFaces & ~part.outer;
  if (is_from_means && inner != 0) {
    repeat_margins_along(work.means, work.fine, split.axis, reach, inner);
  }
  work.means.swap(work.fine);
  work.means.fill_margins(reach, part.outer);
}

/// Runs `stage_work(stage, split)` for the splits of a level or of a part of it.
/// reach  how much of the margins of the means stage_work looks at
template <class Sample, class F>
void run_level(Workspace<Sample>& work, const Part& part, const SampleScale& scale,
               const Parameters& p, int level, const BrickHints& hints, Margins reach,
               F&& stage_work) {
  for (auto& grid : work.magnitudes) grid.set_size({0, 0, 0});
  const std::vector<Split> splits = splits_of(part.shape, level);
  for (const Split& split : splits) {
    stage_work(begin_split(work, part, scale, p, level, hints, split), split);
    end_split(work, part, p, split, reach, level == 0 && &split == &splits.back());
  }
}

/// Calls f(part, hints) for a level above 0, or for the parts of level 0 one after the other; the
/// work space holds the means of the level, and before each call those of the part. Those of the
/// last part are left in the end.
template <class Sample, class F>
void for_each_part(Workspace<Sample>& work, const BrickShape& shape, std::uint8_t cut_axes,
                   int level, const BrickHints& hints, F&& f) {
  if (level > 0 || !has_parts(shape, cut_axes)) {
    f(Part{shape, {}, {}, kAllFaces}, hints);
    return;
  }
  const CoarseSamples<Sample> coarse(work.means);
  for (const Part& part : parts_of(shape, cut_axes)) {
    coarse.put(part, work.means);
    const PartHints own(part, hints);
    f(part, own.hints);
  }
}

/// True samples of a split: an array [z][y][x] of `size`, from the first that the split makes on.
template <class Sample>
struct Target {
  const Sample* samples = nullptr;
  Size3 size;
};

/// The true detail of pair (x, y, z) of a split along `axis`.
template <class Sample>
Wide<Sample> target_detail(const Target<Sample>& target, int axis, std::int64_t x, std::int64_t y,
                           std::int64_t z) {
  const std::int64_t steps[3] = {1, target.size.x, target.size.x * target.size.y};
  const Sample* a = target.samples + (axis == 2 ? 2 * z : z) * steps[2] +
                    (axis == 1 ? 2 * y : y) * steps[1] + (axis == 0 ? 2 * x : x);
  return static_cast<Wide<Sample>>(a[0]) - a[steps[axis]];
}

/// Puts the true details of a split into work.residuals, 0 in uniform cells.
template <class Sample>
void load_details(Workspace<Sample>& work, const Stage& stage, const Target<Sample>& target);

/// Details that the segment of a level codes.
std::int64_t level_detail_count(const BrickShape& shape, int level, const UniformCells* cells);

/// Everything an encoder knows of a brick: samples, the inputs of every halving, flagged cells.
template <class Sample>
struct AnalyzedBrick {
  SampleScale scale;
  /// steps[level][axis]: the samples before the halving along `axis` at `level`; empty when not
  /// halved.
  std::vector<std::array<std::vector<Sample>, 3>> steps;
  std::vector<Sample> coarsest;  ///< samples of the last in-brick level
  UniformCells cells;            ///< no flags when too few cells are uniform to pay
  std::unique_ptr<const ValueGaps> gaps;
  std::int64_t parent = 0;       ///< code of the brick at the next tier's first level

  BrickHints hints(const Parameters& p) const {
    return {cells.flags.empty() ? nullptr : &cells, gaps.get(), p.has_edges};
  }
};

/// What a split of a level along `axis` shall make of a part.
template <class Sample>
Target<Sample> target_of(const AnalyzedBrick<Sample>& brick, const BrickShape& shape,
                         const Part& part, int level, int axis) {
  const auto slot = static_cast<std::size_t>(level);
  const std::vector<Sample>& samples = brick.steps[slot][static_cast<std::size_t>(axis)];
  // Axes split before, z first, are as fine as this one is.
  Size3 size = shape.size[slot + 1];
  Index3 at = part.coarse_at;
  for (int a = axis; a < 3; ++a) {
    size[a] = shape.size[slot][a];
    at[a] = part.at[a];
  }
  return {samples.data() + (at.z * size.y + at.y) * size.x + at.x, size};
}

/// Smallest and largest voxel of a brick.
ValueRange range_of(const BrickView& brick);

/// Requires a range of more than one code. When Sample is 16 bits and the range is wider, samples
/// keep the highest 16 bits (training only).
/// whole  the shape in the codec's axes
/// first  the in-brick level from which on the brick is analyzed, as one that begins there
template <class Sample>
AnalyzedBrick<Sample> analyze(const BrickShape& whole, const BrickView& brick,
                              const SampleScale& scale, const AxisOrder& order, int first = 0);

/// The codes that a model makes of voxels, those of a brick with a map.
CodeScale code_scale(const Parameters& p, const BrickMap& map);

}  // namespace octavo::grey
