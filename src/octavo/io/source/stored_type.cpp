#include "octavo/io/source/stored_type.h"

namespace octavo {

std::string_view stored_type_name(StoredType type) noexcept {
  if (!type.wide()) return voxel_type_name(type.voxel());
  switch (*type.wide()) {
    case WideType::int64: return "int64";
    case WideType::uint64: return "uint64";
    case WideType::float64: break;
  }
  return "float64";
}

std::optional<StoredType> parse_stored_type(std::string_view name) noexcept {
  if (name == "int64" || name == "i64") return WideType::int64;
  if (name == "uint64" || name == "u64") return WideType::uint64;
  if (name == "float64" || name == "f64") return WideType::float64;
  if (const std::optional<VoxelType> type = parse_voxel_type(name)) return *type;
  return std::nullopt;
}

}  // namespace octavo
