#include "octavo/io/dicom/dicom_nuclear.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr DicomTag kSliceVector = 0x00540080;

std::vector<std::uint16_t> slice_numbers(const DicomSet& data, const DicomLayout& layout) {
  std::vector<std::uint16_t> numbers = data.words(kSliceVector);
  if (numbers.empty()) return numbers;
  const std::string vector = "Slice Vector " + dicom_tag_text(kSliceVector);
  if (numbers.size() != static_cast<std::size_t>(layout.frames)) {
    reject(layout, vector + " has " + std::to_string(numbers.size()) + " numbers, there are " +
                       std::to_string(layout.frames) + " frames");
  }
  std::vector<std::uint16_t> sorted = numbers;
  std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted);
  if (twice != sorted.end()) {
    reject(layout, vector + " names slice " + std::to_string(*twice) +
                       " more than once: the file holds several volumes (gates, times, energies), "
                       "of which none can be taken; export one of them alone");
  }
  return numbers;
}

/// Slice 1 lies at the position of the detector, the others along the normal behind it.
void place_frames(const DicomSet& data, const std::vector<std::uint16_t>& numbers,
                  std::vector<DicomSlice>& slices) {
  constexpr DicomTag kDetectors = 0x00540022;
  const std::vector<DicomSet>& detectors = data.items(kDetectors);
  const std::optional<double> step = slices.front().spacing_mm;
  const bool is_volume = slices.front().layout->image_type.find("RECON") != std::string::npos;
  if (detectors.empty() || !step || *step == 0 || !is_volume) return;
  const std::vector<double> first = detectors.front().decimals(0x00200032);
  const std::vector<double> v = detectors.front().decimals(0x00200037);
  if (first.size() != 3 || v.size() != 6) return;
  const Point3 normal = cross(Point3{v[0], v[1], v[2]}, Point3{v[3], v[4], v[5]});
  for (std::size_t i = 0; i < slices.size(); ++i) {
    const double along = *step * (static_cast<double>(numbers[i]) - 1);
    slices[i].orientation = {v[0], v[1], v[2], v[3], v[4], v[5]};
    slices[i].position_mm = {first[0] + normal[0] * along, first[1] + normal[1] * along,
                             first[2] + normal[2] * along};
    slices[i].spacing_mm = std::abs(*step);
  }
}

}  // namespace

void take_nuclear_slices(const DicomSet& data, std::vector<DicomSlice>& slices) {
  const std::vector<std::uint16_t> numbers = slice_numbers(data, *slices.front().layout);
  if (numbers.empty()) return;
  place_frames(data, numbers, slices);
  std::vector<std::size_t> order(slices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return numbers[i]; });
  std::vector<DicomSlice> sorted;
  for (const std::size_t i : order) sorted.push_back(std::move(slices[i]));
  slices = std::move(sorted);
}

}  // namespace octavo
