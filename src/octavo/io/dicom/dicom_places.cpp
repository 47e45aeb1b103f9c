#include "octavo/io/dicom/dicom_places.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/io/source/described_source.h"

namespace octavo {

namespace {

constexpr double kRelativeTolerance = 1e-3;
constexpr double kLengthToleranceMm = 0.01;
constexpr double kGridTolerance = 0.2;  // of a step, behind a gap of many
constexpr double kMaxGap = 1e6;
constexpr double kMinStepMm = 1e-7;
constexpr double kFarthestMm = 1e7;

std::vector<double> sorted_steps(const SlicePlaces& places) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < places.count(); ++i) steps.push_back(places.step_mm(i));
  std::sort(steps.begin(), steps.end());
  return steps;
}

double usual_step_mm(const SlicePlaces& places) {
  const std::vector<double> steps = sorted_steps(places);
  return steps[steps.size() / 2];
}

/// How many steps of the grid lie between slices i - 1 and i; 0 when it is no whole number.
std::int64_t grid_steps(const SlicePlaces& places, std::size_t i, double grid_mm) {
  const double step = places.step_mm(i);
  const double count = std::round(step / grid_mm);
  const double allowed = std::min(count * tolerance_mm(grid_mm), kGridTolerance * grid_mm);
  const bool fits = count >= 1 && count < kMaxGap && std::abs(step - count * grid_mm) <= allowed;
  return fits ? static_cast<std::int64_t>(count) : 0;
}

}  // namespace

std::string mm_text(double mm) { return precise_text(std::round(mm * 1e4) / 1e4) + " mm"; }

double tolerance_mm(double step_mm) {
  return std::max(kRelativeTolerance * step_mm, std::min(kLengthToleranceMm, 0.05 * step_mm));
}

SliceAxes slice_axes(const DicomSlice& slice) {
  const std::array<double, 6>& o = *slice.orientation;
  SliceAxes axes{{o[0], o[1], o[2]}, {o[3], o[4], o[5]}, {}};
  const double r = std::sqrt(dot(axes.row, axes.row));
  const double c = std::sqrt(dot(axes.column, axes.column));
  if (std::abs(r - 1) > 0.01 || std::abs(c - 1) > 0.01 ||
      std::abs(dot(axes.row, axes.column)) > kRelativeTolerance) {
    throw Error(ErrorKind::source_rejected,
                "its orientation " + list_text(o) + " is no pair of perpendicular unit vectors",
                slice.layout->path);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    axes.row[i] /= r;
    axes.column[i] /= c;
  }
  axes.normal = cross(axes.row, axes.column);
  return axes;
}

SlicePlaces sort_along_normal(std::vector<DicomSlice>& slices) {
  SlicePlaces places;
  places.axes = slice_axes(slices.front());
  std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return dot(*a.position_mm, places.axes.normal) < dot(*b.position_mm, places.axes.normal);
  });
  for (const DicomSlice& slice : slices) {
    const Point3 way = difference(*slice.position_mm, *slices.front().position_mm);
    if (!(std::sqrt(dot(way, way)) < kFarthestMm)) {
      throw Error(ErrorKind::source_rejected,
                  slices.front().name() + " and " + slice.name() +
                      " lie more than 10 km apart: their positions are no millimeters",
                  slice.layout->path);
    }
    places.height_mm.push_back(dot(way, places.axes.normal));
    places.shift_mm.push_back({dot(way, places.axes.row), dot(way, places.axes.column)});
  }
  return places;
}

double same_height_mm(const SlicePlaces& places) {
  double widest = 0;
  for (std::size_t i = 1; i < places.count(); ++i) widest = std::max(widest, places.step_mm(i));
  return std::max(kMinStepMm, std::min(kLengthToleranceMm, kRelativeTolerance * widest));
}

std::string find_uneven_step(const std::vector<DicomSlice>& slices, const SlicePlaces& places) {
  const double usual = usual_step_mm(places);
  for (std::size_t i = 1; i < places.count(); ++i) {
    const double step = places.step_mm(i);
    if (std::abs(step - usual) <= tolerance_mm(usual)) continue;
    const std::int64_t missing = grid_steps(places, i, usual) - 1;
    return "the step between " + slices[i - 1].name() + " and " + slices[i].name() + " is " +
           mm_text(step) + ", the usual step is " + mm_text(usual) +
           (missing >= 1 ? ": " + std::to_string(missing) +
                               (missing > 1 ? " slices are" : " slice is") + " missing"
                         : ": the slices are uneven");
  }
  return {};
}

std::optional<double> grid_step_mm(const SlicePlaces& places) {
  return grid_step_near_mm(places, sorted_steps(places).front());
}

std::optional<double> grid_step_near_mm(const SlicePlaces& places, double stated_mm) {
  std::int64_t count = 0;
  for (std::size_t i = 1; i < places.count(); ++i) {
    const std::int64_t steps = grid_steps(places, i, stated_mm);
    if (steps == 0) return std::nullopt;
    count += steps;
  }
  return places.height_mm.back() / static_cast<double>(count);
}

double smallest_regular_step_mm(const SlicePlaces& places) {
  const std::vector<double> steps = sorted_steps(places);
  const std::size_t enough = std::max<std::size_t>(2, (steps.size() + 9) / 10);
  for (auto first = steps.begin(); first != steps.end(); ++first) {
    const double limit = *first + 2 * tolerance_mm(*first);
    const auto last = std::upper_bound(first, steps.end(), limit);
    const auto shared = static_cast<std::size_t>(last - first);
    if (shared >= enough) return std::accumulate(first, last, 0.0) / static_cast<double>(shared);
  }
  return usual_step_mm(places);
}

double tilt_degrees(const SlicePlaces& places) {
  const double along = places.height_mm.back();
  const double sideways = std::hypot(places.shift_mm.back()[0], places.shift_mm.back()[1]);
  if (sideways <= std::max(kLengthToleranceMm, kRelativeTolerance * along)) return 0;
  return std::atan2(sideways, along) * 180 / std::numbers::pi;
}

std::string find_sideways_jump(const std::vector<DicomSlice>& slices, const SlicePlaces& places) {
  const double along = places.height_mm.back();
  for (std::size_t i = 1; i < places.count(); ++i) {
    const double step = places.step_mm(i);
    std::array<double, 2> jump{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double lean = places.shift_mm.back()[axis] / along;
      jump[axis] = places.shift_mm[i][axis] - places.shift_mm[i - 1][axis] - lean * step;
    }
    const double jump_mm = std::hypot(jump[0], jump[1]);
    if (jump_mm <= tolerance_mm(step) + kRelativeTolerance * step) continue;
    return "between " + slices[i - 1].name() + " and " + slices[i].name() +
           " the picture shifts " + mm_text(jump_mm) + " sideways in a step of " + mm_text(step);
  }
  return {};
}

}  // namespace octavo
