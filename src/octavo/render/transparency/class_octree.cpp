#include "octavo/render/transparency/class_octree.h"

#include <algorithm>
#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::int64_t kSide = ClassBlock::kSide;
constexpr std::int32_t kMixed = -1;
constexpr std::int32_t kNothing = 0;

std::int64_t cubes_along(std::int64_t voxels, std::int64_t side) {
  return (voxels + side - 1) / side;
}

Box cube_box(const Index3& corner, std::int64_t side) {
  return {corner, {corner.x + side, corner.y + side, corner.z + side}};
}

// The voxels of `part` that are not in `kept` get the class of nothing.
void clear_outside(const Box& kept, const Box& part, const Index3& corner, ClassBlock& block) {
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
      for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
        if (kept.contains(Index3{x, y, z})) continue;
        block.at(x - corner.x, y - corner.y, z - corner.z) = kNothing;
      }
    }
  }
}

}  // namespace

ClassOctree::ClassOctree(const FileReader& reader, int level, const DensityClasses& classes,
                         const Box& kept)
    : reader_(reader), classes_(classes), level_(level), kept_(kept) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  size_ = reader.levels().size(level);
  brick_side_ = brick_side_at(reader.levels(), level);
  Floor blocks;
  for (int axis = 0; axis < 3; ++axis) blocks.grid[axis] = cubes_along(size_[axis], kSide);
  blocks.classes.reserve(static_cast<std::size_t>(blocks.grid.voxel_count()));
  for (std::int64_t z = 0; z < blocks.grid.z; ++z) {
    for (std::int64_t y = 0; y < blocks.grid.y; ++y) {
      for (std::int64_t x = 0; x < blocks.grid.x; ++x) {
        blocks.classes.push_back(block_class({x, y, z}));
      }
    }
  }
  floors_.push_back(std::move(blocks));
  while (floors_.back().grid.voxel_count() > 1) floors_.push_back(floor_above(floors_.back()));
}

template <class Visit>
void ClassOctree::visit_bricks(const Box& box, Visit&& visit) const {
  const int tier = Levels::tier_of(level_);
  const Size3& side = brick_side_;
  visit_cells(box, side, [&](const Index3& brick) {
    const Index3 lo{brick.x * side.x, brick.y * side.y, brick.z * side.z};
    const Box covered = intersection(box, {lo, {lo.x + side.x, lo.y + side.y, lo.z + side.z}});
    const BrickEntry entry = reader_.brick(tier, brick);
    return visit(entry, covered, brick_class(entry, covered));
  });
}

std::int32_t ClassOctree::brick_class(const BrickEntry& entry, const Box& covered) const {
  if (intersection(covered, kept_).is_empty()) return kNothing;
  const VolumeDescription& d = reader_.description();
  const auto [minimum, maximum] =
      std::minmax({d.voxel_of(entry.range.min), d.voxel_of(entry.range.max)});
  const auto class_id = classes_.common_class(minimum, maximum);
  if (!class_id) return kMixed;
  // The range is that of the finite voxels.
  if (d.codec_type() == VoxelType::float32 && !entry.is_uniform()) return kMixed;
  return *class_id == kNothing || kept_.contains(covered) ? std::int32_t{*class_id} : kMixed;
}

std::int32_t ClassOctree::block_class(const Index3& block) const {
  const Box box = intersection(
      box_of(size_), cube_box({block.x * kSide, block.y * kSide, block.z * kSide}, kSide));
  bool is_first = true;
  std::int32_t common = kMixed;
  visit_bricks(box, [&](const BrickEntry&, const Box&, std::int32_t class_id) {
    common = is_first || class_id == common ? class_id : kMixed;
    is_first = false;
    return common != kMixed;
  });
  return common;
}

bool ClassOctree::is_whole(const Index3& cell, std::int64_t side) const {
  return box_of(size_).contains(cube_box({cell.x * side, cell.y * side, cell.z * side}, side));
}

ClassOctree::Floor ClassOctree::floor_above(const Floor& below) const {
  Floor floor;
  for (int axis = 0; axis < 3; ++axis) floor.grid[axis] = cubes_along(below.grid[axis], 2);
  floor.classes.reserve(static_cast<std::size_t>(floor.grid.voxel_count()));
  for (std::int64_t z = 0; z < floor.grid.z; ++z) {
    for (std::int64_t y = 0; y < floor.grid.y; ++y) {
      for (std::int64_t x = 0; x < floor.grid.x; ++x) {
        std::int32_t common = below.classes[below.place({2 * x, 2 * y, 2 * z})];
        for (std::int64_t i = 1; i < 8; ++i) {
          const Index3 child{2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2)};
          const bool is_inside = box_of(below.grid).contains(child);
          if (!is_inside || below.classes[below.place(child)] != common) common = kMixed;
        }
        floor.classes.push_back(common);
      }
    }
  }
  return floor;
}

void ClassOctree::collect(std::size_t floor, const Index3& cell, const std::array<int, 8>& octants,
                          std::vector<ClassPiece>& pieces) const {
  const std::int64_t side = kSide << floor;
  const std::int32_t class_id = floors_[floor].classes[floors_[floor].place(cell)];
  const bool is_leaf = class_id != kMixed && is_whole(cell, side);
  if (is_leaf || floor == 0) {
    pieces.push_back({{cell.x * side, cell.y * side, cell.z * side}, side, class_id, is_leaf});
    return;
  }
  for (const int octant : octants) {
    const Index3 child{2 * cell.x + (octant >> 1 & 1), 2 * cell.y + (octant & 1),
                       2 * cell.z + (octant >> 2 & 1)};
    if (box_of(floors_[floor - 1].grid).contains(child)) {
      collect(floor - 1, child, octants, pieces);
    }
  }
}

std::vector<ClassPiece> ClassOctree::pieces(const std::array<int, 8>& octants) const {
  std::vector<ClassPiece> pieces;
  collect(floors_.size() - 1, {0, 0, 0}, octants, pieces);
  return pieces;
}

Box ClassOctree::box_of_piece(const ClassPiece& piece) const {
  return intersection(box_of(size_), cube_box(piece.corner, piece.side));
}

void ClassOctree::load(const ClassPiece& piece, ClassBlock& block,
                       std::vector<std::byte>& voxels) const {
  const Box box = box_of_piece(piece);
  block.reset(box.size());
  const std::int64_t width = bytes_per_voxel(reader_.description().type);
  const int in_brick_level = level_ - Levels::first_level(Levels::tier_of(level_));
  visit_bricks(box, [&](const BrickEntry& entry, const Box& part, std::int32_t class_id) {
    const Size3 size = part.size();
    if (class_id == kMixed) {
      voxels.resize(static_cast<std::size_t>(size.voxel_count() * width));
      reader_.read_brick(entry, in_brick_level, voxels.data());
      ++decoded_;
    }
    const std::byte* row = voxels.data();
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        std::uint16_t* const out =
            &block.at(part.lo.x - box.lo.x, part.lo.y - box.lo.y + y, part.lo.z - box.lo.z + z);
        if (class_id == kMixed) classes_.map(row, size.x, out);
        else std::fill_n(out, size.x, static_cast<std::uint16_t>(class_id));
        row += class_id == kMixed ? size.x * width : 0;
      }
    }
    if (class_id == kMixed && !kept_.contains(part)) clear_outside(kept_, part, box.lo, block);
    return true;
  });
  block.condense();
}

}  // namespace octavo
