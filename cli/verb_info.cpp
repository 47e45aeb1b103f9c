// octavo info: what a file holds, on one screen.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/sha256.h"
#include "octavo/tasks/files/info.h"
#include "octavo/tasks/geometry_words.h"
#include "octavo/tasks/volume_facts.h"
#include "text/detail_words.h"
#include "text/identity_words.h"
#include "text/label_words.h"
#include "text/made_by_words.h"
#include "text/preparation_words.h"
#include "text/quantities.h"
#include "text/table.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kInfoText = {
    "info", "Show what a file holds.",
    "Reads the header and the index, of lossless float32 also the coarsest sample; min and max\n"
    "are stored values in --json, null where every voxel is NaN or infinite. A max error\n"
    "is shown in real units: what the file promises, and the largest difference found when it\n"
    "was built. --metadata lists what was kept of the identity of the source and what was\n"
    "dropped, by name and how often it was there; --json holds the same. sha256 tells whether\n"
    "files hold the same voxels: it is that of the SHA-256 of each plane. Of metadata that fill\n"
    "more than 1 MiB both say which bytes of the file they are instead. --thumbnail writes the\n"
    "small picture that build --thumbnail puts into a file, and makes it of any other file. Parts\n"
    "and extensions that this program does not know are listed as such.\n\n"
    "Examples:\n"
    "  octavo info head.8vo\n"
    "  octavo info head.8vo --metadata\n"
    "  octavo info head.8vo --thumbnail head.png\n"
    "  octavo info https://example.org/head.8vo --json"};

struct InfoArguments {
  InfoOptions options;
  bool shows_metadata = false;
};

/// A line of the screen; none without a text.
std::string row(const char* name, const std::string& text) {
  return text.empty() ? "" : fmt::format("  {:<12} {}\n", name, text);
}

/// True when the user gave the spacing to the build.
bool is_spacing_given(const Metadata& metadata) {
  return metadata.facts().spacing_source == "user";
}

std::string geometry_rows(const InfoResult& info, const Metadata& metadata) {
  const VolumeDescription& d = info.volume;
  if (!metadata.is_spacing_known()) {
    return row("spacing",
               "unknown: the source gives none, 1 mm is assumed (build --spacing sets it)");
  }
  std::string text =
      row("spacing", fmt::format("{} mm{}; field of view {} mm", point_text(d.geometry.spacing_mm),
                                 is_spacing_given(metadata) ? " (given by --spacing)" : "",
                                 point_text(field_of_view_mm(d.geometry, d.size))));
  if (!info.is_place_known) {
    return text + row("orientation", "not given; axes as in the source");
  }
  text += row("orientation", orientation_words(d.geometry));
  return text + row("origin", point_text(d.geometry.origin_mm, ", ") + " mm (to left, back, head)");
}

std::string values_row(const InfoResult& info) {
  if (!info.has_values) return row("values", "none: every voxel is NaN or infinite");
  const VolumeDescription& d = info.volume;
  const std::string unit = unit_of(d);
  double min = d.voxel_of(info.range.min);
  double max = d.voxel_of(info.range.max);
  if (d.rescale.slope < 0) std::swap(min, max);
  std::string text =
      fmt::format("{}{} to {}{}", info.is_range_exact() ? "" : "within ",
                  number_text(d.rescale.to_real(min)), number_text(d.rescale.to_real(max)),
                  unit.empty() ? "" : " " + unit);
  if (!d.rescale.is_identity()) {
    text += fmt::format(" (stored {} to {}, slope {}, intercept {})", number_text(min),
                        number_text(max), number_text(d.rescale.slope),
                        number_text(d.rescale.intercept));
  }
  return row("values", text);
}

/// How the voxels of the file relate to those of its source, in a few words.
std::string loss_words(const InfoResult& info, const Metadata& metadata) {
  if (info.detail_level > 0) return "interpolated where fine";
  if (info.max_error > 0) return "with a max error";
  if (!missing_words(metadata).empty()) return "lossless where it is whole";
  if (is_condensed(metadata)) return "condensed, not lossless";
  if (metadata.was_source_lossy()) return "as the source holds them";
  return was_resampled(metadata) ? "lossless from its prepared planes" : "lossless";
}

std::string loss_rows(const InfoResult& info) {
  const VolumeDescription& d = info.volume;
  const std::string unit = unit_of(d);
  std::string text;
  if (info.detail_level > 0) {
    DetailErrors errors = info.detail_errors.value_or(DetailErrors{});
    if (!errors.max) errors.max = info.achieved_error * std::abs(d.rescale.slope);
    text += row("details", fmt::format("from level {} on; {}", info.detail_level,
                                       detail_error_words(d, errors)));
  } else if (info.max_error > 0) {
    text += row("max error", fmt::format("{} promised, {} found when it was built",
                                         distance_text(d, info.max_error),
                                         distance_text(d, info.achieved_error)));
  }
  if (const double error = d.metadata.source_max_error(); error > 0) {
    text += row("source loss", fmt::format("its source lay within {}{} of its own source",
                                           number_text(error), unit.empty() ? "" : " " + unit));
  } else if (d.metadata.was_source_lossy()) {
    text += row("source loss", "the source had been compressed with loss before");
  }
  if (d.coding) {
    const std::string offset =
        d.coding->offset == 0 ? "" : " + " + number_text(d.coding->offset);
    text += row("stored as",
                fmt::format("{} codes; voxel = code * {}{}{}", voxel_type_name(d.coding->type),
                            number_text(d.coding->scale), offset,
                            d.coding->is_exact ? ", then exact bits where it differs" : ""));
  }
  return text;
}

std::string source_row(const Metadata& metadata) {
  const SourceNote source = metadata.facts().source.value_or(SourceNote{});
  std::string text = escaped(source.format.value_or(""));
  const std::int64_t count = source.file_count.value_or(0);
  if (count > 0) text += ", " + counted_text(count, "file");
  const std::string chosen = choice_words(metadata);
  if (!text.empty() && !chosen.empty()) text += ", " + chosen;
  return row("source", text);
}

std::string level_table(const InfoResult& info) {
  TextTable table({{"level", 7},
                   {"size", 21},
                   {"spacing mm", 27},
                   {"bricks", 10},
                   {"uniform", 10},
                   {"bytes", 11}});
  const bool is_known = is_spacing_known(info.volume);
  for (std::size_t level = 0; level < info.levels.size(); ++level) {
    const LevelInfo& one = info.levels[level];
    table.add({std::to_string(level), size_text(one.size),
               is_known ? point_text(one.spacing_mm) : "-", count_text(one.summary.bricks),
               count_text(one.summary.uniform_bricks),
               one.summary.is_in_finer ? "with finer" : bytes_text(one.summary.bytes)});
  }
  return "\n" + table.text();
}

/// What its flags say of a part, in words.
std::string part_words(const PartInfo& part) {
  std::string text = part.is_known ? "" : "unknown to this program";
  const auto add = [&text](const char* words) {
    text += text.empty() ? "" : ", ";
    text += words;
  };
  if (part.is_required) add("required");
  if (part.follows_from_voxels) add("follows from the voxels");
  if (part.follows_from_rest) add("follows from the rest of the file");
  if (!part.follows_from_voxels && !part.follows_from_rest) add("stands for itself");
  return text;
}

std::string part_rows(const InfoResult& info) {
  constexpr std::size_t kMostRows = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(info.parts.size(), kMostRows); ++i) {
    const PartInfo& part = info.parts[i];
    text += row("part", fmt::format("{}, {}: {}", part.tag, bytes_text(part.bytes),
                                    part_words(part)));
  }
  if (info.parts.size() > kMostRows) {
    text += row("parts", fmt::format("{} more; --json lists them", info.parts.size() - kMostRows));
  }
  for (const ExtensionInfo& extension : info.unknown_extensions) {
    text += row("extension", fmt::format("0x{:04x}, {}: unknown to this program", extension.tag,
                                         bytes_text(extension.bytes)));
  }
  return text;
}

/// The program that coded the voxels.
std::string writer_row(const Metadata& metadata) {
  const WriterNote writer = metadata.facts().written_by.value_or(WriterNote{});
  if (!writer.name) return "";
  std::string text = escaped(*writer.name);
  if (writer.revision) text += ", revision " + std::to_string(*writer.revision);
  return row("coded by", text);
}

/// All metadata for people; of long ones only their place.
std::string metadata_text(const InfoResult& info) {
  const Metadata& metadata = info.volume.metadata;
  const std::string json = metadata_json(metadata).dump(
      2, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
  const std::string text = identity_lines(metadata) + "\n" + json + "\n";
  if (text.size() <= kMaxShownMetadataBytes) return text;
  return fmt::format("\n  metadata too long to show: {} bytes from byte {} of the file on\n",
                     metadata.text().size(), info.metadata_offset);
}

std::string screen(const InfoResult& info, bool show_metadata) {
  const VolumeDescription& d = info.volume;
  const Metadata& metadata = d.metadata;
  std::string text = shown_path(info.name) + "\n";
  text += row("holds", fmt::format("{} voxels of {}, {}, {}", size_text(d.size),
                                   voxel_type_name(d.type), word_of(d.kind),
                                   loss_words(info, metadata)));
  text += geometry_rows(info, metadata);
  text += values_row(info);
  text += row("labels", named_labels_text(metadata.facts().labels));
  text += loss_rows(info);
  text += row("bytes", fmt::format("{} of {} raw: {:.2f}:1, {:.3f} bits per voxel",
                                   bytes_text(info.file_bytes), bytes_text(info.raw_bytes),
                                   info.compression_ratio(), info.bits_per_voxel()));
  text += source_row(metadata);
  text += row("made by", made_by_words(metadata));
  text += row("prepared", preparation_words(metadata));
  text += row("identity", identity_words(metadata));
  if (const std::string words = missing_words(metadata); !words.empty()) {
    text += row("missing", words + "; filled");
  }
  if (!metadata.is_readable()) {
    text += row("metadata", "cannot be read, no JSON object: " + metadata.defect());
  }
  if (info.thumbnail_bytes > 0) {
    text += row("thumbnail", bytes_text(info.thumbnail_bytes) + " (info --thumbnail writes it)");
  }
  text += part_rows(info);
  text += row("sha256", hex_text(info.voxel_digest) + " (of the planes' own)");
  text += row("format", "8vo " + info.format_version);
  text += writer_row(metadata);
  text += level_table(info);
  return show_metadata ? text + metadata_text(info) : text;
}

int run_info(const InfoArguments& arguments, Context& context) {
  const InfoResult result = info(arguments.options, brief_task(context));
  if (context.json) print_json(file_json(result));
  else print(screen(result, arguments.shows_metadata));
  return kExitDone;
}

}  // namespace

void add_info(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kInfoText, run_info);
  verb.add_input(arguments.options.input);
  verb.add_flag("--metadata", arguments.shows_metadata, "Show all metadata as well");
  verb.add_output_option("--thumbnail FILE", arguments.options.thumbnail,
                         "Write the thumbnail to a PNG file");
}

}  // namespace octavo::cli
