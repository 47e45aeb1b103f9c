// Opens an .8vo file, reads the 32^3 voxels around its center and prints their range in real units.
//
// usage: read_box FILE.8vo
#include <algorithm>
#include <cstdint>
#include <iostream>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace {

octavo::Box center_box(const octavo::Size3& size, std::int64_t side) {
  octavo::Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t length = std::min(side, size[axis]);
    box.lo[axis] = (size[axis] - length) / 2;
    box.hi[axis] = box.lo[axis] + length;
  }
  return box;
}

void print_range(const std::string& path) {
  const auto reader = octavo::FileReader::open(
      octavo::open_byte_source(octavo::local_storage(), path));
  const octavo::VolumeDescription& volume = reader->description();
  const octavo::Box box = center_box(volume.size, 32);
  octavo::with_voxel_type(volume.type, [&]<class T>(std::type_identity<T>) {
    std::vector<T> voxels(static_cast<std::size_t>(box.size().voxel_count()));
    reader->read(box, 0, voxels.data());
    const auto [low, high] = std::minmax_element(voxels.begin(), voxels.end());
    std::cout << voxels.size() << " voxels from "
              << volume.rescale.to_real(static_cast<double>(*low)) << " to "
              << volume.rescale.to_real(static_cast<double>(*high)) << "\n";
  });
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "usage: read_box FILE.8vo\n";
    return 2;
  }
  try {
    print_range(words[1]);
    return 0;
  } catch (const octavo::Error& error) {
    std::cerr << "read_box: " << error.what() << "\n";
    return 1;
  }
}
