#include "octavo/codec/grey/edge_pairs.h"

#include <algorithm>

#include "octavo/codec/grey/grey_portable.h"

namespace octavo::grey {

namespace {

template <class Sample>
void clear_edges(const Stage& stage, Workspace<Sample>& work) {
  work.edges.set_size(stage.pairs);
  work.edge_details.set_size(stage.pairs);
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      std::fill_n(work.edges.row(y, z), stage.pairs.x, Edge::none);
    }
  }
}

/// Calls f(x, y, z) for the pairs of a split that may be edges: those outside uniform cells whose
/// samples weigh alike.
template <class F>
void for_each_pair(const Stage& stage, F&& f) {
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      const std::int64_t end = stage.first_weighted(y, z);
      const auto run = [&](std::int64_t first, std::int64_t last, bool is_uniform) {
        for (std::int64_t x = first; x < std::min(last, end) && !is_uniform; ++x) f(x, y, z);
      };
      const std::uint8_t* const cells = row_cells(stage, y, z);
      if (cells == nullptr) run(0, stage.pairs.x, false);
      else for_each_cell(stage, cells, run);
    }
  }
}

/// The pairs that may be edges, one after the other, with their contexts.
template <class Sample, class Code>
std::int64_t walk_edges(const Stage& stage, Workspace<Sample>& work, EdgeModels& models,
                        Code&& code) {
  using Int = Wide<Sample>;
  const auto lowest = static_cast<Int>(stage.min);
  const auto highest = static_cast<Int>(stage.max);
  const std::int64_t along = pair_step<Sample>(stage.axis);
  const std::int64_t across1 = pair_step<Sample>(stage.axis == 0 ? 1 : 0);
  const std::int64_t across2 = pair_step<Sample>(stage.axis == 2 ? 1 : 2);
  std::int64_t count = 0;
  for_each_pair(stage, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    const Sample* const mean = work.means.row(y, z) + x;
    if (*mean <= lowest) return;
    // The sample that is not background; one more when the sum of both is odd.
    const Int other = 2 * Int{*mean} - stage.rounding - lowest;
    if (other > highest) return;
    // Is it an edge? By the background around and the edges before.
    const auto is_background = [&](std::int64_t at) { return mean[at] == lowest ? 1u : 0u; };
    const unsigned before = is_background(-along);
    const unsigned after = is_background(along);
    const unsigned across = is_background(-across1) + is_background(across1) +
                            is_background(-across2) + is_background(across2);
    Edge* const edge = work.edges.row(y, z) + x;
    const Edge near[3] = {x > 0 ? edge[-1] : Edge::none,
                          y > 0 ? work.edges.row(y - 1, z)[x] : Edge::none,
                          z > 0 ? work.edges.row(y, z - 1)[x] : Edge::none};
    const auto firsts = std::count(near, near + 3, Edge::first);
    const auto seconds = std::count(near, near + 3, Edge::second);
    auto& is_edge = models.is_edge[before + after][across]
                                  [static_cast<std::size_t>(firsts + seconds)];
    if (!code.adaptive(is_edge, *edge != Edge::none)) return;
    // Which of the two samples is it?
    const std::size_t lean = firsts > seconds ? 2 : firsts == seconds ? 1 : 0;
    const bool is_first = code.adaptive(models.is_first[1 + before - after][lean],
                                        *edge == Edge::first);
    // Its detail, but for one bit where the sum is odd
    Int& detail = work.edge_details.row(y, z)[x];
    const Int size = other - lowest;
    const Int odd = other < highest && code.even((detail < 0 ? -detail : detail) != size) ? 1 : 0;
    *edge = is_first ? Edge::first : Edge::second;
    detail = is_first ? -(size + odd) : size + odd;
    ++count;
  });
  return count;
}

struct Putter {
  BinaryEncoder& coder;
  bool adaptive(AdaptiveBit& model, bool bit) const {
    put_adaptive(coder, model, bit);
    return bit;
  }
  bool even(bool bit) const {
    coder.put(bit, kEvenOdds);
    return bit;
  }
};

struct Getter {
  BinaryDecoder& coder;
  bool adaptive(AdaptiveBit& model, bool) const { return get_adaptive(coder, model); }
  bool even(bool) const { return coder.get(kEvenOdds); }
};

}  // namespace

template <class Sample>
std::int64_t mark_edges(const Stage& stage, Workspace<Sample>& work) {
  using Int = Wide<Sample>;
  const auto lowest = static_cast<Int>(stage.min);
  std::int64_t count = 0;
  clear_edges(stage, work);
  for_each_pair(stage, [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    const Int mean = work.means.row(y, z)[x];
    const Int detail = work.residuals.row(y, z)[x];
    if (mean == lowest || detail == 0) return;
    const Pair<Int> pair = pair_of<Int>(mean, detail, stage.rounding);
    if (pair.a != lowest && pair.b != lowest) return;
    work.edges.row(y, z)[x] = pair.a == lowest ? Edge::first : Edge::second;
    work.edge_details.row(y, z)[x] = detail;
    ++count;
  });
  return count;
}

template <class Sample>
void put_edges(const Stage& stage, Workspace<Sample>& work, BinaryEncoder& coder,
               EdgeModels& models) {
  walk_edges(stage, work, models, Putter{coder});
}

template <class Sample>
std::int64_t take_edges(const Stage& stage, Workspace<Sample>& work, BinaryDecoder& coder,
                        EdgeModels& models) {
  clear_edges(stage, work);
  return walk_edges(stage, work, models, Getter{coder});
}

template std::int64_t mark_edges(const Stage&, Workspace<std::int16_t>&);
template std::int64_t mark_edges(const Stage&, Workspace<std::int32_t>&);
template void put_edges(const Stage&, Workspace<std::int16_t>&, BinaryEncoder&, EdgeModels&);
template void put_edges(const Stage&, Workspace<std::int32_t>&, BinaryEncoder&, EdgeModels&);
template std::int64_t take_edges(const Stage&, Workspace<std::int16_t>&, BinaryDecoder&,
                                 EdgeModels&);
template std::int64_t take_edges(const Stage&, Workspace<std::int32_t>&, BinaryDecoder&,
                                 EdgeModels&);

}  // namespace octavo::grey
