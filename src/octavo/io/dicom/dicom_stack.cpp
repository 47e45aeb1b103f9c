#include "octavo/io/dicom/dicom_stack.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/source/described_source.h"

namespace octavo {

namespace {

constexpr double kMaxTiltDegrees = 45;
/// How many times larger a canvas, and a count of resampled planes, may be than what there is: a
/// few positions far away must not make a volume without end.
constexpr double kMaxCanvasGrowth = 8;
constexpr double kMaxPlaneGrowth = 64;
/// Planes that a segmentation may leave out, however few it holds.
constexpr double kMaxEmptyPlanes = 4096;
constexpr double kAirHounsfield = -1000;
/// Of a step: less than this behind the last plane is not worth a word.
constexpr double kNoticeableRest = 0.05;
/// Slices further apart were not thinned out.
constexpr double kMaxThinning = 64;
constexpr std::size_t kMaxListedRuns = 1000;
/// A shift so near to whole voxels moves voxels unchanged.
constexpr double kWholeShift = 1e-3;

/// hints  the options that would change it
[[noreturn]] void reject(const DicomStack& stack, const std::string& why,
                         const std::vector<OptionHint>& hints = {}) {
  Error failure(ErrorKind::source_rejected, why, stack.slices.front().layout->path);
  for (const auto& [field, value] : hints) failure = failure.with_field(field, value);
  throw failure;
}

std::string count_text(std::size_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

double rounded(double value, double steps) { return std::round(value * steps) / steps; }

/// Some scanners write the gap between slices as their spacing: then it makes up a step with their
/// thickness. Where both are one length but for rounding, the step is twice the spacing instead.
bool states_gap(const DicomSlice& slice, double step_mm) {
  const std::optional<double> spacing = slice.spacing_mm;
  const std::optional<double> thickness = slice.thickness_mm;
  const double tolerance = tolerance_mm(step_mm);
  return spacing && thickness && std::abs(*spacing - *thickness) > tolerance &&
         std::abs(*spacing + *thickness - step_mm) <= tolerance;
}

/// The step of a segmentation whose empty planes are left out, where its frames lie on a grid of
/// the spacing that it states. It counts from center to center, as the standard has it.
std::optional<double> stated_step_mm(const DicomStack& stack, const SlicePlaces& places) {
  const DicomSlice& first = stack.slices.front();
  if (!stack.leaves_out_empty || !first.spacing_mm || !(*first.spacing_mm > 0)) return std::nullopt;
  return grid_step_near_mm(places, *first.spacing_mm);
}

/// The step of an even grid through all slices; nothing when there is no such grid.
std::optional<double> even_step_mm(const DicomStack& stack, const SlicePlaces& places) {
  const std::optional<double> stated = stated_step_mm(stack, places);
  return stated ? stated : grid_step_mm(places);
}

/// Planes that this grid lacks.
std::optional<double> missing_planes(const DicomStack& stack, const SlicePlaces& places) {
  const std::optional<double> step = even_step_mm(stack, places);
  if (!step) return std::nullopt;
  return std::round(places.height_mm.back() / *step) + 1 - static_cast<double>(places.count());
}

/// More planes than there are slices are not made up, but may well be left empty.
bool is_fillable(const DicomStack& stack, double missing) {
  const auto count = static_cast<double>(stack.slices.size());
  return missing <= (stack.leaves_out_empty ? std::max(kMaxPlaneGrowth * count, kMaxEmptyPlanes)
                                            : count);
}

/// Rejects uneven steps and tilt where no option says what to do about them.
void require_even(const DicomStack& stack, const SlicePlaces& places,
                  const SourceOptions& options) {
  const std::string jump = find_sideways_jump(stack.slices, places);
  std::string faults;
  std::vector<OptionHint> hints;
  if (const double degrees = tilt_degrees(places); degrees > 0 && !options.untilt) {
    const double sideways = std::hypot(places.shift_mm.back()[0], places.shift_mm.back()[1]);
    faults = "the slices are sheared (gantry tilt): from " + stack.slices.front().name() + " to " +
             stack.slices.back().name() + " they shift " + mm_text(sideways) + " sideways over " +
             mm_text(places.height_mm.back()) + ", an angle of " +
             precise_text(rounded(degrees, 100)) + " degrees";
    hints.push_back({"untilt", ""});
  }
  if (const std::string uneven = find_uneven_step(stack.slices, places);
      !uneven.empty() && options.on_gap == GapPolicy::error && !stated_step_mm(stack, places)) {
    const std::optional<double> missing = missing_planes(stack, places);
    const bool can_fill = missing && is_fillable(stack, *missing);
    faults += (faults.empty() ? "" : "; also ") + uneven;
    hints.push_back({"on_gap", can_fill ? "fill" : "resample"});
  }
  if (!jump.empty()) reject(stack, jump + (faults.empty() ? "" : "; also ") + faults);
  if (!faults.empty()) reject(stack, faults + "; complete the series", hints);
}

/// How many times further apart slices lie than `expected_mm`, where that is a whole number above
/// 1; else 0.
std::int64_t whole_times(double step_mm, std::optional<double> expected_mm) {
  if (!expected_mm || !(*expected_mm > 0)) return 0;
  const double times = std::round(step_mm / *expected_mm);
  const bool is_whole = std::abs(step_mm - times * *expected_mm) <= tolerance_mm(step_mm);
  return is_whole && times >= 2 && times <= kMaxThinning ? static_cast<std::int64_t>(times) : 0;
}

/// The step of the instance numbers along the stack; 0 where they have none.
std::int64_t number_step(const std::vector<DicomSlice>& slices) {
  std::optional<double> step;
  for (std::size_t i = 1; i < slices.size(); ++i) {
    if (!slices[i].instance_number || !slices[i - 1].instance_number) return 0;
    const double found = std::abs(*slices[i].instance_number - *slices[i - 1].instance_number);
    if (step.value_or(found) != found) return 0;
    step = found;
  }
  return step && *step <= kMaxThinning ? static_cast<std::int64_t>(*step) : 0;
}

/// Warns where the slices are even and yet only every second or third of those that were taken may
/// be there: by the spacing that they state, or by their thickness and their numbers.
void tell_of_thinning(DicomStack& stack, double step_mm) {
  const std::optional<double> spacing = stack.slices.front().spacing_mm;
  const std::optional<double> thickness = stack.slices.front().thickness_mm;
  const bool is_gap = states_gap(stack.slices.front(), step_mm);
  const std::int64_t by_spacing = is_gap ? 0 : whole_times(step_mm, spacing);
  const std::int64_t by_thickness = whole_times(step_mm, thickness);
  const bool is_numbered_so = by_thickness >= 2 && number_step(stack.slices) == by_thickness;
  if (by_spacing == 0 && !is_numbered_so) return;
  const std::int64_t times = by_spacing != 0 ? by_spacing : by_thickness;
  stack.warnings.push_back(
      "the slices lie " + mm_text(step_mm) + " apart, " + std::to_string(times) + " times what " +
      (by_spacing != 0 ? "their Spacing Between Slices (0018,0088) says"
                       : "their thickness and their instance numbers say") +
      ": others may be missing between them; complete the series, or check these lengths");
}

/// Says where even planes of a segmentation may be those that are left when empty ones are not
/// stored, and no spacing tells.
void tell_of_omission(DicomStack& stack, double step_mm) {
  const DicomSlice& first = stack.slices.front();
  const std::int64_t times = whole_times(step_mm, first.thickness_mm);
  if (first.spacing_mm || times == 0) return;
  stack.warnings.push_back("the planes lie " + mm_text(step_mm) + " apart, " +
                           std::to_string(times) +
                           " times their Slice Thickness (0018,0050), and Spacing Between Slices "
                           "(0018,0088) is not there: empty planes between them may not be stored");
}

/// One plane on each slice.
double take_slices(DicomStack& stack, const SlicePlaces& places) {
  for (std::size_t i = 0; i < places.count(); ++i) stack.planes.push_back({i});
  return places.height_mm.back() / static_cast<double>(places.count() - 1);
}

/// Planes between the slices of a grid with gaps.
double fill_gaps(DicomStack& stack, const SlicePlaces& places) {
  const std::optional<double> step = even_step_mm(stack, places);
  const std::optional<double> missing = missing_planes(stack, places);
  if (!step || !missing) {
    reject(stack,
           find_uneven_step(stack.slices, places) +
               " and lie on no even grid whose gaps could be filled",
           {{"on_gap", "resample"}});
  }
  if (!is_fillable(stack, *missing)) {
    const std::string uneven = find_uneven_step(stack.slices, places);
    reject(stack,
           uneven + (uneven.empty() ? "" : "; ") + precise_text(*missing) +
               " planes would be made from " + count_text(places.count(), "slice") +
               ": too many to be called filling; find the missing slices",
           {{"on_gap", "resample"}});
  }
  for (std::size_t i = 0; i + 1 < places.count(); ++i) {
    const auto count = static_cast<std::int64_t>(std::round(places.step_mm(i + 1) / *step));
    for (std::int64_t k = 0; k < count; ++k) {
      const double weight = static_cast<double>(k) / static_cast<double>(count);
      stack.planes.push_back({i, weight, k > 0 && stack.leaves_out_empty});
    }
  }
  stack.planes.push_back({places.count() - 1});
  return *step;
}

/// Even planes from slices at any heights; those that lie at one keep its voxels.
double resample_heights(DicomStack& stack, const SlicePlaces& places) {
  const double step = smallest_regular_step_mm(places);
  const double top = places.height_mm.back();
  const double tolerance = tolerance_mm(step);
  if (top / step > kMaxPlaneGrowth * static_cast<double>(places.count())) {
    reject(stack, find_uneven_step(stack.slices, places) + "; at a regular step of " +
                      mm_text(step) + ", " + count_text(places.count(), "slice") + " over " +
                      mm_text(top) + " would become " + precise_text(std::floor(top / step) + 1) +
                      " planes, too many to be made from them; leave out slices that lie far away");
  }
  const auto count = static_cast<std::int64_t>(std::floor((top + tolerance) / step)) + 1;
  std::size_t below = 0;
  for (std::int64_t k = 0; k < count; ++k) {
    const double height = static_cast<double>(k) * step;
    while (below + 1 < places.count() && places.height_mm[below + 1] <= height + tolerance) ++below;
    const double above_it = height - places.height_mm[below];
    const bool is_slice = above_it <= tolerance || below + 1 == places.count();
    stack.planes.push_back({below, is_slice ? 0 : above_it / places.step_mm(below + 1)});
  }
  const double rest = top - static_cast<double>(count - 1) * step;
  if (rest > kNoticeableRest * step) stack.gaps.left_out_mm = rest;
  return step;
}

void tell_of_gaps(DicomStack& stack, double step_mm) {
  const auto made = static_cast<std::size_t>(stack.made_plane_count());
  const std::size_t kept = stack.planes.size() - made;
  std::string text;
  if (stack.gaps.policy == GapPolicy::fill) {
    text = count_text(made, "missing plane") +
           (stack.leaves_out_empty ? " left empty, a step of " + mm_text(step_mm)
                                   : " interpolated between the neighbors") +
           "; " + count_text(kept, "plane") + " as in the slices";
  } else {
    text = "uneven slices resampled to a step of " + mm_text(step_mm) + ": " +
           count_text(made, "plane") + " made from two slices each, " + count_text(kept, "plane") +
           " as in the slices";
    if (stack.gaps.left_out_mm > 0) {
      text += "; the last " + mm_text(stack.gaps.left_out_mm) +
              ", less than a step, hold no plane";
    }
  }
  stack.warnings.push_back(text);
}

/// What stands where no slice reaches: the padding of the files, air in CT, else 0.
double outside_value(const DicomStack& stack) {
  const DicomSlice& slice = stack.slices.front();
  const DicomLayout& layout = *slice.layout;
  if (stack.leaves_out_empty) return 0;
  if (layout.padding_value) return static_cast<double>(*layout.padding_value);
  const double value =
      layout.modality == "CT"
          ? std::round((kAirHounsfield - slice.values.rescale.intercept) /
                       slice.values.rescale.slope)
          : 0;
  const double span = std::ldexp(1.0, static_cast<int>(layout.bits_stored));
  const double lowest = layout.is_signed ? -span / 2 : 0;
  return std::clamp(value, lowest, lowest + span - 1);
}

void remove_tilt(DicomStack& stack, const SlicePlaces& places) {
  TiltRemoval tilt;
  tilt.angle_degrees = tilt_degrees(places);
  if (tilt.angle_degrees > kMaxTiltDegrees) {
    reject(stack, "the slices shift sideways at an angle of " +
                      precise_text(rounded(tilt.angle_degrees, 100)) +
                      " degrees, more than the 45 degrees of any gantry: their positions are "
                      "wrong, and taking out a tilt does not help");
  }
  const std::array<double, 2>& pixel_mm = *stack.slices.front().pixel_mm;
  std::array<double, 2> min_mm{};
  for (const auto& shift : places.shift_mm) {
    for (std::size_t axis = 0; axis < 2; ++axis)
      min_mm[axis] = std::min(min_mm[axis], shift[axis]);
  }
  std::array<double, 2> most{};
  for (const auto& shift : places.shift_mm) {
    std::array<double, 2>& voxels = tilt.shift.emplace_back();
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double exact = (shift[axis] - min_mm[axis]) / pixel_mm[axis];
      const double whole = std::round(exact);
      voxels[axis] = std::abs(exact - whole) <= kWholeShift ? whole : exact;
      most[axis] = std::max(most[axis], voxels[axis]);
    }
  }
  const DicomLayout& layout = *stack.slices.front().layout;
  if (most[0] > kMaxCanvasGrowth * static_cast<double>(layout.columns) ||
      most[1] > kMaxCanvasGrowth * static_cast<double>(layout.rows)) {
    reject(stack, "the slices shift sideways by " + precise_text(std::max(most[0], most[1])) +
                      " voxels, many times their size of " +
                      size_text(layout.columns, layout.rows) +
                      ": their positions are wrong, and taking out a tilt does not help");
  }
  tilt.columns = layout.columns + static_cast<std::int64_t>(std::ceil(most[0]));
  tilt.rows = layout.rows + static_cast<std::int64_t>(std::ceil(most[1]));
  tilt.outside = outside_value(stack);
  for (std::size_t i = 0; i < 3; ++i) {
    stack.geometry.origin_mm[i] +=
        places.axes.row[i] * min_mm[0] + places.axes.column[i] * min_mm[1];
  }
  stack.warnings.push_back(
      "gantry tilt of " + precise_text(rounded(tilt.angle_degrees, 100)) +
      " degrees removed: slices moved within their planes by up to " +
      precise_text(rounded(std::hypot(most[0], most[1]), 10)) + " voxels and " +
      (stack.holds_labels ? "sampled anew" : "interpolated") + "; " +
      size_text(layout.columns, layout.rows) + " grows to " + size_text(tilt.columns, tilt.rows) +
      ", stored value " + precise_text(tilt.outside) + " where no slice reaches");
  stack.tilt = std::move(tilt);
}

/// Runs of made planes, in order.
std::vector<PlaneRun> made_runs(const std::vector<PlaneOrigin>& planes) {
  std::vector<PlaneRun> runs;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (planes[i].weight_above == 0) continue;
    const auto z = static_cast<std::int64_t>(i);
    if (!runs.empty() && runs.back()[1] == z - 1) runs.back()[1] = z;
    else runs.push_back({z, z});
  }
  return runs;
}

GapsNote gaps_note(const DicomStack& stack, const char* method) {
  const bool fills = stack.gaps.policy == GapPolicy::fill;
  GapsNote note;
  note.on_gap = fills ? "fill" : "resample";
  note.method = fills && stack.leaves_out_empty ? "background" : method;
  note.slices = static_cast<std::int64_t>(stack.slices.size());
  note.step_mm = stack.geometry.spacing_mm[2];
  note.made_plane_count = stack.made_plane_count();
  std::vector<PlaneRun> runs = made_runs(stack.planes);
  if (runs.size() <= kMaxListedRuns) note.made_planes = std::move(runs);
  if (stack.gaps.left_out_mm > 0) note.left_out_mm = stack.gaps.left_out_mm;
  return note;
}

}  // namespace

Size3 DicomStack::size() const {
  const DicomLayout& layout = *slices.front().layout;
  const auto planes_count = static_cast<std::int64_t>(planes.size());
  if (tilt) return {tilt->columns, tilt->rows, planes_count};
  return {layout.columns, layout.rows, planes_count};
}

std::int64_t DicomStack::made_plane_count() const {
  return std::count_if(planes.begin(), planes.end(),
                       [](const PlaneOrigin& plane) { return plane.weight_above > 0; });
}

void plan_planes(DicomStack& stack, const SlicePlaces& places, const SourceOptions& options) {
  require_even(stack, places, options);
  double& step = stack.geometry.spacing_mm[2];
  const bool lacks_none = missing_planes(stack, places).value_or(0) == 0;
  if (find_uneven_step(stack.slices, places).empty() && lacks_none) {
    step = take_slices(stack, places);
    if (stack.leaves_out_empty) tell_of_omission(stack, step);
    else tell_of_thinning(stack, step);
  } else {
    // What a segmentation leaves out is empty, not something between its neighbors.
    const bool fills = options.on_gap == GapPolicy::fill ||
                       (stack.leaves_out_empty && even_step_mm(stack, places).has_value());
    stack.gaps.policy = fills ? GapPolicy::fill : GapPolicy::resample;
    step = fills ? fill_gaps(stack, places) : resample_heights(stack, places);
    tell_of_gaps(stack, step);
  }
  if (options.untilt && tilt_degrees(places) > 0) remove_tilt(stack, places);
}

std::optional<PreparedNote> preparation_note(const DicomStack& stack) {
  const bool has_gaps = stack.gaps.policy != GapPolicy::error;
  if (stack.dropped_duplicates == 0 && !has_gaps && !stack.tilt) return std::nullopt;
  const char* method = stack.holds_labels ? "nearest" : "linear";
  PreparedNote note;
  if (stack.dropped_duplicates > 0) {
    note.dropped_duplicates = static_cast<std::int64_t>(stack.dropped_duplicates);
  }
  if (has_gaps) note.gaps = gaps_note(stack, method);
  if (stack.tilt) {
    const DicomLayout& layout = *stack.slices.front().layout;
    TiltNote& tilt = note.tilt.emplace();
    tilt.angle_degrees = stack.tilt->angle_degrees;
    tilt.method = method;
    tilt.slice_size = {layout.columns, layout.rows};
    tilt.outside = stack.tilt->outside;
  }
  return note;
}

}  // namespace octavo
