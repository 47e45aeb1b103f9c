#include "octavo/ops/morphometry/euler_number.h"

#include <algorithm>
#include <vector>

#include "octavo/ops/morphometry/slab_sums.h"

namespace octavo {

namespace {

/// Cells of one kind: all of them, and their weights in eighths.
struct CellCount {
  std::int64_t all = 0;
  std::int64_t eighths = 0;
};

/// Planes with a rim of background, so that no place needs a test.
class PaddedPlanes {
 public:
  explicit PaddedPlanes(const Size3& size)
      : columns(size.x), rows(size.y), stride(size.x + 2),
        voxels_(static_cast<std::size_t>(stride * (size.y + 2))) {}

  std::uint8_t* row(std::int64_t y) { return voxels_.data() + (y + 1) * stride + 1; }
  const std::uint8_t* row(std::int64_t y) const { return voxels_.data() + (y + 1) * stride + 1; }

  std::int64_t columns;
  std::int64_t rows;
  std::int64_t stride;

 private:
  std::vector<std::uint8_t> voxels_;
};

/// Which places of a plane cells stand at: on voxels, or on the corners between them.
struct CellPlaces {
  bool is_between_x;
  bool is_between_y;
  int layer_eighths;  ///< weight of the layer: 8, or 4 in the border
};

/// Counts the cells of a plane that touch any of the voxels beside them; or, with
/// `takes_all`, those between voxels that are all in the mask.
CellCount count_cells(const PaddedPlanes& plane, const CellPlaces& places, bool takes_all) {
  const std::int64_t x_end = plane.columns + (places.is_between_x ? 1 : 0);
  const std::int64_t y_end = plane.rows + (places.is_between_y ? 1 : 0);
  const std::int64_t before = places.is_between_x ? 1 : 0;
  CellCount count;
  for (std::int64_t y = 0; y < y_end; ++y) {
    const std::uint8_t* const here = plane.row(y);
    const std::uint8_t* const above = places.is_between_y ? plane.row(y - 1) : here;
    const auto cell = [&](std::int64_t x) {
      return takes_all ? here[x] & here[x - before] & above[x] & above[x - before]
                       : here[x] | here[x - before] | above[x] | above[x - before];
    };
    std::int64_t in_row = 0;
    for (std::int64_t x = 0; x < x_end; ++x) in_row += cell(x);
    count.all += in_row;
    const bool is_border_row = places.is_between_y && (y == 0 || y == y_end - 1);
    std::int64_t doubled = 2 * in_row;
    if (places.is_between_x) doubled -= cell(0) + cell(x_end - 1);
    count.eighths += doubled * places.layer_eighths / (is_border_row ? 4 : 2);
  }
  return count;
}

class EulerSlab {
 public:
  EulerSlab(const MaskTree& mask, std::int64_t begin, std::int64_t end)
      : size_(mask.size()), voxels_(size_), before_(size_), both_(size_), shared_(size_) {
    const std::int64_t plane = size_.x * size_.y;
    std::vector<std::uint8_t> inside(static_cast<std::size_t>(plane));
    if (begin > 0) read(mask, begin - 1, inside);
    for (std::int64_t z = begin; z < end; ++z) {
      std::swap(before_, voxels_);
      read(mask, z, inside);
      add_layer(z);
      add_plane();
    }
    // The corners behind the last voxels of the volume.
    if (end == size_.z) {
      std::swap(before_, voxels_);
      voxels_ = PaddedPlanes(size_);
      add_layer(size_.z);
    }
  }

  EulerNumbers numbers() const {
    return {closed_.all, open_, static_cast<double>(closed_.eighths) / 8};
  }

 private:
  void read(const MaskTree& mask, std::int64_t z, std::vector<std::uint8_t>& inside) {
    fill_voxels(mask, {{0, 0, z}, {size_.x, size_.y, z + 1}}, inside.data());
    for (std::int64_t y = 0; y < size_.y; ++y) {
      std::copy_n(inside.data() + y * size_.x, size_.x, voxels_.row(y));
    }
  }

  void add(int sign, const PaddedPlanes& plane, const CellPlaces& places) {
    const CellCount count = count_cells(plane, places, false);
    closed_.all += sign * count.all;
    closed_.eighths += sign * count.eighths;
  }

  /// Cells between the planes before and behind layer z: corners, edges along x and y, faces; and
  /// the pairs, squares and cubes of voxels across it.
  void add_layer(std::int64_t z) {
    for (std::int64_t y = 0; y < size_.y; ++y) {
      const std::uint8_t* const a = before_.row(y);
      const std::uint8_t* const b = voxels_.row(y);
      std::uint8_t* const any = both_.row(y);
      std::uint8_t* const all = shared_.row(y);
      for (std::int64_t x = 0; x < size_.x; ++x) {
        any[x] = a[x] | b[x];
        all[x] = a[x] & b[x];
      }
    }
    const int eighths = z == 0 || z == size_.z ? 4 : 8;
    add(1, both_, {true, true, eighths});
    add(-1, both_, {false, true, eighths});
    add(-1, both_, {true, false, eighths});
    add(1, both_, {false, false, eighths});
    open_ -= count_cells(shared_, {false, false, 8}, true).all;
    open_ += count_cells(shared_, {true, false, 8}, true).all;
    open_ += count_cells(shared_, {false, true, 8}, true).all;
    open_ -= count_cells(shared_, {true, true, 8}, true).all;
  }

  /// Cells of a plane of voxels: edges along z, faces across x and y, voxels; and its pairs and
  /// squares.
  void add_plane() {
    add(-1, voxels_, {true, true, 8});
    add(1, voxels_, {true, false, 8});
    add(1, voxels_, {false, true, 8});
    add(-1, voxels_, {false, false, 8});
    open_ += count_cells(voxels_, {false, false, 8}, true).all;
    open_ -= count_cells(voxels_, {true, false, 8}, true).all;
    open_ -= count_cells(voxels_, {false, true, 8}, true).all;
    open_ += count_cells(voxels_, {true, true, 8}, true).all;
  }

  Size3 size_;
  PaddedPlanes voxels_;  // the plane behind a layer
  PaddedPlanes before_;
  PaddedPlanes both_;    // in either of the two
  PaddedPlanes shared_;  // in both
  CellCount closed_;
  std::int64_t open_ = 0;
};

}  // namespace

EulerNumbers& EulerNumbers::operator+=(const EulerNumbers& other) {
  corners += other.corners;
  faces += other.faces;
  share += other.share;
  return *this;
}

EulerNumbers euler_numbers(const MaskTree& mask, Progress& progress) {
  return sum_of_slabs<EulerNumbers>(
      mask.size().z, progress, [&](std::int64_t begin, std::int64_t end) {
        return EulerSlab(mask, begin, end).numbers();
      });
}

}  // namespace octavo
