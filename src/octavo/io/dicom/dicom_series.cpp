#include "octavo/io/dicom/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/io/dicom/dicom_moment.h"
#include "octavo/io/dicom/dicom_pixels.h"
#include "octavo/io/source/described_source.h"

namespace octavo {

namespace {

constexpr double kAlikeTolerance = 1e-3;

[[noreturn]] void reject(const DicomSlice& slice, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, slice.layout->path);
}

void require_same(const DicomSlice& a, const DicomSlice& b, const char* what,
                  const std::string& in_a, const std::string& in_b) {
  if (in_a == in_b) return;
  reject(b, std::string(what) + " is " + escaped(in_b) + " in " + b.name() + " and " +
                escaped(in_a) + " in " + a.name() + "; the slices of a volume must agree");
}

std::string type_text(const DicomLayout& l) {
  return std::to_string(l.bits_allocated) + " bits allocated, " + std::to_string(l.bits_stored) +
         " stored, " + (l.is_signed ? "signed" : "unsigned") + ", " + std::to_string(l.samples) +
         (l.samples == 1 ? " sample" : " samples");
}

std::string name_or(const std::string& name) { return name.empty() ? "not named" : name; }

template <std::size_t n>
bool are_close(const std::array<double, n>& a, const std::array<double, n>& b) {
  for (std::size_t i = 0; i < n; ++i) {
    const double scale = std::max({std::abs(a[i]), std::abs(b[i]), 1e-3});
    // Direction cosines are of size 1; a thousandth of that is the tolerance for all of them.
    const double allowed = n == 6 ? kAlikeTolerance : kAlikeTolerance * scale;
    if (std::abs(a[i] - b[i]) > allowed) return false;
  }
  return true;
}

template <std::size_t n>
void require_close(const DicomSlice& a, const DicomSlice& b, const char* what,
                   const std::optional<std::array<double, n>>& in_a,
                   const std::optional<std::array<double, n>>& in_b) {
  if (in_a && in_b && are_close(*in_a, *in_b)) return;
  require_same(a, b, what, in_a ? list_text(*in_a) : "absent", in_b ? list_text(*in_b) : "absent");
}

void require_alike(const DicomSlice& a, const DicomSlice& b) {
  const DicomLayout& x = *a.layout;
  const DicomLayout& y = *b.layout;
  require_same(a, b, "the size", size_text(x.columns, x.rows), size_text(y.columns, y.rows));
  require_same(a, b, "the voxel type", type_text(x), type_text(y));
  require_same(a, b, "the photometric interpretation", x.photometric, y.photometric);
  require_close(a, b, "the orientation", a.orientation, b.orientation);
  require_close(a, b, "the pixel spacing", a.pixel_mm, b.pixel_mm);
  require_same(a, b, "the unit of real values", name_or(a.values.unit), name_or(b.values.unit));
  require_same(a, b, "the unit of PET values", name_or(x.pet_units), name_or(y.pet_units));
  const Rescale& in_a = a.values.rescale;
  const Rescale& in_b = b.values.rescale;
  if (in_a == in_b) return;
  const auto text = [](const Rescale& rescale) {
    return precise_text(rescale.slope) + " x + " + precise_text(rescale.intercept);
  };
  const bool is_shown = text(in_a) != text(in_b);
  reject(b, "the rescale " +
                (is_shown ? "is " + text(in_b) + " in " + b.name() + " and " + text(in_a) + " in " +
                                a.name()
                          : "differs between " + b.name() + " and " + a.name() +
                                " beyond the digits shown") +
                "; a volume has one: write the series as real values (float32) to NIfTI, NRRD or "
                "MetaImage, and build that");
}

struct SharedName {
  const char* what;
  std::string DicomLayout::*of;
  bool is_shown;  ///< else it may name somebody
};

/// Two slices of different names, the first and the last in their order; none where all agree, or
/// where about every slice has a name of its own, as some programs that remove names from scans
/// make them do: that says nothing. A blank name is none.
std::optional<std::pair<const DicomSlice*, const DicomSlice*>> find_two(
    const std::vector<DicomSlice>& slices, const SharedName& name) {
  std::map<std::string, const DicomSlice*> found;
  std::size_t naming = 0;
  for (const DicomSlice& slice : slices) {
    const std::string& own = (*slice.layout).*name.of;
    if (own.empty()) continue;
    ++naming;
    found.try_emplace(own, &slice);
  }
  if (found.size() < 2 || found.size() * 2 > naming + 1) return std::nullopt;
  return std::pair(found.begin()->second, found.rbegin()->second);
}

/// Positions in different frames of reference do not stand in one space, nor do those of different
/// patients and studies.
void require_one_space(const std::vector<DicomSlice>& slices) {
  for (const SharedName& name :
       {SharedName{"the frame of reference", &DicomLayout::frame_of_reference, true},
        SharedName{"the Patient ID (0010,0020)", &DicomLayout::patient, false},
        SharedName{"the Study Instance UID (0020,000d)", &DicomLayout::study, true}}) {
    const auto two = find_two(slices, name);
    if (!two) continue;
    const auto& [first, other] = *two;
    if (name.is_shown) {
      require_same(*first, *other, name.what, (*first->layout).*name.of,
                   (*other->layout).*name.of);
    }
    reject(*other, std::string(name.what) + " differs between " + other->name() + " and " +
                       first->name() + "; the slices of a volume must agree");
  }
}

/// Settings that the slices of one volume share.
constexpr SharedName kSettings[] = {
    {"Convolution Kernel (0018,1210)", &DicomLayout::kernel, true},
    {"Patient Position (0018,5100)", &DicomLayout::patient_position, true},
    {"KVP (0018,0060)", &DicomLayout::voltage, true},
    {"Echo Time (0018,0081)", &DicomLayout::echo, true},
    {"Inversion Time (0018,0082)", &DicomLayout::inversion, true},
    {"Flip Angle (0018,1314)", &DicomLayout::flip_angle, true},
    {"Diffusion b-value (0018,9087)", &DicomLayout::b_value, true},
    {"Temporal Position Identifier (0020,0100)", &DicomLayout::temporal_position, true},
    {"Image Type (0008,0008)", &DicomLayout::picture_kind, true}};

/// What tells several pictures of one place apart where no moment does, also where it is no number.
constexpr SharedName kAcquisition = {"Acquisition Number (0020,0012)", &DicomLayout::acquisition,
                                     true};

/// Slices of several volumes may be mixed though no two lie at one place.
void tell_of_mixture(DicomStack& stack) {
  for (const SharedName& name : kSettings) {
    const auto two = find_two(stack.slices, name);
    if (!two) continue;
    const auto& [first, other] = *two;
    stack.warnings.push_back(std::string(name.what) + " is " +
                             escaped((*first->layout).*name.of) + " in " + first->name() +
                             " and " + escaped((*other->layout).*name.of) + " in " +
                             other->name() +
                             ": slices of several volumes may be mixed; build each of them from "
                             "its own files");
  }
}

std::string pair_text(const DicomSlice& a, const DicomSlice& b) {
  return a.name() + " and " + b.name();
}

UnsetBytes voxels_of(const DicomSlice& slice) {
  const DicomLayout& layout = *slice.layout;
  UnsetBytes voxels(static_cast<std::size_t>(
      layout.columns * layout.rows * bytes_per_voxel(dicom_voxel_type(layout))));
  read_dicom_frame(slice, voxels.bytes());
  return voxels;
}

/// What tells that two slices at one place are of several volumes; nothing where no setting does.
std::string difference_of(const DicomSlice& kept, const DicomSlice& slice) {
  const auto told_by = [&](const SharedName& name) -> std::string {
    const std::string& first = (*kept.layout).*name.of;
    const std::string& other = (*slice.layout).*name.of;
    if (first.empty() || other.empty() || first == other) return {};
    return std::string(name.what) + " is " + escaped(first) + " and " + escaped(other);
  };
  for (const SharedName& name : kSettings) {
    if (std::string text = told_by(name); !text.empty()) return text;
  }
  const std::string moment = moment_difference(kept, slice);
  return moment.empty() ? told_by(kAcquisition) : moment;
}

/// What can be done about two slices of which a setting tells that they are of several volumes.
const char* advice_for_volumes(const DicomSlice& kept, const DicomSlice& slice) {
  return kept.layout == slice.layout ? "; not all of them have the same places: export each alone"
                                     : "; build each of them from its own files";
}

/// What can be done about two slices of one place.
const char* advice_for(const DicomSlice& kept, const DicomSlice& slice) {
  return kept.layout == slice.layout
             ? "; the file may hold several volumes (times, echoes): export one of them alone"
             : "; remove one of them";
}

/// Rejects a slice at the height of the one kept before it, unless it is its copy at the same
/// place and copies may go.
void require_copy(const DicomSlice& kept, const DicomSlice& slice, double sideways_mm,
                  bool may_drop) {
  const std::string pair = pair_text(kept, slice);
  const std::string difference = difference_of(kept, slice);
  if (sideways_mm > tolerance_mm(std::min((*slice.pixel_mm)[0], (*slice.pixel_mm)[1]))) {
    reject(slice, pair + " lie at the same height along the normal, " + mm_text(sideways_mm) +
                      " apart sideways" +
                      (difference.empty() ? advice_for(kept, slice)
                                          : ", and are of several volumes: " + difference +
                                                advice_for_volumes(kept, slice)));
  }
  const Point3& at = *kept.position_mm;
  const std::string place = pair + " lie at the same position (" + precise_text(at[0]) + ", " +
                            precise_text(at[1]) + ", " + mm_text(at[2]) + ")";
  if (!may_drop && !difference.empty()) {
    reject(slice, place + ", but are of several volumes: " + difference +
                      advice_for_volumes(kept, slice));
  }
  if (!may_drop) {
    throw Error(ErrorKind::source_rejected, place + advice_for(kept, slice), slice.layout->path)
        .with_field("drop_duplicates");
  }
  if (std::ranges::equal(voxels_of(kept).bytes(), voxels_of(slice).bytes())) return;
  reject(slice, place + ", but their voxels differ: neither is a copy of the other" +
                    advice_for(kept, slice));
}

/// Leaves one slice at each height. Returns the places of those that stay.
SlicePlaces settle_duplicates(DicomStack& stack, const SlicePlaces& all, bool may_drop) {
  const double same_mm = same_height_mm(all);
  SlicePlaces places{all.axes, {}, {}};
  std::vector<DicomSlice> kept;
  std::string example;
  for (std::size_t i = 0; i < all.count(); ++i) {
    DicomSlice& slice = stack.slices[i];
    if (!kept.empty() && all.height_mm[i] - places.height_mm.back() <= same_mm) {
      const double sideways = std::hypot(all.shift_mm[i][0] - places.shift_mm.back()[0],
                                         all.shift_mm[i][1] - places.shift_mm.back()[1]);
      require_copy(kept.back(), slice, sideways, may_drop);
      if (example.empty()) example = slice.name() + " of " + kept.back().name();
      ++stack.dropped_duplicates;
      continue;
    }
    places.height_mm.push_back(all.height_mm[i]);
    places.shift_mm.push_back(all.shift_mm[i]);
    kept.push_back(std::move(slice));
  }
  stack.slices = std::move(kept);
  if (stack.dropped_duplicates > 0) {
    const bool is_one = stack.dropped_duplicates == 1;
    stack.warnings.push_back(std::to_string(stack.dropped_duplicates) +
                             (is_one ? " copy of a slice" : " copies of slices") +
                             " left out (same position, same voxels): " + example +
                             (is_one ? "" : " and others"));
  }
  return places;
}

/// The distance of planes of a single slice cannot be measured.
double lone_spacing(const DicomSlice& slice, DicomStack& stack) {
  const auto is_length = [](std::optional<double> mm) { return mm && *mm > 0; };
  const bool has_spacing = is_length(slice.spacing_mm);
  const std::optional<double> found = has_spacing ? slice.spacing_mm : slice.thickness_mm;
  stack.warnings.push_back(
      std::string("a single slice: its ") +
      (has_spacing ? "Spacing Between Slices (0018,0088)" : "thickness") + " of " +
      (is_length(found) ? mm_text(*found) : std::string("1 mm (assumed)")) +
      " stands for the distance of planes");
  return is_length(found) ? *found : 1.0;
}

void place_stack(DicomStack& stack, const SourceOptions& options) {
  const SlicePlaces all = sort_along_normal(stack.slices);
  const SlicePlaces places = settle_duplicates(stack, all, options.drop_duplicates);
  const DicomSlice& first = stack.slices.front();
  const std::array<double, 2>& pixel = *first.pixel_mm;
  if (!(pixel[0] > 0 && pixel[1] > 0)) {
    reject(first, "its pixel spacing " + list_text(pixel) + " is not positive");
  }
  stack.geometry.origin_mm = *first.position_mm;
  stack.geometry.spacing_mm = {pixel[0], pixel[1], 1};
  for (std::size_t i = 0; i < 3; ++i) {
    stack.geometry.direction[i * 3] = places.axes.row[i];
    stack.geometry.direction[i * 3 + 1] = places.axes.column[i];
    stack.geometry.direction[i * 3 + 2] = places.axes.normal[i];
  }
  stack.spacing_known = true;
  if (stack.slices.size() > 1) {
    plan_planes(stack, places, options);
  } else {
    stack.geometry.spacing_mm[2] = lone_spacing(first, stack);
    stack.planes = {PlaneOrigin{}};
  }
}

bool has_geometry(const DicomSlice& slice) {
  return slice.position_mm && slice.orientation && slice.pixel_mm;
}

/// What tells the order of slices without positions.
struct OrderNumber {
  const char* name;
  bool is_of_frames;  ///< else the frames of a file share one
  std::optional<double> (*of)(const DicomSlice&);
};

constexpr OrderNumber kInstanceNumber = {
    "Instance Number (0020,0013)", false,
    [](const DicomSlice& slice) { return slice.instance_number; }};
constexpr OrderNumber kInStackPosition = {
    "In-Stack Position Number (0020,9057)", true,
    [](const DicomSlice& slice) -> std::optional<double> {
      if (!slice.in_stack_position) return std::nullopt;
      return static_cast<double>(*slice.in_stack_position);
    }};

/// Rejects slices of one number, between which nothing decides, and warns where one may be missing.
void check_numbers(DicomStack& stack, const OrderNumber& number) {
  std::optional<double> usual;
  for (std::size_t i = 1; i < stack.slices.size(); ++i) {
    const DicomSlice& below = stack.slices[i - 1];
    const DicomSlice& slice = stack.slices[i];
    if (!number.is_of_frames && below.layout == slice.layout) continue;
    const double step = *number.of(slice) - *number.of(below);
    const std::string text = precise_text(*number.of(slice));
    if (step == 0) {
      reject(slice, below.name() + " and " + slice.name() + " have one " + number.name + ", " +
                        text + ", and no positions: nothing tells their order" +
                        advice_for(below, slice));
    }
    if (usual.value_or(step) != step) {
      stack.warnings.push_back(std::string(number.name) + " goes from " +
                               precise_text(*number.of(below)) + " in " + below.name() + " to " +
                               text + " in " + slice.name() + ", elsewhere by " +
                               precise_text(*usual) + ": a slice may be missing");
      return;
    }
    usual = step;
  }
}

/// Without positions the order is that of the instance numbers; of the frames of one file, that of
/// their places in a stack, or that in which they stand.
void order_by_number(DicomStack& stack) {
  std::vector<DicomSlice>& slices = stack.slices;
  const bool is_one_file = slices.front().layout == slices.back().layout;
  const OrderNumber& number = is_one_file ? kInStackPosition : kInstanceNumber;
  const bool have_numbers = std::ranges::all_of(
      slices, [&](const DicomSlice& slice) { return number.of(slice).has_value(); });
  if (!have_numbers && is_one_file) return;
  for (const DicomSlice& slice : slices) {
    if (have_numbers) break;
    if (number.of(slice)) continue;
    reject(slice,
           "no geometry: neither a position nor an instance number tells its place in the stack");
  }
  std::ranges::stable_sort(slices, {}, [&](const DicomSlice& slice) { return *number.of(slice); });
  check_numbers(stack, number);
}

/// Slices of a stack that was proven before, in their order.
void take_excerpt(DicomStack& stack, const SliceOutline& outline) {
  stack.planes = outline.planes;
  stack.tilt = outline.tilt;
  stack.padding = outline.padding;
  if (stack.planes.empty()) {
    for (std::size_t i = 0; i < stack.slices.size(); ++i) stack.planes.push_back({i});
  }
  const auto lies_beyond = [&](const PlaneOrigin& plane) {
    return plane.below + (plane.weight_above > 0 ? 1 : 0) >= stack.slices.size();
  };
  if (std::ranges::any_of(stack.planes, lies_beyond) ||
      (stack.tilt && stack.tilt->shift.size() != stack.slices.size())) {
    reject(stack.slices.back(), "the slices given are fewer than those that planes are made of");
  }
}

struct SeriesSummary {
  std::size_t slice_count = 0;
  const DicomSlice* first = nullptr;
};

std::string summary_text(const std::string& uid, const SeriesSummary& summary) {
  const DicomLayout& layout = *summary.first->layout;
  const bool is_described = !layout.series_description.empty();
  const std::string about = is_described ? escaped(layout.series_description) : "no description";
  return escaped(uid.empty() ? "(no UID)" : uid) + ": " + std::to_string(summary.slice_count) +
         (summary.slice_count == 1 ? " slice of " : " slices of ") +
         size_text(layout.columns, layout.rows) + ", " + escaped(layout.modality) + ", " + about;
}

}  // namespace

std::vector<DicomSlice> choose_series(std::vector<DicomSlice> slices, const std::string& series,
                                      const std::string& source) {
  std::map<std::string, SeriesSummary> found;
  for (const DicomSlice& slice : slices) {
    SeriesSummary& summary = found[slice.layout->series];
    if (summary.slice_count++ == 0) summary.first = &slice;
  }
  if (series.empty() && found.size() == 1) return slices;
  if (!series.empty() && found.contains(series)) {
    std::erase_if(slices, [&](const DicomSlice& slice) { return slice.layout->series != series; });
    return slices;
  }
  std::string list;
  for (const auto& [uid, summary] : found)
    list += (list.empty() ? "" : "; ") + summary_text(uid, summary);
  const std::string start =
      series.empty() ? std::to_string(found.size()) + " series found: "
                     : "no series " + escaped(series) + " here; there are: ";
  throw Error(ErrorKind::source_rejected, start + list, source).with_field("series");
}

DicomStack prove_stack(std::vector<DicomSlice> slices, const SourceOptions& options) {
  DicomStack stack;
  stack.slices = std::move(slices);
  stack.leaves_out_empty = stack.slices.front().layout->is_segmentation();
  stack.holds_labels = stack.slices.front().layout->is_binary_segmentation();
  const DicomLayout& first = *stack.slices.front().layout;
  if (!first.is_label_map()) stack.padding = first.padding_value;
  for (const DicomSlice& slice : stack.slices) require_alike(stack.slices.front(), slice);
  if (options.excerpt) {
    take_excerpt(stack, *options.excerpt);
    return stack;
  }
  require_one_space(stack.slices);
  tell_of_mixture(stack);
  const auto lacking = std::find_if_not(stack.slices.begin(), stack.slices.end(), has_geometry);
  if (lacking == stack.slices.end()) {
    place_stack(stack, options);
    return stack;
  }
  if (!options.spacing_mm) {
    throw Error(ErrorKind::source_rejected,
                "no geometry: position, orientation or pixel spacing is missing in " +
                    lacking->name() +
                    (lacking->place_fault.empty() ? "" : " (" + lacking->place_fault + ")") +
                    "; only with a spacing are slices taken in their order",
                lacking->layout->path)
        .with_field("spacing_mm");
  }
  order_by_number(stack);
  for (std::size_t i = 0; i < stack.slices.size(); ++i) stack.planes.push_back({i});
  stack.warnings.push_back(
      "positions are not in the files: slices taken in the order of their numbers");
  if (stack.slices.front().layout->is_cine) {
    stack.warnings.push_back(
        "the frames follow one another in time (Frame Increment Pointer (0028,0009) names a time): "
        "they may be moments of one picture and no planes of a volume");
  }
  return stack;
}

}  // namespace octavo
