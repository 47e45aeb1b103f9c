#include "octavo/mesh/surface_block.h"

#include <algorithm>
#include <array>
#include <bit>

#include "octavo/mesh/point_row.h"

namespace octavo {

namespace {

std::uint32_t count_of(std::uint64_t bits) {
  return static_cast<std::uint32_t>(std::popcount(bits));
}

/// Numbers of points as the cubes of a block see them: those on edges of its own rows and of rows
/// before it, and those of the last edges before each row.
struct JoinedRow {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t z = 0;
  std::uint32_t y_before = 0;
  std::uint32_t z_before = 0;
};

/// Stands for the points of a row of a block that is not there.
std::uint32_t unmade(std::uint32_t dx, int y, int z) {
  return kUnmadePoint + ((z < 0 ? 4u : 0u) + (y < 0 ? 2u : 0u) + dx) * kUnmadeBlock;
}

SurfaceRows<JoinedRow> joined_rows(const BlocksBefore& blocks) {
  SurfaceRows<JoinedRow> rows;
  for (int z = -1; z < kSurfaceSide; ++z) {
    for (int y = -1; y < kSurfaceSide; ++y) {
      const auto& in_plane = blocks[z < 0 ? 1u : 0u][y < 0 ? 1u : 0u];
      const int own_y = y < 0 ? kSurfaceSide - 1 : y;
      const int own_z = z < 0 ? kSurfaceSide - 1 : z;
      JoinedRow& row = rows.at(y, z);
      if (const SurfaceBlock* const block = in_plane[0]) {
        const RowStarts& starts = block->starts.at(own_y, own_z);
        row.x = block->first_point + starts.x;
        row.y = block->first_point + starts.y;
        row.z = block->first_point + starts.z;
      } else {
        row.x = row.y = row.z = unmade(0, y, z);
      }
      if (const SurfaceBlock* const block = in_plane[1]) {
        const RowStarts& starts = block->starts.at(own_y, own_z);
        row.y_before = block->first_point + starts.z - 1;
        row.z_before = block->first_point + starts.end - 1;
      } else {
        row.y_before = row.z_before = unmade(1, y, z);
      }
    }
  }
  return rows;
}

/// The words of a row of cubes of a block, and the numbers that its points begin with.
CubeWords words_of(const SurfaceRows<SurfaceBits>& bits, int y, int z) {
  CubeWords words;
  for (std::size_t k = 0; k < 4; ++k) {
    const SurfaceBits& row = bits.at(y - 1 + static_cast<int>(k & 1),
                                     z - 1 + static_cast<int>(k >> 1));
    words.upper[k] = row.bits;
    words.lower[k] = row.shifted();
  }
  return words;
}

CubeNumbers numbers_of(const SurfaceRows<JoinedRow>& rows, int y, int z) {
  const std::array<const JoinedRow*, 4> row = {&rows.at(y - 1, z - 1), &rows.at(y, z - 1),
                                               &rows.at(y - 1, z), &rows.at(y, z)};
  CubeNumbers numbers;
  for (std::size_t k = 0; k < 4; ++k) numbers.x[k] = row[k]->x;
  for (std::size_t k = 0; k < 2; ++k) {
    numbers.y[k] = row[2 * k + 1]->y;
    numbers.y_before[k] = row[2 * k + 1]->y_before;
    numbers.z[k] = row[k + 2]->z;
    numbers.z_before[k] = row[k + 2]->z_before;
  }
  return numbers;
}

template <bool kIsMirrored>
void join_block(const SurfaceBlock& block, const SurfaceRows<JoinedRow>& rows,
                MeshRoom<MeshTriangle>& room) {
  const CubeCases& cases = CubeCases::shared();
  for (int z = 0; z < kSurfaceSide; ++z) {
    for (int y = 0; y < kSurfaceSide; ++y) {
      const CubeWords words = words_of(block.bits, y, z);
      const std::uint64_t cut = words.cut_cubes();
      if (cut == 0) continue;
      CubeNumbers numbers = numbers_of(rows, y, z);
      join_cubes<kIsMirrored>(cases, words, cut, numbers, room);
    }
  }
}

}  // namespace

bool SurfaceBlock::is_cut() const {
  const std::uint64_t first = bits.at(-1, -1).before != 0 ? ~std::uint64_t{0} : 0;
  for (int z = -1; z < kSurfaceSide; ++z) {
    for (int y = -1; y < kSurfaceSide; ++y) {
      const SurfaceBits& row = bits.at(y, z);
      if (row.bits != first || row.before != (first & 1)) return true;
    }
  }
  return false;
}

template <class T>
void place_points(const SurfaceField& field, const SurfaceFrame& frame, const Index3& corner,
                  const SurfaceValues<T>& values, SurfaceBlock& block) {
  // Number them
  std::uint32_t count = 0;
  for (int z = 0; z < kSurfaceSide; ++z) {
    for (int y = 0; y < kSurfaceSide; ++y) {
      const CutEdges cut = cut_edges(block.bits, y, z);
      RowStarts& starts = block.starts.at(y, z);
      starts.x = count;
      starts.y = starts.x + count_of(cut.x);
      starts.z = starts.y + count_of(cut.y);
      starts.end = count = starts.z + count_of(cut.z);
    }
  }

  // Place them
  const PointRow<T> placer(field, frame);
  block.points.resize(count);
  MeshPoint* out = block.points.data();
  for (int z = 0; z < kSurfaceSide; ++z) {
    for (int y = 0; y < kSurfaceSide; ++y) {
      const RowStarts& starts = block.starts.at(y, z);
      if (starts.end == starts.x) continue;
      const CutEdges cut = cut_edges(block.bits, y, z);
      const Index3 first = {corner.x, corner.y + y, corner.z + z};
      const T* const row = values.at(0, y, z);
      out = placer.place({0, first, row, 1}, cut.x, out);
      out = placer.place({1, first, row, SurfaceValues<T>::kRow}, cut.y, out);
      out = placer.place({2, first, row, SurfaceValues<T>::kPlane}, cut.z, out);
    }
  }
}

template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<std::int8_t>&, SurfaceBlock&);
template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<std::uint8_t>&, SurfaceBlock&);
template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<std::int16_t>&, SurfaceBlock&);
template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<std::uint16_t>&, SurfaceBlock&);
template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<std::int32_t>&, SurfaceBlock&);
template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<std::uint32_t>&, SurfaceBlock&);
template void place_points(const SurfaceField&, const SurfaceFrame&, const Index3&,
                           const SurfaceValues<float>&, SurfaceBlock&);

void join_triangles(const BlocksBefore& blocks, bool is_mirrored, MeshRoom<MeshTriangle>& room) {
  const SurfaceRows<JoinedRow> rows = joined_rows(blocks);
  if (is_mirrored) join_block<true>(*blocks[0][0][0], rows, room);
  else join_block<false>(*blocks[0][0][0], rows, room);
}

}  // namespace octavo
