// Whether a file that is joined in steps still holds what was put into it. Its parts may be gone,
// and what lies on a disk for days, or is carried from one to another, may be changed there.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/dist/join_layout.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// The checksum of the bytes of a file that are no part's, JoinLayout::own_crc.
/// Throws Error{io, truncated}
std::uint32_t crc_of_own_bytes(const JoinLayout& layout, const StorageFile& file);

/// Of these parts those of which a file holds other bytes than were laid out.
/// threads  that read side by side
/// Throws   Error{io, truncated, cancelled}
std::vector<PartPlace> damaged_copies(const JoinLayout& layout,
                                      const std::vector<PartPlace>& places,
                                      const StorageFile& file, int threads, Progress& progress);

}  // namespace octavo
