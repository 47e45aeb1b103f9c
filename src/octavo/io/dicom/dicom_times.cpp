#include "octavo/io/dicom/dicom_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/io/dicom/dicom_moment.h"
#include "octavo/io/dicom/dicom_places.h"

namespace octavo {

namespace {

using Moments = std::map<double, std::vector<std::size_t>>;  // and the slices of each

/// Slices by their numbers; none where one has no number, or all have one.
Moments moments_by(const std::vector<DicomSlice>& slices,
                   const MomentNumber& number) {
  Moments moments;
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const std::optional<double> value = number.of(slices[i]);
    if (!value) return {};
    moments[*value].push_back(i);
  }
  return moments.size() > 1 ? moments : Moments();
}

/// The first voxel of a slice, along its normal and within its plane.
struct TimedPlace {
  double height_mm = 0;
  double across_mm = 0;
  double down_mm = 0;
};

/// Whether all moments have slices at the same places, and each of them one at each height.
/// pixel_mm  so far slices of one place may be apart within their planes
bool share_places(const Moments& moments, const std::vector<TimedPlace>& places,
                  double pixel_mm) {
  constexpr double kSameHeightMm = 1e-3;
  constexpr double kSameHeightSteps = 0.1;
  const auto sorted_places = [&](const std::vector<std::size_t>& slices) {
    std::vector<TimedPlace> sorted;
    for (const std::size_t i : slices) sorted.push_back(places[i]);
    std::ranges::sort(sorted, {}, &TimedPlace::height_mm);
    return sorted;
  };
  const std::vector<TimedPlace> first = sorted_places(moments.begin()->second);
  double same = kSameHeightMm;
  for (std::size_t i = 1; i < first.size(); ++i) {
    same = std::min(same, kSameHeightSteps * (first[i].height_mm - first[i - 1].height_mm));
  }
  if (!(same > 0)) return false;
  return std::ranges::all_of(moments, [&](const auto& moment) {
    const auto is_same = [&](const TimedPlace& a, const TimedPlace& b) {
      return std::abs(a.height_mm - b.height_mm) <= same &&
             std::hypot(a.across_mm - b.across_mm, a.down_mm - b.down_mm) <= pixel_mm;
    };
    return std::ranges::equal(sorted_places(moment.second), first, is_same);
  });
}

/// "Trigger Time (0018,1060): 0, 40, 80 ms".
std::string list_moments(const MomentNumber& number, const Moments& moments) {
  constexpr std::size_t kMaxShown = 8;
  std::string list;
  std::size_t shown = 0;
  for (const auto& [value, members] : moments) {
    if (shown++ == kMaxShown) break;
    list += (list.empty() ? "" : ", ") + precise_text(value);
  }
  if (moments.size() > kMaxShown) list += " to " + precise_text(moments.rbegin()->first);
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

}  // namespace

DicomTimes volumes_in_time(std::vector<DicomSlice> slices) {
  const bool are_placed = std::ranges::all_of(slices, [](const DicomSlice& slice) {
    return slice.position_mm && slice.orientation && !slice.layout->is_segmentation();
  });
  DicomTimes times;
  if (are_placed) {
    const std::vector<TimedPlace> places = places_of(slices);
    const auto pixel = slices.front().pixel_mm.value_or(std::array<double, 2>{1, 1});
    const double pixel_mm = std::min(pixel[0], pixel[1]);
    for (const MomentNumber& number : moment_numbers()) {
      const Moments moments = moments_by(slices, number);
      if (moments.empty() || !share_places(moments, places, pixel_mm)) continue;
      times.told_by = list_moments(number, moments);
      for (const auto& [value, members] : moments) {
        std::vector<DicomSlice>& volume = times.volumes.emplace_back();
        for (const std::size_t i : members) volume.push_back(std::move(slices[i]));
      }
      return times;
    }
  }
  times.volumes.push_back(std::move(slices));
  return times;
}

}  // namespace octavo
