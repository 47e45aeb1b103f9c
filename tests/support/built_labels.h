// Label maps in memory and the files made of them.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "support/built_file.h"

namespace octavo::testing {

/// A label map in a file that vanishes with it.
class BuiltLabels {
 public:
  template <class T>
  BuiltLabels(const Size3& size, const std::vector<T>& voxels, const Geometry& geometry = {}) {
    Volume volume;
    volume.description.kind = VolumeKind::labels;
    volume.description.size = size;
    volume.description.type = voxel_type_of<T>();
    volume.description.geometry = geometry;
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(T));
    build_volume(volume, path_, 1);
    reader_ = open_file(path_);
  }

  const FileReader& reader() const { return *reader_; }
  const std::string& path() const { return path_; }

 private:
  ScratchFolder folder_;
  std::string path_ = folder_.file("labels.8vo");
  std::shared_ptr<FileReader> reader_;
};

/// Labels 0 to `highest`, in cubes of `grain` voxels.
inline std::vector<std::int16_t> random_labels(const Size3& size, unsigned seed, int highest,
                                               std::int64_t grain = 1) {
  std::mt19937 random(seed);
  const Size3 cubes = {size.x / grain + 1, size.y / grain + 1, size.z / grain + 1};
  std::vector<std::int16_t> of_cube(static_cast<std::size_t>(cubes.voxel_count()));
  for (std::int16_t& label : of_cube) {
    label = static_cast<std::int16_t>(random() % static_cast<unsigned>(highest + 1));
  }
  std::vector<std::int16_t> voxels;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::int64_t cube = (z / grain * cubes.y + y / grain) * cubes.x + x / grain;
        voxels.push_back(of_cube[static_cast<std::size_t>(cube)]);
      }
    }
  }
  return voxels;
}

}  // namespace octavo::testing
