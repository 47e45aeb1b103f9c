#include "octavo/core/voxel_type.h"

#include <array>

namespace octavo {

namespace {

struct TypeNames {
  VoxelType type;
  std::string_view name;
  std::string_view short_name;
};

constexpr std::array<TypeNames, 7> kNames = {{
    {VoxelType::int8, "int8", "i8"},
    {VoxelType::uint8, "uint8", "u8"},
    {VoxelType::int16, "int16", "i16"},
    {VoxelType::uint16, "uint16", "u16"},
    {VoxelType::int32, "int32", "i32"},
    {VoxelType::uint32, "uint32", "u32"},
    {VoxelType::float32, "float32", "f32"},
}};

}  // namespace

std::string_view voxel_type_name(VoxelType type) noexcept {
  for (const TypeNames& entry : kNames) {
    if (entry.type == type) return entry.name;
  }
  return "unknown";
}

std::optional<VoxelType> parse_voxel_type(std::string_view name) noexcept {
  for (const TypeNames& entry : kNames) {
    if (name == entry.name || name == entry.short_name) return entry.type;
  }
  return std::nullopt;
}

ValueRange value_range(VoxelType type) {
  return with_voxel_type(type, [](auto tag) -> ValueRange {
    using T = typename decltype(tag)::type;
    if constexpr (std::is_floating_point_v<T>) {
      throw Error(ErrorKind::invalid_argument, "a float type has no integer range");
    } else {
      return {std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()};
    }
  });
}

}  // namespace octavo
