#include "octavo/builder/build_outline.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "octavo/builder/build_setup.h"
#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

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
  if (is_integer(description.type) && options.repair != FloatRepair{}) {
    throw Error(ErrorKind::invalid_argument,
                std::string("only float32 voxels can be NaN or infinite; these are ") +
                    std::string(voxel_type_name(description.type)));
  }
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
  return kAccessNames[static_cast<std::size_t>(*access)];
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

}  // namespace

Metadata recorded_metadata(const VolumeDescription& description, const BuildOptions& options,
                           const std::optional<DetailErrors>& errors) {
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

ClippedVoxels clipped_of(const BuildOutline& outline, const ClippedListener& on_clipped) {
  if (!outline.floats) return {};
  const ClippedVoxels clipped = outline.floats->clipped();
  if (clipped.count > 0 && on_clipped) on_clipped(clipped);
  return clipped;
}

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

BuildOutline outline_build(const VolumeDescription& source, const BuildOptions& options) {
  VolumeDescription original = source;
  original.kind = options.kind;
  check_options(original, options);
  BuildOutline outline{original, original, levels_of(original), {}, {}, {}, {}};
  outline.description.metadata = recorded_metadata(original, options);
  outline.description.coding.reset();
  outline.writing.overwrite = options.overwrite;
  outline.writing.has_thumbnail = options.has_thumbnail;
  outline.writing.detail_level = options.keep_details;
  outline.writing.settings = settings_text(options);
  return outline;
}

void choose_bounds(BuildOutline& outline, PlaneSource& source, const BuildOptions& options,
                   Progress& progress, const FloatChoice* known, bool keeps_planes) {
  if (is_integer(outline.description.type)) {
    take_bounds(outline, options, {});
    return;
  }
  const double max_error =
      options.max_error == 0 ? 0 : options.max_error / std::abs(outline.description.rescale.slope);
  const FloatSettings settings{max_error, options.repair,
                               group_planes(outline.levels, outline.description.type),
                               keeps_planes};
  outline.floats = known != nullptr
                       ? std::make_unique<FloatPlanes>(source, settings, *known, progress)
                       : std::make_unique<FloatPlanes>(source, settings, progress);
  take_bounds(outline, options, outline.floats->choice());
}

void take_bounds(BuildOutline& outline, const BuildOptions& options,
                 const std::optional<FloatChoice>& floats) {
  VolumeDescription& description = outline.description;
  const double slope = std::abs(description.rescale.slope);
  double max_error = options.max_error / slope;
  ErrorBound& bound = outline.bound;
  if (is_integer(description.type)) {
    bound.codes = options.max_error == 0 ? 0 : whole_units(max_error, description.type);
    bound.detail_level = options.keep_details;
    max_error = static_cast<double>(bound.codes);
  } else {
    if (options.max_error == 0) max_error = 0;
    description.coding = floats.value().coding;
    if (description.coding->is_exact) max_error = 0;
    if (max_error > 0) {
      bound = {floats->codec_error, max_error, floats->coding, floats->roomier_error * slope};
    }
  }
  outline.writing.max_error = max_error;
  outline.settings = {.preset = options.preset,
                      .max_error = bound.codes,
                      .access = options.access,
                      .detail_level = options.keep_details};
}

}  // namespace octavo
