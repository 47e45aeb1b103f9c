// The number types a voxel can have, and the one switch that turns a run-time type into a C++ type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>

#include "octavo/core/error.h"

namespace octavo {

/// The values are those of the file format.
enum class VoxelType : std::uint8_t {
  int8 = 1,
  uint8 = 2,
  int16 = 3,
  uint16 = 4,
  int32 = 5,
  uint32 = 6,
  float32 = 7,
};

/// Calls `f(std::type_identity<T>{})` with the C++ type of `type` and returns its result.
/// float32 is passed as `float`. Throws Error{invalid_argument} for a value outside the enum.
template <class F>
decltype(auto) with_voxel_type(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::int8: return f(std::type_identity<std::int8_t>{});
    case VoxelType::uint8: return f(std::type_identity<std::uint8_t>{});
    case VoxelType::int16: return f(std::type_identity<std::int16_t>{});
    case VoxelType::uint16: return f(std::type_identity<std::uint16_t>{});
    case VoxelType::int32: return f(std::type_identity<std::int32_t>{});
    case VoxelType::uint32: return f(std::type_identity<std::uint32_t>{});
    case VoxelType::float32: return f(std::type_identity<float>{});
  }
  throw Error(ErrorKind::invalid_argument, "unknown voxel type");
}

/// The type of a C++ number type: voxel_type_of<int16_t>() == VoxelType::int16.
template <class T>
constexpr VoxelType voxel_type_of() {
  if constexpr (std::is_same_v<T, std::int8_t>) return VoxelType::int8;
  else if constexpr (std::is_same_v<T, std::uint8_t>) return VoxelType::uint8;
  else if constexpr (std::is_same_v<T, std::int16_t>) return VoxelType::int16;
  else if constexpr (std::is_same_v<T, std::uint16_t>) return VoxelType::uint16;
  else if constexpr (std::is_same_v<T, std::int32_t>) return VoxelType::int32;
  else if constexpr (std::is_same_v<T, std::uint32_t>) return VoxelType::uint32;
  else {
    static_assert(std::is_same_v<T, float>);
    return VoxelType::float32;
  }
}

constexpr bool is_valid(VoxelType type) noexcept {
  return type >= VoxelType::int8 && type <= VoxelType::float32;
}

constexpr std::int64_t bytes_per_voxel(VoxelType type) noexcept {
  switch (type) {
    case VoxelType::int8:
    case VoxelType::uint8: return 1;
    case VoxelType::int16:
    case VoxelType::uint16: return 2;
    default: return 4;
  }
}

constexpr bool is_integer(VoxelType type) noexcept { return type != VoxelType::float32; }

/// "int8" ... "uint32", "float32".
std::string_view voxel_type_name(VoxelType type) noexcept;

/// The type of that name; the short forms i8 u8 i16 u16 i32 u32 f32 are understood as well.
std::optional<VoxelType> parse_voxel_type(std::string_view name) noexcept;

/// Smallest and largest value of an integer type.
struct ValueRange {
  std::int64_t min = 0;
  std::int64_t max = 0;
  bool operator==(const ValueRange&) const = default;
};
ValueRange value_range(VoxelType type);

}  // namespace octavo
