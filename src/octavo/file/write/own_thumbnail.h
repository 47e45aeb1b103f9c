// The thumbnail of a file that is being written.
#pragma once

#include "octavo/core/levels.h"
#include "octavo/file/directory.h"
#include "octavo/file/index.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// The thumbnail of a growing file, read back from what it holds already.
/// file    ends with its index pages
/// header  says where they are
/// Throws  Error{io, corrupt} where other bytes come back than were written
/// Memory  that of a reader with a small cache
Part own_thumbnail(const StorageFile& file, const FileHeader& header, const IndexRoot& root,
                   const Levels& levels);

}  // namespace octavo
