#include "octavo/io/dicom/dicom_segments.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/io/dicom/dicom_places.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxListedSegments = 8;
constexpr std::size_t kMaxNotedSegments = 4096;
constexpr std::int64_t kMaxLabel = 255;

/// Those of a label map without the background, which may have a number and a label as well.
std::vector<DicomSegment> segments_of(const DicomLayout& layout) {
  std::vector<DicomSegment> segments = layout.segments;
  if (!layout.is_label_map()) return segments;
  const std::int64_t background = layout.padding_value.value_or(0);
  std::erase_if(segments, [&](const DicomSegment& s) { return s.number == background; });
  return segments;
}

/// "1 liver, 2 tumor".
std::string list_of(const DicomLayout& layout) {
  std::string list;
  const std::vector<DicomSegment> segments = segments_of(layout);
  for (std::size_t i = 0; i < std::min(segments.size(), kMaxListedSegments); ++i) {
    list += (i == 0 ? "" : ", ") + std::to_string(segments[i].number) + " " +
            escaped(segments[i].label);
  }
  if (segments.size() > kMaxListedSegments) {
    list += " and " + std::to_string(segments.size() - kMaxListedSegments) + " more";
  }
  return list;
}

/// The number that `text` stands for: a label counts before a number.
std::int64_t number_of(const DicomLayout& layout, const std::string& text) {
  const std::vector<DicomSegment> segments = segments_of(layout);
  for (const DicomSegment& segment : segments) {
    if (lower_case(segment.label) == lower_case(text)) return segment.number;
  }
  for (const DicomSegment& segment : segments) {
    if (std::to_string(segment.number) == text) return segment.number;
  }
  throw Error(ErrorKind::invalid_argument,
              "segment " + escaped(text) + " is not there; segments are " + list_of(layout),
              layout.path)
      .with_field("segment", "one of these numbers or labels");
}

std::set<std::int64_t> numbers_in(const std::vector<DicomSlice>& slices) {
  std::set<std::int64_t> numbers;
  for (const DicomSlice& slice : slices) numbers.insert(slice.segment);
  return numbers;
}

[[noreturn]] void ask_for_one(const DicomLayout& layout, const std::string& why) {
  throw Error(ErrorKind::source_rejected,
              "a segmentation (SEG) of several segments (" + list_of(layout) + ") " + why,
              layout.path)
      .with_field("segment", "a number or label");
}

/// One slice for each place, with the frames of all segments there.
std::vector<DicomSlice> join_places(std::vector<DicomSlice> slices) {
  std::map<Point3, std::size_t> places;
  std::vector<DicomSlice> joined;
  for (DicomSlice& slice : slices) {
    const auto [place, is_new] = places.try_emplace(*slice.position_mm, joined.size());
    const LabelFrame part{slice.frame, slice.segment};
    if (is_new) joined.push_back(std::move(slice));
    joined[place->second].label_frames.push_back(part);
  }
  return joined;
}

void require_joinable(const std::vector<DicomSlice>& slices) {
  const DicomLayout& layout = *slices.front().layout;
  if (!layout.is_binary_segmentation()) {
    ask_for_one(layout, "that are fractions, of which a volume holds one");
  }
  if (layout.segments_overlap) ask_for_one(layout, "that overlap, while a voxel has one label");
  for (const DicomSlice& slice : slices) {
    if (slice.layout != slices.front().layout) ask_for_one(layout, "in several files");
    if (slice.segment < 1 || slice.segment > kMaxLabel) {
      ask_for_one(layout, "with numbers that are no labels from 1 to 255");
    }
    if (!slice.position_mm) ask_for_one(layout, "whose frames have no positions");
  }
}

/// The frames of one segment, and a blank slice at each place where others alone have one, so that
/// all segments of a file become volumes of the same planes.
std::vector<DicomSlice> of_one_segment(std::vector<DicomSlice> slices, std::int64_t number) {
  constexpr double kSamePlaceMm = 0.01;
  constexpr double kSamePlaceSteps = 0.1;
  const auto is_other = [&](const DicomSlice& slice) { return slice.segment != number; };
  const auto is_placed = [](const DicomSlice& s) { return s.position_mm && s.orientation; };
  if (!std::ranges::all_of(slices, is_placed)) {
    std::erase_if(slices, is_other);
    return slices;
  }
  const Point3 normal = slice_axes(slices.front()).normal;
  std::set<double> heights;
  for (const DicomSlice& slice : slices) {
    if (!is_other(slice)) heights.insert(dot(*slice.position_mm, normal));
  }
  std::vector<DicomSlice> taken;
  for (DicomSlice& slice : slices) {
    if (is_other(slice)) {
      const double height = dot(*slice.position_mm, normal);
      const double steps = kSamePlaceSteps * slice.spacing_mm.value_or(1);
      const double same = steps > 0 ? std::min(kSamePlaceMm, steps) : kSamePlaceMm;
      const auto near = heights.lower_bound(height - same);
      if (near != heights.end() && *near <= height + same) continue;
      heights.insert(height);
      slice.is_blank = true;
      slice.segment = number;
    }
    taken.push_back(std::move(slice));
  }
  return taken;
}

/// Slices whose voxels are numbers of segments, or those of one of them.
std::vector<DicomSlice> of_label_map(std::vector<DicomSlice> slices, const SourceOptions& options) {
  const DicomLayout& layout = *slices.front().layout;
  if (!options.segment.empty()) {
    const std::int64_t number = number_of(layout, options.segment);
    for (DicomSlice& slice : slices) slice.taken_label = slice.segment = number;
    return slices;
  }
  for (const DicomSlice& slice : slices) {
    if (slice.layout->padding_value != layout.padding_value) {
      ask_for_one(layout, "in files of different Pixel Padding Value (0028,0120)");
    }
  }
  const bool has_zero = std::ranges::any_of(
      segments_of(layout), [](const DicomSegment& segment) { return segment.number == 0; });
  if (has_zero) ask_for_one(layout, "one of which is 0, the label of what is in none");
  return slices;
}

/// Whether voxels are numbers of segments, else 1 where they are in the only one.
bool holds_numbers(const DicomSlice& slice) {
  return !slice.label_frames.empty() || (slice.layout->is_label_map() && !slice.taken_label);
}

/// The colors of the labels that a volume of these slices has.
LabelNames colors_of(const DicomSlice& slice) {
  LabelNames colors;
  if (!slice.layout->is_binary_segmentation()) return colors;
  for (const DicomSegment& segment : segments_of(*slice.layout)) {
    const bool is_there = holds_numbers(slice) || segment.number == slice.segment;
    if (!segment.color || !is_there || colors.size() == kMaxNotedSegments) continue;
    colors.set(holds_numbers(slice) ? segment.number : 1, {"", segment.color});
  }
  return colors;
}

}  // namespace

std::vector<DicomSlice> choose_segments(std::vector<DicomSlice> slices,
                                        const SourceOptions& options) {
  const DicomLayout& layout = *slices.front().layout;
  if (!layout.is_segmentation()) {
    if (options.segment.empty()) return slices;
    throw Error(ErrorKind::invalid_argument,
                "no DICOM segmentation (SEG), of which alone a segment can be taken", layout.path)
        .with_field("segment");
  }
  if (layout.is_label_map()) return of_label_map(std::move(slices), options);
  const double largest = static_cast<double>(std::max<std::int64_t>(layout.max_fraction, 1));
  if (!options.segment.empty()) {
    const std::int64_t number = number_of(layout, options.segment);
    if (!numbers_in(slices).contains(number)) {
      throw Error(ErrorKind::source_rejected,
                  "segment " + std::to_string(number) + " has no frames: it is empty", layout.path);
    }
    slices = of_one_segment(std::move(slices), number);
  } else if (numbers_in(slices).size() > 1) {
    require_joinable(slices);
    return join_places(std::move(slices));
  }
  if (!slices.front().layout->is_binary_segmentation()) {
    for (DicomSlice& slice : slices) slice.values.rescale = {1 / largest, 0};
  }
  return slices;
}

void note_segments(const std::vector<DicomSlice>& slices, const SourceOptions& options,
                   MetadataFacts& noted) {
  const DicomSlice& first = slices.front();
  noted.labels = colors_of(first);
  std::vector<SegmentNote> all;
  for (const DicomSegment& segment : segments_of(*first.layout)) {
    if (!options.segment.empty() && segment.number == first.segment) {
      noted.segment = SegmentNote{segment.number};
      break;
    }
    if (all.size() < kMaxNotedSegments) all.push_back({segment.number});
  }
  if (!noted.segment && holds_numbers(first) && !all.empty()) noted.segments = std::move(all);
}

}  // namespace octavo
