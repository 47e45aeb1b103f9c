#include "octavo/render/transparency/line_integrals.h"

#include <limits>
#include <memory>

#include "octavo/core/error.h"
#include "octavo/render/transparency/class_octree.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/ordered_pipeline.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

// The straight sum: cells are added to.
template <std::size_t kChannels>
class EmissionSum {
 public:
  using Cell = std::array<std::int64_t, kChannels>;
  static constexpr Cell kClear{};

  explicit EmissionSum(std::span<const std::int32_t> emission)
      : emission_(emission.size() / kChannels) {
    for (std::size_t i = 0; i < emission.size(); ++i) {
      emission_[i / kChannels][i % kChannels] = emission[i];
    }
  }

  bool is_clear(std::uint16_t class_id) const { return emission_[class_id] == Emission{}; }

  void draw_voxel(Cell& cell, std::uint16_t class_id) const {
    const Emission& emission = emission_[class_id];
    for (std::size_t c = 0; c < kChannels; ++c) cell[c] += emission[c];
  }

  // Gives what puts a run of so many voxels of a class on a cell.
  auto run_of(std::uint16_t class_id, std::int64_t) const {
    return [emission = emission_[class_id]](Cell& cell, std::int64_t count) {
      for (std::size_t c = 0; c < kChannels; ++c) cell[c] += emission[c] * count;
    };
  }

  void composite_over(Cell& cell, const Cell& nearer) const {
    for (std::size_t c = 0; c < kChannels; ++c) cell[c] += nearer[c];
  }

 private:
  using Emission = std::array<std::int32_t, kChannels>;
  std::vector<Emission> emission_;
};

// The exponential average: a cell is cell * transmittance + emission, its last channel the
// transmittance of all that was drawn, which the background shines through.
class Compositing {
 public:
  using Cell = LineColor;
  static constexpr Cell kClear{0, 0, 0, 1};

  explicit Compositing(std::span<const ClassTransfer> transfer) {
    for (const ClassTransfer& one : transfer) {
      Layer& layer = layers_.emplace_back();
      for (std::size_t c = 0; c < 3; ++c) layer.emission[c] = one.color[c] * one.opacity;
      layer.transmittance = 1 - one.opacity;
    }
  }

  bool is_clear(std::uint16_t class_id) const { return layers_[class_id].transmittance == 1; }

  void draw_voxel(Cell& cell, std::uint16_t class_id) const {
    const Layer& layer = layers_[class_id];
    for (std::size_t c = 0; c < 4; ++c) {
      cell[c] = cell[c] * layer.transmittance + layer.emission[c];
    }
  }

  // After n voxels of transmittance t: t^n of what was behind, and the emission times
  // 1 + t + ... + t^(n-1).
  auto run_of(std::uint16_t class_id, std::int64_t longest) const {
    const Layer& layer = layers_[class_id];
    std::vector<std::array<float, 2>> runs(static_cast<std::size_t>(longest) + 1);
    double transmittance = 1;
    double sum = 0;
    for (auto& run : runs) {
      run = {static_cast<float>(transmittance), static_cast<float>(sum)};
      sum += transmittance;
      transmittance *= static_cast<double>(layer.transmittance);
    }
    return [layer, runs = std::move(runs)](Cell& cell, std::int64_t count) {
      const auto [all, times] = runs[static_cast<std::size_t>(count)];
      for (std::size_t c = 0; c < 4; ++c) cell[c] = cell[c] * all + layer.emission[c] * times;
    };
  }

  void composite_over(Cell& cell, const Cell& nearer) const {
    const float transmittance = nearer[3];
    for (std::size_t c = 0; c < 3; ++c) cell[c] = cell[c] * transmittance + nearer[c];
    cell[3] *= transmittance;
  }

 private:
  struct Layer {
    std::array<float, 4> emission{};
    float transmittance = 1;
  };
  std::vector<Layer> layers_;
};

// The lines of one block, or of the whole volume.
template <class Model>
struct LineBuffer {
  LineRange range;
  std::vector<typename Model::Cell> cells;

  explicit LineBuffer(const LineRange& lines)
      : range(lines),
        cells(static_cast<std::size_t>((lines.u_hi - lines.u_lo) * (lines.v_hi - lines.v_lo)),
              Model::kClear) {}

  std::int64_t row() const { return range.u_hi - range.u_lo; }
  auto* at(std::int64_t u, std::int64_t v) {
    return cells.data() + (v - range.v_lo) * row() + (u - range.u_lo);
  }
};

template <class Model>
void draw_cube(LineBuffer<Model>& buffer, const VoxelLines& lines, const Model& model,
               const Index3& corner, std::int64_t side, std::uint16_t class_id) {
  if (model.is_clear(class_id)) return;
  const LineRange covered =
      lines_of(lines, {corner, {corner.x + side, corner.y + side, corner.z + side}});
  auto* const first = buffer.at(covered.u_lo, covered.v_lo);
  const auto put = model.run_of(class_id, side);
  const std::int64_t row = buffer.row();
  for_each_line(lines.axes, side, [&](std::int64_t u, std::int64_t v, std::int64_t count) {
    put(first[v * row + u], count);
  });
}

// Draws the leaves of a block; returns how many there are.
template <class Model>
std::int64_t draw_block(LineBuffer<Model>& buffer, const VoxelLines& lines, const Model& model,
                        const Index3& corner, const ClassBlock& block,
                        const std::array<int, 8>& octants) {
  // A voxel's cell is linear in its place.
  const std::int64_t row = buffer.row();
  auto* const first = buffer.at(lines.u_of(corner), lines.v_of(corner));
  std::array<std::int64_t, 3> step{};
  for (std::size_t a = 0; a < 3; ++a) step[a] = lines.u_step[a] + lines.v_step[a] * row;
  std::int64_t leaves = 0;
  block.visit_leaves(
      octants,
      [&](const Index3& v, std::uint16_t class_id) {
        ++leaves;
        model.draw_voxel(first[v.x * step[0] + v.y * step[1] + v.z * step[2]], class_id);
      },
      [&](const Index3& v, std::int64_t side, std::uint16_t class_id) {
        ++leaves;
        draw_cube(buffer, lines, model, {corner.x + v.x, corner.y + v.y, corner.z + v.z}, side,
                  class_id);
      });
  return leaves;
}

template <class Model>
void composite_over(LineBuffer<Model>& buffer, LineBuffer<Model>& nearer, const Model& model) {
  for (std::int64_t v = nearer.range.v_lo; v < nearer.range.v_hi; ++v) {
    auto* const to = buffer.at(nearer.range.u_lo, v);
    const auto* const from = nearer.at(nearer.range.u_lo, v);
    for (std::int64_t i = 0; i < nearer.row(); ++i) model.composite_over(to[i], from[i]);
  }
}

// A piece on its way: blocks are drawn into buffers of their own, by any thread.
template <class Model>
struct DrawnPiece {
  ClassPiece piece;
  std::unique_ptr<LineBuffer<Model>> buffer;
  std::int64_t leaves = 1;
};

struct Scratch {
  ClassBlock block;
  std::vector<std::byte> voxels;
};

template <class Model>
std::vector<typename Model::Cell> draw_volume(const ClassOctree& octree, const VoxelLines& lines,
                                              const Model& model, Progress& progress,
                                              LineCounts& counts) {
  const std::array<int, 8> octants = back_to_front(lines.along);
  const std::vector<ClassPiece> pieces = octree.pieces(octants);
  const ProgressScope scope(progress, "picture", static_cast<std::int64_t>(pieces.size()),
                            "blocks");
  LineBuffer<Model> whole({0, 0, lines.width, lines.height});
  PerThread<Scratch> scratches;
  const auto draw = [&](std::size_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    DrawnPiece<Model> drawn{pieces[i], nullptr, 1};
    if (pieces[i].is_leaf) return drawn;
    Scratch& scratch = scratches.local();
    octree.load(pieces[i], scratch.block, scratch.voxels);
    drawn.buffer =
        std::make_unique<LineBuffer<Model>>(lines_of(lines, octree.box_of_piece(pieces[i])));
    drawn.leaves =
        draw_block(*drawn.buffer, lines, model, pieces[i].corner, scratch.block, octants);
    return drawn;
  };
  const auto put = [&](const DrawnPiece<Model>& drawn) {
    const ClassPiece& piece = drawn.piece;
    if (drawn.buffer) composite_over(whole, *drawn.buffer, model);
    else
      draw_cube(whole, lines, model, piece.corner, piece.side,
                static_cast<std::uint16_t>(piece.class_id));
    counts.leaves += drawn.leaves;
    progress.advance(1);
  };
  const auto at_a_time = static_cast<std::size_t>(2 * arena_threads());
  ordered_pipeline(pieces.size(), at_a_time, draw, put);
  counts.decoded_bricks = octree.decoded_bricks();
  return std::move(whole.cells);
}

ClassOctree octree_of(const FileReader& reader, const LineView& view,
                      const DensityClasses& classes) {
  constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
  return {reader, view.level, classes, view.kept.value_or(Box{{0, 0, 0}, {kFar, kFar, kFar}})};
}

void require_table(std::size_t entries, const DensityClasses& classes) {
  if (entries == classes.count()) return;
  throw Error(ErrorKind::invalid_argument, "every density class needs its emission or transfer");
}

template <std::size_t kChannels>
void sum_channels(const ClassOctree& octree, std::span<const std::int32_t> emission,
                  Progress& progress, LineSums& result) {
  const auto cells =
      draw_volume(octree, result.lines, EmissionSum<kChannels>(emission), progress, result.counts);
  result.sums.reserve(cells.size() * kChannels);
  for (const auto& cell : cells) result.sums.insert(result.sums.end(), cell.begin(), cell.end());
}

}  // namespace

LineSums sum_along_lines(const FileReader& reader, const LineView& view,
                         const DensityClasses& classes, std::span<const std::int32_t> emission,
                         int channels, Progress& progress) {
  if (channels != 1 && channels != 3) {
    throw Error(ErrorKind::invalid_argument, "emission has 1 or 3 channels");
  }
  require_table(emission.size() / static_cast<std::size_t>(channels), classes);
  const ClassOctree octree = octree_of(reader, view, classes);
  LineSums result;
  result.lines = voxel_lines(octree.size(), view.along);
  result.channels = channels;
  if (channels == 1) sum_channels<1>(octree, emission, progress, result);
  else sum_channels<3>(octree, emission, progress, result);
  return result;
}

LineAverages average_along_lines(const FileReader& reader, const LineView& view,
                                 const DensityClasses& classes,
                                 std::span<const ClassTransfer> transfer, Progress& progress) {
  require_table(transfer.size(), classes);
  const ClassOctree octree = octree_of(reader, view, classes);
  LineAverages result;
  result.lines = voxel_lines(octree.size(), view.along);
  result.colors = draw_volume(octree, result.lines, Compositing(transfer), progress, result.counts);
  return result;
}

}  // namespace octavo
