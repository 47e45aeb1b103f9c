#include "octavo/mesh/memory_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/cube_row.h"
#include "octavo/mesh/mesh_room.h"
#include "octavo/mesh/point_row.h"
#include "octavo/mesh/surface_frame.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

/// Numbers of the first points of a row, along x, y and z.
using RowNumbers = std::array<std::uint32_t, 3>;

template <class T>
class MemorySurface {
 public:
  MemorySurface(const VoxelsInMemory& volume, const SurfaceField& field, Progress& progress)
      : voxels_(static_cast<const T*>(volume.voxels)),
        size_(volume.size),
        frame_(volume.geometry, volume.size),
        inside_(field),
        placer_(field, frame_),
        progress_(progress),
        words_(static_cast<std::size_t>(size_.x / 64 + 1)),
        rows_(static_cast<std::size_t>(size_.y + 2)),
        bits_(words_ * rows_ * static_cast<std::size_t>(size_.z + 2)),
        numbers_(rows_ * static_cast<std::size_t>(size_.z + 2) + 1) {}

  TriangleMesh run() {
    visit_planes([&](std::int64_t first, std::int64_t end) { make_points(first, end); });
    gather_points();
    // A closed surface with few handles has two triangles for each point.
    mesh_.triangles.reserve(2 * mesh_.points.size() + mesh_.points.size() / 16);
    visit_planes([&](std::int64_t first, std::int64_t end) { make_triangles(first, end); });
    return std::move(mesh_);
  }

 private:
  // Rows and planes are counted with one before the first, which lies outside.
  std::size_t row_at(std::int64_t y, std::int64_t z) const {
    return static_cast<std::size_t>(z) * rows_ + static_cast<std::size_t>(y);
  }
  std::uint64_t* words_at(std::size_t row) { return bits_.data() + row * words_; }
  const std::uint64_t* words_at(std::size_t row) const { return bits_.data() + row * words_; }

  template <class Work>
  void for_each(std::int64_t first, std::int64_t end, Work work) {
    parallel_for(first, end, [&](std::int64_t i) {
      stop_if_cancelled(progress_);
      work(i);
    });
  }

  static constexpr std::int64_t kPlanes = 4;

  /// Calls visit(first, end) for runs of planes, some for each thread.
  template <class Visit>
  void visit_planes(Visit visit) {
    const std::int64_t end = size_.z + 2;
    const std::int64_t at_once = kPlanes * arena_threads();
    for (std::int64_t first = 1; first < end; first += at_once) {
      visit(first, std::min(first + at_once, end));
    }
  }

  /// Makes what the planes first .. end have, some on each thread, and appends it in order.
  template <class Item, class Make>
  void append(std::int64_t first, std::int64_t end, std::vector<MeshRoom<Item>>& rooms,
              std::vector<Item>& all, Make make) {
    const std::int64_t runs = (end - first + kPlanes - 1) / kPlanes;
    rooms.resize(std::max(rooms.size(), static_cast<std::size_t>(runs)));
    for_each(0, runs, [&](std::int64_t i) {
      MeshRoom<Item>& room = rooms[static_cast<std::size_t>(i)];
      room.clear();
      const std::int64_t begin = first + i * kPlanes;
      for (std::int64_t z = begin; z < std::min(begin + kPlanes, end); ++z) make(z, room);
    });
    for (std::size_t i = 0; i < static_cast<std::size_t>(runs); ++i) {
      all.insert(all.end(), rooms[i].all().begin(), rooms[i].all().end());
    }
  }

  /// Makes bits, numbers and points of some planes, while the processor has their voxels at hand.
  void make_points(std::int64_t first, std::int64_t end) {
    for_each(first, std::min(end, size_.z + 1), [&](std::int64_t z) { find_bits(z); });
    for_each(first, end, [&](std::int64_t z) { count_points(z); });
    sum_counts(row_at(0, first), row_at(0, end));
    append(first, end, point_rooms_, points_.emplace_back(),
           [&](std::int64_t z, MeshRoom<MeshPoint>& room) { place_points(z, room); });
  }

  /// Puts the points in one place; not as they come, which would move them again and again.
  void gather_points() {
    mesh_.points.reserve(numbers_.back()[0]);
    for (std::vector<MeshPoint>& some : points_) {
      mesh_.points.insert(mesh_.points.end(), some.begin(), some.end());
      std::vector<MeshPoint>().swap(some);
    }
  }

  void make_triangles(std::int64_t first, std::int64_t end) {
    append(first, end, triangle_rooms_, mesh_.triangles,
           [&](std::int64_t z, MeshRoom<MeshTriangle>& room) {
             if (frame_.is_mirrored()) join_plane<true>(z, room);
             else join_plane<false>(z, room);
           });
  }

  void find_bits(std::int64_t z) {
    for (std::int64_t y = 1; y <= size_.y; ++y) {
      const T* row = voxels_ + ((z - 1) * size_.y + y - 1) * size_.x;
      std::uint64_t* to = words_at(row_at(y, z));
      for (std::int64_t x = 0; x < size_.x; x += 64) {
        *to++ = inside_.bits(row + x, static_cast<int>(std::min<std::int64_t>(size_.x - x, 64)));
      }
    }
  }

  /// Edges that the surface cuts in word w of a row.
  std::array<std::uint64_t, 3> cut_edges(std::size_t row, std::size_t w) const {
    const std::uint64_t* const at = words_at(row);
    const std::uint64_t before = w == 0 ? 0 : at[w - 1] >> 63;
    return {at[w] ^ (at[w] << 1 | before), at[w] ^ words_at(row - 1)[w],
            at[w] ^ words_at(row - rows_)[w]};
  }

  void count_points(std::int64_t z) {
    for (std::int64_t y = 1; y <= size_.y + 1; ++y) {
      const std::size_t row = row_at(y, z);
      RowNumbers counts{};
      for (std::size_t w = 0; w < words_; ++w) {
        const auto cut = cut_edges(row, w);
        if ((cut[0] | cut[1] | cut[2]) == 0) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          counts[axis] += static_cast<std::uint32_t>(std::popcount(cut[axis]));
        }
      }
      numbers_[row] = counts;
    }
  }

  /// Makes numbers of the counts of rows first .. end.
  void sum_counts(std::size_t first, std::size_t end) {
    std::uint64_t sum = numbers_[first][0];
    numbers_[first] = {};  // of a row outside; held where the rows before it end
    for (std::size_t row = first; row < end; ++row) {
      for (std::uint32_t& number : numbers_[row]) {
        const std::uint32_t count = number;
        number = static_cast<std::uint32_t>(sum);
        sum += count;
      }
    }
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    if (sum > kMost) {
      throw Error(ErrorKind::limit_exceeded,
                  "the surface has more than " + std::to_string(kMost) + " points");
    }
    if (end < numbers_.size()) numbers_[end][0] = static_cast<std::uint32_t>(sum);
  }

  void place_points(std::int64_t z, MeshRoom<MeshPoint>& room) const {
    const std::uint32_t start = numbers_[row_at(0, z)][0];
    const std::uint32_t count = numbers_[row_at(0, z + 1)][0] - start;
    if (count == 0) return;
    MeshPoint* const out = room.next(count);
    for (std::int64_t y = 1; y <= size_.y + 1; ++y) {
      const std::size_t row = row_at(y, z);
      if (numbers_[row + 1][0] != numbers_[row][0]) place_row(y, z, out, start);
    }
    room.finish(out + count);
  }

  /// Writes the points of a row; that of number `start` stands at `points`.
  void place_row(std::int64_t y, std::int64_t z, MeshPoint* points, std::uint32_t start) const {
    const std::size_t row = row_at(y, z);
    const std::array<std::ptrdiff_t, 3> back = {1, size_.x, size_.x * size_.y};
    std::array<MeshPoint*, 3> out;
    for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = points + (numbers_[row][axis] - start);
    for (std::size_t w = 0; w < words_; ++w) {
      const auto cut = cut_edges(row, w);
      const Index3 first = {static_cast<std::int64_t>(64 * w), y - 1, z - 1};
      const T* const values = voxels_ + (first.z * size_.y + first.y) * size_.x + first.x;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (cut[axis] == 0) continue;
        out[axis] = placer_.place({static_cast<int>(axis), first, values, back[axis]}, cut[axis],
                                  out[axis]);
      }
    }
  }

  template <bool kIsMirrored>
  void join_plane(std::int64_t z, MeshRoom<MeshTriangle>& room) const {
    const CubeCases& cases = CubeCases::shared();
    for (std::int64_t y = 1; y <= size_.y + 1; ++y) {
      const std::size_t row = row_at(y, z);
      const std::array<std::size_t, 4> rows = {row - rows_ - 1, row - rows_, row - 1, row};
      std::array<const std::uint64_t*, 4> at;
      for (std::size_t k = 0; k < 4; ++k) at[k] = words_at(rows[k]);
      CubeNumbers numbers = first_numbers(rows);
      std::array<std::uint64_t, 4> before{};
      for (std::size_t w = 0; w < words_; ++w) {
        CubeWords words;
        for (std::size_t k = 0; k < 4; ++k) {
          words.upper[k] = at[k][w];
          words.lower[k] = at[k][w] << 1 | before[k];
          before[k] = at[k][w] >> 63;
        }
        const std::uint64_t cut = words.cut_cubes();
        if (cut != 0) join_cubes<kIsMirrored>(cases, words, cut, numbers, room);
      }
    }
  }

  CubeNumbers first_numbers(const std::array<std::size_t, 4>& rows) const {
    CubeNumbers numbers;
    for (std::size_t k = 0; k < 4; ++k) numbers.x[k] = numbers_[rows[k]][0];
    for (std::size_t k = 0; k < 2; ++k) {
      numbers.y[k] = numbers_[rows[2 * k + 1]][1];
      numbers.z[k] = numbers_[rows[k + 2]][2];
    }
    return numbers;
  }

  const T* voxels_;
  Size3 size_;
  SurfaceFrame frame_;
  InsideTest<T> inside_;
  PointRow<T> placer_;
  Progress& progress_;
  std::size_t words_;  ///< of a row: one bit more than there are voxels
  std::size_t rows_;   ///< of a plane
  std::vector<std::uint64_t> bits_;
  std::vector<RowNumbers> numbers_;  ///< one more than there are rows
  std::vector<std::vector<MeshPoint>> points_;  ///< of runs of planes
  std::vector<MeshRoom<MeshPoint>> point_rooms_;
  std::vector<MeshRoom<MeshTriangle>> triangle_rooms_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh surface_of(const VoxelsInMemory& volume, const SurfaceField& field,
                        Progress& progress) {
  TriangleMesh mesh;
  with_voxel_type(volume.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    mesh = MemorySurface<T>(volume, field, progress).run();
  });
  return mesh;
}

}  // namespace octavo
