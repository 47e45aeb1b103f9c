// Makes blocks of a surface out of the bricks of a file and level.
#pragma once


#include <algorithm>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_set>
#include <utility>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/mesh/surface_block.h"
#include "octavo/mesh/surface_field.h"
#include "octavo/mesh/surface_frame.h"
#include "octavo/octree/o_code.h"

namespace octavo {

/// The part of a block that one brick of the file covers, in voxels of the block.
struct BrickPart {
  Box box;  ///< each side within -1 .. 64
  InsideShare share = InsideShare::none;
  std::uint64_t code = 0;   ///< of the brick
  bool is_uniform = false;  ///< of one value: nothing has to be decoded
};

/// What a thread works with.
template <class T>
struct BlockSpace {
  SurfaceValues<T> values;
  std::vector<BrickPart> parts;
};

inline std::uint64_t low_bits(std::int64_t count) {
  return count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

/// Makes the blocks of one file and level.
template <class T>
class BlockMaker {
 public:
  BlockMaker(const FileReader& reader, int level, const SurfaceField& field)
      : reader_(reader),
        level_(level),
        field_(field),
        inside_(field),
        frame_(reader.levels().geometry(reader.description().geometry, level),
               reader.levels().size(level)),
        brick_side_(brick_side_at(reader.levels(), level)) {}

  const SurfaceFrame& frame() const { return frame_; }
  /// Bricks that had to be decoded so far.
  std::uint64_t decoded_bricks() const { return decoded_.size(); }

  /// Has the reader decode and keep the bricks that begin in a block.
  void fetch(const Index3& place, BlockSpace<T>& space) const {
    const Index3 corner = corner_of(place);
    find_parts(corner, space.parts);
    for (const BrickPart& part : space.parts) {
      const Index3& lo = part.box.lo;
      if (part.share == InsideShare::some && lo.x >= 0 && lo.y >= 0 && lo.z >= 0) {
        read(part, corner, space.values);
      }
    }
  }

  /// The block at a place of the grid of blocks, its numbers counted from 0; nothing where the
  /// surface cuts none of its edges.
  std::unique_ptr<SurfaceBlock> make(const Index3& place, BlockSpace<T>& space) const {
    const Index3 corner = corner_of(place);
    find_parts(corner, space.parts);
    const auto is_outside = [](const BrickPart& part) { return part.share == InsideShare::none; };
    if (std::all_of(space.parts.begin(), space.parts.end(), is_outside)) return nullptr;

    auto block = std::make_unique<SurfaceBlock>();
    for (const BrickPart& part : space.parts) set_bits(part, corner, space.values, block->bits);
    if (!block->is_cut()) return nullptr;
    if (field_.isovalue) read_decided(corner, *block, space);
    place_points(field_, frame_, corner, space.values, *block);
    return block;
  }

 private:
  static Index3 corner_of(const Index3& place) {
    return {place.x * kSurfaceSide, place.y * kSurfaceSide, place.z * kSurfaceSide};
  }

  void find_parts(const Index3& corner, std::vector<BrickPart>& parts) const {
    const VolumeDescription& description = reader_.description();
    const bool may_hold_others = description.codec_type() == VoxelType::float32;
    const Box block = {{corner.x - 1, corner.y - 1, corner.z - 1},
                       {corner.x + kSurfaceSide, corner.y + kSurfaceSide,
                        corner.z + kSurfaceSide}};
    parts.clear();
    visit_cells(intersection(block, box_of(frame_.size())), brick_side_,
                [&](const Index3& brick) {
      const Box box = intersection(brick_box_at(reader_.levels(), level_, brick), block);
      const ValueRange range = reader_.brick(Levels::tier_of(level_), brick).range;
      const auto [lowest, highest] = std::minmax(
          {description.voxel_of(range.min), description.voxel_of(range.max)});
      parts.push_back({{{box.lo.x - corner.x, box.lo.y - corner.y, box.lo.z - corner.z},
                        {box.hi.x - corner.x, box.hi.y - corner.y, box.hi.z - corner.z}},
                       inside_share(field_, lowest, highest, may_hold_others),
                       interleave(brick), range.min == range.max});
      return true;
    });
  }

  void read(const BrickPart& part, const Index3& corner, SurfaceValues<T>& values) const {
    const Box& box = part.box;
    if (!part.is_uniform) {
      const std::lock_guard lock(mutex_);
      decoded_.insert(part.code);
    }
    reader_.read_strided({{box.lo.x + corner.x, box.lo.y + corner.y, box.lo.z + corner.z},
                          {box.hi.x + corner.x, box.hi.y + corner.y, box.hi.z + corner.z}},
                         level_, values.at(static_cast<int>(box.lo.x), static_cast<int>(box.lo.y),
                                           static_cast<int>(box.lo.z)),
                         SurfaceValues<T>::kRow, SurfaceValues<T>::kPlane);
  }

  void set_bits(const BrickPart& part, const Index3& corner, SurfaceValues<T>& values,
                SurfaceRows<SurfaceBits>& rows) const {
    if (part.share == InsideShare::none) return;
    const bool are_all = part.share == InsideShare::all;
    if (!are_all) read(part, corner, values);
    const auto begin = static_cast<int>(std::max<std::int64_t>(part.box.lo.x, 0));
    const int count = static_cast<int>(part.box.hi.x) - begin;
    const std::uint64_t ones = low_bits(count);
    for (auto z = static_cast<int>(part.box.lo.z); z < part.box.hi.z; ++z) {
      for (auto y = static_cast<int>(part.box.lo.y); y < part.box.hi.y; ++y) {
        SurfaceBits& row = rows.at(y, z);
        if (part.box.lo.x < 0) {
          row.before = are_all ? 1 : inside_.bits(values.at(-1, y, z), 1);
        }
        if (count == 0) continue;
        row.bits |= (are_all ? ones : inside_.bits(values.at(begin, y, z), count))
                    << begin;
      }
    }
  }

  /// Reads the values of parts that were decided without, where the surface passes beside them.
  void read_decided(const Index3& corner, const SurfaceBlock& block, BlockSpace<T>& space) const {
    for (const BrickPart& part : space.parts) {
      if (part.share == InsideShare::some) continue;
      if (is_cut_at(part, block.bits)) read(part, corner, space.values);
    }
  }

  /// Whether a voxel of a part, or one beside it in the block, lies on the other side.
  static bool is_cut_at(const BrickPart& part, const SurfaceRows<SurfaceBits>& rows) {
    const std::uint64_t expected = part.share == InsideShare::all ? ~std::uint64_t{0} : 0;
    const std::int64_t first = std::max<std::int64_t>(part.box.lo.x - 1, 0);
    const std::int64_t end = std::min<std::int64_t>(part.box.hi.x + 1, kSurfaceSide);
    const std::uint64_t columns = low_bits(end) & ~low_bits(first);
    const auto low = [](std::int64_t at) {
      return static_cast<int>(std::max<std::int64_t>(at - 1, -1));
    };
    const auto high = [](std::int64_t at) {
      return static_cast<int>(std::min<std::int64_t>(at + 1, kSurfaceSide));
    };
    for (int z = low(part.box.lo.z); z < high(part.box.hi.z); ++z) {
      for (int y = low(part.box.lo.y); y < high(part.box.hi.y); ++y) {
        const SurfaceBits& row = rows.at(y, z);
        if (((row.bits ^ expected) & columns) != 0) return true;
        if (part.box.lo.x <= 0 && row.before != (expected & 1)) return true;
      }
    }
    return false;
  }

  const FileReader& reader_;
  int level_;
  const SurfaceField& field_;
  InsideTest<T> inside_;
  SurfaceFrame frame_;
  Size3 brick_side_;
  mutable std::mutex mutex_;
  mutable std::unordered_set<std::uint64_t> decoded_;  // codes of bricks
};

}  // namespace octavo
