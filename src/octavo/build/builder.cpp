#include "octavo/build/builder.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
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

void check_options(const VolumeDescription& description, const BuildOptions& options) {
  if (!std::isfinite(options.max_error) || options.max_error < 0) {
    throw Error(ErrorKind::invalid_argument, "a max error must be a number and not below 0");
  }
  if (options.max_error > 0 && description.rescale.slope == 0) {
    throw Error(ErrorKind::invalid_argument, "a max error needs a rescale slope other than 0");
  }
  if (description.kind != VolumeKind::labels) return;
  if (options.max_error > 0) {
    throw Error(ErrorKind::invalid_argument, "label maps are always lossless; leave the max error");
  }
  if (!is_integer(description.type)) {
    throw Error(ErrorKind::invalid_argument, "labels are integers; these voxels are float32");
  }
}

// What integers may be changed by: whole stored units. A quotient that misses a whole number by
// the rounding of the division alone counts as that number.
std::int64_t whole_units(double max_error, VoxelType type) {
  constexpr double kDivisionRounding = 1e-12;
  const ValueRange range = value_range(type);
  const double units = std::floor(max_error * (1 + kDivisionRounding));
  return static_cast<std::int64_t>(std::min(units, static_cast<double>(range.max - range.min)));
}

std::string number_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

// The metadata of the source with what was asked for, where that is not the default.
std::string recorded(const VolumeDescription& description, const BuildOptions& options) {
  const std::string& metadata = description.metadata_json;
  const bool is_float = !is_integer(description.type);
  std::string record;
  const auto add = [&](const std::string& name, const std::string& value) {
    record += (record.empty() ? "\"" : ",\"") + name + "\":" + value;
  };
  if (options.preset == Preset::fast) add("preset", "\"fast\"");
  if (options.max_error > 0) add("max_error", number_text(options.max_error));
  if (is_float && options.repair.nan) add("nan", number_text(*options.repair.nan));
  if (is_float && options.repair.infinity) add("inf", number_text(*options.repair.infinity));
  const std::size_t end = metadata.rfind('}');
  if (record.empty() || end == std::string::npos) return metadata;
  const std::size_t last = metadata.find_last_not_of(" \t\r\n", end - 1);
  const bool is_empty = last == std::string::npos || metadata[last] == '{';
  return metadata.substr(0, end) + (is_empty ? "" : ",") + "\"coding\":{" + record + "}}";
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
  /// max_error  that the header promises, voxel units
  Build(const VolumeDescription& description, const Levels& levels, int threads, Progress& progress,
        Preset preset, const ErrorBound& bound, double max_error)
      : description_(description),
        levels_(levels),
        workers_(threads),
        progress_(progress),
        settings_{preset, bound.codes},
        bound_(bound),
        max_error_(max_error) {}

  /// Encodes all groups; the writer is created once the first one is known. While a group is being
  /// encoded the next one is read and trained on. Returns the parents.
  std::vector<std::byte> encode_groups(GroupReader& reader, Storage& storage,
                                       const std::string& path, bool overwrite) {
    std::optional<TierEncoder> encoder;
    while (!reader.is_done()) {
      const VoxelBlock group = reader.next();
      if (!writer_) {
        writer_ = FileWriter::create(storage, path, description_, levels_, content_hash_of(group),
                                     {.overwrite = overwrite, .max_error = max_error_});
        encoder.emplace(levels_, 0, group.type, workers_, *writer_, progress_, bound_);
      }
      encoder->check();
      const Model model = workers_.run([&] {
        return make_model(train_on(levels_, 0, group, description_.kind, settings_), group.type);
      });
      settings_.axis_order = model.encoder->axis_order();
      if (!first_model_) first_model_ = model;
      encoder->start(model, group, true, [&reader] { reader.release(); });
    }
    encoder->finish();
    return encoder->take_parents();
  }

  /// Encodes the tiers above tier 0 exactly, all with the first group's model or, where that one
  /// changes voxels, with an untrained one: they are too small to learn from.
  void encode_tiers(std::vector<std::byte> samples) {
    const VoxelType type = description_.coded_type();
    if (bound_.codes > 0 && levels_.tier_count() > 1) {
      CodecSettings exact = settings_;
      exact.max_error = 0;
      first_model_ = make_model(train_model(description_.kind, type, {}, exact), type);
      writer_->add_model(first_model_->serialized);
    }
    for (int tier = 1; tier < levels_.tier_count(); ++tier) {
      const Size3& size = levels_.size(Levels::first_level(tier));
      TierEncoder encoder(levels_, tier, type, workers_, *writer_, progress_);
      encoder.encode(*first_model_, {samples.data(), type, size, 0});
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
  CodecSettings settings_;
  ErrorBound bound_;
  double max_error_;
  std::unique_ptr<FileWriter> writer_;
  std::optional<Model> first_model_;
};

BuildResult build(PlaneSource& source, Storage& storage, const std::string& path,
                  const BuildOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  VolumeDescription description = source.description();
  description.kind = options.kind;
  description.metadata_json = recorded(description, options);
  description.coding.reset();
  check_options(description, options);
  const Levels levels = levels_of(description);
  BuildResult result;
  result.threads = thread_count(options.threads);
  result.raw_bytes =
      checked_mul(static_cast<std::uint64_t>(description.size.voxel_count()),
                  static_cast<std::uint64_t>(bytes_per_voxel(description.type)), "the volume");
  check_memory(build_memory_bytes(description, result.threads, options.max_error) +
                   source.resident_bytes(),
               options.max_memory_bytes);

  check_target(storage, path, options.overwrite);

  const ProgressScope scope(progress, 2 * description.size.z);
  ErrorBound bound;
  std::optional<FloatPlanes> floats;
  result.max_error = options.max_error / std::abs(description.rescale.slope);
  if (is_integer(description.type)) {
    bound.codes = options.max_error == 0 ? 0 : whole_units(result.max_error, description.type);
    result.max_error = static_cast<double>(bound.codes);
  } else {
    if (options.max_error == 0) result.max_error = 0;
    const std::int64_t first_planes = group_planes(levels, description.type);
    floats.emplace(source, FloatSettings{result.max_error, options.repair, first_planes}, progress);
    description.coding = result.coding = floats->coding();
    bound = {floats->codec_error(), result.max_error, floats->coding(),
             floats->roomier_error() * std::abs(description.rescale.slope)};
  }

  Build work(description, levels, result.threads, progress, options.preset, bound,
             result.max_error);
  std::vector<std::byte> parents;
  {
    GroupReader reader(floats ? static_cast<PlaneSource&>(*floats) : source, levels, progress,
                       floats && result.max_error > 0 ? &*floats : nullptr);
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

std::uint64_t build_memory_bytes(const VolumeDescription& description, int threads,
                                 double max_error) {
  const Levels levels = levels_of(description);
  const auto planes = static_cast<std::uint64_t>(group_planes(levels, description.type));
  const auto plane_bytes = static_cast<std::uint64_t>(description.size.x * description.size.y *
                                                      bytes_per_voxel(description.type));
  // float32: the planes read for the coding; with a max error the voxels beside their codes.
  const std::uint64_t count = is_integer(description.type) ? 2 : max_error > 0 ? 5 : 3;
  const std::uint64_t groups = checked_mul(count * planes, plane_bytes, "the memory of groups");
  const auto workers = static_cast<std::uint64_t>(thread_count(threads)) * kThreadBytes;
  return checked_add(groups, workers + kFixedBytes, "the memory of a build");
}

}  // namespace octavo
