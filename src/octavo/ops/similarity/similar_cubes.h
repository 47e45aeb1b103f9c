// Cubes of the octree that look like another cube of their own or of the next coarser level,
// however it is turned or mirrored: what a fractal code would replace by a reference.
//
//     cubes of side 16, then 8, then 4, each level in o-code order
//
//     . . . a . . . . b .      b refers to a when some of the 48 turns lays a onto it within T;
//     . A A . . . . . . .      to A when the means of A's octants of voxels do
//     . A A . . . . . . .      only cubes that come before it, so that a decoder has them
//
// Nobody compares all with all. Numbers that no turn changes are hashed (cube_turns.h): a cube is
// compared with those alone whose numbers are all within T of its own.
//
// Invariants
//   What a reference points to is not itself replaced, whole or in part: voxels change by at most
//   T.
// Consequences
//   A cube that others refer to keeps its voxels, though smaller cubes in it might have matched.
//
// Source  thesis 5.1
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/progress.h"

namespace octavo {

struct SimilarityOptions {
  std::int32_t max_difference = 0;  ///< T, at every voxel
  bool is_up_to_mean = false;       ///< compares what is left when each cube's mean is taken away
};

struct CubeReference {
  Index3 corner;             ///< of the cube that is replaced
  bool is_coarser = false;   ///< it refers to a cube of the next level
  bool is_turned = false;    ///< turned or mirrored
};

/// What was found among cubes of one side.
struct SimilarCubes {
  int level = 0;               ///< their side is 2^level
  std::uint64_t cubes = 0;     ///< that lie wholly in the volume
  std::uint64_t uniform = 0;   ///< of one value: they need no reference
  std::uint64_t asked = 0;     ///< neither uniform, nor in a larger one that was replaced, nor in
                               ///< use by one
  std::vector<CubeReference> references;
  /// Bits of all references, and of the flags that say which cubes have one: which cube of those
  /// that were there, which turn; flags by their entropy.
  double reference_bits = 0;
  /// Cubes that had more neighbors in the hash than are looked at and found none among these.
  std::uint64_t cut_short = 0;
};

/// Levels 4, 3 and 2. Uses the threads of the calling task arena; does not depend on them.
/// voxels  [z][y][x], within +-2^30
/// Throws  Error{cancelled}
/// Memory  a byte for 64 voxels, and about 200 bytes for each cube of a level
std::vector<SimilarCubes> similar_cubes(std::span<const std::int32_t> voxels, const Size3& size,
                                        const SimilarityOptions& options, Progress& progress);

}  // namespace octavo
