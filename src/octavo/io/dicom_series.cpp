#include "octavo/io/dicom_series.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/described_source.h"

namespace octavo {

namespace {

constexpr double kRelativeTolerance = 1e-3;
constexpr double kLengthToleranceMm = 0.01;

using Normal = Point3;

double dot(const Point3& a, const Point3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Point3& a) { return std::sqrt(dot(a, a)); }
Point3 minus(const Point3& a, const Point3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point3 cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

std::string mm_text(double mm) { return number_text(std::round(mm * 1e4) / 1e4) + " mm"; }

template <std::size_t n>
std::string list_text(const std::array<double, n>& values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += '\\';
    text += number_text(value);
  }
  return text;
}

/// A length may differ by a thousandth, or by 0.01 mm where that is little beside it.
double tolerance_mm(double step_mm) {
  return std::max(kRelativeTolerance * step_mm, std::min(kLengthToleranceMm, 0.05 * step_mm));
}

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
         " samples";
}

template <std::size_t n>
bool are_close(const std::array<double, n>& a, const std::array<double, n>& b) {
  for (std::size_t i = 0; i < n; ++i) {
    const double scale = std::max({std::abs(a[i]), std::abs(b[i]), 1e-3});
    // Direction cosines are of size 1; a thousandth of that is the tolerance for all of them.
    const double allowed = n == 6 ? kRelativeTolerance : kRelativeTolerance * scale;
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
  require_same(a, b, "the rescale",
               number_text(a.rescale.slope) + " x + " + number_text(a.rescale.intercept),
               number_text(b.rescale.slope) + " x + " + number_text(b.rescale.intercept));
  if (a.rescale == b.rescale) return;
  reject(b, "the rescale differs between " + b.name() + " and " + a.name() +
                " beyond the digits shown");
}

/// Unit vectors along rows and columns, and their normal.
struct Axes {
  Point3 row;
  Point3 column;
  Normal normal;
};

Axes axes_of(const DicomSlice& slice) {
  const std::array<double, 6>& o = *slice.orientation;
  Axes axes{{o[0], o[1], o[2]}, {o[3], o[4], o[5]}, {}};
  const double r = length(axes.row);
  const double c = length(axes.column);
  if (std::abs(r - 1) > 0.01 || std::abs(c - 1) > 0.01 ||
      std::abs(dot(axes.row, axes.column)) > kRelativeTolerance) {
    reject(slice, "its orientation " + list_text(o) + " is no pair of perpendicular unit vectors");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    axes.row[i] /= r;
    axes.column[i] /= c;
  }
  axes.normal = cross(axes.row, axes.column);
  return axes;
}

std::string pair_text(const DicomSlice& a, const DicomSlice& b) {
  return a.name() + " and " + b.name();
}

/// Positions along the normal of sorted slices.
std::vector<double> heights(const std::vector<DicomSlice>& slices, const Normal& normal) {
  std::vector<double> result;
  for (const DicomSlice& slice : slices) result.push_back(dot(*slice.position_mm, normal));
  return result;
}

double median_step(const std::vector<double>& height) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < height.size(); ++i) steps.push_back(height[i] - height[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Refuses two slices at one place.
void refuse_duplicate(const std::vector<DicomSlice>& slices, const std::vector<double>& height) {
  double widest = 0;
  for (std::size_t i = 1; i < height.size(); ++i)
    widest = std::max(widest, height[i] - height[i - 1]);
  for (std::size_t i = 1; i < height.size(); ++i) {
    if (height[i] - height[i - 1] > kRelativeTolerance * widest) continue;
    reject(slices[i], pair_text(slices[i - 1], slices[i]) + " lie at the same position, " +
                          mm_text(height[i - 1]) + " and " + mm_text(height[i]) +
                          " along the normal; remove one of them");
  }
}

/// A step that differs from the usual one; empty when all are even.
std::string find_uneven_step(const std::vector<DicomSlice>& slices,
                             const std::vector<double>& height) {
  const double usual = median_step(height);
  for (std::size_t i = 1; i < height.size(); ++i) {
    const double step = height[i] - height[i - 1];
    if (std::abs(step - usual) <= tolerance_mm(usual)) continue;
    const double missing = std::round(step / usual) - 1;
    const bool is_gap = missing >= 1 && std::abs(step - (missing + 1) * usual) <=
                                            (missing + 1) * tolerance_mm(usual);
    return "the step between " + pair_text(slices[i - 1], slices[i]) + " is " + mm_text(step) +
           ", the usual step is " + mm_text(usual) +
           (is_gap ? ": " + number_text(missing) + (missing > 1 ? " slices are" : " slice is") +
                         " missing"
                   : ": the slices are uneven");
  }
  return {};
}

/// Gantry tilt: slices that shift sideways as they go along; empty when they do not.
std::string find_shear(const std::vector<DicomSlice>& slices, const Normal& normal) {
  const Point3 way = minus(*slices.back().position_mm, *slices.front().position_mm);
  const double along = std::abs(dot(way, normal));
  const double sideways = length(cross(way, normal));
  if (along > 0 && sideways > std::max(kLengthToleranceMm, kRelativeTolerance * along)) {
    const double degrees = std::atan2(sideways, along) * 180 / std::numbers::pi;
    return "the slices are sheared (gantry tilt): from " +
           pair_text(slices.front(), slices.back()) + " they shift " + mm_text(sideways) +
           " sideways over " + mm_text(along) + ", an angle of " +
           number_text(std::round(degrees * 100) / 100) + " degrees";
  }
  for (std::size_t i = 1; i < slices.size(); ++i) {
    const Point3 step = minus(*slices[i].position_mm, *slices[i - 1].position_mm);
    const double shift = length(cross(step, normal));
    const double forward = dot(step, normal);
    if (shift <= tolerance_mm(forward) + kRelativeTolerance * forward) continue;
    return "between " + pair_text(slices[i - 1], slices[i]) + " the picture shifts " +
           mm_text(shift) + " sideways in a step of " + mm_text(forward);
  }
  return {};
}

void prove_positions(const std::vector<DicomSlice>& slices, const Normal& normal) {
  const std::vector<double> height = heights(slices, normal);
  refuse_duplicate(slices, height);
  const std::string uneven = find_uneven_step(slices, height);
  const std::string sheared = find_shear(slices, normal);
  if (uneven.empty() && sheared.empty()) return;
  reject(slices.front(), sheared + (uneven.empty() || sheared.empty() ? "" : "; also ") + uneven +
                             "; complete or resample the series first");
}

/// The distance of planes of a single slice cannot be measured.
double lone_spacing(const DicomSlice& slice, DicomStack& stack) {
  const std::optional<double> thickness = slice.layout->slice_thickness_mm;
  const bool is_usable = thickness && *thickness > 0;
  stack.warnings.push_back("a single slice: its thickness of " +
                           (is_usable ? mm_text(*thickness) : std::string("1 mm (assumed)")) +
                           " stands for the distance of planes");
  return is_usable ? *thickness : 1.0;
}

void place_stack(DicomStack& stack) {
  std::vector<DicomSlice>& slices = stack.slices;
  const Axes axes = axes_of(slices.front());
  std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return dot(*a.position_mm, axes.normal) < dot(*b.position_mm, axes.normal);
  });
  double step = 0;
  if (slices.size() > 1) {
    prove_positions(slices, axes.normal);
    const Point3 way = minus(*slices.back().position_mm, *slices.front().position_mm);
    step = dot(way, axes.normal) / static_cast<double>(slices.size() - 1);
  } else {
    step = lone_spacing(slices.front(), stack);
  }
  const std::array<double, 2>& pixel = *slices.front().pixel_mm;
  stack.geometry.origin_mm = *slices.front().position_mm;
  stack.geometry.spacing_mm = {pixel[0], pixel[1], step};
  for (std::size_t i = 0; i < 3; ++i) {
    stack.geometry.direction[i * 3] = axes.row[i];
    stack.geometry.direction[i * 3 + 1] = axes.column[i];
    stack.geometry.direction[i * 3 + 2] = axes.normal[i];
  }
  stack.spacing_known = true;
}

bool has_geometry(const DicomSlice& slice) {
  return slice.position_mm && slice.orientation && slice.pixel_mm;
}

/// Without positions the order is that of the instance numbers, or of the frames of one file.
void order_by_number(std::vector<DicomSlice>& slices) {
  for (const DicomSlice& slice : slices) {
    if (slice.instance_number || slice.layout == slices.front().layout) continue;
    reject(slice,
           "no geometry: neither a position nor an instance number tells its place in the stack");
  }
  std::stable_sort(slices.begin(), slices.end(), [](const DicomSlice& a, const DicomSlice& b) {
    return a.instance_number.value_or(0) < b.instance_number.value_or(0);
  });
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
      series.empty() ? std::to_string(found.size()) + " series found, give --series UID: "
                     : "no series " + escaped(series) + " here; there are: ";
  throw Error(ErrorKind::source_rejected, start + list, source);
}

DicomStack prove_stack(std::vector<DicomSlice> slices, bool may_lack_geometry) {
  DicomStack stack;
  stack.slices = std::move(slices);
  for (const DicomSlice& slice : stack.slices) require_alike(stack.slices.front(), slice);
  const auto lacking = std::find_if_not(stack.slices.begin(), stack.slices.end(), has_geometry);
  if (lacking == stack.slices.end()) {
    place_stack(stack);
    return stack;
  }
  if (!may_lack_geometry) {
    reject(*lacking, "no geometry: position, orientation or pixel spacing is missing in " +
                         lacking->name() +
                         "; give --spacing x,y,z to take the slices in their order");
  }
  order_by_number(stack.slices);
  stack.warnings.push_back(
      "positions are not in the files: slices taken in the order of their numbers");
  return stack;
}

}  // namespace octavo
