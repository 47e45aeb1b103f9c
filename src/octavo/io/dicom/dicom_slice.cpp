#include "octavo/io/dicom/dicom_slice.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/io/dicom/dicom_cielab.h"
#include "octavo/io/dicom/dicom_extent.h"
#include "octavo/io/dicom/dicom_mosaic.h"
#include "octavo/io/dicom/dicom_nuclear.h"
#include "octavo/io/dicom/dicom_strays.h"
#include "octavo/io/dicom/dicom_tags.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

using octavo::reject;  // the other files of this folder have some for slices and stacks

constexpr DicomTag kImagePosition = 0x00200032;
constexpr DicomTag kSharedGroups = 0x52009229;
constexpr DicomTag kPerFrameGroups = 0x52009230;
constexpr DicomTag kFrameContent = 0x00209111;
constexpr DicomTag kPlanePosition = 0x00209113;
constexpr DicomTag kPlaneOrientation = 0x00209116;
constexpr DicomTag kPixelMeasures = 0x00289110;
constexpr DicomTag kValueTransformation = 0x00289145;
constexpr DicomTag kRealWorldMapping = 0x00409096;
constexpr DicomTag kSegmentIdentification = 0x0062000a;
constexpr DicomTag kSegmentSequence = 0x00620002;
constexpr const char* kParametricMap = "1.2.840.10008.5.1.4.1.1.30";
constexpr const char* kSegmentation = "1.2.840.10008.5.1.4.1.1.66.4";
constexpr const char* kLabelMap = "1.2.840.10008.5.1.4.1.1.66.7";
constexpr std::int64_t kMaxFrames = std::int64_t{1} << 21;
constexpr std::int64_t kMaxSide = 65535;

bool is_lossy_syntax(const std::string& uid) {
  // JPEG baseline and extended, JPEG-LS near-lossless, JPEG 2000 (which may be either).
  static const std::set<std::string> kLossy = {"1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51",
                                               "1.2.840.10008.1.2.4.81", "1.2.840.10008.1.2.4.91",
                                               "1.2.840.10008.1.2.4.93"};
  return kLossy.contains(uid);
}

std::int64_t required(const DicomFile& file, DicomTag tag, const char* name) {
  const std::optional<std::int64_t> value = file.data.unsigned_value(tag);
  if (!value) reject(file.path, std::string(name) + " " + dicom_tag_text(tag) + " is missing");
  return *value;
}

/// Pixel Padding Value as a stored value: unused bits masked and the sign extended, as in voxels.
std::optional<std::int64_t> read_padding(const DicomLayout& layout,
                                         std::optional<std::int64_t> raw) {
  if (!raw || layout.bits_stored < 1 || layout.bits_stored > 32) return std::nullopt;
  const std::int64_t span = std::int64_t{1} << layout.bits_stored;
  const std::int64_t value = *raw & (span - 1);
  return layout.is_signed && value >= span / 2 ? value - span : value;
}

/// A setting of the scanner; what is measured anew for every slice differs a little.
std::string setting_text(const DicomSet& data, DicomTag tag, const std::string& unit) {
  const std::optional<double> value = data.decimal(tag);
  return value ? precise_text(std::round(*value * 10) / 10) + unit : "";
}

/// What tells a magnitude from a phase, or water from fat: Image Type without whether the picture
/// is original. Of CT slices some may be sums (ADD) of thinner ones.
std::string picture_kind(const std::string& image_type) {
  std::string kind;
  std::size_t number = 0;
  for (std::size_t at = 0; at < image_type.size(); ++number) {
    const std::size_t end = std::min(image_type.find('\\', at), image_type.size());
    const std::string value = image_type.substr(at, end - at);
    if (number >= 2 && value != "ADD") kind += (kind.empty() ? "" : "\\") + value;
    at = end + 1;
  }
  return kind;
}

/// Whether the Frame Increment Pointer of several frames is a time between them.
bool is_cine(const DicomSet& data, const DicomLayout& layout) {
  constexpr std::uint16_t kTimeGroup = 0x0018;
  constexpr std::uint16_t kFrameTime = 0x1063;
  constexpr std::uint16_t kFrameTimeVector = 0x1065;
  const std::vector<std::uint16_t> pointer = data.words(0x00280009);
  return layout.frames > 1 && pointer.size() == 2 && pointer[0] == kTimeGroup &&
         (pointer[1] == kFrameTime || pointer[1] == kFrameTimeVector);
}

/// Whether the frames are tiles of a larger picture, as of a slide under a microscope.
bool is_slide(const DicomSet& data, const DicomLayout& layout) {
  const std::int64_t columns = data.unsigned_value(0x00480006).value_or(0);
  const std::int64_t rows = data.unsigned_value(0x00480007).value_or(0);
  return layout.frames > 1 && (columns > layout.columns || rows > layout.rows);
}

/// Number of Frames; 1 where it is absent or blank.
std::int64_t frame_count(const DicomSet& data, const std::string& path) {
  constexpr DicomTag kNumberOfFrames = 0x00280008;
  const std::string text = data.text(kNumberOfFrames);
  if (text.empty()) return 1;
  const std::vector<double> numbers = data.decimals(kNumberOfFrames);
  const double frames = numbers.size() == 1 ? numbers.front() : 0;
  if (frames >= 1 && frames <= static_cast<double>(kMaxFrames) && frames == std::floor(frames)) {
    return static_cast<std::int64_t>(frames);
  }
  reject(path, "Number of Frames " + dicom_tag_text(kNumberOfFrames) + " is \"" + escaped(text) +
                   "\", a whole number of 1 to " + std::to_string(kMaxFrames) +
                   " expected; correct it in the file, or export the series again");
}

/// Pixel Representation; no sign where it is absent.
bool has_sign(const DicomSet& data, const std::string& path) {
  constexpr DicomTag kPixelRepresentation = 0x00280103;
  const auto kind = data.unsigned_value(kPixelRepresentation).value_or(0);
  if (kind == 0 || kind == 1) return kind == 1;
  reject(path, "Pixel Representation " + dicom_tag_text(kPixelRepresentation) + " is " +
                   std::to_string(kind) + ", 0 or 1 expected; correct it in the file, or export "
                   "the series again");
}

DicomLayout read_layout(const DicomFile& file) {
  const DicomSet& data = file.data;
  DicomLayout layout;
  layout.path = file.path;
  layout.transfer_syntax = file.transfer_syntax;
  layout.big_endian = file.big_endian;
  layout.sop_class = data.text(0x00080016);
  layout.series = data.text(0x0020000e);
  layout.series_description = data.text(0x0008103e);
  layout.study = data.text(0x0020000d);
  layout.patient = data.text(0x00100020);
  layout.patient_position = data.text(0x00185100);
  layout.kernel = data.text(0x00181210);
  layout.voltage = setting_text(data, 0x00180060, " kV");
  layout.echo = setting_text(data, 0x00180081, " ms");
  layout.inversion = setting_text(data, 0x00180082, " ms");
  layout.flip_angle = setting_text(data, 0x00181314, " degrees");
  if (const std::optional<double> b_value = data.float64(0x00189087)) {
    layout.b_value = precise_text(*b_value) + " s/mm2";
  }
  layout.temporal_position = data.text(0x00200100);
  layout.acquisition = data.text(0x00200012);
  layout.modality = data.text(0x00080060);
  layout.image_type = data.text(0x00080008);
  layout.picture_kind = picture_kind(layout.image_type);
  layout.photometric = data.text(0x00280004);
  layout.frame_of_reference = data.text(0x00200052);
  layout.pet_units = data.text(0x00541001);
  layout.rows = required(file, 0x00280010, "Rows");
  layout.columns = required(file, 0x00280011, "Columns");
  layout.samples = data.unsigned_value(0x00280002).value_or(1);
  layout.is_planar = data.unsigned_value(0x00280006).value_or(0) == 1;
  layout.bits_allocated = required(file, 0x00280100, "Bits Allocated");
  layout.bits_stored = data.unsigned_value(0x00280101).value_or(layout.bits_allocated);
  layout.high_bit = data.unsigned_value(0x00280102).value_or(layout.bits_stored - 1);
  layout.is_signed = has_sign(data, file.path);
  layout.was_lossy = data.text(0x00282110) == "01" || is_lossy_syntax(file.transfer_syntax);
  layout.has_burned_in_text = data.text(0x00280301) == "YES";
  layout.shows_who_it_is = data.text(0x00280302) == "YES";
  layout.counts = read_dicom_counts(data);
  layout.pixels = file.pixels;
  layout.elements.assign(file.element_counts.begin(), file.element_counts.end());
  layout.private_elements = file.private_count;
  layout.padding_value = read_padding(layout, data.unsigned_value(0x00280120));
  layout.segmentation_type = data.text(0x00620001);
  layout.segments_overlap = data.text(0x00620013) == "YES";
  layout.max_fraction = data.unsigned_value(0x0062000e).value_or(layout.max_fraction);
  for (const DicomSet& segment : data.items(kSegmentSequence)) {
    layout.segments.push_back({segment.unsigned_value(0x00620004).value_or(0),
                               segment.text(0x00620005),
                               color_of_cielab(segment.words(kSegmentColor))});
  }
  layout.frames = frame_count(data, file.path);
  layout.is_cine = is_cine(data, layout);
  layout.is_slide = is_slide(data, layout);
  if (layout.rows == 0 || layout.columns == 0)
    reject(file.path, "a picture without rows or columns");
  if (layout.rows > kMaxSide || layout.columns > kMaxSide) {
    reject(file.path, "a picture of " + size_text(layout.columns, layout.rows) +
                          " voxels, a DICOM picture has at most 65535 x 65535: it is damaged");
  }
  require_part_for_each_frame(layout);
  find_frame_starts(layout);
  return layout;
}

/// The first item of a functional group macro: of the frame, else of all frames, else nothing.
const DicomSet* macro(const DicomSet& shared, const DicomSet& frame, DicomTag tag) {
  if (!frame.items(tag).empty()) return &frame.items(tag).front();
  if (!shared.items(tag).empty()) return &shared.items(tag).front();
  return nullptr;
}

void take_place(const DicomSet* position, const DicomSet* orientation, const DicomSet* measures,
                DicomSlice& slice) {
  if (position != nullptr) {
    const std::vector<double> mm = position->decimals(kImagePosition);
    if (mm.size() == 3) slice.position_mm = {mm[0], mm[1], mm[2]};
  }
  if (orientation != nullptr) {
    const std::vector<double> v = orientation->decimals(0x00200037);
    if (v.size() == 6) slice.orientation = {v[0], v[1], v[2], v[3], v[4], v[5]};
  }
  if (measures != nullptr) {
    // Pixel Spacing is "distance of rows \ distance of columns".
    const std::vector<double> mm = measures->decimals(0x00280030);
    if (mm.size() == 2) slice.pixel_mm = {mm[1], mm[0]};
    slice.thickness_mm = measures->decimal(0x00180050);
    slice.spacing_mm = measures->decimal(0x00180088);
  }
}

/// A parametric map says what its numbers stand for as a mapping to the real world.
void take_real_world(const DicomSet* mapping, DicomValues& values) {
  if (mapping == nullptr || !values.rescale.is_identity()) return;
  const std::optional<double> slope = mapping->float64(0x00409225);
  if (slope && *slope != 0) values.rescale = {*slope, mapping->float64(0x00409224).value_or(0)};
}

void note_dose_fault(std::vector<DicomSlice>& slices, const std::string& fault) {
  const std::string name = "Grid Frame Offset Vector " + dicom_tag_text(kGridFrameOffsets);
  for (DicomSlice& slice : slices) slice.place_fault = name + " " + fault;
}

/// The frames of an RTDOSE lie along the normal of the first at the offsets that it lists.
void take_dose_planes(const DicomSet& data, std::vector<DicomSlice>& slices) {
  const std::vector<double> offsets = data.decimals(kGridFrameOffsets);
  const std::vector<double> first = data.decimals(kImagePosition);
  if (first.size() != 3 || !slices.front().orientation) return;
  if (offsets.size() != slices.size()) {
    return note_dose_fault(slices, "has " + std::to_string(offsets.size()) + " numbers for " +
                                       std::to_string(slices.size()) + " frames");
  }
  const std::array<double, 6>& v = *slices.front().orientation;
  const Point3 normal = cross({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
  // Others list heights of the patient instead: the first is that of the position.
  const bool are_heights = offsets.front() != 0;
  const bool is_level = normal[0] == 0 && normal[1] == 0 && std::abs(normal[2]) == 1;
  if (are_heights && (offsets.front() != first[2] || !is_level)) {
    return note_dose_fault(slices, "starts with " + precise_text(offsets.front()) +
                                       ", 0 or the height of the position expected");
  }
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const double up = are_heights ? normal[2] : 1;
    const double along = up * (offsets[i] - offsets.front());
    slices[i].position_mm = {first[0] + normal[0] * along, first[1] + normal[1] * along,
                             first[2] + normal[2] * along};
  }
}

}  // namespace

void reject(const DicomLayout& layout, const std::string& why) { reject(layout.path, why); }

std::uint64_t DicomLayout::frame_bytes() const {
  return static_cast<std::uint64_t>(stored_rows() * stored_columns() * samples *
                                    ((bits_allocated + 7) / 8));
}

std::uint64_t DicomLayout::native_bytes() const {
  const auto count = static_cast<std::uint64_t>(frames);
  if (bits_allocated != 1) return frame_bytes() * count;
  return (static_cast<std::uint64_t>(stored_rows() * stored_columns() * samples) * count + 7) / 8;
}

bool DicomLayout::is_segmentation() const { return sop_class == kSegmentation || is_label_map(); }

bool DicomLayout::is_label_map() const { return sop_class == kLabelMap; }

bool DicomLayout::is_binary_segmentation() const {
  return is_segmentation() && segmentation_type != "FRACTIONAL";
}

std::string list_text(std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += '\\';
    text += precise_text(value);
  }
  return text;
}

std::string DicomSlice::name() const {
  const std::string file = escaped(base_name(layout->path));
  if (layout->tile_count > 1) return file + " tile " + std::to_string(tile + 1);
  return layout->frames == 1 ? file : file + " frame " + std::to_string(frame + 1);
}

std::vector<DicomSlice> read_dicom_slices(const std::string& path) {
  const DicomFile file = read_dicom_file(path);
  if (!file.pixels.is_present) {
    require_no_picture(file);
    return {};
  }
  const auto layout = std::make_shared<const DicomLayout>(read_layout(file));
  const std::vector<DicomSet>& shared_items = file.data.items(kSharedGroups);
  const std::vector<DicomSet>& frame_items = file.data.items(kPerFrameGroups);
  if (frame_items.size() > static_cast<std::size_t>(layout->frames)) {
    reject(path, "Per-frame Functional Groups Sequence " + dicom_tag_text(kPerFrameGroups) +
                     " has " + std::to_string(frame_items.size()) +
                     " items, Number of Frames (0028,0008) says " +
                     std::to_string(layout->frames) + "; export the series again");
  }
  const DicomSet none;
  const DicomSet& shared = shared_items.empty() ? none : shared_items.front();
  std::vector<DicomSlice> slices;
  for (std::int64_t i = 0; i < layout->frames; ++i) {
    const auto item = static_cast<std::size_t>(i);
    DicomSlice slice;
    slice.layout = layout;
    slice.frame = i;
    const DicomSet& own = item < frame_items.size() ? frame_items[item] : none;
    slice.moment = read_dicom_moment(file.data, shared, own);
    if (!shared_items.empty() || !frame_items.empty()) {
      take_place(macro(shared, own, kPlanePosition), macro(shared, own, kPlaneOrientation),
                 macro(shared, own, kPixelMeasures), slice);
      slice.values = read_dicom_values(file.data, macro(shared, own, kValueTransformation));
      if (layout->sop_class == kParametricMap) {
        take_real_world(macro(shared, own, kRealWorldMapping), slice.values);
      }
      if (const DicomSet* content = macro(shared, own, kFrameContent)) {
        slice.in_stack_position = content->unsigned_value(0x00209057);
        slice.temporal_index = content->unsigned_value(0x00209128);
      }
      if (const DicomSet* segment = macro(shared, own, kSegmentIdentification)) {
        slice.segment = segment->unsigned_value(0x0062000b).value_or(0);
      }
    } else {
      // Without functional groups one position cannot be that of several frames.
      take_place(layout->frames == 1 ? &file.data : nullptr, &file.data, &file.data, slice);
      slice.values = read_dicom_values(file.data, nullptr);
      slice.instance_number = file.data.decimal(0x00200013);
    }
    slices.push_back(std::move(slice));
  }
  if (is_mosaic(*layout)) return unfold_mosaic(file, slices.front());
  if (layout->modality == "RTDOSE" && layout->frames > 1) take_dose_planes(file.data, slices);
  if (layout->modality == "NM" && layout->frames > 1) take_nuclear_slices(file.data, slices);
  return slices;
}

}  // namespace octavo
