#include "octavo/mesh/decimation.h"

#include <optional>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/mesh/decimation_frame.h"
#include "octavo/mesh/decimation_rounds.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

Decimated decimate(const TriangleMesh& full, const DecimationOptions& options,
                   Progress& progress) {
  if (auto full_surface = undecimated(full, options, progress)) return *std::move(full_surface);
  const DecimationFrame frame(full, options);
  const DecimationProof proof = decimate_in_rounds(full, options, frame, nullptr, progress);
  if (!proof.is_proven) return frame.undecimated(proof.rounds, TriangleTree(full), progress);
  return frame.compacted(proof.surface.mesh, proof.rounds, proof.crossing_triangles);
}

void require_numbered(std::uint64_t triangle_count) {
  constexpr std::uint64_t kMost = TriangleTree::kNone;
  if (triangle_count <= kMost) return;
  throw Error(ErrorKind::limit_exceeded, "the surface has " + std::to_string(triangle_count) +
                                             " triangles, more than " + std::to_string(kMost))
      .with_field("level");
}

}  // namespace octavo
