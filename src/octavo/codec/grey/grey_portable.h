// The passes of a split in plain C++: the reference for every instruction set, and what wide
// samples run on.
#pragma once

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "octavo/codec/encoders.h"
#include "octavo/codec/grey/grey_stage.h"
#include "octavo/codec/grey/octant_transform.h"
#include "octavo/codec/grey/residual_fold.h"

namespace octavo::grey {

/// Offsets of the rows of 8 taps around a sample, in samples, by split axis.
template <class Sample>
struct TapRows {
  static constexpr std::int64_t R = SampleGrid<Sample>::kRow;
  static constexpr std::int64_t P = SampleGrid<Sample>::kPlane;
  static constexpr int kCount[3] = {10, 12, 12};
  static constexpr std::int64_t kOffsets[3][12] = {
      {-8, 0, -R - 3, R - 3, -P - 3, P - 3, -P - R - 3, -P + R - 3, P - R - 3, P + R - 3, 0, 0},
      {-2 * R - 3, -R - 3, -3, R - 3, 2 * R - 3, -P - R - 3, -P - 3, -P + R - 3, -P + 2 * R - 3,
       P - R - 3, P - 3, P + 2 * R - 3},
      {-2 * P - 3, -P - R - 3, -P - 3, -P + R - 3, -R - 3, -3, R - 3, P - R - 3, P - 3,
       2 * P - R - 3, 2 * P - 3, 2 * P + R - 3}};
};

/// The distance between the two samples of a pair, and between neighboring pairs of a row.
template <class Sample>
constexpr std::int64_t pair_step(int axis) {
  return axis == 0 ? 1 : axis == 1 ? SampleGrid<Sample>::kRow : SampleGrid<Sample>::kPlane;
}
constexpr std::int64_t pair_stretch(int axis) { return axis == 0 ? 2 : 1; }

/// The first sample of the first pair of a row.
template <class Sample>
Sample* first_of_row(SampleGrid<Sample>& fine, int axis, std::int64_t y, std::int64_t z) {
  return fine.row(axis == 1 ? 2 * y : y, axis == 2 ? 2 * z : z);
}

/// The lowest bits of 8 bytes.
inline RowMask mask_of_bytes(const std::uint8_t* bytes) {
  std::uint64_t eight;
  std::memcpy(&eight, bytes, 8);
  if constexpr (std::endian::native == std::endian::big) eight = __builtin_bswap64(eight);
  // That of each byte to the highest byte, in their order
  return (eight & 0x0101010101010101u) * 0x0102040810204080u >> 56;
}

/// Calls f(x) for the pairs of a mask, first to last.
template <class F>
void for_each_pair(RowMask pairs, F&& f) {
  for (; pairs != 0; pairs &= pairs - 1) f(std::countr_zero(pairs));
}

/// The pairs of a row that lie in no uniform cell.
template <class Sample>
RowMask open_pairs(const Stage& stage, Workspace<Sample>& work, std::int64_t y, std::int64_t z) {
  return stage.cells == nullptr ? first_pairs(stage.pairs.x) : work.open.row(y, z);
}

/// The pairs of a row whose residuals are coded.
template <class Sample>
RowMask coded_pairs(const Stage& stage, Workspace<Sample>& work, std::int64_t y, std::int64_t z) {
  const RowMask open = open_pairs(stage, work, y, z);
  return stage.has_edges ? open & ~work.edges.row(y, z) : open;
}

/// The number of coded pairs of a row; they are listed in work.row.order unless it is all.
template <class Sample>
int list_coded(const Stage& stage, Workspace<Sample>& work, std::int64_t y, std::int64_t z) {
  const RowMask coded = coded_pairs(stage, work, y, z);
  const int count = std::popcount(coded);
  if (count == stage.pairs.x) return count;
  std::uint8_t* to = work.row.order;
  for_each_pair(coded, [&](int x) { *to++ = static_cast<std::uint8_t>(x); });
  return count;
}

/// The details of pairs that are not coded are known: a limit of 0 makes their predictions 0.
template <class Limit>
void close_pairs(RowMask coded, std::int64_t count, Limit* limits) {
  if (coded == first_pairs(count)) return;
  for (std::int64_t x = 0; x < count; ++x) {
    limits[x] = (coded >> x & 1) != 0 ? limits[x] : Limit{0};
  }
}

/// The details of the edges of a row, 0 for its other pairs; null where it has none.
template <class Sample>
const Wide<Sample>* edge_details(const Stage& stage, Workspace<Sample>& work, std::int64_t y,
                                 std::int64_t z) {
  if (!stage.has_edges || work.edges.row(y, z) == 0) return nullptr;
  return work.edges.details.row(y, z);
}

/// The details of pairs of two weights leave the samples within the brick's range only if they are
/// true ones; their limit is the whole range.
template <class Limit>
void open_weighted(const Stage& stage, std::int64_t first, Limit* limits,
                   std::uint16_t* scaled_limits) {
  const std::int64_t range = stage.max - stage.min;
  for (std::int64_t x = first; x < stage.pairs.x; ++x) {
    limits[x] = static_cast<Limit>(range);
    scaled_limits[x] = static_cast<std::uint16_t>(range >> stage.shift);
  }
}

/// The samples of a pair of two weights, within the brick's range.
template <class Sample>
Pair<Sample> weighted_pair(const Stage& stage, std::int64_t mean, std::int64_t detail) {
  const auto pair = weighted_pair_of(mean, detail, stage.last_pair, stage.rounding);
  return {static_cast<Sample>(std::clamp(pair.a, stage.min, stage.max)),
          static_cast<Sample>(std::clamp(pair.b, stage.min, stage.max))};
}

/// A Q12 sum to an integer; wraps like the sum itself.
template <class Int>
Int rounded_weights(Int sum) {
  using Unsigned = std::make_unsigned_t<Int>;
  return static_cast<Int>(static_cast<Unsigned>(sum) + (1u << (kWeightBits - 1))) >> kWeightBits;
}

/// Half of the unit of shares, for rounding.
inline constexpr std::int32_t kHalfShare = 1 << (kShareBits - 1);

/// What the two means before a pair and the two after it predict.
template <class Sample>
Wide<Sample> predict_from_means(const Sample* means, std::int64_t along, std::int32_t weight,
                                std::int32_t far_share) {
  using Int = Wide<Sample>;
  const Int near = Int{means[-along]} - means[along];
  const Int far = Int{means[-2 * along]} - means[2 * along];
  const Int slope = near + ((far * far_share + kHalfShare) >> kShareBits);
  return rounded_weights<Int>(slope * weight);
}

/// The detail of a residual; a damaged one is brought within the limit, so that nothing overflows.
template <class Int>
Int decoded_detail(Int residual, Int prediction, Int limit, std::int32_t step) {
  if (step == 1) return detail_of(residual, prediction, limit);
  const std::int64_t detail = std::int64_t{prediction} + residual;
  return static_cast<Int>(std::clamp<std::int64_t>(detail, -limit, limit));
}

/// Gives the pairs of two weights of a row their samples, after a pass that took them for pairs of
/// equal weights. Of a prediction from means: the other pairs of the plane do not see them.
template <class DetailAt>
void settle_weighted(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y,
                     std::int64_t z, DetailAt&& detail_at) {
  const std::int16_t* const means = work.means.row(y, z);
  std::int16_t* const row = first_of_row(work.fine, stage.axis, y, z);
  for (std::int64_t x = stage.first_weighted(y, z); x < stage.pairs.x; ++x) {
    const Pair<std::int16_t> pair = weighted_pair<std::int16_t>(stage, means[x], detail_at(x));
    std::int16_t* const at = row + pair_stretch(stage.axis) * x;
    at[0] = pair.a;
    at[pair_step<std::int16_t>(stage.axis)] = pair.b;
  }
}

/// What is added to a residual's magnitude before it is cut down to a multiple of the step.
constexpr std::int32_t rounding_bias(std::int32_t step) { return step * 3 / 8; }

/// The margins of a row of magnitudes that contexts look at.
inline void fill_margins(std::int16_t* magnitudes, std::int64_t count) {
  magnitudes[-1] = magnitudes[-2] = magnitudes[0];
  magnitudes[count] = magnitudes[count + 1] = magnitudes[count - 1];
}

template <class Sample>
struct PortableKernel;

/// The rows of magnitudes around row (y, z) of the split along `axis`. A model that predicts from
/// means does not look at the row above, nor anywhere in the own plane.
inline MagnitudeRows magnitude_rows(const SampleGrid<std::int16_t>* magnitudes, Predictor predictor,
                                    int axis, std::int64_t y, std::int64_t z,
                                    const std::int16_t* zeros) {
  const auto sibling = [&](int other, std::int64_t yy, std::int64_t zz) {
    const SampleGrid<std::int16_t>& grid = magnitudes[other];
    if (grid.size().voxel_count() == 0) return zeros;
    return grid.row(std::min(yy, grid.size().y - 1), std::min(zz, grid.size().z - 1));
  };
  MagnitudeRows near{{zeros, zeros}, nullptr, nullptr, nullptr, nullptr};
  if (axis == 1) near.sibling[0] = sibling(2, y, z / 2);
  if (axis == 0) {
    const bool is_y_halved = magnitudes[1].size().voxel_count() > 0;
    near.sibling[0] = sibling(1, y / 2, z);
    near.sibling[1] = sibling(2, is_y_halved ? y / 2 : y, z / 2);
  }
  const SampleGrid<std::int16_t>& own = magnitudes[axis];
  near.up = predictor == Predictor::means ? zeros
            : y > 0                       ? own.row(y - 1, z)
            : z > 0                       ? own.row(y, z - 1)
                                          : zeros;
  near.back = z > 0 ? own.row(y, z - 1) : near.up;
  near.back_up = z > 0 && y > 0 ? own.row(y - 1, z - 1) : near.back;
  near.back_down = z > 0 && y + 1 < own.size().y ? own.row(y + 1, z - 1) : near.back;
  return near;
}

/// The passes built on a Kernel, which has
///   row_features(p, stage, work, y, z)    fills work.row, and the activities and limits of the row
///   close_row(coded, count, limits)        close_pairs
///   row_contexts(p, stage, near, row, contexts)
///   take_row(symbols, contexts, coded, count, residuals)   0 for pairs that are not coded
///   takes_planes(p, stage)                     whether take_plane knows this split from means
///   take_plane(p, task, z)                     all of a plane: contexts, residuals and samples
///   take_planes(p, tasks, z)                   the same for several splits along one axis
///   give_plane(p, stage, work, z)              details of a plane to contexts, residuals, samples
///                                              and magnitudes
///   write_row(residuals, contexts, count, writer)
///   keep_magnitudes(residuals, count, shift, magnitudes)
///   predicts_rows(p, stage)                    whether predict_row knows this split
///   predict_row(p, stage, work, y, z)          details to residuals and samples, after the rows
///                                              before it
///   reconstruct_row<is_encoding>(p, stage, work, y, z)   from means: residuals to samples, or
///                                              details to residuals and samples
///   reconstruct<is_encoding>(p, stage, work)   the same from neighbors, for all rows
template <class Sample, class Kernel>
struct Passes {
  using Int = Wide<Sample>;

  /// keeps_planes: whether the numbers of all planes are needed at once; small buffers leave the
  /// cache to the tables.
  static void set_sizes(const Stage& stage, bool keeps_planes, Workspace<Sample>& work) {
    const auto set = [&](auto& grid) {
      if (keeps_planes) grid.set_size(stage.pairs);
      else grid.set_plane_size(stage.pairs);
    };
    set(work.residuals);
    set(work.limits);
    set(work.activities);
    set(work.predictions);
    work.excesses.set_plane_size(stage.pairs);
    work.plane_excesses.set_plane_size(stage.pairs);
    work.contexts.set_plane_size(stage.pairs);
    // Whoever marked the edges has found them already.
    if (stage.cells != nullptr && !stage.has_edges) find_open_pairs(stage, work.open);
    work.magnitudes[stage.axis].set_size(stage.pairs);
  }

  static void features(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                       std::int64_t y, std::int64_t z) {
    const RowMask coded = coded_pairs(stage, work, y, z);
    if (coded == 0) {
      // Nothing looks at the others.
      std::fill_n(work.limits.row(y, z), stage.pairs.x, Limit<Sample>{0});
      std::fill_n(work.activities.row(y, z), stage.pairs.x, std::uint8_t{0});
      return;
    }
    Kernel::row_features(p, stage, work, y, z);
    open_weighted(stage, stage.first_weighted(y, z), work.limits.row(y, z), work.row.limit);
    Kernel::close_row(coded, stage.pairs.x, work.limits.row(y, z));
  }

  static void contexts(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                       std::int64_t y, std::int64_t z) {
    if (coded_pairs(stage, work, y, z) == 0) return;
    const MagnitudeRows near = magnitude_rows(work.magnitudes, p.predictor, stage.axis, y, z,
                                              work.row.zeros + 8);
    Kernel::row_contexts(p, stage, near, work.row, work.contexts.row(y, z));
  }

  static void take(const Stage& stage, Workspace<Sample>& work, std::int64_t y, std::int64_t z,
                   SymbolReader& symbols) {
    const int count = static_cast<int>(stage.pairs.x);
    const RowMask coded = coded_pairs(stage, work, y, z);
    Int* const residuals = work.residuals.row(y, z);
    if (coded == 0) std::fill_n(residuals, count, Int{0});
    else Kernel::take_row(symbols, work.contexts.row(y, z), coded, count, residuals);
    if (stage.step > 1) {
      using Unsigned = std::make_unsigned_t<Int>;
      for (int x = 0; x < count; ++x) {
        residuals[x] = static_cast<Int>(static_cast<Unsigned>(residuals[x]) *
                                        static_cast<Unsigned>(stage.step));
      }
    }
    keep_magnitudes(stage, work, y, z);
  }

  static bool takes_planes(const Parameters& p, const Stage& stage) {
    return p.predictor == Predictor::means && stage.gaps == nullptr &&
           Kernel::takes_planes(p, stage);
  }

  static void decode(const Parameters& p, const SplitTask<Sample>& task) {
    const auto& [stage, work, symbols] = task;
    // Predicted from means, a plane's details are done with at its end.
    set_sizes(stage, p.predictor == Predictor::neighbors, work);
    if (stage.pairs.voxel_count() == 0) return;
    if (takes_planes(p, stage)) {
      for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
        Kernel::take_plane(p, task, z);
      }
      return;
    }
    if (p.predictor == Predictor::means) {
      // No row needs another one of its plane: the machine may overlap them.
      for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
        for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
          features(p, stage, work, y, z);
          contexts(p, stage, work, y, z);
        }
        for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
          take(stage, work, y, z, symbols);
          Kernel::template reconstruct_row<false>(p, stage, work, y, z);
        }
      }
      return;
    }
    for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
      for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
        features(p, stage, work, y, z);
        contexts(p, stage, work, y, z);
        take(stage, work, y, z, symbols);
      }
    }
    Kernel::template reconstruct<false>(p, stage, work);
  }

  static void decode_together(const Parameters& p, std::span<const SplitTask<Sample>> tasks) {
    const bool is_of_planes = std::all_of(tasks.begin(), tasks.end(), [&](const auto& task) {
      return task.stage.pairs.voxel_count() > 0 && takes_planes(p, task.stage);
    });
    if (tasks.size() == 1 || !is_of_planes) {
      for (const auto& task : tasks) decode(p, task);
      return;
    }
    std::int64_t most = 0;
    std::vector<const SplitTask<Sample>*> sorted;
    for (const auto& task : tasks) {
      set_sizes(task.stage, false, task.work);
      most = std::max(most, task.stage.pairs.z);
      sorted.push_back(&task);
    }
    // Streams of as many states stand side by side.
    std::sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) {
      return a->symbols.state_mask > b->symbols.state_mask;
    });
    // Some may have fewer planes than others.
    std::vector<SplitTask<Sample>> left;
    for (std::int64_t z = 0; z < most; ++z) {
      left.clear();
      for (const auto* const task : sorted) {
        if (z < task->stage.pairs.z) left.push_back(*task);
      }
      if (left.size() == 1) Kernel::take_plane(p, left.front(), z);
      else Kernel::take_planes(p, left, z);
    }
  }

  static void measure(const Parameters& p, const Stage& stage, Workspace<Sample>& work) {
    require_encoders();
    set_sizes(stage, true, work);
    for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
      for (std::int64_t y = 0; y < stage.pairs.y; ++y) features(p, stage, work, y, z);
    }
  }

  static void predict(const Parameters& p, const Stage& stage, Workspace<Sample>& work) {
    require_encoders();
    set_sizes(stage, true, work);
    if (stage.pairs.voxel_count() == 0) return;
    const bool predicts_rows = Kernel::predicts_rows(p, stage);
    for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
      for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
        features(p, stage, work, y, z);
        if (predicts_rows) Kernel::predict_row(p, stage, work, y, z);
      }
    }
    if (!predicts_rows) Kernel::template reconstruct<true>(p, stage, work);
  }

  /// Calls prepare_plane(z) for every plane, and prepare_row(y, z, coded pairs) for every row,
  /// before take(coded pairs, y, z) takes its residuals and contexts.
  template <class PreparePlane, class PrepareRow, class Take>
  static void list(const Stage& stage, Workspace<Sample>& work, PreparePlane&& prepare_plane,
                   PrepareRow&& prepare_row, Take&& take) {
    if (stage.pairs.voxel_count() == 0) return;
    for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
      prepare_plane(z);
      for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
        const int coded = list_coded(stage, work, y, z);
        prepare_row(y, z, coded);
        take(coded, y, z);
      }
    }
  }

  /// The same of a split whose residuals are known.
  template <class Take>
  static void list_known(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                         Take&& take) {
    list(stage, work, [](std::int64_t) {},
         [&](std::int64_t y, std::int64_t z, int coded) {
           keep_magnitudes(stage, work, y, z);
           if (coded == 0) return;
           features(p, stage, work, y, z);
           contexts(p, stage, work, y, z);
         },
         take);
  }

  /// The same of one whose details are known.
  template <class Take>
  static void encode_rows(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                          Take&& take) {
    const bool has_planes = takes_planes(p, stage);
    if (!has_planes && !Kernel::predicts_rows(p, stage)) {
      predict(p, stage, work);
      list_known(p, stage, work, take);
      return;
    }
    set_sizes(stage, false, work);
    work.residuals.set_size(stage.pairs);
    if (has_planes) {
      list(stage, work, [&](std::int64_t z) { Kernel::give_plane(p, stage, work, z); },
           [](std::int64_t, std::int64_t, int) {}, take);
      return;
    }
    list(stage, work, [](std::int64_t) {},
         [&](std::int64_t y, std::int64_t z, int coded) {
           features(p, stage, work, y, z);
           Kernel::predict_row(p, stage, work, y, z);
           keep_magnitudes(stage, work, y, z);
           if (coded > 0) contexts(p, stage, work, y, z);
         },
         take);
  }

  /// Calls pass(take) and appends the symbols of the rows that it takes.
  template <class Pass>
  static void append(const Stage& stage, Workspace<Sample>& work, std::vector<Symbol>& symbols,
                     Pass&& pass) {
    const std::size_t listed = symbols.size();
    symbols.resize(listed + static_cast<std::size_t>(stage.pairs.voxel_count()));
    Symbol* next = symbols.data() + listed;
    pass([&](int coded, std::int64_t y, std::int64_t z) {
      next = list_row(stage, work, coded, y, z, next);
    });
    symbols.resize(static_cast<std::size_t>(next - symbols.data()));
  }

  static void list_symbols(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                           std::vector<Symbol>& symbols) {
    require_encoders();
    append(stage, work, symbols, [&](auto&& take) { list_known(p, stage, work, take); });
  }

  static void encode(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                     std::vector<Symbol>& symbols) {
    require_encoders();
    append(stage, work, symbols, [&](auto&& take) { encode_rows(p, stage, work, take); });
  }

  static void write(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                    SymbolWriter& writer) {
    require_encoders();
    encode_rows(p, stage, work, [&](int coded, std::int64_t y, std::int64_t z) {
      write_row(stage, work, coded, y, z, writer);
    });
  }

  static void keep_magnitudes(const Stage& stage, Workspace<Sample>& work, std::int64_t y,
                              std::int64_t z) {
    const int count = static_cast<int>(stage.pairs.x);
    std::int16_t* const magnitudes = work.magnitudes[stage.axis].row(y, z);
    Kernel::keep_magnitudes(work.residuals.row(y, z), count, stage.shift, magnitudes);
    fill_margins(magnitudes, count);
  }

  /// Lists the coded pairs of a row; gives where the next row's go.
  static Symbol* list_row(const Stage& stage, Workspace<Sample>& work, int coded, std::int64_t y,
                          std::int64_t z, Symbol* to) {
    const Int* const residuals = work.residuals.row(y, z);
    const std::uint16_t* const context = work.contexts.row(y, z);
    if (coded == stage.pairs.x && stage.step == 1) {
      for (int x = 0; x < coded; ++x) to[x] = Symbol(zigzag(residuals[x]), context[x], x);
      return to + coded;
    }
    for (int i = 0; i < coded; ++i) {
      const int x = coded == stage.pairs.x ? i : work.row.order[i];
      const Int value = stage.step > 1 ? residuals[x] / stage.step : residuals[x];
      to[i] = Symbol(zigzag(value), context[x], i);
    }
    return to + coded;
  }

  /// Adds the coded pairs of a row to a segment.
  static void write_row(const Stage& stage, Workspace<Sample>& work, int coded, std::int64_t y,
                        std::int64_t z, SymbolWriter& writer) {
    const Int* residuals = work.residuals.row(y, z);
    const std::uint16_t* context = work.contexts.row(y, z);
    Int own_residuals[kBrickSide];
    std::uint16_t own_contexts[kBrickSide];
    if (coded < stage.pairs.x || stage.step > 1) {
      for (int i = 0; i < coded; ++i) {
        const int x = coded == stage.pairs.x ? i : work.row.order[i];
        own_residuals[i] = stage.step > 1 ? residuals[x] / stage.step : residuals[x];
        own_contexts[i] = context[x];
      }
      residuals = own_residuals;
      context = own_contexts;
    }
    Kernel::write_row(residuals, context, coded, writer);
  }

  /// Less those of edges.
  static constexpr StagePasses<Sample> functions() {
    return {decode, decode_together, measure, predict, list_symbols,
            encode, write,           nullptr, nullptr};
  }
};

/// Plain loops in raster order.
template <class Sample>
struct PortableKernel {
  using Int = Wide<Sample>;

  static void row_features(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                           std::int64_t y, std::int64_t z) {
    some_features(p, stage, work, {{0, y, z}, {stage.pairs.x, y + 1, z + 1}});
  }
  /// The same of some pairs of a row.
  static void some_features(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                            const Box& pairs);
  static void close_row(RowMask coded, std::int64_t count, Limit<Sample>* limits) {
    close_pairs(coded, count, limits);
  }
  static void row_contexts(const Parameters& p, const Stage& stage, const MagnitudeRows& near,
                           const RowBuffers& row, std::uint16_t* contexts);
  static void take_row(SymbolReader& symbols, const std::uint16_t* contexts, RowMask coded,
                       int count, Int* residuals) {
    std::fill_n(residuals, count, Int{0});
    int i = 0;
    for_each_pair(coded, [&](int x) {
      residuals[x] = static_cast<Int>(symbols.take(i++, contexts[x]));
    });
    symbols.expect_inside();
  }
  static bool takes_planes(const Parameters&, const Stage&) { return false; }
  static void take_plane(const Parameters&, const SplitTask<Sample>&, std::int64_t) {}
  static void take_planes(const Parameters&, std::span<const SplitTask<Sample>>, std::int64_t) {}
  static void give_plane(const Parameters&, const Stage&, Workspace<Sample>&, std::int64_t) {}
  static bool predicts_rows(const Parameters&, const Stage&) { return true; }
  static void predict_row(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                          std::int64_t y, std::int64_t z) {
    reconstruct_row<true>(p, stage, work, y, z);
  }
  static void write_row(const Int* residuals, const std::uint16_t* contexts, int count,
                        SymbolWriter& writer) {
    writer.make_room(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      writer.add(Symbol(zigzag(std::int64_t{residuals[i]}), contexts[i], i));
    }
  }
  static void keep_magnitudes(const Int* residuals, int count, int shift,
                              std::int16_t* magnitudes) {
    for (int x = 0; x < count; ++x) {
      // A damaged residual may be the lowest number of its type, which has no opposite.
      const auto bits = static_cast<std::make_unsigned_t<Int>>(residuals[x]);
      const auto magnitude = (residuals[x] < 0 ? 0 - bits : bits) >> shift;
      magnitudes[x] = static_cast<std::int16_t>(
          std::min<std::make_unsigned_t<Int>>(magnitude, kMaxMagnitude));
    }
  }
  template <bool kIsEncoding>
  static void reconstruct_row(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                              std::int64_t y, std::int64_t z);
  template <bool kIsEncoding>
  static void reconstruct(const Parameters& p, const Stage& stage, Workspace<Sample>& work);
};

}  // namespace octavo::grey
