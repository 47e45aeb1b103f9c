// One block of 64^3 voxels and what of a surface belongs to it.
//
// Whether voxels lie inside is held as bits, a word for each row of 64, with those of one voxel
// more before the block along each axis. An edge between two voxels, and the point where the
// surface cuts it, belongs to the block of its upper end; a cube of 2^3 voxels to that of its last
// one. So all that the triangles of a block join belongs to it or to the blocks before it:
//
//          y ^    . . . . . .        . bits before the block
//            |    . o-o-o-o-o        o voxels of the block
//            |    . o-o-o-o-o        - edges of the block; so are those to the voxels before it
//            +->x . . . . . .
//
// The number of a point is that where the points of its row begin, plus the edges cut before it in
// the row: a count of bits. Points stand row by row, of a row first those on edges along x, then y,
// then z.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/cube_row.h"
#include "octavo/mesh/surface_field.h"
#include "octavo/mesh/surface_frame.h"

namespace octavo {

/// Sides of a block, and with the voxels before it.
inline constexpr int kSurfaceSide = 64;
inline constexpr int kSurfaceRows = kSurfaceSide + 1;

/// The rows of a block and those before it: y and z from -1 to 63.
template <class T>
class SurfaceRows {
 public:
  SurfaceRows() : rows_(static_cast<std::size_t>(kSurfaceRows * kSurfaceRows)) {}
  T& at(int y, int z) { return rows_[place(y, z)]; }
  const T& at(int y, int z) const { return rows_[place(y, z)]; }

 private:
  static std::size_t place(int y, int z) {
    return static_cast<std::size_t>((z + 1) * kSurfaceRows + y + 1);
  }
  std::vector<T> rows_;
};

/// Bits of voxels x = 0 .. 63, and one of x = -1.
struct SurfaceBits {
  std::uint64_t bits = 0;
  std::uint64_t before = 0;

  /// Bit x is that of voxel x - 1.
  std::uint64_t shifted() const { return bits << 1 | before; }
};

/// Numbers of the first points on edges of a row along x, y and z, and behind the last one.
struct RowStarts {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t z = 0;
  std::uint32_t end = 0;
};

/// Edges of a row that the surface cuts; bit x stands for the edge that ends at voxel x.
struct CutEdges {
  std::uint64_t x;
  std::uint64_t y;
  std::uint64_t z;
};

inline CutEdges cut_edges(const SurfaceRows<SurfaceBits>& bits, int y, int z) {
  const SurfaceBits& row = bits.at(y, z);
  return {row.bits ^ row.shifted(), row.bits ^ bits.at(y - 1, z).bits,
          row.bits ^ bits.at(y, z - 1).bits};
}

/// Values of the voxels of a block and those before it; those outside the volume are unset.
template <class T>
struct SurfaceValues {
  static constexpr std::int64_t kRow = kSurfaceRows;
  static constexpr std::int64_t kPlane = kRow * kRow;

  std::vector<T> values = std::vector<T>(static_cast<std::size_t>(kPlane * kRow));

  /// Voxel x, y, z of the block; each from -1 to 63.
  T* at(int x, int y, int z) {
    return values.data() + (z + 1) * kPlane + (y + 1) * kRow + (x + 1);
  }
  const T* at(int x, int y, int z) const {
    return values.data() + (z + 1) * kPlane + (y + 1) * kRow + (x + 1);
  }
};

struct SurfaceBlock {
  SurfaceRows<SurfaceBits> bits;
  SurfaceRows<RowStarts> starts;  ///< of the rows of the block alone, counted from 0
  std::vector<MeshPoint> points;  ///< that belong to the block
  std::uint32_t first_point = 0;  ///< what is added to all numbers

  /// Whether the surface cuts an edge of the block: not all its bits are alike.
  bool is_cut() const;
};

/// The blocks that hold the points which triangles of a block join, as far as these are cut;
/// [1][0][0] is the one before along z, [0][0][0] the block itself.
using BlocksBefore = std::array<std::array<std::array<const SurfaceBlock*, 2>, 2>, 2>;

/// Numbers from here on stand for points of blocks that are null in BlocksBefore but are cut:
/// kUnmadePoint + (4 dz + 2 dy + dx) * kUnmadeBlock and more, for the block [dz][dy][dx].
inline constexpr std::uint32_t kUnmadePoint = 0xc0000000;
inline constexpr std::uint32_t kUnmadeBlock = 0x01000000;

/// Numbers the points of a block and gives their places.
/// corner  of the block, in voxels
template <class T>
void place_points(const SurfaceField& field, const SurfaceFrame& frame, const Index3& corner,
                  const SurfaceValues<T>& values, SurfaceBlock& block);

/// Appends the triangles of a block. Requires that all numbers are final.
void join_triangles(const BlocksBefore& blocks, bool is_mirrored, MeshRoom<MeshTriangle>& room);

}  // namespace octavo
