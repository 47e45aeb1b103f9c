// One block of 64^3 voxels of labels and what of their net belongs to it.
//
// It is seen with the voxels before it, as in surface_block.h. A corner belongs to the block of its
// last voxel, the one above and behind it; a quad to that of its last corner. So all that the quads
// of a block join belongs to it or to the blocks before it.
//
// Points stand row by row; the number of one is that where its row begins, plus the corners before
// it in the row.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/mesh/nets/corner_fans.h"
#include "octavo/mesh/nets/surface_net.h"
#include "octavo/mesh/surface_block.h"

namespace octavo {

/// A face between two labels: its last corner in the block, before the corners have numbers.
struct NetFace {
  std::uint8_t x = 0;
  std::uint8_t y = 0;
  std::uint8_t z = 0;
  std::uint8_t axis = 0;
  /// Twice the number of its pair in the block; odd where the label inside lies behind the face.
  std::uint32_t pair = 0;
};

struct NetRow {
  std::uint64_t corners = 0;   ///< bit x: not all voxels there have one label
  std::uint64_t touching = 0;  ///< of those, where a label touches itself
  std::uint32_t first = 0;     ///< number of its first point in the block
  std::uint32_t first_touching = 0;  ///< place of the first corner where a label touches itself
};

struct NetBlock {
  std::vector<NetRow> rows = std::vector<NetRow>(kSurfaceSide * kSurfaceSide);  ///< [z][y]
  std::vector<NetPoint> points;
  std::vector<CornerSurfaces> touching;  ///< of corners at which a label touches itself
  std::vector<NetFace> faces;
  std::vector<LabelPair> pairs;
  std::uint32_t first_point = 0;            ///< what is added to all numbers
  std::vector<std::uint32_t> pair_numbers;  ///< of its pairs, among all

  const NetRow& row(int y, int z) const {
    return rows[static_cast<std::size_t>(z * kSurfaceSide + y)];
  }
  bool is_touching(int x, int y, int z) const { return (row(y, z).touching >> x & 1) != 0; }
  /// Requires a touching corner.
  const CornerSurfaces& surfaces_of(int x, int y, int z) const {
    const NetRow& own = row(y, z);
    const std::uint64_t below = own.touching & ((std::uint64_t{1} << x) - 1);
    return touching[own.first_touching + static_cast<std::size_t>(std::popcount(below))];
  }
};

/// The blocks that hold the corners of the quads of a block, as far as there are any;
/// [1][0][0] is the one before along z, [0][0][0] the block itself.
using NetBlocksBefore = std::array<std::array<std::array<const NetBlock*, 2>, 2>, 2>;

/// What a thread works with while it makes a block.
template <class T>
class NetBlockMaker {
 public:
  SurfaceValues<T> labels;

  /// The block of the labels; nothing where they are all one. Of a pair of labels the lower one
  /// lies outside, or 0.
  /// corner  of the block, in voxels
  std::unique_ptr<NetBlock> make(const Index3& corner);

 private:
  /// Where voxels differ from those before them; bit x is that of voxel x.
  struct Differences {
    std::uint64_t x = 0;
    std::uint64_t y = 0;
    std::uint64_t z = 0;
    std::uint8_t y_before = 0;  ///< of voxel -1
    std::uint8_t z_before = 0;
  };

  /// A pair of labels and its number in the block; no key: none.
  struct RecentPair {
    std::uint64_t key = 0;
    std::uint32_t number = 0;
  };
  static constexpr int kRecentBits = 8;

  bool find_differences();
  void make_row(const Index3& corner, int y, int z, NetBlock& block);
  void add_faces(std::uint64_t bits, int axis, int y, int z, NetBlock& block);
  std::uint64_t candidates(int y, int z) const;
  CornerSurfaces surfaces_at(int x, int y, int z, bool& is_touching) const;
  std::uint32_t pair_number(T inside, T outside, NetBlock& block);

  SurfaceRows<Differences> differences_;
  std::unordered_map<std::uint64_t, std::uint32_t> pair_numbers_;
  std::array<RecentPair, std::size_t{1} << kRecentBits> recent_pairs_{};  // of these some
};

/// The quads of a block. Requires that all numbers are final.
std::vector<NetQuad> joined_quads(const NetBlocksBefore& blocks, bool is_mirrored);

}  // namespace octavo
