#include "octavo/core/place_known.h"

namespace octavo {

bool is_place_known(const VolumeDescription& description) {
  const MetadataFacts& facts = description.metadata.facts();
  if (facts.place_known) return *facts.place_known;
  return facts.dicom || description.geometry.origin_mm != Point3{} ||
         description.geometry.direction != Geometry{}.direction;
}

}  // namespace octavo
