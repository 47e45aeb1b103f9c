// The leaves of an octree balanced 2:1 by p4est, and its trilinear nodes. Sees p4est and MPI alone.
//
// usage: bench_hexahedra_p4est LEAVES
//
// LEAVES  a text: the root's level, then the level of each leaf and the o-code of its first voxel,
//         ascending
//
// Prints the seconds of p8est_balance, those of its ghost layer and nodes, and its elements.

#include <p8est_bits.h>
#include <p8est_extended.h>
#include <p8est_ghost.h>
#include <p8est_lnodes.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <vector>

namespace {

struct Leaves {
  std::vector<std::uint64_t> firsts;
  std::vector<int> levels;
  int root_level = 0;
};

bool read_leaves(const char* path, Leaves& leaves) {
  std::ifstream in(path);
  in >> leaves.root_level;
  int level = 0;
  std::uint64_t first = 0;
  while (in >> level >> first) {
    leaves.levels.push_back(level);
    leaves.firsts.push_back(first);
  }
  return in.eof() && !leaves.levels.empty();
}

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The bits of y, x and z of an o-code, from the lowest.
std::uint64_t code_of(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 21; ++bit) {
    code |= (y >> bit & 1) << 3 * bit | (x >> bit & 1) << (3 * bit + 1) |
            (z >> bit & 1) << (3 * bit + 2);
  }
  return code;
}

/// A cube is refined where a leaf smaller than it lies in it.
int has_smaller(p8est_t* forest, p4est_topidx_t, p8est_quadrant_t* cube) {
  const auto& leaves = *static_cast<const Leaves*>(forest->user_pointer);
  const int shift = P8EST_MAXLEVEL - leaves.root_level;
  const int level = leaves.root_level - cube->level;
  const std::uint64_t code = code_of(static_cast<std::uint64_t>(cube->x >> shift),
                                     static_cast<std::uint64_t>(cube->y >> shift),
                                     static_cast<std::uint64_t>(cube->z >> shift));
  const auto found = std::lower_bound(leaves.firsts.begin(), leaves.firsts.end(), code);
  if (found == leaves.firsts.end() || *found >= code + (std::uint64_t{1} << 3 * level)) return 0;
  return leaves.levels[static_cast<std::size_t>(found - leaves.firsts.begin())] < level ? 1 : 0;
}

void measure(Leaves& leaves) {
  p8est_connectivity_t* const cube = p8est_connectivity_new_unitcube();
  p8est_t* const forest = p8est_new_ext(sc_MPI_COMM_WORLD, cube, 0, 0, 1, 0, nullptr, &leaves);
  p8est_refine(forest, 1, has_smaller, nullptr);
  const double begin = processor_seconds();
  p8est_balance(forest, P8EST_CONNECT_FULL, nullptr);
  const double balanced = processor_seconds();
  p8est_ghost_t* const ghost = p8est_ghost_new(forest, P8EST_CONNECT_FULL);
  p8est_lnodes_t* const nodes = p8est_lnodes_new(forest, ghost, 1);
  const double numbered = processor_seconds();
  std::printf("%.9f %.9f %lld\n", balanced - begin, numbered - balanced,
              static_cast<long long>(forest->local_num_quadrants));
  p8est_lnodes_destroy(nodes);
  p8est_ghost_destroy(ghost);
  p8est_destroy(forest);
  p8est_connectivity_destroy(cube);
}

}  // namespace

int main(int count, char** words) {
  sc_MPI_Init(&count, &words);
  sc_set_log_defaults(nullptr, nullptr, SC_LP_SILENT);
  Leaves leaves;
  const bool is_read = count == 2 && read_leaves(words[1], leaves);
  if (is_read) measure(leaves);
  else std::fprintf(stderr, "usage: bench_hexahedra_p4est LEAVES\n");
  sc_MPI_Finalize();
  return is_read ? 0 : 2;
}
