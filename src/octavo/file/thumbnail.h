// The thumbnail of a file: one plane of the volume as a small PNG.
//
// It follows from voxels and header alone, by a rule that fixes every byte: docs/format.md, section
// 7. So any program can make it anew, and prove the one that stands in a file.
#pragma once

#include "octavo/core/bytes.h"
#include "octavo/file/reader.h"

namespace octavo {

/// The PNG of a volume: at most 256 x 256 pixels and 256 KiB.
/// Throws  Error{corrupt} for damaged bricks; Error{cancelled}, Error{io}
/// Memory  2 MiB and the cache of the reader; decodes the bricks along one plane of the first level
///         that it fits into
Bytes thumbnail_of(const FileReader& reader);

/// Whether the thumbnail of a file is that of its volume, byte for byte. Throws as thumbnail_of
bool has_true_thumbnail(const FileReader& reader);

}  // namespace octavo
