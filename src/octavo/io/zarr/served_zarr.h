// A volume as the files of a zarr hierarchy for a server, each made when it is asked for.
//
//     zarr.json          the OME-Zarr 0.5 group, down to the level that is one chunk
//     2/zarr.json        the array of level 2, its chunks uncompressed
//     2/c/0/1/7          64^3 voxels of it, decoded from the bricks that hold them
#pragma once

#include <memory>
#include <string>

#include "octavo/file/reader.h"
#include "octavo/io/serve/served_content.h"

namespace octavo {

/// Files of `reader` at keys behind an address that ends in "/". A chunk that cannot be decoded is
/// one that cannot be read: nothing is filled in.
/// name    of the image
/// Memory  a chunk for each answer; any number of threads
std::unique_ptr<ServedContent> zarr_content(std::shared_ptr<const FileReader> reader,
                                            const std::string& name);

}  // namespace octavo
