#include "support/volume_readers.h"

#include "octavo/io/open_source.h"
#include "support/voxel_numbers.h"

namespace octavo::testing {

namespace {

ReadVolume read_with_octavo(const std::string& path) {
  const auto source = open_source({path}, {});
  const VolumeDescription& description = source->description();
  ReadVolume volume{description.size, description.type, description.geometry, {}};
  std::vector<std::byte> plane(static_cast<std::size_t>(plane_bytes(description)));
  for (std::int64_t z = 0; z < description.size.z; ++z) {
    source->read_plane(plane);
    for (const double stored : as_numbers(plane, description.type)) {
      volume.values.push_back(description.rescale.to_real(stored));
    }
  }
  return volume;
}

Geometry read_geometry_with_octavo(const std::string& path) {
  return open_source({path}, {})->description().geometry;
}

}  // namespace

const std::vector<VolumeReader>& volume_readers() {
  static const std::vector<VolumeReader> readers = [] {
    std::vector<VolumeReader> all = {
        {"Octavo", true, read_with_octavo, read_geometry_with_octavo}};
    if (const VolumeReader* itk = itk_reader()) all.push_back(*itk);
    return all;
  }();
  return readers;
}

}  // namespace octavo::testing
