// What a build decides before it encodes a brick: in one piece or in parts, it decides the same.
#pragma once

#include <memory>
#include <optional>

#include "octavo/builder/builder.h"
#include "octavo/builder/float_planes.h"
#include "octavo/builder/tier_encoder.h"
#include "octavo/codec/brick_codec.h"
#include "octavo/core/levels.h"
#include "octavo/core/volume.h"
#include "octavo/file/write/writer.h"

namespace octavo {

struct BuildOutline {
  VolumeDescription original;     ///< the source's, of the kind that was asked for
  VolumeDescription description;  ///< that the file begins with; float32 with its coding
  Levels levels;
  ErrorBound bound;
  CodecSettings settings;         ///< without an axis order
  WriterOptions writing;          ///< max error, thumbnail, settings; nothing of other builds
  std::unique_ptr<FloatPlanes> floats;  ///< of a float32 source: what is read in its place

  /// What groups are read from.
  PlaneSource& planes(PlaneSource& source) const {
    return floats ? static_cast<PlaneSource&>(*floats) : source;
  }
  /// The floats that groups hold beside their codes; null where they hold none.
  const FloatPlanes* float_voxels() const {
    return writing.max_error > 0 ? floats.get() : nullptr;
  }
};

/// All but what depends on the voxels.
/// Throws  Error{invalid_argument} where a volume cannot be built so, Error{limit_exceeded}
BuildOutline outline_build(const VolumeDescription& source, const BuildOptions& options);

/// Fills in bound, settings, max error and, for float32, what planes of it decide.
/// source  read from its start, and outlives the outline
/// known   what other readers of the source have found; otherwise float planes are read for it
/// keeps_planes  as FloatSettings
/// Throws  as FloatPlanes
void choose_bounds(BuildOutline& outline, PlaneSource& source, const BuildOptions& options,
                   Progress& progress, const FloatChoice* known = nullptr,
                   bool keeps_planes = true);

/// The same for who reads no planes: without floats.
/// floats  for a float32 volume what its planes decided
void take_bounds(BuildOutline& outline, const BuildOptions& options,
                 const std::optional<FloatChoice>& floats);

/// The metadata of the source with what was asked for, where that is not the default, and who codes
/// the voxels.
/// errors  of details that were left out, once they are known
Metadata recorded_metadata(const VolumeDescription& original, const BuildOptions& options,
                           const std::optional<DetailErrors>& errors = std::nullopt);

/// The floats, of the planes that were read, which only level 0 holds. Where there are any,
/// `on_clipped` was told of them.
ClippedVoxels clipped_of(const BuildOutline& outline, const ClippedListener& on_clipped);

/// The errors of all voxels, and how they compare to the range of the voxels.
DetailErrors detail_errors_of(const WrittenErrors& written, const VolumeDescription& description);

}  // namespace octavo
