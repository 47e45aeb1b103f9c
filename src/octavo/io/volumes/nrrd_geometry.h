// Where the voxels of a NRRD lie: spaces, directions, spacings, units.
#pragma once

#include <cstddef>
#include <vector>

#include "octavo/io/source/described_source.h"
#include "octavo/io/volumes/nrrd_header.h"

namespace octavo {

/// The axes of a NRRD, counted from 0, that are directions in space.
struct NrrdSpaceAxes {
  std::vector<std::size_t> axes;  ///< 2 or 3, the fastest first
  std::size_t axis_count = 0;     ///< of all axes of the file
};

/// Sets the geometry of facts.description in LPS and millimeters, and facts.spacing_known. Where
/// the header does not say where left is, axes and origin stay as in the file: a warning says so
/// and facts.place_known becomes false.
/// Throws Error{source_rejected} for a space of another name, for sheared axes, and naming the
///        field that is not usable
void read_nrrd_geometry(const NrrdHeader& header, const NrrdSpaceAxes& space,
                        const SourceOptions& options, SourceFacts& facts);

}  // namespace octavo
