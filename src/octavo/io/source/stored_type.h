// The types of the numbers in a file: those of voxels, and wider ones of which voxels are made
// where their values fit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "octavo/core/voxel_type.h"

namespace octavo {

/// Numbers of 64 bits. The values are those of the worker protocol.
enum class WideType : std::uint8_t { int64 = 1, uint64, float64 };

/// A voxel type or a wide one.
class StoredType {
 public:
  constexpr StoredType(VoxelType type = VoxelType::uint8) noexcept : voxel_(type) {}
  constexpr StoredType(WideType type) noexcept : wide_(type) {}

  constexpr bool operator==(const StoredType&) const = default;

  /// The voxel type; of a wide one what its voxels become unless its values ask for another.
  constexpr VoxelType voxel() const noexcept { return wide_ ? usual_voxel(*wide_) : voxel_; }
  constexpr std::optional<WideType> wide() const noexcept { return wide_; }

 private:
  static constexpr VoxelType usual_voxel(WideType type) noexcept {
    if (type == WideType::int64) return VoxelType::int32;
    return type == WideType::uint64 ? VoxelType::uint32 : VoxelType::float32;
  }

  VoxelType voxel_ = VoxelType::uint8;
  std::optional<WideType> wide_;
};

constexpr std::size_t bytes_per_value(StoredType type) noexcept {
  return type.wide() ? sizeof(std::uint64_t)
                     : static_cast<std::size_t>(bytes_per_voxel(type.voxel()));
}

/// "int8" ... "float32", "int64", "uint64", "float64".
std::string_view stored_type_name(StoredType type) noexcept;

/// The type of that name; the short forms i8 ... f32, i64, u64 and f64 are understood as well.
std::optional<StoredType> parse_stored_type(std::string_view name) noexcept;

}  // namespace octavo
