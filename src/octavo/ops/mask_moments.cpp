#include "octavo/ops/mask_moments.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <bit>
#include <vector>

#include "octavo/ops/mask_kernels.h"

namespace octavo {

namespace {

// The voxels of `sums`, counted from `corner`, counted from the volume's first voxel.
void move(MomentSums& sums, const Index3& corner) {
  const std::array<__int128, 3> by = {corner.x, corner.y, corner.z};
  const auto count = static_cast<__int128>(sums.count);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t a = MomentSums::kPairs[i][0];
    const std::size_t b = MomentSums::kPairs[i][1];
    sums.second[i] += by[a] * sums.first[b] + by[b] * sums.first[a] + by[a] * by[b] * count;
  }
  for (std::size_t a = 0; a < 3; ++a) sums.first[a] += by[a] * count;
}

// Adds sums counted from `corner`.
void add(const SmallSums& sums, const Index3& corner, MomentSums& to) {
  MomentSums wide;
  wide.count = static_cast<std::uint64_t>(sums.count);
  for (std::size_t a = 0; a < 3; ++a) wide.first[a] = sums.first[a];
  for (std::size_t i = 0; i < 6; ++i) wide.second[i] = sums.second[i];
  move(wide, corner);
  to.add(wide);
}

// Adds the children of side `side` whose bits are set.
void add_children(std::uint64_t bits, std::int64_t side, const Index3& corner, MomentSums& to) {
  if (bits == 0) return;
  const SmallSums cells = sums_of_bits(bits);
  const __int128 s = side;
  const __int128 line = MomentSums::sum_below(side);  // of the offsets inside a child
  const __int128 squares = MomentSums::squares_below(side);
  MomentSums wide;
  wide.count = static_cast<std::uint64_t>(cells.count * side * side * side);
  for (std::size_t a = 0; a < 3; ++a) {
    const __int128 sum = cells.first[a];
    wide.first[a] = s * s * (s * s * sum + line * cells.count);
    wide.second[a] =
        s * s * (s * s * s * cells.second[a] + 2 * s * line * sum + squares * cells.count);
  }
  for (std::size_t i = 3; i < 6; ++i) {
    const __int128 sum =
        cells.first[MomentSums::kPairs[i][0]] + cells.first[MomentSums::kPairs[i][1]];
    wide.second[i] =
        s * (s * s * s * s * cells.second[i] + s * s * line * sum + line * line * cells.count);
  }
  move(wide, corner);
  to.add(wide);
}

// A stored cube and where it starts.
struct Place {
  std::uint64_t place = 0;
  Index3 corner;
};

class Walk {
 public:
  explicit Walk(const MaskTree& mask) : mask_(mask) {}

  void add_cube(int rank, std::uint64_t place, const Index3& corner, MomentSums& sums) const {
    const MaskCube& cube = mask_.cubes(rank)[place];
    const std::int64_t side = child_side(rank);
    add_children(cube.full, side, corner, sums);
    sums.box = united(sums.box, box_of_children(cube.full, corner, side));
    if (rank > 0) {
      for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        add_cube(rank - 1, cube.place_of(bit), child_box(corner, bit, side).lo, sums);
      }
      return;
    }
    const std::uint64_t* words = mask_.words().data() + cube.first;
    add(sums_of_words(cube.mixed, words), corner, sums);
    if (cube.mixed == 0 || sums.box.contains(box_of_children(cube.mixed, corner, side))) return;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const Index3 at = child_box(corner, std::countr_zero(left), side).lo;
      sums.box = united(sums.box, box_of_children(*words++, at, 1));
    }
  }

  // The stored cubes of rank 1; the full children above them go into `sums`.
  std::vector<Place> gather(MomentSums& sums) const {
    std::vector<Place> places;
    gather(mask_.rank_count() - 1, 0, {0, 0, 0}, sums, places);
    return places;
  }

 private:
  void gather(int rank, std::uint64_t place, const Index3& corner, MomentSums& sums,
              std::vector<Place>& places) const {
    if (rank == 1) {
      places.push_back({place, corner});
      return;
    }
    const MaskCube& cube = mask_.cubes(rank)[place];
    const std::int64_t side = child_side(rank);
    add_children(cube.full, side, corner, sums);
    sums.box = united(sums.box, box_of_children(cube.full, corner, side));
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      gather(rank - 1, cube.place_of(bit), child_box(corner, bit, side).lo, sums, places);
    }
  }

  const MaskTree& mask_;
};

}  // namespace

MomentSums mask_moments(const MaskTree& mask) {
  const Walk walk(mask);
  MomentSums above;
  const std::vector<Place> places = walk.gather(above);
  const MomentSums below = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, places.size(), 4), MomentSums{},
      [&](const tbb::blocked_range<std::size_t>& range, MomentSums sums) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          walk.add_cube(1, places[i].place, places[i].corner, sums);
        }
        return sums;
      },
      [](MomentSums a, const MomentSums& b) {
        a.add(b);
        return a;
      });
  above.add(below);
  return above;
}

}  // namespace octavo
