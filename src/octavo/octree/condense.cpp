#include "octavo/octree/condense.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo {

namespace {

// Sums of differences over the universe stay below 2^62.
void check_flat(std::int64_t flat, int n) {
  const std::int64_t limit = (std::int64_t{1} << 62) >> 3 * n;
  if (flat == 0 || (flat > 0 && flat < limit)) return;
  throw Error(ErrorKind::invalid_argument,
              "flat " + std::to_string(flat) + "; for this volume it must be between 0 and " +
                  std::to_string(std::max<std::int64_t>(0, limit - 1)));
}

template <class T>
void widen(std::span<const std::byte> plane, std::vector<std::int64_t>& out) {
  const T* const voxels = reinterpret_cast<const T*>(plane.data());
  std::copy(voxels, voxels + out.size(), out.begin());
}

// The corner `octant` of a pair of planes, for octant x, y: digit 4z + 2x + y.
Index3 corner(std::int64_t x, std::int64_t y, int octant) {
  return {2 * x + (octant >> 1 & 1), 2 * y + (octant & 1), octant >> 2};
}

std::int64_t mean_of(std::int64_t min, std::uint64_t excess, int level) {
  const std::uint64_t count = cube_volume(level);
  return min + static_cast<std::int64_t>((excess + count / 2) / count);
}

}  // namespace

PlaneCondenser::PlaneCondenser(const Size3& size, const CondenseOptions& options)
    : size_(size), options_(options), octree_(empty_octree(universe_level(size))) {
  check_flat(options.flat, octree_.root_level);
  voxels_.resize(static_cast<std::size_t>(size.x * size.y));
  waiting_.resize(static_cast<std::size_t>(octree_.root_level) + 1);
}

void PlaneCondenser::add_plane(VoxelType type, std::span<const std::byte> plane) {
  const auto expected = static_cast<std::size_t>(size_.x * size_.y * bytes_per_voxel(type));
  if (plane.size() != expected) {
    throw Error(ErrorKind::invalid_argument, "plane of " + std::to_string(plane.size()) +
                                                 " bytes; expected " + std::to_string(expected));
  }
  if (plane_count_ == size_.z) {
    throw Error(ErrorKind::invalid_argument,
                "more planes than the " + std::to_string(size_.z) + " of the volume");
  }
  with_voxel_type(type, [&](auto id) {
    using T = typename decltype(id)::type;
    if constexpr (std::is_same_v<T, float>) {
      throw Error(ErrorKind::invalid_argument, "condensing float32 voxels is not supported");
    } else {
      widen<T>(plane, voxels_);
    }
  });
  ++plane_count_;
  if (plane_count_ % 2 == 1 && plane_count_ < size_.z) {
    voxels_below_ = voxels_;
  } else if (plane_count_ % 2 == 1) {
    pair_voxels(voxels_, {});
  } else {
    pair_voxels(voxels_below_, voxels_);
  }
}

std::uint64_t PlaneCondenser::memory_bytes() const noexcept {
  std::uint64_t bytes = (voxels_.capacity() + voxels_below_.capacity()) * sizeof(std::int64_t);
  for (const Waiting& level : waiting_) bytes += level.plane.cells.capacity() * sizeof(Cell);
  for (const LinearOctree::Level& level : octree_.levels) {
    bytes += level.codes.capacity() * sizeof(std::uint64_t) +
             level.values.capacity() * sizeof(std::int64_t);
  }
  return bytes;
}

LinearOctree PlaneCondenser::finish() {
  if (plane_count_ != size_.z) {
    throw Error(
        ErrorKind::invalid_argument,
        std::to_string(plane_count_) + " planes given; the volume has " + std::to_string(size_.z));
  }
  // A plane that still waits has no partner inside the volume; what it holds is final.
  for (int k = 1; k < octree_.root_level; ++k) {
    Waiting& level = waiting_[static_cast<std::size_t>(k)];
    if (!level.is_held) continue;
    level.is_held = false;
    pair_cells(k, level.plane, nullptr);
  }
  sort_leaves();
  return std::move(octree_);
}

PlaneCondenser::Cell PlaneCondenser::voxel_cell(std::int64_t value) const {
  const bool is_background = options_.background && value == *options_.background;
  return {value, value, 0, is_background ? State::background : State::cube};
}

// The cell a level up: a cube of level + 1 when all eight siblings of `level` are homogeneous.
PlaneCondenser::Cell PlaneCondenser::condensed(const Cell* const (&siblings)[8], int level) const {
  Cell cell = *siblings[0];
  for (const Cell* sibling : siblings) {
    if (sibling->state != cell.state || sibling->state == State::mixed) return {};
    cell.min = std::min(cell.min, sibling->min);
    cell.max = std::max(cell.max, sibling->max);
  }
  if (cell.state == State::cube && cell.max - cell.min > options_.flat) return {};
  cell.excess = 0;
  for (const Cell* sibling : siblings) {
    cell.excess +=
        sibling->excess + static_cast<std::uint64_t>(sibling->min - cell.min) * cube_volume(level);
  }
  return cell;
}

// Condenses two planes of voxels; without an upper one, the lower one lies at the border.
void PlaneCondenser::pair_voxels(std::span<const std::int64_t> lower,
                                 std::span<const std::int64_t> upper) {
  const std::int64_t z = (plane_count_ - 1) / 2 * 2;
  Plane out{(size_.x + 1) / 2, (size_.y + 1) / 2, {}};
  out.cells.resize(static_cast<std::size_t>(out.width * out.height));
  Cell cells[8];
  const Cell* siblings[8];
  for (std::int64_t y = 0; y < out.height; ++y) {
    for (std::int64_t x = 0; x < out.width; ++x) {
      for (int octant = 0; octant < 8; ++octant) {
        const Index3 p = corner(x, y, octant);
        const auto plane = p.z == 0 ? lower : upper;
        const bool is_inside = p.x < size_.x && p.y < size_.y && !plane.empty();
        cells[octant] =
            is_inside ? voxel_cell(plane[static_cast<std::size_t>(p.y * size_.x + p.x)]) : Cell{};
        siblings[octant] = &cells[octant];
      }
      Cell& up = out.cells[static_cast<std::size_t>(y * out.width + x)];
      if (octree_.root_level > 0) up = condensed(siblings, 0);
      if (up.state != State::mixed) continue;
      for (int octant = 0; octant < 8; ++octant) {
        const Index3 p = corner(x, y, octant);
        emit(0, {p.x, p.y, z + p.z}, cells[octant]);
      }
    }
  }
  if (octree_.root_level > 0) take_plane(1, std::move(out));
}

void PlaneCondenser::take_plane(int level, Plane plane) {
  Waiting& waiting = waiting_[static_cast<std::size_t>(level)];
  ++waiting.seen;
  if (level == octree_.root_level) {
    emit(level, {0, 0, 0}, plane.cells.front());
  } else if (waiting.is_held) {
    waiting.is_held = false;
    pair_cells(level, waiting.plane, &plane);
  } else {
    waiting.is_held = true;
    waiting.plane = std::move(plane);
  }
}

void PlaneCondenser::pair_cells(int level, const Plane& lower, const Plane* upper) {
  static const Cell kOutside;
  const std::int64_t z = (waiting_[static_cast<std::size_t>(level)].seen - 1) / 2 * 2;
  Plane out{(lower.width + 1) / 2, (lower.height + 1) / 2, {}};
  out.cells.resize(static_cast<std::size_t>(out.width * out.height));
  const Cell* siblings[8];
  for (std::int64_t y = 0; y < out.height; ++y) {
    for (std::int64_t x = 0; x < out.width; ++x) {
      for (int octant = 0; octant < 8; ++octant) {
        const Index3 p = corner(x, y, octant);
        const Plane* const plane = p.z == 0 ? &lower : upper;
        const bool is_inside = p.x < lower.width && p.y < lower.height && plane != nullptr;
        siblings[octant] = is_inside
                               ? &plane->cells[static_cast<std::size_t>(p.y * lower.width + p.x)]
                               : &kOutside;
      }
      Cell& up = out.cells[static_cast<std::size_t>(y * out.width + x)];
      up = condensed(siblings, level);
      if (up.state != State::mixed) continue;
      for (int octant = 0; octant < 8; ++octant) {
        const Index3 p = corner(x, y, octant);
        emit(level, {p.x, p.y, z + p.z}, *siblings[octant]);
      }
    }
  }
  take_plane(level + 1, std::move(out));
}

// A cube whose parent is not condensed is final; anything else has no leaf at this level.
void PlaneCondenser::emit(int level, const Index3& cell, const Cell& leaf) {
  if (leaf.state != State::cube) return;
  LinearOctree::Level& list = octree_.levels[static_cast<std::size_t>(level)];
  list.codes.push_back(interleave(cell));
  list.values.push_back(mean_of(leaf.min, leaf.excess, level));
}

void PlaneCondenser::sort_leaves() {
  std::vector<std::pair<std::uint64_t, std::int64_t>> leaves;
  for (LinearOctree::Level& level : octree_.levels) {
    leaves.clear();
    leaves.reserve(level.codes.size());
    for (std::size_t i = 0; i < level.codes.size(); ++i) {
      leaves.emplace_back(level.codes[i], level.values[i]);
    }
    std::sort(leaves.begin(), leaves.end());
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      level.codes[i] = leaves[i].first;
      level.values[i] = leaves[i].second;
    }
  }
}

template <class T>
LinearOctree condense(std::span<const T> voxels, const Size3& size,
                      const CondenseOptions& options) {
  PlaneCondenser condenser(size, options);
  const auto plane = static_cast<std::size_t>(size.x * size.y);
  if (voxels.size() != static_cast<std::size_t>(size.voxel_count())) {
    throw Error(ErrorKind::invalid_argument, std::to_string(voxels.size()) +
                                                 " voxels; the size asks for " +
                                                 std::to_string(size.voxel_count()));
  }
  for (std::size_t offset = 0; offset < voxels.size(); offset += plane) {
    condenser.add_plane(voxel_type_of<T>(), std::as_bytes(voxels.subspan(offset, plane)));
  }
  return condenser.finish();
}

template LinearOctree condense(std::span<const std::int8_t>, const Size3&, const CondenseOptions&);
template LinearOctree condense(std::span<const std::uint8_t>, const Size3&, const CondenseOptions&);
template LinearOctree condense(std::span<const std::int16_t>, const Size3&, const CondenseOptions&);
template LinearOctree condense(std::span<const std::uint16_t>, const Size3&,
                               const CondenseOptions&);
template LinearOctree condense(std::span<const std::int32_t>, const Size3&, const CondenseOptions&);
template LinearOctree condense(std::span<const std::uint32_t>, const Size3&,
                               const CondenseOptions&);

std::vector<std::int64_t> expand(const LinearOctree& octree, const Size3& size,
                                 std::int64_t background) {
  std::vector<std::int64_t> voxels(static_cast<std::size_t>(checked_voxel_count(size)), background);
  for (const Leaf& leaf : leaves_in_post_order(octree)) {
    const Box box = box_of(leaf.cube);
    if (!box_of(size).contains(box)) {
      throw Error(
          ErrorKind::invalid_argument,
          "leaf " + to_mixed_octal(leaf.cube, octree.root_level) + " reaches outside the volume");
    }
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const auto row = voxels.begin() + (z * size.y + y) * size.x;
        std::fill(row + box.lo.x, row + box.hi.x, leaf.value);
      }
    }
  }
  return voxels;
}

}  // namespace octavo
