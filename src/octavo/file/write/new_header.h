// The header that a file is begun with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "octavo/file/write/writer.h"

namespace octavo {

/// Metadata of large files end in as many spaces at least, and fill blocks.
inline constexpr std::size_t kMetadataRoom = 256;
inline constexpr std::size_t kMetadataBlock = 512;

/// Throws Error{internal}: a writer was not used as its header says.
[[noreturn]] void misused(const std::string& what);

/// Throws Error{limit_exceeded} where metadata are too long for a file.
void check_room(const Metadata& metadata);

/// The header, unsealed and without sections.
/// Throws Error{invalid_argument} for a geometry or a rescale that no file holds,
///        Error{limit_exceeded}, Error{internal}
FileHeader new_header(const VolumeDescription& description, const Levels& levels,
                      std::uint32_t content_hash, const WriterOptions& options);

}  // namespace octavo
