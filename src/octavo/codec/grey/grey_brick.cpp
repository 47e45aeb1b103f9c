#include "octavo/codec/grey/grey_brick.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <type_traits>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/codec/grey/grey_interpolation.h"
#include "octavo/codec/grey/voxel_walk.h"

namespace octavo::grey {

namespace {

/// Flags pay when more cells than this are uniform.
constexpr std::int64_t kFewCells = 8;

/// Dense samples of a brick.
template <class Sample>
std::vector<Sample> gather(const BrickView& brick, const SampleScale& scale,
                           const AxisOrder& order) {
  std::vector<Sample> samples(static_cast<std::size_t>(brick.size.voxel_count()));
  // Keeping the highest 16 bits of a wide range moves the base by the same amount.
  const int drop = sizeof(Sample) == 2 ? scale.shift() : 0;
  const std::int64_t zero = scale.range.min;
  const std::int64_t lowest = std::numeric_limits<Sample>::lowest();
  with_voxel_type(brick.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    if constexpr (std::is_integral_v<T>) {
      const Size3 size = in_order(brick.size, order);
      const Size3 steps = in_order(Size3{1, brick.row_stride, brick.plane_stride}, order);
      // Modulo the samples' width, where that is all there is to it: vectors.
      using Modulo = std::make_unsigned_t<Sample>;
      const bool is_shift = scale.codes.step <= 1 && drop == 0;
      const auto offset = static_cast<Modulo>(static_cast<std::uint64_t>(lowest - zero));
      const auto shifted = [offset](T voxel) {
        return static_cast<Sample>(static_cast<Modulo>(static_cast<Modulo>(voxel) + offset));
      };
      const auto sample_of = [&](T voxel) {
        const std::int64_t code = scale.codes.step > 1 ? scale.codes.code_of(voxel)
                                                       : static_cast<std::int64_t>(voxel);
        return static_cast<Sample>(((code - zero) >> drop) + lowest);
      };
      for_each_tile(size, steps, [&](std::int64_t y, std::int64_t z, int axis, int count) {
        const T* const in = static_cast<const T*>(brick.voxels) + z * steps.z + y * steps.y;
        Sample* const out = samples.data() + (z * size.y + y) * size.x;
        if (axis == 0 && is_shift) {
          for (std::int64_t x = 0; x < size.x; ++x) out[x] = shifted(in[x]);
          return;
        }
        if (axis == 0) {
          for (std::int64_t x = 0; x < size.x; ++x) out[x] = sample_of(in[x]);
          return;
        }
        const std::int64_t next_row = axis == 1 ? size.x : size.x * size.y;
        for (std::int64_t x = 0; x < size.x; ++x) {
          for (int k = 0; k < count; ++k) {
            const T voxel = in[x * steps.x + k];
            out[k * next_row + x] = is_shift ? shifted(voxel) : sample_of(voxel);
          }
        }
      });
    } else {
      throw Error(ErrorKind::invalid_argument, "float voxels have no grey codec");
    }
  });
  return samples;
}

/// The number of halvings of `axis` between two in-brick levels.
int halvings_between(const BrickShape& shape, int from, int to, int axis) {
  int count = 0;
  for (int i = from; i < to; ++i) count += shape.halving[static_cast<std::size_t>(i)] >> axis & 1;
  return count;
}

/// Marks the cells of level-2 footprint that hold one value.
template <class Sample>
UniformCells find_cells(const BrickShape& shape, const std::vector<Sample>& samples) {
  UniformCells cells{shape.size[2], {}};
  const Size3& fine = shape.size[0];
  int shift[3];
  for (int axis = 0; axis < 3; ++axis) shift[axis] = halvings_between(shape, 0, 2, axis);
  const auto cell_row = [&](std::int64_t y, std::int64_t z) {
    return static_cast<std::size_t>(((z >> shift[2]) * cells.size.y + (y >> shift[1])) *
                                    cells.size.x);
  };
  std::vector<Sample> first(static_cast<std::size_t>(cells.size.voxel_count()));
  std::vector<std::uint8_t> flags(first.size(), 1);
  const std::int64_t corner_mask[3] = {(1 << shift[0]) - 1, (1 << shift[1]) - 1,
                                       (1 << shift[2]) - 1};
  const Sample* row = samples.data();
  for (std::int64_t z = 0; z < fine.z; ++z) {
    for (std::int64_t y = 0; y < fine.y; ++y, row += fine.x) {
      const auto at = static_cast<std::int64_t>(cell_row(y, z));
      const bool is_first_row = (y & corner_mask[1]) == 0 && (z & corner_mask[2]) == 0;
      for (std::int64_t x = 0, cell = at; x < fine.x; x += corner_mask[0] + 1, ++cell) {
        const auto own = static_cast<std::size_t>(cell);
        if (is_first_row) first[own] = row[x];
        if (flags[own] == 0) continue;
        const auto differs = [&](Sample s) { return s != first[own]; };
        const std::int64_t end = std::min(x + corner_mask[0] + 1, fine.x);
        if (std::any_of(row + x, row + end, differs)) flags[own] = 0;
      }
    }
  }
  if (std::count(flags.begin(), flags.end(), 1) > kFewCells) cells.flags = std::move(flags);
  return cells;
}

/// One adaptive bit per context: which of the cells to the left, above and behind are flagged.
using CellModels = std::array<AdaptiveBit, 8>;

template <class F>
void walk_cells(UniformCells& cells, F&& code) {
  CellModels models;
  const Size3& size = cells.size;
  const auto flag = [&](std::int64_t x, std::int64_t y, std::int64_t z) -> unsigned {
    if (x < 0 || y < 0 || z < 0) return 0;
    return cells.flags[static_cast<std::size_t>((z * size.y + y) * size.x + x)];
  };
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x, ++at) {
        const unsigned context =
            flag(x - 1, y, z) | flag(x, y - 1, z) << 1 | flag(x, y, z - 1) << 2;
        cells.flags[at] = code(models[context], cells.flags[at]);
      }
    }
  }
}

}  // namespace

Bytes encode_cells(const UniformCells& cells) {
  Bytes out;
  if (cells.flags.empty()) return out;
  BinaryEncoder coder(out);
  UniformCells copy = cells;
  walk_cells(copy, [&](AdaptiveBit& model, std::uint8_t flag) {
    put_adaptive(coder, model, flag != 0);
    return flag;
  });
  coder.finish();
  return out;
}

UniformCells decode_cells(ByteSpan bytes, const Size3& size) {
  UniformCells cells{size, {}};
  if (bytes.empty()) return cells;
  cells.flags.resize(static_cast<std::size_t>(size.voxel_count()));
  BinaryDecoder coder(bytes);
  walk_cells(cells, [&](AdaptiveBit& model, std::uint8_t) {
    return static_cast<std::uint8_t>(get_adaptive(coder, model));
  });
  if (!coder.is_consumed()) throw Error(ErrorKind::corrupt, "cell flags of a wrong length");
  return cells;
}

std::vector<Split> splits_of(const BrickShape& shape, int level) {
  const auto slot = static_cast<std::size_t>(level);
  Size3 size = shape.size[slot + 1];
  std::vector<Split> splits;
  for (int axis = 2; axis >= 0; --axis) {
    if ((shape.halving[slot] >> axis & 1) == 0) continue;
    size[axis] = shape.size[slot][axis];
    splits.push_back({axis, size});
  }
  return splits;
}

namespace {

/// The pairs of a split and which of them are coded.
Stage pairs_of(const BrickShape& shape, int level, int axis, const Size3& fine_size,
               const UniformCells* cells) {
  Stage stage;
  stage.axis = axis;
  stage.pairs = fine_size;
  stage.pairs[axis] /= 2;
  if (cells == nullptr || level >= 2) return stage;
  stage.cells = cells;
  for (int a = 0; a < 3; ++a) {
    // A pair stands at the coarse resolution along its axis; axes after it are still coarse as
    // well.
    const bool is_coarse = a <= axis;
    stage.cell_shift[a] = halvings_between(shape, is_coarse ? level + 1 : level, 2, a);
  }
  return stage;
}

/// The axis of the split that makes the samples of level 0.
int finest_axis(const BrickShape& shape) { return std::countr_zero(shape.halving[0]); }

}  // namespace

std::unique_ptr<const ValueGaps> gaps_of(const ValueMap& map, const BrickMap& brick,
                                         const BrickShape& shape, const SampleScale& scale) {
  if (!brick.has_gaps || shape.level_count < 2) return nullptr;
  return std::make_unique<const ValueGaps>(
      make_gaps(map, brick, scale.range, scale.min_sample(),
                rounding_term(shape, 0, finest_axis(shape))));
}

CodeScale code_scale(const Parameters& p, const BrickMap& map) {
  if (!p.quantizer.is_lossless()) return {p.quantizer.voxel_step, 0};
  return map.scale(p.value_map);
}

BrickShape in_order(const BrickShape& shape, const AxisOrder& order) {
  BrickShape result = shape;
  result.weights = {in_order(shape.weights.each, order), in_order(shape.weights.last, order)};
  for (std::size_t i = 0; i < shape.size.size(); ++i) {
    result.size[i] = in_order(shape.size[i], order);
    result.halving[i] = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int bit = shape.halving[i] >> order[static_cast<std::size_t>(axis)] & 1;
      result.halving[i] = static_cast<HalvingMask>(result.halving[i] | bit << axis);
    }
  }
  return result;
}

Stage make_stage(const BrickShape& shape, const SampleScale& scale, const Parameters& p, int level,
                 int axis, const Size3& fine_size, const BrickHints& hints) {
  Stage stage = pairs_of(shape, level, axis, fine_size, hints.cells);
  if (level == 0 && axis == finest_axis(shape)) stage.gaps = hints.gaps;
  stage.has_edges = hints.has_edges;
  stage.group = level_group(level);
  stage.set = table_set(level);
  stage.rounding = rounding_term(shape, level, axis);
  stage.last_pair = weights_of(shape, level).last_pair(axis, fine_size[axis]);
  stage.min = scale.min_sample();
  stage.max = scale.max_sample();
  stage.shift = scale.shift();
  if (p.quantizer.detail_step > 0) {
    stage.step = detail_step_of(p.quantizer, level, axis);
    stage.step_bits = bit_length(static_cast<std::uint64_t>(stage.step)) - 1;
  }
  if (stage.step == 1 && !scale.is_cut) {
    stage.odd_low = 1 - stage.rounding;
    stage.odd_high = stage.rounding;
  }
  return stage;
}

std::int64_t level_detail_count(const BrickShape& shape, int level, const UniformCells* cells) {
  std::int64_t count = 0;
  for (const Split& split : splits_of(shape, level)) {
    count += pairs_of(shape, level, split.axis, split.fine_size, cells).detail_count();
  }
  return count;
}

template <class Sample>
void load_details(Workspace<Sample>& work, const Stage& stage, const Target<Sample>& target) {
  const Size3& pairs = stage.pairs;
  work.residuals.set_size(pairs);
  const auto load = [&](auto stretch, std::int64_t step) {
    for (std::int64_t z = 0; z < pairs.z; ++z) {
      for (std::int64_t y = 0; y < pairs.y; ++y) {
        const std::int64_t fine_y = stage.axis == 1 ? 2 * y : y;
        const std::int64_t fine_z = stage.axis == 2 ? 2 * z : z;
        const Sample* const a = target.samples + (fine_z * target.size.y + fine_y) * target.size.x;
        Wide<Sample>* const details = work.residuals.row(y, z);
        for (std::int64_t x = 0; x < pairs.x; ++x) {
          details[x] = static_cast<Wide<Sample>>(a[stretch * x]) - a[stretch * x + step];
        }
      }
    }
  };
  // Distances that compilers know make vectors.
  if (stage.axis == 0) load(std::integral_constant<int, 2>(), 1);
  else load(std::integral_constant<int, 1>(),
            stage.axis == 1 ? target.size.x : target.size.x * target.size.y);
}

template void load_details(Workspace<std::int16_t>&, const Stage&, const Target<std::int16_t>&);
template void load_details(Workspace<std::int32_t>&, const Stage&, const Target<std::int32_t>&);

namespace {

/// The ranges of every 32nd voxel of rows: compilers make vectors of them. Types of 8 and 16 bits
/// are compared as those that any machine has vectors for: others have their highest bit turned.
template <class T>
class ColumnRanges {
 public:
  ColumnRanges() {
    lowest_.fill(std::numeric_limits<Compared>::max());
    highest_.fill(std::numeric_limits<Compared>::lowest());
  }

  void add(const T* row, std::int64_t length) {
    for (; length >= kColumns; length -= kColumns, row += kColumns) add_some(row, kColumns);
    add_some(row, length);
  }

  ValueRange range() const {
    const auto voxel = [](Compared c) { return static_cast<std::int64_t>(turned<T>(c)); };
    return {voxel(*std::min_element(lowest_.begin(), lowest_.end())),
            voxel(*std::max_element(highest_.begin(), highest_.end()))};
  }

 private:
  using Compared = std::conditional_t<sizeof(T) == 1, std::uint8_t,
                                      std::conditional_t<sizeof(T) == 2, std::int16_t, T>>;
  static constexpr std::int64_t kColumns = 32;

  template <class To, class From>
  static To turned(From number) {
    if constexpr (std::is_same_v<T, Compared>) return number;
    else return static_cast<To>(number ^ (1 << (8 * sizeof(T) - 1)));
  }

  void add_some(const T* row, std::int64_t count) {
    Compared* const lowest = lowest_.data();
    Compared* const highest = highest_.data();
    for (std::int64_t i = 0; i < count; ++i) {
      const auto number = turned<Compared>(row[i]);
      lowest[i] = std::min(lowest[i], number);
      highest[i] = std::max(highest[i], number);
    }
  }

  std::array<Compared, kColumns> lowest_;
  std::array<Compared, kColumns> highest_;
};

/// Has a row fetched that will be read soon: rows of a brick lie far apart.
template <class T>
void fetch_row(const T* row, std::int64_t length) {
  constexpr std::int64_t kLine = 64 / sizeof(T);
  for (std::int64_t x = 0; x < length; x += kLine) __builtin_prefetch(row + x);
}

}  // namespace

ValueRange range_of(const BrickView& brick) {
  if (!is_integer(brick.type)) {
    throw Error(ErrorKind::invalid_argument, "float voxels have no grey codec");
  }
  return with_voxel_type(brick.type, [&](auto tag) -> ValueRange {
    using T = typename decltype(tag)::type;
    ColumnRanges<T> columns;
    for (std::int64_t z = 0; z < brick.size.z; ++z) {
      const T* row = static_cast<const T*>(brick.voxels) + z * brick.plane_stride;
      for (std::int64_t y = 0; y < brick.size.y; ++y, row += brick.row_stride) {
        if (z + 1 < brick.size.z) fetch_row(row + brick.plane_stride, brick.size.x);
        columns.add(row, brick.size.x);
      }
    }
    return columns.range();
  });
}

template <class Sample>
AnalyzedBrick<Sample> analyze(const BrickShape& whole, const BrickView& brick,
                              const SampleScale& scale, const AxisOrder& order, int first) {
  AnalyzedBrick<Sample> result;
  result.scale = scale;
  std::vector<Sample> samples = gather<Sample>(brick, result.scale, order);
  for (int i = 0; i < first; ++i) samples = coarser_level(std::move(samples), whole, i);
  const BrickShape shape = shape_from(whole, first);
  if (has_cells(shape)) result.cells = find_cells(shape, samples);
  result.steps.resize(static_cast<std::size_t>(shape.level_count));
  for (int level = 0; level < shape.level_count; ++level) {
    const auto slot = static_cast<std::size_t>(level);
    const bool is_last = level + 1 == shape.level_count;
    if (is_last) result.coarsest = samples;
    const SampleWeights weights = weights_of(shape, level);
    Size3 size = shape.size[slot];
    for (int axis = 0; axis < 3; ++axis) {
      if ((shape.halving[slot] >> axis & 1) == 0) continue;
      std::vector<Sample> means =
          means_along(samples, size, axis, rounding_term(shape, level, axis),
                      weights.last_pair(axis, size[axis]));
      size = halved(size, static_cast<HalvingMask>(1 << axis));
      if (!is_last) result.steps[slot][static_cast<std::size_t>(axis)] = std::move(samples);
      samples = std::move(means);
    }
  }
  result.parent = samples.front() + result.scale.base();
  return result;
}

template AnalyzedBrick<std::int16_t> analyze(const BrickShape&, const BrickView&,
                                             const SampleScale&, const AxisOrder&, int);
template AnalyzedBrick<std::int32_t> analyze(const BrickShape&, const BrickView&,
                                             const SampleScale&, const AxisOrder&, int);

}  // namespace octavo::grey
