#include "octavo/mesh/surface_block.h"

#include <algorithm>
#include <bit>

#include "octavo/mesh/cube_cases.h"

namespace octavo {

namespace {

/// Edges of a row that the surface cuts; bit x stands for the edge that ends at voxel x.
struct CutEdges {
  std::uint64_t x;
  std::uint64_t y;
  std::uint64_t z;
};

CutEdges cut_edges(const SurfaceRows<SurfaceBits>& bits, int y, int z) {
  const SurfaceBits& row = bits.at(y, z);
  return {row.bits ^ row.shifted(), row.bits ^ bits.at(y - 1, z).bits,
          row.bits ^ bits.at(y, z - 1).bits};
}

std::uint32_t count_of(std::uint64_t bits) {
  return static_cast<std::uint32_t>(std::popcount(bits));
}

/// Gives the points of a block their places.
template <class T>
class PointPlacer {
 public:
  PointPlacer(const SurfaceField& field, const SurfaceFrame& frame, const Index3& corner,
              const SurfaceValues<T>& values, std::vector<MeshPoint>& points)
      : field_(field),
        frame_(frame),
        corner_(corner),
        values_(values),
        border_(crossing_at_border(field)),
        points_(points) {}

  void place_row(const CutEdges& cut, int y, int z) {
    const auto row_y = static_cast<double>(corner_.y + y);
    const auto row_z = static_cast<double>(corner_.z + z);
    const auto x_of = [&](int x) { return static_cast<double>(corner_.x + x); };
    for (std::uint64_t left = cut.x; left != 0; left &= left - 1) {
      const int x = std::countr_zero(left);
      points_.push_back(frame_.point_at(x_of(x) - 1 + share(0, x, y, z), row_y, row_z));
    }
    for (std::uint64_t left = cut.y; left != 0; left &= left - 1) {
      const int x = std::countr_zero(left);
      points_.push_back(frame_.point_at(x_of(x), row_y - 1 + share(1, x, y, z), row_z));
    }
    for (std::uint64_t left = cut.z; left != 0; left &= left - 1) {
      const int x = std::countr_zero(left);
      points_.push_back(frame_.point_at(x_of(x), row_y, row_z - 1 + share(2, x, y, z)));
    }
  }

 private:
  /// How far along the edge that ends at a voxel the surface cuts it.
  double share(int axis, int x, int y, int z) const {
    const std::int64_t end = axis == 0 ? corner_.x + x : axis == 1 ? corner_.y + y : corner_.z + z;
    if (end == 0) return 1 - border_;
    if (end == frame_.size()[axis]) return border_;
    const T* const to = values_.at(x, y, z);
    const T* const from = to - (axis == 0   ? 1
                                : axis == 1 ? SurfaceValues<T>::kRow
                                            : SurfaceValues<T>::kPlane);
    return crossing_between(field_, static_cast<double>(*from), static_cast<double>(*to));
  }

  const SurfaceField& field_;
  const SurfaceFrame& frame_;
  Index3 corner_;
  const SurfaceValues<T>& values_;
  double border_;
  std::vector<MeshPoint>& points_;
};

/// Numbers of points as the cubes of a block see them: those on edges of its own rows and of rows
/// before it, and those of the last edges before each row.
struct JoinedRow {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
  std::uint32_t z = 0;
  std::uint32_t y_before = 0;
  std::uint32_t z_before = 0;
};

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
      }
      if (const SurfaceBlock* const block = in_plane[1]) {
        const RowStarts& starts = block->starts.at(own_y, own_z);
        row.y_before = block->first_point + starts.z - 1;
        row.z_before = block->first_point + starts.end - 1;
      }
    }
  }
  return rows;
}

/// Joins the points of one row of cubes.
class RowJoiner {
 public:
  RowJoiner(const SurfaceRows<SurfaceBits>& bits, const SurfaceRows<JoinedRow>& rows, int y,
            int z) {
    for (std::size_t k = 0; k < 4; ++k) {
      const int row_y = y - 1 + static_cast<int>(k & 1);
      const int row_z = z - 1 + static_cast<int>(k >> 1);
      upper_[k] = bits.at(row_y, row_z).bits;
      lower_[k] = bits.at(row_y, row_z).shifted();
      rows_[k] = &rows.at(row_y, row_z);
    }
  }

  /// Cubes that the surface goes through; bit x stands for the one whose last voxel is x.
  std::uint64_t cut_cubes() const {
    std::uint64_t any = 0;
    std::uint64_t all = ~std::uint64_t{0};
    for (std::size_t k = 0; k < 4; ++k) {
      any |= upper_[k] | lower_[k];
      all &= upper_[k] & lower_[k];
    }
    return any & ~all;
  }

  void join(int x, bool is_mirrored, std::vector<MeshTriangle>& triangles) const {
    unsigned inside = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      inside |= static_cast<unsigned>((lower_[k] >> x & 1) | (upper_[k] >> x & 1) << 1) << 2 * k;
    }
    const auto numbers = points_at(x);
    for (const CubeTriangle& t : cases_.triangles(static_cast<std::uint8_t>(inside))) {
      const std::uint32_t second = numbers[t[1]];
      const std::uint32_t third = numbers[t[2]];
      triangles.push_back({numbers[t[0]], is_mirrored ? third : second,
                           is_mirrored ? second : third});
    }
  }

 private:
  /// The points on the 12 edges of a cube, numbered as in cube_cases.h. Those on edges that are not
  /// cut are unset.
  std::array<std::uint32_t, 12> points_at(int x) const {
    const std::uint64_t below = (std::uint64_t{1} << x) - 1;
    std::array<std::uint32_t, 12> numbers;
    for (std::size_t k = 0; k < 4; ++k) {
      numbers[k] = rows_[k]->x + count_of((upper_[k] ^ lower_[k]) & below);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      // Along y between rows 2k and 2k + 1, which owns the edge; along z between k and k + 2.
      const std::uint32_t y = rows_[2 * k + 1]->y +
                              count_of((upper_[2 * k] ^ upper_[2 * k + 1]) & below);
      const std::uint32_t z = rows_[k + 2]->z + count_of((upper_[k] ^ upper_[k + 2]) & below);
      numbers[4 + 2 * k] = x == 0 ? rows_[2 * k + 1]->y_before : y - 1;
      numbers[5 + 2 * k] = y;
      numbers[8 + 2 * k] = x == 0 ? rows_[k + 2]->z_before : z - 1;
      numbers[9 + 2 * k] = z;
    }
    return numbers;
  }

  const CubeCases& cases_ = CubeCases::shared();
  std::array<std::uint64_t, 4> upper_;  // rows (y-1, z-1), (y, z-1), (y-1, z), (y, z)
  std::array<std::uint64_t, 4> lower_;  // the same, one voxel before
  std::array<const JoinedRow*, 4> rows_;
};

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
  PointPlacer<T> placer(field, frame, corner, values, block.points);
  std::uint32_t count = 0;
  for (int z = 0; z < kSurfaceSide; ++z) {
    for (int y = 0; y < kSurfaceSide; ++y) {
      const CutEdges cut = cut_edges(block.bits, y, z);
      RowStarts& starts = block.starts.at(y, z);
      starts.x = count;
      starts.y = starts.x + count_of(cut.x);
      starts.z = starts.y + count_of(cut.y);
      starts.end = starts.z + count_of(cut.z);
      if (starts.end != count) placer.place_row(cut, y, z);
      count = starts.end;
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

std::vector<MeshTriangle> joined_triangles(const BlocksBefore& blocks, bool is_mirrored) {
  const SurfaceBlock& block = *blocks[0][0][0];
  const SurfaceRows<JoinedRow> rows = joined_rows(blocks);
  std::vector<MeshTriangle> triangles;
  triangles.reserve(2 * block.points.size());
  for (int z = 0; z < kSurfaceSide; ++z) {
    for (int y = 0; y < kSurfaceSide; ++y) {
      const RowJoiner row(block.bits, rows, y, z);
      for (std::uint64_t left = row.cut_cubes(); left != 0; left &= left - 1) {
        row.join(std::countr_zero(left), is_mirrored, triangles);
      }
    }
  }
  return triangles;
}

}  // namespace octavo
