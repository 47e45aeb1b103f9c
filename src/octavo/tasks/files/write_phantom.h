// A test scan of any size, made plane by plane.
#pragma once

#include <variant>

#include "octavo/planes/phantom.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/files/plane_writer.h"

namespace octavo {

struct WritePhantomOptions {
  PhantomOptions phantom;
  Output output;  ///< .8vo, or plain voxels as .raw or .mhd
};

struct WritePhantomResult {
  VolumeDescription volume;
  std::variant<BuiltVolume, PlaneWriteResult> written;
};

/// Throws as make_phantom, build_file and write_plain_planes; Error{invalid_argument} for a name of
///        another format
WritePhantomResult write_phantom(const WritePhantomOptions& options, const TaskContext& context);

}  // namespace octavo
