#include "octavo/tasks/files/repair.h"

#include <filesystem>
#include <optional>
#include <utility>

#include "octavo/builder/crypto_hasher.h"
#include "octavo/core/error.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

namespace {

void require_output(const RepairOptions& options) {
  const std::string& path = options.output.path;
  if (!path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument, "repair writes .8vo files; name one", path);
  }
  std::error_code none;
  if (std::filesystem::equivalent(options.input, path, none)) {
    throw Error(ErrorKind::invalid_argument, "is the file to repair; name another output", path);
  }
  require_free(options.output);
}

BitRepairResult repaired_bits(const RepairOptions& options, const TaskContext& context) {
  BitRepairOptions how;
  how.overwrite = options.output.overwrite;
  how.for_each = for_each_parallel(context.thread_count());
  how.make_hasher = make_crypto_hasher;
  try {
    return repair_bits(local_storage(), options.input, options.output.path, how,
                       context.watcher());
  } catch (const Error& error) {
    const bool is_damage =
        error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::truncated;
    // With a field something else helps.
    throw is_damage && error.field().empty() ? error.with_field("repair.input") : error;
  }
}

}  // namespace

RepairResult repair(const RepairOptions& options, const TaskContext& context) {
  require_output(options);
  std::error_code none;
  const bool is_there = std::filesystem::exists(options.input, none);
  if (!is_there || is_growing_name(options.input)) {
    std::optional<SealResult> sealed =
        seal_interrupted(local_storage(), options.input, options.output.path,
                         {options.output.overwrite, context.threads}, context.watcher());
    if (sealed) return std::move(*sealed);
  }
  if (!is_there) {
    throw Error(ErrorKind::io, "no such file, and no interrupted build of it", options.input);
  }
  BitRepairResult result = repaired_bits(options, context);
  if (!result.is_sound()) return result;
  throw Error(ErrorKind::invalid_argument, "is sound: there is nothing to repair", options.input);
}

}  // namespace octavo
