#include "octavo/mesh/surface_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace octavo {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The bits of 8 bytes that are 0 or 1, the first one lowest.
std::uint64_t packed(std::uint64_t bytes) { return bytes * 0x0102040810204080u >> 56; }

/// The values of type T in a range; lowest > highest where it has none.
template <class T>
struct TypedRange {
  T lowest;
  T highest;
};

template <class T>
TypedRange<T> typed(const InsideRange& range) {
  constexpr auto kMin = static_cast<double>(std::numeric_limits<T>::lowest());
  constexpr auto kMax = static_cast<double>(std::numeric_limits<T>::max());
  if (range.lowest > kMax || range.highest < kMin || range.lowest > range.highest) return {1, 0};
  if constexpr (std::numeric_limits<T>::is_integer) {
    return {static_cast<T>(std::ceil(std::max(range.lowest, kMin))),
            static_cast<T>(std::floor(std::min(range.highest, kMax)))};
  } else {
    // The nearest floats within: a float is compared as the number that it is.
    auto lowest = static_cast<T>(std::max(range.lowest, kMin));
    auto highest = static_cast<T>(std::min(range.highest, kMax));
    if (static_cast<double>(lowest) < range.lowest) lowest = std::nextafter(lowest, T(kMax));
    if (static_cast<double>(highest) > range.highest) highest = std::nextafter(highest, T(kMin));
    return {lowest, highest};
  }
}

template <class T>
std::uint64_t bits_of_64(T lowest, T highest, const T* row) {
  std::array<std::uint8_t, 64> is_inside;
  for (std::size_t i = 0; i < 64; ++i) {
    is_inside[i] = static_cast<std::uint8_t>((row[i] >= lowest) & (row[i] <= highest));
  }
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    std::uint64_t bytes;
    std::memcpy(&bytes, is_inside.data() + 8 * i, sizeof bytes);
    bits |= packed(bytes) << 8 * i;
  }
  return bits;
}

}  // namespace

SurfaceField SurfaceField::of_grey(double value, bool is_falling, VoxelType type) {
  SurfaceField field;
  const bool is_whole = is_integer(type);
  if (is_falling) {
    const double highest = is_whole ? std::floor(value) : value;
    field.inside = {{-kInfinity, highest}};
    field.isovalue = is_whole ? highest + 0.5 : highest;
  } else {
    const double lowest = is_whole ? std::ceil(value) : value;
    field.inside = {{lowest, kInfinity}};
    field.isovalue = is_whole ? lowest - 0.5 : lowest;
  }
  return field;
}

SurfaceField SurfaceField::of_labels(std::span<const std::int64_t> labels) {
  SurfaceField field;
  if (labels.empty()) field.inside = {{-kInfinity, -1}, {1, kInfinity}};
  for (const std::int64_t label : labels) {
    field.inside.push_back({static_cast<double>(label), static_cast<double>(label)});
  }
  return field;
}

InsideShare inside_share(const SurfaceField& field, double lowest, double highest,
                         bool may_hold_others) {
  bool is_some = may_hold_others && lowest != highest;
  for (const InsideRange& range : field.inside) {
    const bool are_all = range.lowest <= lowest && highest <= range.highest;
    if (are_all && !is_some) return InsideShare::all;
    if (range.lowest <= highest && lowest <= range.highest) return InsideShare::some;
  }
  return InsideShare::none;
}

template <class T>
InsideTest<T>::InsideTest(const SurfaceField& field) {
  for (const InsideRange& range : field.inside) {
    const auto [lowest, highest] = typed<T>(range);
    ranges_.push_back({lowest, highest});
  }
}

template <class T>
std::uint64_t InsideTest<T>::bits(const T* row, int count) const {
  std::array<T, 64> padded;
  const T* values = row;
  if (count < 64) {
    padded.fill(T{});
    std::copy_n(row, count, padded.begin());
    values = padded.data();
  }
  std::uint64_t bits = 0;
  for (const Range& range : ranges_) bits |= bits_of_64(range.lowest, range.highest, values);
  return count < 64 ? bits & ((std::uint64_t{1} << count) - 1) : bits;
}

template class InsideTest<std::int8_t>;
template class InsideTest<std::uint8_t>;
template class InsideTest<std::int16_t>;
template class InsideTest<std::uint16_t>;
template class InsideTest<std::int32_t>;
template class InsideTest<std::uint32_t>;
template class InsideTest<float>;

double crossing_at_border(const SurfaceField& field) {
  return field.isovalue ? kNearestCrossing : 0.5;
}

}  // namespace octavo
