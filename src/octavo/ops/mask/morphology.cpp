#include "octavo/ops/mask/morphology.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/ops/mask/mask_kernels.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/mask/surface_voxels.h"
#include "octavo/ops/mask/word_rows.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr int kTaskRank = 1;
constexpr std::int64_t kSide = 64;  // of the cubes of that rank
constexpr std::size_t kWordsOfCube = 4096;

/// What the surface does to a cube.
enum class Coverage { none, some, all };

/// Which cubes are worked on: a search of the surface for each, down from the root.
class Search {
 public:
  Search(const MaskTree& surface, const Reach& reach)
      : surface_(surface),
        reach_(reach),
        volume_(box_of(surface.size())),
        can_cover_(reach.contains(corner_to_corner(surface.size()))) {}

  Coverage coverage_of(const Box& box) const {
    const int top = surface_.rank_count() - 1;
    if (!is_reached(box, top, surface_.root(), {0, 0, 0})) return Coverage::none;
    if (can_cover_ && is_covered(box, top, surface_.root(), {0, 0, 0})) return Coverage::all;
    return Coverage::some;
  }

 private:
  // Across a cube, or what the volume has of one.
  static Index3 corner_to_corner(const Size3& size) {
    Index3 step;
    for (int axis = 0; axis < 3; ++axis) step[axis] = std::min(size[axis], kSide) - 1;
    return step;
  }

  // The step between the nearest voxels of two boxes.
  static Index3 nearest_step(const Box& a, const Box& b) {
    Index3 step;
    for (int axis = 0; axis < 3; ++axis) {
      step[axis] =
          std::max({std::int64_t{0}, b.lo[axis] - a.hi[axis] + 1, a.lo[axis] - b.hi[axis] + 1});
    }
    return step;
  }

  static Index3 farthest_step(const Box& a, const Box& b) {
    Index3 step;
    for (int axis = 0; axis < 3; ++axis) {
      step[axis] = std::max(b.hi[axis] - 1 - a.lo[axis], a.hi[axis] - 1 - b.lo[axis]);
    }
    return step;
  }

  bool is_reached(const Box& box, int rank, const MaskCube& cube, const Index3& corner) const {
    for (std::uint64_t left = cube.full | cube.mixed; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const Box child = child_box(corner, bit, child_side(rank));
      if (!reach_.contains(nearest_step(box, child))) continue;
      // A word is near enough to be looked at.
      if (rank == 0 || (cube.full >> bit & 1) != 0) return true;
      if (is_reached(box, rank - 1, below(rank, cube, bit), child.lo)) return true;
    }
    return false;
  }

  // Whether some cube that holds a voxel is so near that wherever it is, it reaches all of the box.
  bool is_covered(const Box& box, int rank, const MaskCube& cube, const Index3& corner) const {
    for (std::uint64_t left = cube.full | cube.mixed; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const Box child = child_box(corner, bit, child_side(rank));
      if (reach_.contains(farthest_step(box, intersection(child, volume_)))) return true;
      if (rank == kTaskRank || !reach_.contains(nearest_step(box, child))) continue;
      if ((cube.mixed >> bit & 1) == 0) continue;
      if (is_covered(box, rank - 1, below(rank, cube, bit), child.lo)) return true;
    }
    return false;
  }

  const MaskCube& below(int rank, const MaskCube& cube, int bit) const {
    return surface_.cubes(rank - 1)[cube.place_of(bit)];
  }

  const MaskTree& surface_;
  const Reach& reach_;
  Box volume_;
  bool can_cover_;
};

/// A cube of 64^3 that is reached; `is_covered`: all of it.
struct Target {
  std::uint64_t code = 0;
  bool is_covered = false;
};

constexpr const char* kGrownMask = "the mask that grows";

// A target and its part, a cube at least.
constexpr std::uint64_t kTargetBytes = sizeof(Target) + sizeof(MaskPart) + sizeof(MaskPiece);

class Targets {
 public:
  Targets(const MaskTree& mask, const MaskTree& surface, const Reach& reach,
          std::uint64_t max_bytes)
      : mask_(mask), search_(surface, reach), max_bytes_(max_bytes) {}

  std::vector<Target> list(const Progress& watcher) {
    watcher_ = &watcher;
    visit(mask_.rank_count() - 1, 0, {0, 0, 0}, mask_.root(), false);
    return std::move(targets_);
  }

 private:
  // is_covered: a cube around this one is.
  void visit(int rank, std::uint64_t code, const Index3& corner, const MaskCube& cube,
             bool is_covered) {
    if (cube.is_full()) return;
    const std::int64_t side = 4 * child_side(rank);
    const Box box{corner, {corner.x + side, corner.y + side, corner.z + side}};
    const Box inside = intersection(box, box_of(mask_.size()));
    if (inside.is_empty()) return;
    if (!is_covered) {
      const Coverage coverage = search_.coverage_of(inside);
      if (coverage == Coverage::none) return;
      is_covered = coverage == Coverage::all;
    }
    if (rank == kTaskRank) {
      if (watcher_->is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      targets_.push_back({code, is_covered});
      require_memory_within(targets_.size() * kTargetBytes, max_bytes_, kGrownMask);
      return;
    }
    for (int bit = 0; bit < 64; ++bit) {
      const Index3 lo = child_box(corner, bit, child_side(rank)).lo;
      MaskCube child;
      if ((cube.mixed >> bit & 1) != 0) child = mask_.cubes(rank - 1)[cube.place_of(bit)];
      if ((cube.full >> bit & 1) != 0) child.full = kFullWord;
      visit(rank - 1, code << 6 | static_cast<std::uint64_t>(bit), lo, child, is_covered);
    }
  }

  const MaskTree& mask_;
  Search search_;
  std::uint64_t max_bytes_;
  const Progress* watcher_ = nullptr;
  std::vector<Target> targets_;
};

constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();

/// A row of the surface beside a cube: its voxels in the 64 columns of the cube, and how far the
/// nearest ones beyond are from the first and the last column.
struct SurfaceRow {
  std::uint64_t bits = 0;
  std::int32_t before = kNone;
  std::int32_t behind = kNone;

  bool is_empty() const { return bits == 0 && before == kNone && behind == kNone; }
};

// The bits within `steps` of set ones.
std::uint64_t widened(std::uint64_t bits, std::int64_t steps) {
  // What was widened by n can be moved by n + 1 without a gap.
  for (std::int64_t done = 0; steps > 0 && bits != 0 && bits != kFullWord;) {
    const std::int64_t step = std::min({steps, done + 1, kSide - 1});
    bits |= bits << step | bits >> step;
    done += step;
    steps -= step;
  }
  return bits;
}

// The columns that voxels before and behind the cube reach.
std::uint64_t reached_from_beside(const SurfaceRow& row, std::int64_t run) {
  const auto lowest = [](std::int64_t count) {
    return count >= kSide ? kFullWord : count <= 0 ? 0 : (std::uint64_t{1} << count) - 1;
  };
  return lowest(run - row.before + 1) | ~lowest(kSide - (run - row.behind + 1));
}

// The voxels of one cube of 64^3 that the surface reaches.
class GrownCube {
 public:
  GrownCube(const MaskTree& surface, const Reach& reach, const Target& target)
      : surface_(surface),
        reach_(reach),
        code_(target.code),
        corner_(corner_of({2 * (kTaskRank + 2), target.code})),
        rows_(kWordsOfCube) {
    const Box cube{corner_, {corner_.x + kSide, corner_.y + kSide, corner_.z + kSide}};
    inside_ = intersection(cube, box_of(surface.size()));
    const Size3 size = inside_.size();
    columns_ = size.x == kSide ? kFullWord : (std::uint64_t{1} << size.x) - 1;
    open_.assign(static_cast<std::size_t>(size.z), {inside_.lo.y, inside_.hi.y - 1});
    const Index3& by = reach.longest();
    window_ = intersection({{cube.lo.x - by.x, cube.lo.y - by.y, cube.lo.z - by.z},
                            {cube.hi.x + by.x, cube.hi.y + by.y, cube.hi.z + by.z}},
                           box_of(surface.size()));
  }

  MaskPart make() {
    // Layers of planes that share cubes of the tree, the cube's own first: it fills the most rows.
    take_layer(corner_.z);
    for (std::int64_t z = window_.lo.z / kSide * kSide; z < window_.hi.z; z += kSide) {
      if (z != corner_.z) take_layer(z);
    }
    return folded();
  }

  // All of the cube that lies in the volume.
  MaskPart make_covered() {
    if (inside_.size() == Size3{kSide, kSide, kSide}) {
      return {{{code_, {kFullWord, 0, 0}}}, arrays_below(kTaskRank)};
    }
    for (std::int64_t z = inside_.lo.z; z < inside_.hi.z; ++z) {
      for (std::int64_t y = inside_.lo.y; y < inside_.hi.y; ++y) {
        rows_[static_cast<std::size_t>(kSide * (z - corner_.z) + y - corner_.y)] = columns_;
      }
    }
    return folded();
  }

 private:
  // The rows of a plane of the cube that are not full yet, first to last.
  struct OpenRows {
    std::int64_t first = 0;
    std::int64_t last = 0;
  };

  void take_layer(std::int64_t first_plane) {
    Box layer = window_;
    layer.lo.z = std::max(layer.lo.z, first_plane);
    layer.hi.z = std::min(layer.hi.z, first_plane + kSide);
    const Size3 size = layer.size();
    source_.assign(static_cast<std::size_t>(size.z * size.y), SurfaceRow());
    visit_items(surface_, layer, [&](int rank, std::uint64_t place, const Index3& corner) {
      if (rank < 0) take_word(surface_.words()[place], corner, layer);
    });
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        const SurfaceRow& row = source_[static_cast<std::size_t>(z * size.y + y)];
        if (!row.is_empty()) grow(row, layer.lo.y + y, layer.lo.z + z);
      }
      close_full_rows();
    }
  }

  void close_full_rows() {
    for (std::size_t plane = 0; plane < open_.size(); ++plane) {
      const std::uint64_t* const rows = rows_.data() + plane * static_cast<std::size_t>(kSide);
      const auto is_full = [&](std::int64_t y) {
        return (rows[y - corner_.y] & columns_) == columns_;
      };
      OpenRows& open = open_[plane];
      while (open.first <= open.last && is_full(open.first)) ++open.first;
      while (open.first <= open.last && is_full(open.last)) --open.last;
    }
  }

  void take_word(std::uint64_t word, const Index3& corner, const Box& layer) {
    const std::int64_t column = corner.x - corner_.x;
    for (int z = 0; z < 4; ++z) {
      for (int y = 0; y < 4; ++y) {
        const std::uint64_t four = row_of_word(word, y, z);
        const std::int64_t at_y = corner.y + y - layer.lo.y;
        const std::int64_t at_z = corner.z + z - layer.lo.z;
        const Size3 size = layer.size();
        if (four == 0 || at_y < 0 || at_y >= size.y || at_z < 0 || at_z >= size.z) continue;
        SurfaceRow& row = source_[static_cast<std::size_t>(at_z * size.y + at_y)];
        if (column < 0) {
          const std::int64_t last = column + (63 - std::countl_zero(four));
          row.before = std::min(row.before, static_cast<std::int32_t>(-last));
        } else if (column >= kSide) {
          const std::int64_t first = column + std::countr_zero(four);
          row.behind = std::min(row.behind, static_cast<std::int32_t>(first - kSide + 1));
        } else {
          row.bits |= four << column;
        }
      }
    }
  }

  // Adds what a row of the surface at (y, z) of the volume reaches, plane by plane.
  void grow(const SurfaceRow& row, std::int64_t y, std::int64_t z) {
    const std::int64_t lo = std::max(inside_.lo.z, z - reach_.longest().z);
    const std::int64_t hi = std::min(inside_.hi.z, z + reach_.longest().z + 1);
    for (std::int64_t plane = lo; plane < hi; ++plane) grow_in_plane(row, y, plane, z);
  }

  // The farthest rows first, where the ball is thinnest: so the row is only ever widened.
  void grow_in_plane(const SurfaceRow& row, std::int64_t y, std::int64_t plane, std::int64_t z) {
    const std::int64_t dz = std::abs(plane - z);
    const auto [first, last] = open_[static_cast<std::size_t>(plane - corner_.z)];
    const std::int64_t base = kSide * (plane - corner_.z) - corner_.y;
    const std::int64_t nearest = std::max({std::int64_t{0}, first - y, y - last});
    std::int64_t dy = std::min(std::max(last - y, y - first), reach_.longest().y);
    while (dy >= nearest && reach_.along_x(dy, dz) < 0) --dy;
    std::uint64_t bits = row.bits;
    std::int64_t run = 0;
    for (; dy >= nearest; --dy) {
      const std::int64_t next = reach_.along_x(dy, dz);
      bits = widened(bits, next - run);
      run = next;
      const std::uint64_t reached = bits | reached_from_beside(row, run);
      for (const std::int64_t to : {y - dy, y + dy}) {
        if (to >= first && to <= last) rows_[static_cast<std::size_t>(base + to)] |= reached;
      }
    }
  }

  MaskPart folded() const {
    constexpr std::size_t kCells = 16;  // words along an axis
    std::vector<std::uint64_t> words(kWordsOfCube);
    std::array<std::uint64_t, 16 * kCells> rows;
    std::array<std::uint64_t, 16 * kCells> layer;
    for (std::size_t z = 0; z < kCells; ++z) {
      for (std::size_t row = 0; row < 16; ++row) {
        const std::size_t first = static_cast<std::size_t>(kSide) * (4 * z + row / 4) + row % 4;
        for (std::size_t y = 0; y < kCells; ++y) {
          rows[kCells * row + y] = rows_[first + 4 * y] & columns_;
        }
      }
      words_of_rows(rows.data(), kCells, kCells, layer.data());
      for (std::size_t y = 0; y < kCells; ++y) {
        for (std::size_t x = 0; x < kCells; ++x) {
          const auto code = interleave({static_cast<std::int64_t>(x), static_cast<std::int64_t>(y),
                                        static_cast<std::int64_t>(z)});
          words[code] = layer[kCells * x + y];
        }
      }
    }
    return fold_cube(words.data(), code_);
  }

  const MaskTree& surface_;
  const Reach& reach_;
  std::uint64_t code_;
  Index3 corner_;
  Box inside_;                       // the cube, as far as it lies in the volume
  Box window_;                       // where its sources may be
  std::uint64_t columns_;            // those of them that lie in the volume
  std::vector<OpenRows> open_;       // by plane
  std::vector<std::uint64_t> rows_;  // [z][y] of the cube
  std::vector<SurfaceRow> source_;   // [z][y] of a layer of the window
};

// Keeps what threads make below a limit.
class MemoryWatch {
 public:
  explicit MemoryWatch(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  void take(const MaskPart& part) {
    const std::uint64_t bytes = memory_bytes(part);
    // The parts are copied when they are put together.
    require_memory_within(2 * (bytes_.fetch_add(bytes) + bytes), max_bytes_, kGrownMask);
  }

 private:
  std::uint64_t max_bytes_;
  std::atomic<std::uint64_t> bytes_ = 0;
};

}  // namespace

MaskTree dilate(const MaskTree& mask, const Reach& reach, Progress& progress,
                std::uint64_t max_bytes) {
  const MaskTree surface = surface_voxels(mask, progress);
  const std::vector<Target> targets = Targets(mask, surface, reach, max_bytes).list(progress);
  std::vector<MaskPart> parts(targets.size());
  MemoryWatch watch(max_bytes);
  const ProgressScope scope(progress, "grow", static_cast<std::int64_t>(targets.size()), "cubes");
  parallel_for(std::size_t{0}, targets.size(), [&](std::size_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    GrownCube cube(surface, reach, targets[i]);
    parts[i] = targets[i].is_covered ? cube.make_covered() : cube.make();
    watch.take(parts[i]);
    progress.advance(1);
  });
  return combine(mask, assemble(mask.size(), kTaskRank, parts), SetOperation::unite);
}

MaskTree erode(const MaskTree& mask, const Reach& reach, Progress& progress,
               std::uint64_t max_bytes) {
  return complement(dilate(complement(mask), reach, progress, max_bytes));
}

MaskTree opening(const MaskTree& mask, const Reach& reach, Progress& progress,
                 std::uint64_t max_bytes) {
  return dilate(erode(mask, reach, progress, max_bytes), reach, progress, max_bytes);
}

MaskTree closing(const MaskTree& mask, const Reach& reach, Progress& progress,
                 std::uint64_t max_bytes) {
  return erode(dilate(mask, reach, progress, max_bytes), reach, progress, max_bytes);
}

std::uint64_t dilation_thread_bytes(const Reach& reach, const Size3& size) noexcept {
  const std::int64_t rows =
      std::min(size.z, kSide) * std::min(size.y, kSide + 2 * reach.longest().y);
  return static_cast<std::uint64_t>(rows) * sizeof(SurfaceRow) +
         2 * kWordsOfCube * sizeof(std::uint64_t);
}

}  // namespace octavo
