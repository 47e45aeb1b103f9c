// A file written again with another description: its bricks are copied, not decoded.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/core/volume.h"
#include "octavo/file/storage/byte_source.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// Writes `path` with the bricks and models of `source` and the place and metadata of
/// `description`. The checksum of every part is proven on the way. The file is the one that a build
/// of the same voxels under that description gives, but for the build id where details were left
/// out, and as far from their source. A thumbnail is
/// made anew; parts of others are kept unless they follow from more than the voxels, or from the
/// voxels where the place is another one.
/// description  of the kind, type, size, rescale and coding of the file, and with the same halvings
/// Returns      the bytes of the new file
/// Throws       Error{invalid_argument} for another kind of volume; Error{io} where the target
///              exists (without overwrite) or cannot be written, or an interrupted build of it
///              waits; Error{cancelled}; what FileReader::open and read_piece throw. Then nothing
///              stands under `path`
/// Memory       one brick and the index
std::uint64_t copy_described(std::shared_ptr<const ByteSource> source,
                             const VolumeDescription& description, Storage& storage,
                             const std::string& path, bool overwrite, Progress& progress);

}  // namespace octavo
