#include "octavo/build/builder.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <optional>
#include <span>
#include <thread>

#include "octavo/build/group_reader.h"
#include "octavo/build/tier_encoder.h"
#include "octavo/build/training.h"
#include "octavo/codec/crc32c.h"
#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/file/writer.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kThreadBytes = 24 * kMiB;
// Training and the file's own buffers.
constexpr std::uint64_t kFixedBytes = 192 * kMiB;

int thread_count(int wanted) {
  if (wanted > 0) return wanted;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Levels levels_of(const VolumeDescription& description) {
  checked_voxel_count(description.size);
  return {description.size, choose_halvings(description.size, description.geometry.spacing_mm)};
}

void check_type(const VolumeDescription& description) {
  if (is_integer(description.type)) return;
  throw Error(
      ErrorKind::invalid_argument,
      "voxel type float32 is not supported by the codec; rescale the volume to integers first");
}

void check_memory(std::uint64_t needed_bytes, std::uint64_t limit_bytes) {
  if (limit_bytes == 0 || needed_bytes <= limit_bytes) return;
  throw Error(ErrorKind::limit_exceeded,
              "the build needs about " + std::to_string((needed_bytes + kMiB - 1) / kMiB) +
                  " MiB of memory; the limit is " + std::to_string(limit_bytes / kMiB) +
                  " MiB; raise the limit or use fewer threads");
}

// Announces the work, and its end however it comes. Every plane passes twice: read, then coded.
class ProgressScope {
 public:
  ProgressScope(Progress& progress, std::int64_t planes) : progress_(progress) {
    progress_.begin("build", planes, "plane passes");
  }
  ~ProgressScope() { progress_.end(); }
  ProgressScope(const ProgressScope&) = delete;
  ProgressScope& operator=(const ProgressScope&) = delete;

 private:
  Progress& progress_;
};

std::uint32_t content_hash_of(const VoxelBlock& block) {
  const auto bytes =
      static_cast<std::size_t>(block.size.voxel_count() * bytes_per_voxel(block.type));
  return crc32c({reinterpret_cast<const std::uint8_t*>(block.voxels), bytes});
}

// One build: the groups of tier 0, then the tiers made of parents.
class Build {
 public:
  Build(const VolumeDescription& description, const Levels& levels, int threads, Progress& progress)
      : description_(description), levels_(levels), workers_(threads), progress_(progress) {}

  /// Encodes all groups; the writer is created once the first one is known. Returns the parents.
  std::vector<std::byte> encode_groups(GroupReader& reader, Storage& storage,
                                       const std::string& path, bool overwrite) {
    std::optional<TierEncoder> encoder;
    while (!reader.is_done()) {
      const VoxelBlock group = reader.next();
      if (!writer_) {
        writer_ = FileWriter::create(storage, path, description_, levels_, content_hash_of(group),
                                     {.overwrite = overwrite});
        encoder.emplace(levels_, 0, description_.type, workers_, *writer_, progress_);
      }
      Model model = workers_.run([&] {
        return make_model(train_on(levels_, 0, group, description_.kind), description_.type);
      });
      writer_->add_model(model.serialized);
      encoder->encode(model, group);
      if (!first_model_) first_model_ = std::move(model);
    }
    return encoder->take_parents();
  }

  /// Encodes the tiers above tier 0, all with the first group's model.
  void encode_tiers(std::vector<std::byte> samples) {
    for (int tier = 1; tier < levels_.tier_count(); ++tier) {
      const Size3& size = levels_.size(Levels::first_level(tier));
      TierEncoder encoder(levels_, tier, description_.type, workers_, *writer_, progress_);
      encoder.encode(*first_model_, {samples.data(), description_.type, size, 0});
      samples = encoder.take_parents();
    }
  }

  std::uint64_t finish() {
    writer_->finish();
    return writer_->bytes_written();
  }

 private:
  const VolumeDescription& description_;
  const Levels& levels_;
  Workers workers_;
  Progress& progress_;
  std::unique_ptr<FileWriter> writer_;
  std::optional<Model> first_model_;
};

BuildResult build(PlaneSource& source, Storage& storage, const std::string& path,
                  const BuildOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  VolumeDescription description = source.description();
  description.kind = options.kind;
  check_type(description);
  const Levels levels = levels_of(description);
  BuildResult result;
  result.threads = thread_count(options.threads);
  result.raw_bytes =
      checked_mul(static_cast<std::uint64_t>(description.size.voxel_count()),
                  static_cast<std::uint64_t>(bytes_per_voxel(description.type)), "the volume");
  check_memory(build_memory_bytes(description, result.threads) + source.resident_bytes(),
               options.max_memory_bytes);

  check_target(storage, path, options.overwrite);

  const ProgressScope scope(progress, 2 * description.size.z);
  Build work(description, levels, result.threads, progress);
  std::vector<std::byte> parents;
  {
    GroupReader reader(source, levels, progress);
    parents = work.encode_groups(reader, storage, path, options.overwrite);
    result.read_seconds = reader.read_seconds();
  }
  work.encode_tiers(std::move(parents));
  result.file_bytes = work.finish();
  result.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

BuildResult build_file(PlaneSource& source, Storage& storage, const std::string& path,
                       const BuildOptions& options, Progress& progress) {
  try {
    return build(source, storage, path, options, progress);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorKind::out_of_memory,
                "out of memory while building; use fewer threads (about 24 MiB each)", path);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::internal) throw error.with_path(path);
    throw;
  }
}

std::uint64_t build_memory_bytes(const VolumeDescription& description, int threads) {
  const Levels levels = levels_of(description);
  const auto planes = static_cast<std::uint64_t>(group_planes(levels, description.type));
  const auto plane_bytes = static_cast<std::uint64_t>(description.size.x * description.size.y *
                                                      bytes_per_voxel(description.type));
  const std::uint64_t groups = checked_mul(2 * planes, plane_bytes, "the memory of two groups");
  const auto workers = static_cast<std::uint64_t>(thread_count(threads)) * kThreadBytes;
  return checked_add(groups, workers + kFixedBytes, "the memory of a build");
}

}  // namespace octavo
