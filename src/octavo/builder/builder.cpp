#include "octavo/builder/builder.h"

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <new>
#include <optional>
#include <span>

#include "octavo/builder/build_setup.h"
#include "octavo/builder/coarse_tiers.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/tier_encoder.h"
#include "octavo/builder/training.h"
#include "octavo/core/checked.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/writer.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
// Training and the file's own buffers.
constexpr std::uint64_t kFixedBytes = 192 * kMiB;

// Whether details can be left out of such a volume.
void check_keep_details(const VolumeDescription& description, const BuildOptions& options) {
  const auto reject = [](const std::string& why, const std::string& value = "") {
    throw Error(ErrorKind::invalid_argument, why).with_field("keep_details", value);
  };
  if (description.kind == VolumeKind::labels) {
    reject("label maps are always lossless: their details cannot be left out");
  }
  if (!is_integer(description.type)) {
    reject("details can be left out of integer voxels; these are float32");
  }
  if (options.max_error > 0) {
    reject("without details no max error is kept: one of them can be given");
  }
  if (options.access.value_or(Access::none) != Access::none) {
    reject("level 0 has no bytes to be cut into parts where its details are left out");
  }
  const int most = levels_of(description).tier_level_count(0) - 1;
  if (options.keep_details >= 1 && options.keep_details <= most) return;
  if (most == 0) reject("the volume has one level: it has no details");
  reject("details cannot be kept from level " + std::to_string(options.keep_details) + " on",
         most == 1 ? "1" : "1 to " + std::to_string(most));
}

void check_options(const VolumeDescription& description, const BuildOptions& options) {
  if (!std::isfinite(options.max_error) || options.max_error < 0) {
    throw Error(ErrorKind::invalid_argument, "a max error must be a number and not below 0");
  }
  if (options.max_error > 0 && description.rescale.slope == 0) {
    throw Error(ErrorKind::invalid_argument, "a max error needs a rescale slope other than 0");
  }
  if (options.keep_details != 0) check_keep_details(description, options);
  if (description.kind != VolumeKind::labels) return;
  if (options.max_error > 0) {
    throw Error(ErrorKind::invalid_argument, "label maps are always lossless")
        .with_field("max_error", "0");
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

std::optional<std::string> name_of(const std::optional<Access>& access) {
  if (!access) return std::nullopt;
  switch (*access) {
    case Access::none: return "none";
    case Access::slices: return "slices";
    case Access::boxes: return "boxes";
  }
  return std::nullopt;
}

// The metadata of the source with what was asked for, where that is not the default, and who codes
// the voxels.
// errors  of details that were left out, once they are known
Metadata recorded(const VolumeDescription& description, const BuildOptions& options,
                  const std::optional<DetailErrors>& errors = std::nullopt) {
  const bool is_float = !is_integer(description.type);
  CodingNote coding;
  if (options.preset == Preset::fast) coding.preset = "fast";
  coding.access = name_of(options.access);
  if (options.max_error > 0) coding.max_error = options.max_error;
  if (is_float) {
    coding.nan = options.repair.nan;
    coding.infinity = options.repair.infinity;
  }
  Metadata metadata = description.metadata;
  if (options.keep_details > 0) coding.keep_details = options.keep_details;
  coding.detail_errors = errors;
  const bool is_default = !coding.preset && !coding.access && !coding.max_error && !coding.nan &&
                          !coding.infinity && !coding.keep_details;
  if (!is_default) metadata.set_coding(coding);
  metadata.set_written_by(this_writer());
  return metadata;
}

// The errors of all voxels, and how they compare to the range of the voxels.
DetailErrors detail_errors_of(const WrittenErrors& written, const VolumeDescription& description) {
  const double slope = std::abs(description.rescale.slope);
  DetailErrors errors;
  errors.max = static_cast<double>(written.max_steps) * slope;
  errors.rms =
      std::sqrt(written.squared / static_cast<double>(description.size.voxel_count())) * slope;
  const auto range = static_cast<double>(written.range.max - written.range.min);
  if (written.squared > 0) {
    // Logarithms differ from machine to machine, in digits that say nothing.
    constexpr double kDigits = 100;
    errors.psnr_db = std::round(kDigits * 20 * std::log10(range * slope / *errors.rms)) / kDigits;
  }
  return errors;
}

// malloc keeps what a thread freed for that thread alone. Any of them may train next: in the end
// each would hold what training takes.
void return_freed_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

// How the bricks are made, as far as the header does not say it; options by their fields.
std::string settings_text(const BuildOptions& options) {
  std::string text = "program: " OCTAVO_VERSION "\n";
  text += std::string("preset: ") + (options.preset == Preset::fast ? "fast" : "small") + "\n";
  text += "access: " + name_of(options.access).value_or(kSettingNotGiven) + "\n";
  text += "max_error: " + exact_text(options.max_error) + "\n";
  text += "keep_details: " +
          (options.keep_details > 0 ? std::to_string(options.keep_details) : kSettingNotGiven) +
          "\n";
  const auto repair = [](const std::optional<float>& value) {
    return value ? exact_text(*value) : std::string(kSettingNotGiven);
  };
  text += "repair.nan: " + repair(options.repair.nan) + "\n";
  text += "repair.infinity: " + repair(options.repair.infinity) + "\n";
  return text + (options.has_thumbnail ? kThumbnailSetting
                                       : std::string("thumbnail: ") + kSettingNotGiven + "\n");
}

std::string crc_text(std::uint32_t crc) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", crc);
  return text;
}

// One build: the groups of tier 0, then the tiers made of parents.
class Build {
 public:
  Build(const VolumeDescription& description, const Levels& levels, int threads, Progress& progress,
        const BuildOptions& options, const ErrorBound& bound)
      : description_(description),
        levels_(levels),
        workers_(threads),
        progress_(progress),
        settings_{.preset = options.preset,
                  .max_error = bound.codes,
                  .access = options.access,
                  .detail_level = options.keep_details},
        bound_(bound) {}

  /// Encodes all groups; the writer is created once the first one is known. While a group is being
  /// encoded the next one is read and trained on. Returns the parents.
  std::vector<std::byte> encode_groups(GroupReader& reader, Storage& storage,
                                       const std::string& path, const WriterOptions& options) {
    std::optional<TierEncoder> encoder;
    for (std::size_t number = 0; !reader.is_done(); ++number) {
      const VoxelBlock group = reader.next();
      if (!writer_) {
        writer_ = FileWriter::create(storage, path, description_, levels_, content_hash_of(group),
                                     options);
        encoder.emplace(levels_, 0, group.type, workers_, *writer_, progress_, bound_);
      }
      encoder->check();
      const bool is_encoded = number < writer_->resumed().size();
      if (is_encoded) check_group(group, writer_->resumed()[number]);
      if (!is_encoded || number == 0) train(group);
      if (is_encoded) {
        if (number == 0) check_model();
        encoder->restore_parents(writer_->resumed()[number].parents);
        resumed_planes_ += group.size.z;
        progress_.advance(group.size.z);
        reader.release();
      } else {
        encoder->start(model_, group, true, [&reader] { reader.release(); });
      }
    }
    encoder->finish();
    return encoder->take_parents();
  }

  /// Encodes the tiers above tier 0.
  void encode_tiers(std::vector<std::byte> samples) {
    encode_coarse_tiers({description_, levels_, workers_, *writer_, progress_}, *first_model_,
                        settings_, std::move(samples));
  }

  WrittenErrors written_errors() const { return writer_->written_errors(); }

  /// metadata  in place of those that the file was begun with
  std::uint64_t finish(const Metadata& metadata) {
    writer_->set_metadata(metadata);
    writer_->finish();
    return writer_->bytes_written();
  }

  std::int64_t resumed_planes() const { return resumed_planes_; }

  /// The planes that the same build can continue behind when this one ends now.
  std::int64_t kept_planes() const {
    return writer_ && !is_other_ ? planes_in(levels_, writer_->kept_layers()) : 0;
  }

 private:
  // As the header says of all voxels, before the first brick.
  std::uint32_t content_hash_of(const VoxelBlock& block) const {
    if (block.floats == nullptr) return block.crc;
    const auto bytes =
        static_cast<std::size_t>(block.size.voxel_count() * bytes_per_voxel(block.type));
    return crc32c({reinterpret_cast<const std::uint8_t*>(block.voxels), bytes});
  }

  void train(const VoxelBlock& group) {
    // As the file holds it, so that whoever has the file or a part of it comes to the same models.
    const BrickCodec* const first = first_model_ ? first_model_->decoder.get() : nullptr;
    model_ = workers_.run([&] {
      return make_model(
          train_on(levels_, 0, group, description_.kind, settings_, description_.coding, first),
          description_.coded_type(), description_.coding, settings_.detail_level);
    });
    return_freed_memory();
    settings_.axis_order = model_.encoder->axis_order();
    if (!first_model_) first_model_ = model_;
  }

  // Proves that a group which an interrupted build encoded has the voxels it had then.
  void check_group(const VoxelBlock& group, const JournalGroup& stored) {
    is_other_ = true;
    const std::int64_t end = group.first_plane + group.size.z;
    if (planes_in(levels_, stored.end_layer) != end) throw other_version();
    is_other_ = stored.voxels_crc != group.crc;
    if (!is_other_) return;
    throw Error(ErrorKind::source_rejected,
                planes_text(group.first_plane, end, description_.size.z) +
                    " are not those of the interrupted build (checksum " +
                    crc_text(stored.voxels_crc) + " there, " + crc_text(group.crc) + " now)")
        .with_field("interrupted", "discard");
  }

  // Proves that the same voxels still give the same model.
  void check_model() {
    is_other_ = writer_->first_model() != model_.serialized;
    if (is_other_) throw other_version();
  }

  static Error other_version() {
    return Error(ErrorKind::invalid_argument,
                 "the interrupted build was made by another version of the program")
        .with_field("interrupted", "discard");
  }

  const VolumeDescription& description_;
  const Levels& levels_;
  Workers workers_;
  Progress& progress_;
  CodecSettings settings_;
  ErrorBound bound_;
  std::unique_ptr<FileWriter> writer_;
  Model model_;  ///< of the group that was trained on last
  std::optional<Model> first_model_;
  std::int64_t resumed_planes_ = 0;
  bool is_other_ = false;  ///< than the interrupted build that it was to continue
};

// The failure, and how to go on where something is kept.
Error with_kept(const Error& error, std::int64_t planes, std::int64_t count,
                const std::string& path) {
  if (planes == 0) return error;
  // Whose source it was that failed, the caller knows.
  const bool is_ours = error.path().empty() && error.kind() != ErrorKind::source_rejected;
  const Error kept = error.with_detail(error.detail() + "; " + planes_text(0, planes, count) +
                                       " are kept for " + escaped(base_name_of(path)));
  return (is_ours ? kept.with_path(path) : kept).with_field("interrupted", "resume");
}

BuildResult build(PlaneSource& source, Storage& storage, const std::string& path,
                  const BuildOptions& options, Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  // What is built, and whether memory will do
  VolumeDescription description = source.description();
  description.kind = options.kind;
  check_options(description, options);
  const VolumeDescription original = description;
  description.metadata = recorded(original, options);
  description.coding.reset();
  const Levels levels = levels_of(description);
  BuildResult result;
  result.threads = build_threads(options.threads);
  result.raw_bytes =
      checked_mul(static_cast<std::uint64_t>(description.size.voxel_count()),
                  static_cast<std::uint64_t>(bytes_per_voxel(description.type)), "the volume");
  check_build_memory(build_memory_bytes(description, result.threads, options.max_error) +
                   source.resident_bytes(),
               options.max_memory_bytes);

  // Whether the name is free
  check_target(storage, path, options.overwrite);
  if (options.interrupted == Interrupted::reject) {
    reject_running(storage, path);
    reject_interrupted(storage, path);
  }

  // Every plane passes twice: read, then coded.
  const ProgressScope scope(progress, options.progress_name, 2 * description.size.z,
                            "plane passes");
  // The maximum error in codes; floats become integers
  ErrorBound bound;
  std::optional<FloatPlanes> floats;
  result.max_error = options.max_error / std::abs(description.rescale.slope);
  if (is_integer(description.type)) {
    bound.codes = options.max_error == 0 ? 0 : whole_units(result.max_error, description.type);
    bound.detail_level = options.keep_details;
    result.max_error = static_cast<double>(bound.codes);
  } else {
    if (options.max_error == 0) result.max_error = 0;
    const std::int64_t first_planes = group_planes(levels, description.type);
    floats.emplace(source, FloatSettings{result.max_error, options.repair, first_planes}, progress);
    description.coding = result.coding = floats->coding();
    if (result.max_error > 0) {
      bound = {floats->codec_error(), result.max_error, floats->coding(),
               floats->roomier_error() * std::abs(description.rescale.slope)};
    }
  }

  // Group by group, then the tiers above
  Build work(description, levels, result.threads, progress, options, bound);
  WriterOptions writing;
  writing.overwrite = options.overwrite;
  writing.max_error = result.max_error;
  writing.has_thumbnail = options.has_thumbnail;
  writing.detail_level = options.keep_details;
  writing.is_resuming = options.interrupted == Interrupted::resume;
  writing.discards_interrupted = options.interrupted == Interrupted::discard;
  const bool is_one_group = group_planes(levels, description.coded_type()) == description.size.z;
  writing.has_journal = writing.is_resuming || (options.is_resumable && !is_one_group);
  writing.settings = settings_text(options);
  try {
    std::vector<std::byte> parents;
    {
      GroupReader reader(floats ? static_cast<PlaneSource&>(*floats) : source, levels, progress,
                         floats && result.max_error > 0 ? &*floats : nullptr);
      parents = work.encode_groups(reader, storage, path, writing);
      result.read_seconds = reader.read_seconds();
    }
    work.encode_tiers(std::move(parents));
    if (options.keep_details > 0) {
      const WrittenErrors errors = work.written_errors();
      result.max_error = static_cast<double>(errors.max_steps);
      result.detail_errors = detail_errors_of(errors, description);
    }
    result.file_bytes = work.finish(recorded(original, options, result.detail_errors));
  } catch (const std::bad_alloc&) {
    throw with_kept(out_of_build_memory(path), work.kept_planes(), description.size.z, path);
  } catch (const Error& error) {
    throw with_kept(error, work.kept_planes(), description.size.z, path);
  }
  result.resumed_planes = work.resumed_planes();
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
    throw out_of_build_memory(path);
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
  const auto workers = static_cast<std::uint64_t>(build_threads(threads)) * kThreadBytes;
  return checked_add(groups, workers + kFixedBytes, "the memory of a build");
}

}  // namespace octavo
