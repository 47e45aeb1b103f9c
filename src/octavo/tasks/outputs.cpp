#include "octavo/tasks/outputs.h"

#include <filesystem>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

void require_free(const Output& output) {
  const std::string& path = output.path;
  if (base_name_of(path).size() > kMaxNameBytes) {
    throw Error(ErrorKind::io, "its name is longer than 255 bytes", path);
  }
  switch (local_storage().path_type(path)) {
    case PathType::missing: return;
    case PathType::folder: throw Error(ErrorKind::io, "is a folder; name the file to write", path);
    case PathType::other:
      throw Error(ErrorKind::io, "exists and is not a regular file; choose another name", path);
    default: break;
  }
  if (output.overwrite) return;
  throw Error(ErrorKind::io, "exists already", path).with_field("output.overwrite");
}

void require_computed(const Output& output, const std::vector<std::string>& inputs) {
  if (!is_octavo_path(output.path)) {
    throw Error(ErrorKind::invalid_argument, "the result is an .8vo file", output.path)
        .with_field("output.format");
  }
  require_free(output);
  std::error_code none;
  for (const std::string& input : inputs) {
    if (!std::filesystem::equivalent(output.path, input, none)) continue;
    throw Error(ErrorKind::invalid_argument, "is the input itself; name another output",
                output.path);
  }
}

BuildOptions build_options_for(const TaskContext& context, const Output& output,
                               const std::string& work, BuildOptions options) {
  options.overwrite = output.overwrite;
  const bool is_resuming = options.interrupted == Interrupted::resume;
  if (output.overwrite && !is_resuming) options.interrupted = Interrupted::discard;
  options.threads = context.threads;
  options.max_memory_bytes = context.max_memory_bytes;
  options.progress_name = work;
  return options;
}

}  // namespace octavo
