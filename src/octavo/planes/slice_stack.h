// A stack of slices that stand in a file each, so that some of them can be opened apart.
//
// Invariants
//   A plane is made of one slice, or of two that follow each other; what else it takes is here.
// Consequences
//   Planes come out the same from a few files as from all of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/planes/plane_files.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

struct SliceStack {
  VolumeDescription description;
  PlaneFiles files;  ///< with SliceOutline
};

/// The stack that a source reads; nothing where its files cannot be opened apart.
std::optional<SliceStack> slice_stack_of(const PlaneSource& source);

/// A stack of some slices, of which planes first .. end of another are made.
/// Requires first < end, a SliceOutline
struct SliceExcerpt {
  std::vector<std::string> paths;
  SliceOutline outline;  ///< of the planes of the excerpt alone
};
SliceExcerpt excerpt_of(const PlaneFiles& files, std::int64_t first, std::int64_t end);

/// Proves that planes are made of slices that are there, and of files that hold them.
/// Returns  what is wrong, or nothing
std::string fault_of(const SliceStack& stack);

}  // namespace octavo
