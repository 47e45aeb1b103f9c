// OME-Zarr images and plain arrays of zarr as planes: versions 2 and 3, with shards or without.
//
//     chunks of an array        what is held of it
//     +--+--+--+--+
//     |  |  |  |  |             one layer of chunks: all that hold plane z, unpacked side by side
//     +--+--+--+--+
//
// A layer is read when its first plane is asked for. Chunks that are not there have the fill value.
#pragma once

#include <memory>
#include <string>

#include "octavo/io/source_options.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// True for folders that hold the texts of zarr, and for files named .ozx.
bool is_zarr_source(const std::string& path);

/// path    an image, one of its arrays, or a plain array with axes z, y, x
/// level   of an image: its array that becomes the volume; a path to an array says it by itself
/// Throws  Error{source_rejected} naming the file for what is not read, damaged, or leads out of
///         the folder; Error{limit_exceeded} where a layer of chunks is larger than
///         options.max_memory_bytes; Error{invalid_argument} for a level that is not there
/// Memory  a layer of chunks, and of those being unpacked one for each thread
std::unique_ptr<PlaneSource> open_zarr_source(const std::string& path,
                                              const SourceOptions& options, int level = 0);

}  // namespace octavo
