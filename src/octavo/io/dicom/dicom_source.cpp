#include "octavo/io/dicom/dicom_source.h"

#include <algorithm>
#include <set>
#include <utility>

#include "octavo/io/dicom/dicom_attributes.h"
#include "octavo/io/dicom/dicom_coded.h"
#include "octavo/io/dicom/dicom_counts.h"
#include "octavo/io/dicom/dicom_extent.h"
#include "octavo/io/dicom/dicom_identity.h"
#include "octavo/io/dicom/dicom_palette.h"
#include "octavo/io/dicom/dicom_pixels.h"
#include "octavo/io/dicom/dicom_plane.h"
#include "octavo/io/dicom/dicom_real_values.h"
#include "octavo/io/dicom/dicom_segments.h"
#include "octavo/io/dicom/dicom_series.h"
#include "octavo/io/dicom/dicom_strays.h"
#include "octavo/io/dicom/dicom_times.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

class DicomSource final : public IndexedPlaneSource {
 public:
  DicomSource(SourceFacts facts, DicomStack stack)
      : IndexedPlaneSource(std::move(facts)), stack_(std::move(stack)) {}

  void read_plane_at(std::int64_t z, std::span<std::byte> plane) const override {
    require_plane(plane);
    read_stack_plane(stack_, z, plane);
  }

 private:
  DicomStack stack_;
};

std::vector<DicomSlice> collect_slices(const std::vector<std::string>& files,
                                       std::vector<Warning>& warnings) {
  std::vector<DicomSlice> slices;
  DicomStrays strays;
  for (const std::string& path : files) {
    if (!looks_like_dicom(path)) {
      strays.add(path, files.size() == 1);
      continue;
    }
    std::vector<DicomSlice> found = read_dicom_slices(path);
    if (found.empty()) strays.add_without_picture(path);
    std::move(found.begin(), found.end(), std::back_inserter(slices));
  }
  for (std::string& text : strays.warnings()) warnings.push_back(std::move(text));
  return slices;
}

/// Rejects pixel data that do not fit their header and values of unknown meaning; warns where more
/// is stored than is taken.
void check_slices(const std::vector<DicomSlice>& slices, std::vector<Warning>& warnings) {
  const DicomLayout* example = nullptr;
  std::set<const DicomLayout*> checked;
  std::size_t count = 0;
  for (const DicomSlice& slice : slices) {
    const DicomLayout& layout = *slice.layout;
    if (!slice.values.fault.empty()) {
      throw Error(ErrorKind::source_rejected, slice.values.fault, layout.path);
    }
    if (!checked.insert(&layout).second) continue;
    dicom_voxel_type(layout);
    check_dicom_pixels(layout);
    if (surplus_bytes(layout) == 0) continue;
    if (count++ == 0) example = &layout;
  }
  if (count == 0) return;
  warnings.push_back(std::to_string(count) + (count == 1 ? " file holds" : " files hold") +
                     " more pixel data than the size in the header takes (" +
                     escaped(base_name(example->path)) + ": " +
                     std::to_string(surplus_bytes(*example)) +
                     " bytes more); what is behind the picture is left out");
}

/// Says where numbers of compressed pictures are wider than the header has them. Many programs
/// write all pictures with 16 bits, so the numbers themselves are looked at, in the first, the
/// middle and the last slice that may hold such.
void warn_of_more_bits(const std::vector<DicomSlice>& slices, std::vector<Warning>& warnings) {
  std::vector<const DicomSlice*> wide;
  const DicomLayout* asked = nullptr;
  std::optional<PictureHead> head;
  for (const DicomSlice& slice : slices) {
    if (slice.layout.get() != asked) head = first_picture_head(*slice.layout);
    asked = slice.layout.get();
    if (head && has_more_bits(*slice.layout, *head)) wide.push_back(&slice);
  }
  if (wide.empty()) return;
  const DicomSlice* before = nullptr;
  for (const DicomSlice* slice : {wide.front(), wide[wide.size() / 2], wide.back()}) {
    if (slice == std::exchange(before, slice) || !has_wide_number(*slice)) continue;
    const DicomLayout& layout = *slice->layout;
    warnings.push_back("compressed pictures hold numbers of more bits than Bits Stored "
                       "(0028,0101) says, " + std::to_string(layout.bits_stored) + " of " +
                       std::to_string(layout.bits_allocated) + " allocated (as in " +
                       escaped(base_name(layout.path)) +
                       "): all bits are kept; compare the values with those of their origin");
    return;
  }
}

MetadataFacts noted_facts(const DicomStack& stack, const SourceOptions& options, bool was_lossy) {
  MetadataFacts noted;
  note_segments(stack.slices, options, noted);
  if (!stack.spacing_known) noted.place_known = false;
  noted.dicom = dicom_note(read_dicom_file(stack.slices.front().layout->path).data);
  if (was_lossy) noted.lossy_source = true;
  noted.prepared = preparation_note(stack);
  return noted;
}

/// Says what a picture may give away that no metadata do.
void warn_of_likeness(const DicomStack& stack, std::vector<Warning>& warnings) {
  const auto example = [&](auto is_so) -> std::string {
    const auto found = std::find_if(stack.slices.begin(), stack.slices.end(), is_so);
    return found == stack.slices.end() ? "" : found->name();
  };
  const std::string written = example([](const DicomSlice& slice) {
    return slice.layout->has_burned_in_text;
  });
  if (!written.empty()) {
    warnings.push_back("text is burned into the picture (Burned In Annotation (0028,0301) is YES, "
                       "as in " + written + "), perhaps a name; voxels are kept as they are");
  }
  const std::string likeness = example([](const DicomSlice& slice) {
    return slice.layout->shows_who_it_is;
  });
  if (!likeness.empty()) {
    warnings.push_back("the picture may show who it is (Recognizable Visual Features (0028,0302) "
                       "is YES, as in " + likeness + "); voxels are kept as they are");
  }
}

/// A plane between two slices is made of both, one that no slice speaks of of none.
PlaneFiles files_of(const DicomStack& stack) {
  std::vector<std::string> paths;
  for (const DicomSlice& slice : stack.slices) paths.push_back(slice.layout->path);
  PlaneFiles files = files_of_slices(paths);
  const std::vector<FileRange> of_slice = std::move(files.of_plane);
  files.of_plane.clear();
  for (const PlaneOrigin& plane : stack.planes) {
    FileRange range;
    if (!plane.is_background) range = of_slice[plane.below];
    if (plane.weight_above > 0 && !plane.is_background) {
      range = joined(range, of_slice[plane.below + 1]);
    }
    files.of_plane.push_back(range);
  }
  const bool is_one_each = files.paths.size() == stack.slices.size();
  // Some slices alone do not tell that others have another rescale.
  const bool tells_values = !stack.slices.front().made_real_by;
  if (is_one_each && tells_values && !stack.leaves_out_empty && stack.slices.size() > 1) {
    files.outline = SliceOutline{stack.planes, stack.tilt, stack.padding};
  }
  return files;
}

SourceFacts describe(const DicomStack& stack, const SourceOptions& options) {
  const DicomSlice& first = stack.slices.front();
  const DicomLayout& layout = *first.layout;
  SourceFacts facts;
  facts.format = "DICOM";
  facts.description.type = dicom_voxel_type(layout);
  facts.description.size = stack.size();
  if (stack.holds_labels) facts.description.kind = VolumeKind::labels;
  facts.description.geometry = stack.geometry;
  facts.description.rescale = first.values.rescale;
  if (!layout.is_label_map()) facts.description.padding = layout.padding_value;
  facts.spacing_known = stack.spacing_known;
  facts.unit = first.values.unit;
  facts.files = files_of(stack);
  facts.file_count = static_cast<std::int64_t>(facts.files.paths.size());
  const bool was_lossy = std::ranges::any_of(
      stack.slices, [](const DicomSlice& slice) { return slice.layout->was_lossy; });
  if (was_lossy) {
    facts.warnings.push_back(
        "some slices were compressed with loss before they came here; what is kept is what is "
        "left");
  }
  if (layout.photometric == "MONOCHROME1") {
    facts.warnings.push_back(
        "larger values are darker in these files (MONOCHROME1); kept as stored");
  }
  if (layout.pixels.is_float && layout.bits_allocated == 64) {
    facts.warnings.push_back(float_rounding_warning());
  }
  warn_of_likeness(stack, facts.warnings);
  facts.identity = dicom_identity(stack);
  facts.noted = noted_facts(stack, options, was_lossy);
  return facts;
}

}  // namespace

std::unique_ptr<PlaneSource> open_dicom_source(const std::vector<std::string>& files,
                                               const std::string& source,
                                               const SourceOptions& options) {
  std::vector<Warning> warnings;
  std::vector<DicomSlice> slices = collect_slices(files, warnings);
  if (slices.empty()) {
    throw Error(ErrorKind::source_rejected, "no DICOM file with a picture found", source);
  }
  slices = choose_series(std::move(slices), options.series, source);
  SourceComponents components;
  if (has_palette(*slices.front().layout)) {
    components = palette_components();
  } else {
    components.channels = slices.front().layout->samples;
    components.channel_names = color_names(components.channels);
  }
  check_slices(slices, warnings);
  warn_of_more_bits(slices, warnings);
  if (!options.excerpt) {
    require_whole_concatenations(slices);
    tell_of_missing_images(slices, warnings);
  }
  if (options.on_gap == GapPolicy::ignore) {
    throw Error(ErrorKind::invalid_argument,
                "DICOM slices say where they lie: gaps between them are not ignored", source)
        .with_field("on_gap", "fill or resample");
  }
  slices = choose_segments(std::move(slices), options);
  DicomTimes times = volumes_in_time(std::move(slices));
  components.times = static_cast<std::int64_t>(times.volumes.size());
  components.times_told_by = times.told_by;
  if (options.time.value_or(0) != 0 && components.times == 1) {
    // Slices of several volumes tell more than a time that is not there.
    std::vector<Warning> unsaid;
    prove_stack(take_real_values(times.volumes.front(), unsaid), options);
  }
  const ComponentChoice choice =
      choose_component(components, options, times.volumes.front().front().layout->path);
  slices = std::move(times.volumes[static_cast<std::size_t>(choice.time)]);
  if (!options.excerpt) tell_of_missing_slices(slices, components.times, warnings);
  if (has_palette(*slices.front().layout)) {
    slices = choose_palette_color(std::move(slices), choice.channel);
  } else {
    for (DicomSlice& slice : slices) slice.channel = choice.channel;
  }
  slices = take_real_values(std::move(slices), warnings);
  DicomStack stack = prove_stack(std::move(slices), options);
  SourceFacts facts = describe(stack, options);
  // Some slices alone do not tell that there are other times.
  if (components.times > 1) facts.files.outline.reset();
  facts.warnings.insert(facts.warnings.begin(), warnings.begin(), warnings.end());
  facts.warnings.insert(facts.warnings.end(), stack.warnings.begin(), stack.warnings.end());
  facts.components = std::move(components);
  settle(facts, options, source);
  return std::make_unique<DicomSource>(std::move(facts), std::move(stack));
}

}  // namespace octavo
