#include "octavo/tasks/files/verify_volume.h"

#include <memory>
#include <utility>

#include "octavo/builder/crypto_hasher.h"
#include "octavo/builder/float_planes.h"
#include "octavo/file/parallel_read.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/files/planes_between.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

VerifyReport checked(const std::string& path, const TaskContext& context) {
  return with_verify_options(
      path, context,
      [&](const std::shared_ptr<const ByteSource>& source, const VerifyOptions& options) {
        return verify_file(source, options, context.watcher());
      });
}

SourceCheck compared(const VerifyVolumeOptions& options,
                     const std::shared_ptr<const FileReader>& reader, const TaskContext& context) {
  const VolumeDescription& file = reader->description();
  FilePlanes planes(reader, 0, context.thread_count());
  auto opened = open_planes(options.against, options.scan, context);
  const Size3 opened_size = opened->description().size;
  const auto read = repeat_isotropic(options.against.front(), std::move(opened), file, context);
  const auto source = make_repaired_source(*read, repair_of(file));

  context.require_memory(compare_memory_bytes(planes, *source) + decoding_bytes(file, context),
                         "comparing layers of planes");
  SourceCheck check;
  check.source = source->description();
  check.has_planes_between = check.source.size != opened_size;
  // It is at most the promised one.
  check.allowed_error = reader->achieved_error();
  check.is_bounded = reader->max_error() > 0;
  check.comparison = compare_planes(planes, *source, check.allowed_error, context.watcher());
  return check;
}

/// Whether a scan stands where the file was expected, and the file in its place.
bool is_swapped(const Error& error, const VerifyVolumeOptions& options) {
  return error.kind() == ErrorKind::not_octavo && !is_octavo_path(options.input) &&
         options.against.size() == 1 && options.against.front().ends_with(".8vo");
}

VerifyReport checked_file(const VerifyVolumeOptions& options, const TaskContext& context) {
  try {
    return checked(options.input, context);
  } catch (const Error& error) {
    if (!is_swapped(error, options)) throw;
    throw Error(ErrorKind::invalid_argument,
                "no 8vo file, and " + options.against.front() +
                    " is one by its name: they stand in each other's place",
                options.input);
  }
}

}  // namespace

VerifyOptions verify_options(const TaskContext& context) {
  constexpr std::uint64_t kBytesPerThread = std::uint64_t{8} << 20;
  // Besides that, rows of bricks whose planes are hashed
  constexpr std::uint64_t kRowBytes = std::uint64_t{64} << 20;
  context.require_memory(
      kBytesPerThread * static_cast<std::uint64_t>(context.thread_count()) + kRowBytes,
      "decoding bricks on all threads");
  VerifyOptions options;
  options.for_each = for_each_parallel(context.thread_count());
  options.make_hasher = make_crypto_hasher;
  return options;
}

VerifyVolumeResult verify_volume(const VerifyVolumeOptions& options, const TaskContext& context) {
  if (options.against.empty()) require_scan_for_options({options.input}, options.scan);
  VerifyVolumeResult result{checked_file(options, context), {}, {}};
  if (!result.report.is_sound()) return result;
  TaskContext any_size = context;
  any_size.max_voxels = 0;  // what was proven is what is there, and no voxel of it is kept
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, any_size);
  result.volume = reader->description();
  if (!options.against.empty()) result.against = compared(options, reader, context);
  return result;
}

}  // namespace octavo
