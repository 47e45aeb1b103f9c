#include "octavo/ops/measure/mask_moments.h"

#include <bit>
#include <vector>

#include "octavo/ops/measure/cube_moments.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

// A stored cube and where it starts.
struct Place {
  std::uint64_t place = 0;
  Index3 corner;
};

class Traversal {
 public:
  explicit Traversal(const MaskTree& mask) : mask_(mask) {}

  void add_cube(int rank, std::uint64_t place, const Index3& corner, MomentSums& sums) const {
    const MaskCube& cube = mask_.cubes(rank)[place];
    const std::int64_t side = child_side(rank);
    add_children(cube.full, side, corner, sums);
    if (rank > 0) {
      for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        add_cube(rank - 1, cube.place_of(bit), child_box(corner, bit, side).lo, sums);
      }
      return;
    }
    add_words(cube.mixed, mask_.words().data() + cube.first, corner, sums);
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
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      gather(rank - 1, cube.place_of(bit), child_box(corner, bit, side).lo, sums, places);
    }
  }

  const MaskTree& mask_;
};

}  // namespace

MomentSums mask_moments(const MaskTree& mask) {
  const Traversal traversal(mask);
  MomentSums above;
  const std::vector<Place> places = traversal.gather(above);
  const MomentSums below = parallel_reduce(
      std::size_t{0}, places.size(), 4, MomentSums{},
      [&](std::size_t begin, std::size_t end, MomentSums sums) {
        for (std::size_t i = begin; i < end; ++i) {
          traversal.add_cube(1, places[i].place, places[i].corner, sums);
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
