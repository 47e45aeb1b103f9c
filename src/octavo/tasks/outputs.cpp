#include "octavo/tasks/outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "octavo/builder/build_memory.h"
#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/memory_limit.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

/// Memory of this machine; 0 where it does not say.
std::uint64_t machine_memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return 0;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
}

}  // namespace

void require_folder_around(const std::string& path) {
  switch (local_storage().path_type(folder_of(path))) {
    case PathType::folder: break;
    case PathType::missing:
      throw Error(ErrorKind::io, "cannot create: its folder does not exist; make it first", path);
    default: throw Error(ErrorKind::io, "cannot create: Not a directory", path);
  }
  const std::string why = local_storage().why_closed(folder_of(path));
  if (!why.empty()) throw Error(ErrorKind::io, "cannot create: " + why, path);
}

void require_free(const Output& output) {
  const std::string& path = output.path;
  if (base_name_of(path).size() > kMaxNameBytes) {
    throw Error(ErrorKind::io, "its name is longer than 255 bytes", path);
  }
  switch (local_storage().path_type(path)) {
    case PathType::missing: return require_folder_around(path);
    case PathType::folder: throw Error(ErrorKind::io, "is a folder; name the file to write", path);
    case PathType::other:
      throw Error(ErrorKind::io, "exists and is not a regular file; choose another name", path);
    default: break;
  }
  if (!output.overwrite) {
    throw Error(ErrorKind::io, "exists already", path).with_field("output.overwrite");
  }
  require_folder_around(path);
}

void require_no_input(const std::string& path, const std::vector<std::string>& inputs) {
  std::error_code none;
  for (const std::string& input : inputs) {
    if (!std::filesystem::equivalent(path, input, none)) continue;
    throw Error(ErrorKind::invalid_argument, "is the input itself; name another output", path);
  }
}

void require_apart(const std::vector<std::string>& outputs) {
  std::set<std::filesystem::path> places;
  for (const std::string& output : outputs) {
    if (output.empty()) continue;
    if (places.insert(std::filesystem::weakly_canonical(output)).second) continue;
    throw Error(ErrorKind::invalid_argument, "is to hold two results; name another output", output);
  }
}

void require_computed(const Output& output, const std::vector<std::string>& inputs) {
  if (!is_octavo_path(output.path)) {
    throw Error(ErrorKind::invalid_argument, "the result is an .8vo file", output.path)
        .with_field("output.format");
  }
  require_free(output);
  require_no_input(output.path, inputs);
}

void require_room_for(const VolumeDescription& volume, const BuildOptions& options,
                      std::uint64_t source_bytes, const Output& output, const char* advice) {
  const bool is_limited = options.max_memory_bytes != 0;
  const std::uint64_t limit = is_limited ? options.max_memory_bytes : machine_memory_bytes();
  const char* field = "";
  try {
    checked_voxel_count(volume.size);
    if (is_limited) field = "max_memory_bytes";
    require_memory_within(
        build_memory_bytes(volume, options.threads, options.max_error) + source_bytes, limit,
        "a result of " + size_text(volume.size) + " voxels",
        is_limited ? advice : std::string("that is all this machine has; ") + advice);
  } catch (const Error& error) {
    throw error.with_path(output.path).with_field(field);
  }
}

ClippedListener clipped_listener(const std::string& path, const TaskContext& context) {
  return [path, context](const ClippedVoxels& clipped) {
    const bool is_one = clipped.count == 1;
    const auto [farthest, limit] =
        unlike_texts(clipped.farthest, std::copysign(clipped.limit, clipped.farthest));
    context.warn(fmt::format("{}: {} beyond what coarse levels hold, {}at {}: there {} as {}; "
                             "level 0 has {}",
                             path, counted_text(clipped.count, "voxel lies", "voxels lie"),
                             is_one ? "" : "the farthest ", farthest,
                             is_one ? "it counts" : "they count",
                             limit,
                             is_one ? "it as it is" : "them as they are"));
  };
}

BuildOptions build_options_for(const TaskContext& context, const Output& output,
                               const std::string& work, BuildOptions options) {
  options.overwrite = output.overwrite;
  const bool is_resuming = options.interrupted == Interrupted::resume;
  if (output.overwrite && !is_resuming) options.interrupted = Interrupted::discard;
  options.threads = context.threads;
  options.max_memory_bytes = context.max_memory_bytes;
  options.progress_name = work;
  options.has_thumbnail = output.has_thumbnail;
  options.on_clipped = clipped_listener(output.path, context);
  return options;
}

}  // namespace octavo
