#include "octavo/io/dicom/dicom_identity.h"

#include <algorithm>
#include <map>
#include <set>

#include "octavo/io/dicom/dicom_attributes.h"
#include "octavo/io/dicom/dicom_library.h"
#include "octavo/io/dicom/dicom_tags.h"

namespace octavo {

namespace {

constexpr DicomTag kCharacterSet = 0x00080005;
constexpr DicomTag kSegmentLabel = 0x00620005;

/// How the file and the picture are laid out: taken up by the volume, or by nothing at all.
bool is_layout(DicomTag tag) {
  static const std::set<DicomTag> kLayout = {
      0x00020001, 0x00020010,  // of the file meta information
      0x00020002, 0x00080016,  // what kind of object it is
      0x00080005,              // characters
      0x00200013, 0x00200032, 0x00200037, 0x00280030, kSegmentColor};
  if ((tag & 0xffffU) == 0 || kLayout.contains(tag)) return true;
  const DicomTag group = tag >> 16;
  if (group == 0x7fe0 || group == 0xfffe) return true;
  return group == 0x0028 && dicom_library().content(tag) != DicomContent::words;
}

/// Latin 1 as UTF-8.
std::string widened(const std::string& text) {
  std::string wide;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      wide += c;
    } else {
      wide += static_cast<char>(0xc0 | code >> 6);
      wide += static_cast<char>(0x80 | (code & 0x3f));
    }
  }
  return wide;
}

std::int64_t labels_of(const DicomLayout& layout) {
  return std::count_if(layout.segments.begin(), layout.segments.end(),
                       [](const DicomSegment& segment) { return !segment.label.empty(); });
}

/// "1 liver", "2 tumor": the labels could be kept with the numbers that they name.
void note_segments(const DicomLayout& layout, bool is_latin, SourceIdentity& identity) {
  for (const DicomSegment& segment : layout.segments) {
    if (segment.label.empty()) continue;
    identity.note(dicom_library().keyword(kSegmentLabel), std::to_string(segment.number) + " " +
                      (is_latin ? widened(segment.label) : segment.label));
  }
}

}  // namespace

SourceIdentity dicom_identity(const DicomStack& stack) {
  std::set<const DicomLayout*> files;
  std::map<DicomTag, std::int64_t> counts;
  SourceIdentity identity;
  for (const DicomSlice& slice : stack.slices) {
    if (!files.insert(slice.layout.get()).second) continue;
    for (const auto& [tag, count] : slice.layout->elements) counts[tag] += count;
    identity.note_lost("private", slice.layout->private_elements);
  }
  const DicomFile first = read_dicom_file(stack.slices.front().layout->path);
  const bool is_latin = first.data.text(kCharacterSet).find("ISO_IR 100") != std::string::npos;
  const DicomLayout& layout = *stack.slices.front().layout;
  note_segments(layout, is_latin, identity);
  for (auto& [tag, count] : counts) {
    if (tag == kSegmentLabel) count -= labels_of(layout);
    if (is_dicom_attribute(tag) ? is_dicom_metadata(first.data, tag) : is_layout(tag)) continue;
    const std::string known = dicom_library().keyword(tag);
    const std::string keyword = known.empty() ? dicom_tag_text(tag) : known;
    if (dicom_library().content(tag) != DicomContent::binary) {
      const std::string text = first.data.text(tag);
      identity.note(keyword, is_latin ? widened(text) : text);
      if (!text.empty()) --count;
    }
    identity.note_lost(keyword, count);
  }
  return identity;
}

}  // namespace octavo
