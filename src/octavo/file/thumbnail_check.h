// Whether the thumbnail of a file is the one of its volume.
#pragma once

#include <optional>

#include "octavo/core/progress.h"
#include "octavo/file/damage.h"
#include "octavo/file/open_file.h"

namespace octavo {

/// What is wrong with the thumbnail of an otherwise sound file, if it has one.
/// watcher  whether to stop
/// Throws   as thumbnail_of
std::optional<Damage> thumbnail_damage(const OpenFile& file, const Progress& watcher);

}  // namespace octavo
