// How much of a scan looks like another part of it, and what a code of references would save.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/tasks/result_facts.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct SelfSimilarityOptions {
  std::string input;  ///< a grey .8vo file or a URL of one
  /// The most by which a voxel of a cube may differ from that of the one it refers to, real units.
  double max_difference = 0;
  /// Means are taken away first: the tree holds those of all cubes anyway.
  bool is_up_to_mean = false;
  /// Another file of the same scan whose bytes are what references save, as one built within that
  /// max error; or nothing: those of `input`.
  std::string coded;
};

/// Cubes of one side.
struct SimilarityLevel {
  std::int64_t side = 0;           ///< voxels
  std::uint64_t cubes = 0;         ///< wholly in the volume
  std::uint64_t uniform = 0;       ///< of one value
  std::uint64_t asked = 0;         ///< for which another was looked for
  std::uint64_t same_level = 0;    ///< that equal another of the same side
  std::uint64_t next_level = 0;    ///< one of twice the side, halved
  std::uint64_t turned = 0;        ///< of both, turned or mirrored
  std::uint64_t cut_short = 0;     ///< given up after too many candidates
  double coded_bytes = 0;          ///< what the codec has of the cubes that refer
  double reference_bytes = 0;      ///< references and flags in their place

  double saved_bytes() const { return coded_bytes - reference_bytes; }
};

struct SelfSimilarityResult {
  VolumeDescription volume;
  std::uint64_t file_bytes = 0;           ///< of the coded file
  std::vector<SimilarityLevel> levels;    ///< the largest cubes first

  /// Of the levels that save anything.
  double saved_bytes() const;
};

/// The numbers of a level.
Facts similarity_facts(const SimilarityLevel& level);

/// Looks for cubes of side 16, 8 and 4 that equal another one: similar_cubes. The bytes of a cube
/// are those of the levels below its own in its brick, shared out by how much its voxels differ
/// from the means of their octants: sum of log2(1 + difference / step), the step 1, or as wide as
/// the max error of the coded file allows.
/// Throws  as open_volume; Error{invalid_argument} for labels, a negative difference, a coded file
///         of another size; Error{limit_exceeded}
/// Memory  4 bytes a voxel, and what similar_cubes takes
SelfSimilarityResult self_similarity(const SelfSimilarityOptions& options,
                                     const TaskContext& context);

}  // namespace octavo
