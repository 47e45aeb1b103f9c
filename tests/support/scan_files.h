// Small scans for the tests of tasks that read and write files: raw planes of a ramp, in a folder
// that vanishes.
#pragma once

#include <fstream>
#include <utility>
#include <vector>

#include "octavo/tasks/open_scan.h"
#include "support/task_files.h"

namespace octavo::testing {

class ScanFiles : public TaskFiles {
 protected:
  static constexpr Size3 kScanSize = {40, 33, 16};  // one brick

  ScanFiles() {
    context_.on_note = [this](const std::string& text, const std::string& field) {
      notes_.emplace_back(text, field);
    };
    scan_.source.raw = RawLayout{kScanSize, VoxelType::int16};
    scan_.source.spacing_mm = Point3{0.5, 0.5, 2};
    for (std::int64_t i = 0; i < kScanSize.voxel_count(); ++i) {
      voxels_.push_back(static_cast<std::int16_t>(3 * (i % kScanSize.x) + i % 7 - 50));
    }
  }

  /// Writes voxels without a header, little-endian as this machine is.
  template <class T>
  std::string write_raw(const std::string& name, const std::vector<T>& voxels) {
    std::ofstream out(folder_.file(name), std::ios::binary);
    out.write(reinterpret_cast<const char*>(voxels.data()),
              static_cast<std::streamsize>(voxels.size() * sizeof(T)));
    return folder_.file(name);
  }

  /// The ramp as a grey file of int16 in HU.
  std::string write_grey(const std::string& name, const Rescale& rescale = {}) {
    Volume volume;
    volume.description.size = kScanSize;
    volume.description.type = VoxelType::int16;
    volume.description.geometry = geometry_;
    volume.description.rescale = rescale;
    volume.description.metadata = Metadata::read(R"({"spacing_known":true,"unit":"HU"})");
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels_.data());
    volume.voxels.assign(bytes, bytes + voxels_.size() * sizeof(std::int16_t));
    build_volume(volume, folder_.file(name), 1);
    return folder_.file(name);
  }

  /// Changes one byte of a file.
  static void damage(const std::string& path, std::uint64_t offset, int mask) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(offset));
    const int byte = file.get();
    file.seekp(static_cast<std::streamoff>(offset));
    file.put(static_cast<char>(byte ^ mask));
  }

  /// Where the bytes of a brick at the finest level begin.
  static std::uint64_t brick_offset(const std::string& path) {
    return open_file(path)->brick(0, {0, 0, 0}).pieces.front().offset;
  }

  ScanOptions scan_;  ///< reads write_raw("...", voxels_)
  std::vector<std::int16_t> voxels_;
  std::vector<std::pair<std::string, std::string>> notes_;  ///< text and field
};

}  // namespace octavo::testing
