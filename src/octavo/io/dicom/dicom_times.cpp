#include "octavo/io/dicom/dicom_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/io/dicom/dicom_moment.h"
#include "octavo/io/dicom/dicom_places.h"

namespace octavo {

namespace {

/// Slices of one moment, and what their numbers go from and to.
struct Moment {
  double first = 0;
  double last = 0;
  std::vector<std::size_t> slices;
};

using Moments = std::vector<Moment>;  // in the order of their numbers

/// Slices by their numbers; none where one has no number, or all have one.
Moments moments_by(const std::vector<DicomSlice>& slices, const MomentNumber& number) {
  std::map<double, std::vector<std::size_t>> found;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const std::optional<double> value = number.of(slices[i]);
    if (!value) return {};
    found[*value].push_back(i);
  }
  Moments moments;
  for (auto& [value, members] : found) moments.push_back({value, value, std::move(members)});
  return moments.size() > 1 ? moments : Moments();
}

/// The first voxel of a slice, along its normal and within its plane.
struct TimedPlace {
  double height_mm = 0;
  double across_mm = 0;
  double down_mm = 0;
};

constexpr double kSameHeightMm = 1e-3;

/// Slices by the order of their numbers at each height, of which all have as many; none where the
/// numbers of two moments overlap.
Moments moments_in_order(const std::vector<DicomSlice>& slices, const MomentNumber& number,
                         const std::vector<TimedPlace>& places) {
  struct Timed {
    double height_mm;
    double value;
    std::size_t slice;
  };
  std::vector<Timed> all;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const std::optional<double> value = number.of(slices[i]);
    if (!value) return {};
    all.push_back({places[i].height_mm, *value, i});
  }
  std::ranges::sort(all, {}, &Timed::height_mm);
  const auto is_at_first = [&](const Timed& timed) {
    return timed.height_mm - all.front().height_mm <= kSameHeightMm;
  };
  const auto count = static_cast<std::size_t>(std::ranges::count_if(all, is_at_first));
  if (count < 2 || all.size() % count != 0) return {};
  Moments moments(count);
  for (std::size_t at = 0; at < all.size(); at += count) {
    const auto place = std::span(all).subspan(at, count);
    if (place.back().height_mm - place.front().height_mm > kSameHeightMm) return {};
    std::ranges::sort(place, {}, &Timed::value);
    for (std::size_t n = 0; n < count; ++n) {
      Moment& moment = moments[n];
      const double value = place[n].value;
      moment.first = at == 0 ? value : std::min(moment.first, value);
      moment.last = at == 0 ? value : std::max(moment.last, value);
      moment.slices.push_back(place[n].slice);
    }
  }
  for (std::size_t n = 1; n < count; ++n) {
    if (!(moments[n - 1].last < moments[n].first)) return {};
  }
  return moments;
}

/// Whether settings that make several volumes of one moment are those of all slices.
bool share_settings(const std::vector<DicomSlice>& slices) {
  const DicomLayout& a = *slices.front().layout;
  return std::ranges::all_of(slices, [&](const DicomSlice& slice) {
    const DicomLayout& b = *slice.layout;
    return a.kernel == b.kernel && a.echo == b.echo && a.inversion == b.inversion &&
           a.flip_angle == b.flip_angle && a.b_value == b.b_value &&
           a.picture_kind == b.picture_kind;
  });
}

/// Whether all moments have slices at the same places, and each of them one at each height.
/// pixel_mm  so far slices of one place may be apart within their planes
bool share_places(const Moments& moments, const std::vector<TimedPlace>& places,
                  double pixel_mm) {
  constexpr double kSameHeightSteps = 0.1;
  const auto sorted_places = [&](const std::vector<std::size_t>& slices) {
    std::vector<TimedPlace> sorted;
    for (const std::size_t i : slices) sorted.push_back(places[i]);
    std::ranges::sort(sorted, {}, &TimedPlace::height_mm);
    return sorted;
  };
  const std::vector<TimedPlace> first = sorted_places(moments.front().slices);
  double same = kSameHeightMm;
  for (std::size_t i = 1; i < first.size(); ++i) {
    same = std::min(same, kSameHeightSteps * (first[i].height_mm - first[i - 1].height_mm));
  }
  if (!(same > 0)) return false;
  return std::ranges::all_of(moments, [&](const Moment& moment) {
    const auto is_same = [&](const TimedPlace& a, const TimedPlace& b) {
      return std::abs(a.height_mm - b.height_mm) <= same &&
             std::hypot(a.across_mm - b.across_mm, a.down_mm - b.down_mm) <= pixel_mm;
    };
    return std::ranges::equal(sorted_places(moment.slices), first, is_same);
  });
}

/// "Trigger Time (0018,1060): 0, 40, 80 ms".
std::string list_moments(const MomentNumber& number, const Moments& moments) {
  constexpr std::size_t kMaxShown = 8;
  std::string list;
  std::size_t shown = 0;
  for (const Moment& moment : moments) {
    if (shown++ == kMaxShown) break;
    list += (list.empty() ? "" : ", ") + number.text(moment.first);
    if (moment.last > moment.first) list += " to " + number.text(moment.last);
  }
  if (moments.size() > kMaxShown) list += " to " + number.text(moments.back().last);
  return std::string(number.name) + ": " + list + number.unit;
}

/// The first voxel of each slice.
std::vector<TimedPlace> places_of(const std::vector<DicomSlice>& slices) {
  const SliceAxes axes = slice_axes(slices.front());
  std::vector<TimedPlace> places;
  for (const DicomSlice& slice : slices) {
    const Point3& at = *slice.position_mm;
    places.push_back({dot(at, axes.normal), dot(at, axes.row), dot(at, axes.column)});
  }
  return places;
}

/// Whether numbers of a kind tell slices apart, which then tell their moments or contradict what
/// else may.
bool tell_apart(MomentKind kind, const std::vector<DicomSlice>& slices) {
  return std::ranges::any_of(moment_numbers(), [&](const MomentNumber& number) {
    return number.kind == kind && !moments_by(slices, number).empty();
  });
}

struct FoundMoments {
  const MomentNumber* number = nullptr;  ///< null: none tells moments apart
  Moments moments;
};

/// By a number that is the same for all slices of a moment, else by the order of numbers that were
/// measured for each.
FoundMoments find_moments(const std::vector<DicomSlice>& slices) {
  const std::vector<TimedPlace> places = places_of(slices);
  const auto pixel = slices.front().pixel_mm.value_or(std::array<double, 2>{1, 1});
  const double pixel_mm = std::min(pixel[0], pixel[1]);
  const bool are_counted = tell_apart(MomentKind::count, slices);
  const bool may_be_clock = !are_counted && !tell_apart(MomentKind::measure, slices) &&
                            share_settings(slices);
  for (const bool is_in_order : {false, true}) {
    for (const MomentNumber& number : moment_numbers()) {
      if (number.kind == MomentKind::clock && !may_be_clock) continue;
      const bool is_measured =
          number.kind == MomentKind::measure || number.kind == MomentKind::clock;
      if (is_in_order && (!is_measured || are_counted)) continue;
      Moments moments = is_in_order ? moments_in_order(slices, number, places)
                                    : moments_by(slices, number);
      if (moments.empty() || !share_places(moments, places, pixel_mm)) continue;
      return {&number, std::move(moments)};
    }
  }
  return {};
}

}  // namespace

DicomTimes volumes_in_time(std::vector<DicomSlice> slices) {
  const bool are_placed = std::ranges::all_of(slices, [](const DicomSlice& slice) {
    return slice.position_mm && slice.orientation && !slice.layout->is_segmentation();
  });
  DicomTimes times;
  const FoundMoments found = are_placed ? find_moments(slices) : FoundMoments();
  if (found.number == nullptr) {
    times.volumes.push_back(std::move(slices));
    return times;
  }
  times.told_by = list_moments(*found.number, found.moments);
  for (const Moment& moment : found.moments) {
    std::vector<DicomSlice>& volume = times.volumes.emplace_back();
    for (const std::size_t i : moment.slices) volume.push_back(std::move(slices[i]));
  }
  return times;
}

}  // namespace octavo
