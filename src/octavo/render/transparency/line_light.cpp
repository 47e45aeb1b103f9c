#include "octavo/render/transparency/line_light.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <limits>
#include <memory>

#include "octavo/core/error.h"
#include "octavo/render/transparency/tone_octree.h"

namespace octavo {

namespace {

// The straight sum: cells are added to.
template <std::size_t kChannels>
class SumInk {
 public:
  using Cell = std::array<std::int64_t, kChannels>;
  static constexpr Cell kClear{};

  explicit SumInk(std::span<const std::int32_t> light) : light_(light.size() / kChannels) {
    for (std::size_t i = 0; i < light.size(); ++i) light_[i / kChannels][i % kChannels] = light[i];
  }

  bool is_clear(std::uint16_t tone) const { return light_[tone] == Light{}; }

  void draw_voxel(Cell& cell, std::uint16_t tone) const {
    const Light& light = light_[tone];
    for (std::size_t c = 0; c < kChannels; ++c) cell[c] += light[c];
  }

  // Gives what puts a run of so many voxels of a tone on a cell.
  auto run_of(std::uint16_t tone, std::int64_t) const {
    return [light = light_[tone]](Cell& cell, std::int64_t count) {
      for (std::size_t c = 0; c < kChannels; ++c) cell[c] += light[c] * count;
    };
  }

  void put_before(Cell& cell, const Cell& nearer) const {
    for (std::size_t c = 0; c < kChannels; ++c) cell[c] += nearer[c];
  }

 private:
  using Light = std::array<std::int32_t, kChannels>;
  std::vector<Light> light_;
};

// The exponential average: a cell is cell * kept + given, its last channel what is kept of the
// background.
class VeilInk {
 public:
  using Cell = LineColor;
  static constexpr Cell kClear{0, 0, 0, 1};

  explicit VeilInk(std::span<const ToneVeil> veils) {
    for (const ToneVeil& veil : veils) {
      Veil& v = veils_.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) v.given[c] = veil.color[c] * veil.opacity;
      v.kept = 1 - veil.opacity;
    }
  }

  bool is_clear(std::uint16_t tone) const { return veils_[tone].kept == 1; }

  void draw_voxel(Cell& cell, std::uint16_t tone) const {
    const Veil& veil = veils_[tone];
    for (std::size_t c = 0; c < 4; ++c) cell[c] = cell[c] * veil.kept + veil.given[c];
  }

  // After n voxels: kept^n of what was behind, and given * (1 + kept + ... + kept^(n-1)).
  auto run_of(std::uint16_t tone, std::int64_t longest) const {
    const Veil& veil = veils_[tone];
    std::vector<std::array<float, 2>> runs(static_cast<std::size_t>(longest) + 1);
    double kept = 1;
    double sum = 0;
    for (auto& run : runs) {
      run = {static_cast<float>(kept), static_cast<float>(sum)};
      sum += kept;
      kept *= static_cast<double>(veil.kept);
    }
    return [veil, runs = std::move(runs)](Cell& cell, std::int64_t count) {
      const auto [all_kept, all_sum] = runs[static_cast<std::size_t>(count)];
      for (std::size_t c = 0; c < 4; ++c) cell[c] = cell[c] * all_kept + veil.given[c] * all_sum;
    };
  }

  void put_before(Cell& cell, const Cell& nearer) const {
    const float kept = nearer[3];
    for (std::size_t c = 0; c < 3; ++c) cell[c] = cell[c] * kept + nearer[c];
    cell[3] *= kept;
  }

 private:
  struct Veil {
    std::array<float, 4> given{};
    float kept = 1;
  };
  std::vector<Veil> veils_;
};

// The lines of one block, or of the whole volume.
template <class Ink>
struct Sheet {
  LineRange range;
  std::vector<typename Ink::Cell> cells;

  explicit Sheet(const LineRange& lines)
      : range(lines),
        cells(static_cast<std::size_t>((lines.u_hi - lines.u_lo) * (lines.v_hi - lines.v_lo)),
              Ink::kClear) {}

  std::int64_t row() const { return range.u_hi - range.u_lo; }
  auto* at(std::int64_t u, std::int64_t v) {
    return cells.data() + (v - range.v_lo) * row() + (u - range.u_lo);
  }
};

template <class Ink>
void draw_cube(Sheet<Ink>& sheet, const VoxelLines& lines, const Ink& ink, const Index3& corner,
               std::int64_t side, std::uint16_t tone) {
  if (ink.is_clear(tone)) return;
  const LineRange covered = lines_of(
      lines, {corner, {corner.x + side, corner.y + side, corner.z + side}});
  auto* const first = sheet.at(covered.u_lo, covered.v_lo);
  const auto put = ink.run_of(tone, side);
  const std::int64_t row = sheet.row();
  for_each_line(lines.axes, side, [&](std::int64_t u, std::int64_t v, std::int64_t count) {
    put(first[v * row + u], count);
  });
}

// Draws the leaves of a block; returns how many there are.
template <class Ink>
std::int64_t draw_block(Sheet<Ink>& sheet, const VoxelLines& lines, const Ink& ink,
                        const Index3& corner, const ToneBlock& block,
                        const std::array<int, 8>& octants) {
  // A voxel's cell is linear in its place.
  const std::int64_t row = sheet.row();
  auto* const first = sheet.at(lines.u_of(corner), lines.v_of(corner));
  std::array<std::int64_t, 3> step{};
  for (std::size_t a = 0; a < 3; ++a) step[a] = lines.u_step[a] + lines.v_step[a] * row;
  std::int64_t leaves = 0;
  block.visit_leaves(
      octants,
      [&](const Index3& v, std::uint16_t tone) {
        ++leaves;
        ink.draw_voxel(first[v.x * step[0] + v.y * step[1] + v.z * step[2]], tone);
      },
      [&](const Index3& v, std::int64_t side, std::uint16_t tone) {
        ++leaves;
        draw_cube(sheet, lines, ink, {corner.x + v.x, corner.y + v.y, corner.z + v.z}, side, tone);
      });
  return leaves;
}

template <class Ink>
void put_before(Sheet<Ink>& sheet, Sheet<Ink>& nearer, const Ink& ink) {
  for (std::int64_t v = nearer.range.v_lo; v < nearer.range.v_hi; ++v) {
    auto* const to = sheet.at(nearer.range.u_lo, v);
    const auto* const from = nearer.at(nearer.range.u_lo, v);
    for (std::int64_t i = 0; i < nearer.row(); ++i) ink.put_before(to[i], from[i]);
  }
}

// A piece on its way: blocks are drawn on sheets of their own, by any thread.
template <class Ink>
struct DrawnPiece {
  TonePiece piece;
  std::unique_ptr<Sheet<Ink>> sheet;
  std::int64_t leaves = 1;
};

struct Scratch {
  ToneBlock block;
  std::vector<std::byte> voxels;
};

template <class Ink>
std::vector<typename Ink::Cell> draw_volume(const ToneOctree& octree, const VoxelLines& lines,
                                            const Ink& ink, Progress& progress,
                                            LineCounts& counts) {
  const std::array<int, 8> octants = back_to_front(lines.along);
  const std::vector<TonePiece> pieces = octree.pieces(octants);
  const ProgressScope scope(progress, "picture", static_cast<std::int64_t>(pieces.size()),
                            "blocks");
  Sheet<Ink> whole({0, 0, lines.width, lines.height});
  tbb::enumerable_thread_specific<Scratch> scratches;
  std::size_t next = 0;
  const auto take = [&](tbb::flow_control& flow) -> std::size_t {
    if (next < pieces.size()) return next++;
    flow.stop();
    return next;
  };
  const auto draw = [&](std::size_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    auto drawn = std::make_shared<DrawnPiece<Ink>>(DrawnPiece<Ink>{pieces[i], nullptr, 1});
    if (pieces[i].is_leaf) return drawn;
    Scratch& scratch = scratches.local();
    octree.load(pieces[i], scratch.block, scratch.voxels);
    drawn->sheet = std::make_unique<Sheet<Ink>>(lines_of(lines, octree.box_of_piece(pieces[i])));
    drawn->leaves =
        draw_block(*drawn->sheet, lines, ink, pieces[i].corner, scratch.block, octants);
    return drawn;
  };
  const auto put = [&](const std::shared_ptr<DrawnPiece<Ink>>& drawn) {
    const TonePiece& piece = drawn->piece;
    if (drawn->sheet) put_before(whole, *drawn->sheet, ink);
    else draw_cube(whole, lines, ink, piece.corner, piece.side,
                   static_cast<std::uint16_t>(piece.tone));
    counts.leaves += drawn->leaves;
    progress.advance(1);
  };
  const auto tokens = static_cast<std::size_t>(2 * tbb::this_task_arena::max_concurrency());
  using Drawn = std::shared_ptr<DrawnPiece<Ink>>;
  tbb::parallel_pipeline(
      tokens, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, take) &
                  tbb::make_filter<std::size_t, Drawn>(tbb::filter_mode::parallel, draw) &
                  tbb::make_filter<Drawn, void>(tbb::filter_mode::serial_in_order, put));
  counts.decoded_bricks = octree.decoded_bricks();
  return std::move(whole.cells);
}

ToneOctree octree_of(const FileReader& reader, const LineView& view, const ToneMap& tones) {
  constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
  return {reader, view.level, tones, view.kept.value_or(Box{{0, 0, 0}, {kFar, kFar, kFar}})};
}

void require_table(std::size_t entries, const ToneMap& tones) {
  if (entries == tones.count()) return;
  throw Error(ErrorKind::invalid_argument, "every tone needs its light");
}

template <std::size_t kChannels>
void sum_channels(const ToneOctree& octree, std::span<const std::int32_t> light,
                  Progress& progress, LineSums& result) {
  const auto cells =
      draw_volume(octree, result.lines, SumInk<kChannels>(light), progress, result.counts);
  result.sums.reserve(cells.size() * kChannels);
  for (const auto& cell : cells) result.sums.insert(result.sums.end(), cell.begin(), cell.end());
}

}  // namespace

LineSums sum_along_lines(const FileReader& reader, const LineView& view,
                         const ToneMap& tones, std::span<const std::int32_t> light, int channels,
                         Progress& progress) {
  if (channels != 1 && channels != 3) {
    throw Error(ErrorKind::invalid_argument, "light has 1 or 3 channels");
  }
  require_table(light.size() / static_cast<std::size_t>(channels), tones);
  const ToneOctree octree = octree_of(reader, view, tones);
  LineSums result;
  result.lines = voxel_lines(octree.size(), view.along);
  result.channels = channels;
  if (channels == 1) sum_channels<1>(octree, light, progress, result);
  else sum_channels<3>(octree, light, progress, result);
  return result;
}

LineAverages average_along_lines(const FileReader& reader, const LineView& view,
                                 const ToneMap& tones, std::span<const ToneVeil> veils,
                                 Progress& progress) {
  require_table(veils.size(), tones);
  const ToneOctree octree = octree_of(reader, view, tones);
  LineAverages result;
  result.lines = voxel_lines(octree.size(), view.along);
  result.colors = draw_volume(octree, result.lines, VeilInk(veils), progress, result.counts);
  return result;
}

}  // namespace octavo
