#include "octavo/io/source/described_source.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/levels.h"
#include "octavo/core/text.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/stack_names.h"
#include "octavo/io/source/value_unit.h"

namespace octavo {

namespace {

// Where a spacing is from, as the metadata say it.
constexpr const char* kFile = "file";
constexpr const char* kUser = "user";
constexpr const char* kAssumed = "assumed";

std::string settle_spacing(SourceFacts& facts, const SourceOptions& options) {
  Point3& spacing = facts.description.geometry.spacing_mm;
  if (options.spacing_mm) {
    for (const double mm : *options.spacing_mm) {
      if (std::isfinite(mm) && mm > 0) continue;
      throw Error(ErrorKind::invalid_argument,
                  "a spacing must be a positive number of millimeters");
    }
    spacing = *options.spacing_mm;
    return kUser;
  }
  if (facts.spacing_known) return kFile;
  facts.warnings.emplace_back("spacing is not in the files: 1 mm assumed", "spacing_mm");
  spacing = {1, 1, 1};
  return kAssumed;
}

/// The names of files behind the folder that holds them all.
std::vector<std::string> differing_names(const std::vector<std::string>& files) {
  std::string_view common = files.empty() ? std::string_view() : files.front();
  for (const std::string& file : files) {
    const auto ends = std::mismatch(common.begin(), common.end(), file.begin(), file.end());
    common = common.substr(0, static_cast<std::size_t>(ends.first - common.begin()));
  }
  const std::size_t start = common.rfind('/') + 1;  // 0 where there is none
  std::vector<std::string> names;
  for (const std::string& file : files) names.push_back(file.substr(start));
  return names;
}

constexpr const char* kNameOneStack = "; name the files of one stack, in which one number counts";

/// Says what is wrong with the order of the names of a stack.
std::string gap_text(const std::vector<std::string>& names, const std::vector<NumberGap>& gaps) {
  if (const auto grid = number_grid(names); grid && !gaps.front().is_counted) {
    return "two numbers in the names count, " + std::to_string(grid->outer) + " x " +
           std::to_string(grid->inner) + " files from " + escaped(names.front()) + " to " +
           escaped(names.back()) + ", as those of several channels or times do";
  }
  const NumberGap& first = gaps.front();
  std::string text =
      escaped(names[first.before]) + " is followed by " + escaped(names[first.before + 1]) + ": ";
  if (!first.is_counted) {
    text += "no number in their names counts from one to the other";
  } else if (first.missing > 0) {
    text += (first.missing == 1 ? "1 file is" : std::to_string(first.missing) + " files are") +
            std::string(" missing by their numbers");
  } else {
    text += "the numbers are uneven";
  }
  if (gaps.size() == 2) text += " (and 1 more such place)";
  if (gaps.size() > 2) text += " (and " + std::to_string(gaps.size() - 1) + " more such places)";
  return text;
}

}  // namespace

void settle(SourceFacts& facts, const SourceOptions& options, const std::string& path) {
  facts.choice = choose_component(facts.components, options, path);
  facts.path = path;
  facts.is_cancelled = options.is_cancelled;
  const std::string spacing_source = settle_spacing(facts, options);
  try {
    checked_voxel_count(facts.description.size);
  } catch (const Error& failure) {
    throw failure.with_path(path);
  }
  if (!is_valid(facts.description.geometry)) {
    throw Error(ErrorKind::source_rejected,
                "its geometry is not usable: spacings must lie between 1e-9 and 1e9 mm, the "
                "origin within 1e12 mm, and axes be independent; "
                "repair the header",
                path)
        .with_field("spacing_mm");
  }
  if (!std::isfinite(facts.description.rescale.slope) || facts.description.rescale.slope == 0 ||
      !std::isfinite(facts.description.rescale.intercept)) {
    throw Error(ErrorKind::source_rejected, "its rescale slope or intercept is not a usable number",
                path);
  }
  MetadataFacts& noted = facts.noted;
  noted.source = SourceNote{facts.file_count, facts.format, {}};
  noted.spacing_known = spacing_source != kAssumed;
  noted.spacing_source = spacing_source;
  if (facts.place_known) noted.place_known = facts.place_known;
  if (facts.ignored_number_gaps > 0) {
    if (!noted.prepared) noted.prepared.emplace();
    noted.prepared->ignored_number_gaps = static_cast<std::int64_t>(facts.ignored_number_gaps);
  }
  if (!facts.unit.empty()) noted.unit = unit_code(facts.unit);
  noted.chosen = choice_note(facts.components, facts.choice);
  if (options.keep_identity) facts.identity.note("FileName", base_name(path));
  if (!facts.identity.is_empty()) {
    noted.identity = facts.identity.note_for_file(options.keep_identity);
  }
  facts.description.metadata = Metadata::of(noted);
}

void take_stored_type(SourceFacts& facts, StoredType type) {
  facts.description.type = type.voxel();
  facts.wide = type.wide();
}

std::uint64_t stored_plane_bytes(const SourceFacts& facts) {
  const std::uint64_t bytes = plane_bytes(facts.description);
  if (!facts.wide) return bytes;
  return bytes / static_cast<std::uint64_t>(bytes_per_voxel(facts.description.type)) *
         bytes_per_value(*facts.wide);
}

void settle_narrowing(SourceFacts& facts, const WidePlaneReader& read) {
  if (!facts.wide) return;
  const auto read_or_stop = [&](std::int64_t z, std::span<std::byte> plane) {
    if (facts.is_cancelled && facts.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while the type of voxels was chosen");
    }
    read(z, plane);
  };
  try {
    facts.narrowing = choose_narrowing(*facts.wide, facts.description.size.z,
                                       stored_plane_bytes(facts), read_or_stop);
  } catch (const Error& failure) {
    if (!failure.path().empty() || failure.kind() != ErrorKind::source_rejected) throw;
    throw failure.with_path(facts.path);
  }
  facts.description.type = facts.narrowing->to;
  if (!is_integer(facts.description.type)) facts.description.kind = VolumeKind::grey;
  if (!facts.narrowing->rounds) return;
  facts.warnings.push_back(float_rounding_warning());
}

void settle_number_gaps(const std::vector<std::string>& files, const SourceOptions& options,
                        SourceFacts& facts) {
  if (options.excerpt) return;
  const std::vector<std::string> names = differing_names(files);
  const std::vector<NumberGap> gaps = number_gaps(names);
  if (gaps.empty()) return;
  const std::string found = gap_text(names, gaps);
  if (options.on_gap != GapPolicy::ignore) {
    throw Error(ErrorKind::source_rejected,
                found + (gaps.front().is_counted ? "; complete the stack" : kNameOneStack),
                files[gaps.front().before + 1])
        .with_field("on_gap", "ignore");
  }
  facts.ignored_number_gaps = gaps.size();
  facts.warnings.push_back(found + "; taken as neighbors");
}

DescribedSource::DescribedSource(SourceFacts facts)
    : facts_(std::move(facts)), cursor_(facts_.description.size.z) {}

void DescribedSource::require_plane(std::span<const std::byte> plane) const {
  if (plane.size() == plane_bytes(facts_.description)) return;
  throw Error(ErrorKind::invalid_argument,
              "a plane buffer of " + std::to_string(plane.size()) + " bytes, " +
                  std::to_string(plane_bytes(facts_.description)) + " needed");
}

}  // namespace octavo
