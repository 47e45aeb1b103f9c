#include "octavo/io/dicom/dicom_counts.h"

#include <algorithm>
#include <map>
#include <set>

#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

namespace {

constexpr const char* kPart = "In-concatenation Number (0020,9162)";
constexpr const char* kParts = "In-concatenation Total Number (0020,9163)";
constexpr const char* kImages = "Images in Acquisition (0020,1002)";
constexpr const char* kSlices = "Number of Slices (0054,0081)";
constexpr const char* kMoments = "Number of Temporal Positions (0020,0105)";
constexpr const char* kTimeSlices = "Number of Time Slices (0054,0101)";

/// An integer string; 0 where it is none above 0, or so large that nobody counted it.
std::int64_t count_in(const DicomSet& data, DicomTag tag) {
  constexpr double kMost = 1e9;
  const double value = data.decimal(tag).value_or(0);
  return value >= 1 && value <= kMost ? static_cast<std::int64_t>(value) : 0;
}

/// "4 slices are there, Number of Slices (0054,0081) says 5".
std::string counts_text(std::int64_t found, const char* one, const char* several,
                        const std::string& name_and_verb, std::int64_t said) {
  return std::to_string(found) + " " + (found == 1 ? one : several) +
         (found == 1 ? " is there, " : " are there, ") + name_and_verb + " " +
         std::to_string(said);
}

/// The files of one concatenation.
struct Concatenation {
  const DicomSlice* first = nullptr;
  std::set<std::int64_t> parts;
  std::int64_t said = 0;
};

}  // namespace

DicomCounts read_dicom_counts(const DicomSet& data) {
  DicomCounts counts;
  counts.concatenation = data.text(0x00209161);
  counts.part = data.unsigned_value(0x00209162).value_or(0);
  counts.parts = data.unsigned_value(0x00209163).value_or(0);
  counts.images = count_in(data, 0x00201002);
  counts.moments = count_in(data, 0x00200105);
  if (data.text(0x00080060) != "PT") return counts;
  counts.slices = data.unsigned_value(0x00540081).value_or(0);
  counts.time_slices = data.unsigned_value(0x00540101).value_or(0);
  return counts;
}

void require_whole_concatenations(const std::vector<DicomSlice>& slices) {
  std::map<std::string, Concatenation> all;
  for (const DicomSlice& slice : slices) {
    const DicomCounts& counts = slice.layout->counts;
    if (counts.concatenation.empty() || counts.part == 0) continue;
    Concatenation& found = all[counts.concatenation];
    if (found.first == nullptr) found.first = &slice;
    found.parts.insert(counts.part);
    found.said = std::max(found.said, counts.parts);
  }
  for (const auto& [uid, found] : all) {
    const std::int64_t last = *found.parts.rbegin();
    const auto count = static_cast<std::int64_t>(found.parts.size());
    if (count >= std::max(found.said, last)) continue;
    const bool is_said = found.said >= last;
    reject(*found.first->layout,
           counts_text(count, "file of a concatenation", "files of a concatenation",
                       is_said ? std::string(kParts) + " says" : std::string(kPart) + " goes up to",
                       is_said ? found.said : last) +
               ": complete the series");
  }
}

void tell_of_missing_images(const std::vector<DicomSlice>& slices, std::vector<Warning>& warnings) {
  std::set<const DicomLayout*> files;
  std::int64_t said = 0;
  for (const DicomSlice& slice : slices) {
    if (slice.layout->frames > 1) return;
    files.insert(slice.layout.get());
    said = std::max(said, slice.layout->counts.images);
  }
  const auto found = static_cast<std::int64_t>(files.size());
  if (found >= said) return;
  warnings.push_back(counts_text(found, "image", "images", std::string(kImages) + " says", said) +
                     ": others may be missing, or in another series; complete the series");
}

void tell_of_missing_slices(const std::vector<DicomSlice>& slices, std::int64_t moments,
                            std::vector<Warning>& warnings) {
  const DicomLayout& layout = *slices.front().layout;
  const auto found = static_cast<std::int64_t>(slices.size());
  if (found < layout.counts.slices) {
    warnings.push_back(counts_text(found, "slice", "slices", std::string(kSlices) + " says",
                                   layout.counts.slices) +
                       ": others may be missing; complete the series");
  }
  const bool is_pet = layout.counts.time_slices > 0;
  const std::int64_t said = is_pet ? layout.counts.time_slices : layout.counts.moments;
  // One alone is whole: many programs write each moment as a series of its own.
  if (moments < 2 || moments >= said) return;
  warnings.push_back(counts_text(moments, "point in time", "points in time",
                                 std::string(is_pet ? kTimeSlices : kMoments) + " says", said) +
                     ": others may be missing; complete the series");
}

}  // namespace octavo
