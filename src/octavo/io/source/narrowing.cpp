#include "octavo/io/source/narrowing.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/unset_bytes.h"

namespace octavo {

namespace {

constexpr int kTellingPlanes = 32;

template <class T>
T number_at(std::span<const std::byte> numbers, std::size_t index) {
  T value;
  std::memcpy(&value, numbers.data() + index * sizeof(T), sizeof(T));
  return value;
}

/// Calls `f(std::type_identity<T>{})` with the C++ type of `type`.
template <class F>
decltype(auto) with_wide_type(WideType type, F&& f) {
  switch (type) {
    case WideType::int64: return f(std::type_identity<std::int64_t>{});
    case WideType::uint64: return f(std::type_identity<std::uint64_t>{});
    case WideType::float64: break;
  }
  return f(std::type_identity<double>{});
}

/// True where the voxel type has exactly this number. -0 counts as 0.
template <class To, class From>
bool holds(From value) {
  if constexpr (std::is_integral_v<From>) {
    return std::in_range<To>(value);
  } else if constexpr (std::is_integral_v<To>) {
    return value >= static_cast<From>(std::numeric_limits<To>::min()) &&
           value <= static_cast<From>(std::numeric_limits<To>::max()) && value == std::trunc(value);
  } else {
    return !std::isfinite(value) || (std::abs(value) <= std::numeric_limits<To>::max() &&
                                     static_cast<From>(static_cast<To>(value)) == value);
  }
}

/// From here on numbers are rounded to infinity, by half a step beyond the largest float32.
constexpr double kBeyondFloats = 0x1.ffffffp127;

/// True where float32 has this number or one near it, NaN and infinities included.
bool holds_roughly(double value) {
  return !std::isfinite(value) || std::abs(value) < kBeyondFloats;
}

/// The nearest one. Requires a value that holds_roughly.
float nearest_float(double value) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  return static_cast<float>(std::isfinite(value) ? std::clamp(value, -kLargest, kLargest) : value);
}

/// What values seen so far fit.
struct Fits {
  bool int32 = true;
  bool uint32 = true;
  bool float32 = true;
  double largest = 0;  ///< the distance of a finite value from 0
};

template <class From>
void look_at(std::span<const std::byte> plane, Fits& fits) {
  for (std::size_t i = 0; i < plane.size() / sizeof(From); ++i) {
    const From value = number_at<From>(plane, i);
    fits.int32 = fits.int32 && holds<std::int32_t>(value);
    fits.uint32 = fits.uint32 && holds<std::uint32_t>(value);
    if constexpr (std::is_floating_point_v<From>) {
      fits.float32 = fits.float32 && holds<float>(value);
      if (std::isfinite(value)) fits.largest = std::max(fits.largest, std::abs(value));
    }
  }
}

/// All numbers have the bits of the first.
bool is_constant(std::span<const std::byte> plane) {
  const std::size_t rest = plane.size() - sizeof(std::uint64_t);
  return std::memcmp(plane.data(), plane.data() + sizeof(std::uint64_t), rest) == 0;
}

Narrowing narrowing_of(WideType from, const Fits& fits) {
  const bool is_signed_first = from != WideType::uint64;
  if (is_signed_first && fits.int32) return {from, VoxelType::int32};
  if (fits.uint32) return {from, VoxelType::uint32};
  if (from != WideType::float64) return {from, StoredType(from).voxel()};
  if (!fits.float32 && fits.largest < std::numeric_limits<float>::min()) {
    throw Error(ErrorKind::source_rejected,
                "no value of the first planes is farther from 0 than " +
                    precise_text(fits.largest) +
                    ", where float32, which these float64 voxels become, has few numbers or "
                    "none; scale them first");
  }
  return {from, VoxelType::float32, !fits.float32};
}

template <class From>
[[noreturn]] void reject_value(const Narrowing& narrowing, From value, std::size_t index,
                               const RunPlace& place) {
  const std::int64_t at = place.first + static_cast<std::int64_t>(index);
  std::string text;
  if constexpr (std::is_integral_v<From>) text = std::to_string(value);
  else text = exact_text(value);
  const bool is_late = std::is_floating_point_v<From> && !narrowing.rounds &&
                       holds_roughly(static_cast<double>(value));
  throw Error(ErrorKind::source_rejected,
              "the value " + text + " at x,y,z = " + std::to_string(at % place.columns) + "," +
                  std::to_string(at / place.columns) + "," + std::to_string(place.z) +
                  " does not fit " + std::string(voxel_type_name(narrowing.to)) +
                  ", which these " + std::string(stored_type_name(narrowing.from)) +
                  " voxels become" +
                  (is_late ? " by what the first planes hold; convert it to float32 first"
                           : ": voxels have 32 bits at most; convert it first"),
              place.path);
}

template <class From, class To>
void narrow_values(const Narrowing& narrowing, std::span<const std::byte> wide,
                   std::span<std::byte> voxels, const RunPlace& place) {
  for (std::size_t i = 0; i < wide.size() / sizeof(From); ++i) {
    const From value = number_at<From>(wide, i);
    bool fits = holds<To>(value);
    if constexpr (std::is_floating_point_v<To>) {
      fits = fits || (narrowing.rounds && holds_roughly(static_cast<double>(value)));
    }
    if (!fits) reject_value(narrowing, value, i, place);
    To nearest{};
    if constexpr (std::is_floating_point_v<To>) nearest = nearest_float(static_cast<double>(value));
    else nearest = static_cast<To>(value);
    // Adding 0 makes 0 of -0, which no integer behind a float voxel stands for.
    const To voxel = static_cast<To>(nearest + To{0});
    std::memcpy(voxels.data() + i * sizeof(To), &voxel, sizeof(To));
  }
}

}  // namespace

std::string float_rounding_warning() {
  return "float64 voxels are rounded to float32, to the nearest: each by 1 part in 16,777,216 at "
         "most, those nearer to 0 than 1.2e-38 by 7.1e-46 at most";
}

Narrowing choose_narrowing(WideType from, std::int64_t plane_count, std::uint64_t plane_bytes,
                           const WidePlaneReader& read) {
  UnsetBytes plane(static_cast<std::size_t>(plane_bytes));
  Fits fits;
  int telling = 0;
  for (std::int64_t z = 0; z < plane_count && telling < kTellingPlanes; ++z) {
    read(z, plane.bytes());
    with_wide_type(from, [&](auto tag) {
      look_at<typename decltype(tag)::type>(plane.bytes(), fits);
    });
    if (!is_constant(plane.bytes())) ++telling;
  }
  return narrowing_of(from, fits);
}

void narrow(const Narrowing& narrowing, std::span<const std::byte> wide,
            std::span<std::byte> voxels, const RunPlace& place) {
  with_wide_type(narrowing.from, [&](auto tag) {
    using From = typename decltype(tag)::type;
    if (narrowing.to == VoxelType::int32) {
      narrow_values<From, std::int32_t>(narrowing, wide, voxels, place);
    } else if (narrowing.to == VoxelType::uint32) {
      narrow_values<From, std::uint32_t>(narrowing, wide, voxels, place);
    } else if constexpr (std::is_floating_point_v<From>) {
      narrow_values<From, float>(narrowing, wide, voxels, place);
    }
  });
}

}  // namespace octavo
