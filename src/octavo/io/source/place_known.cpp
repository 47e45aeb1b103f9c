#include "octavo/io/source/place_known.h"

#include <nlohmann/json.hpp>

namespace octavo {

bool is_place_known(const VolumeDescription& description) {
  const auto metadata = nlohmann::json::parse(description.metadata_json, nullptr, false);
  if (metadata.is_object()) {
    const auto known = metadata.find("place_known");
    if (known != metadata.end() && known->is_boolean()) return known->get<bool>();
    if (metadata.contains("dicom")) return true;
  }
  return description.geometry.origin_mm != Point3{} ||
         description.geometry.direction != Geometry{}.direction;
}

}  // namespace octavo
