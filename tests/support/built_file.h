// Builds volumes in memory into files of a folder that vanishes.
#pragma once

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <unistd.h>

#include "octavo/builder/builder.h"
#include "octavo/file/reader.h"
#include "octavo/planes/memory_source.h"

namespace octavo::testing {

/// A folder of its own for a test, removed with all it holds.
class ScratchFolder {
 public:
  ScratchFolder() {
    static std::atomic<int> count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("octavo-test-" + std::to_string(::getpid()) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string file(const std::string& name) const { return (path_ / name).string(); }
  bool is_empty() const { return std::filesystem::is_empty(path_); }

 private:
  std::filesystem::path path_;
};

/// A volume with its voxels as bytes, [z][y][x].
struct Volume {
  VolumeDescription description;
  std::vector<std::byte> voxels;
};

inline BuildResult build_volume(const Volume& volume, const std::string& path, int threads) {
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  BuildOptions options;
  options.kind = volume.description.kind;
  options.threads = threads;
  return build_file(*source, local_storage(), path, options, progress);
}

inline std::shared_ptr<FileReader> open_file(const std::string& path) {
  return FileReader::open(open_byte_source(local_storage(), path));
}

inline std::vector<std::byte> read_box(const FileReader& reader, const Box& box, int level) {
  const auto width = bytes_per_voxel(reader.description().type);
  std::vector<std::byte> out(static_cast<std::size_t>(box.size().voxel_count() * width));
  reader.read(box, level, out.data());
  return out;
}

/// The voxels of `box` out of a dense volume.
inline std::vector<std::byte> crop(const std::vector<std::byte>& voxels, const Size3& size,
                                   std::int64_t width, const Box& box) {
  std::vector<std::byte> out;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const auto row = voxels.begin() + ((z * size.y + y) * size.x + box.lo.x) * width;
      out.insert(out.end(), row, row + box.size().x * width);
    }
  }
  return out;
}

inline std::string bytes_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace octavo::testing
