#include "octavo/builder/build_setup.h"

#include <algorithm>
#include <thread>

#include "octavo/core/memory_advice.h"
#include "octavo/threads/forked.h"

namespace octavo {

WriterNote this_writer() {
  WriterNote writer;
  writer.name = "octavo";
  writer.revision = kEncodingRevision;
  return writer;
}

int build_threads(int wanted) {
  if (!has_threads()) return 1;
  if (wanted > 0) return wanted;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

Levels levels_of(const VolumeDescription& description) {
  checked_voxel_count(description.size);
  return {description.size, choose_halvings(description.size, description.geometry.spacing_mm)};
}

void check_build_memory(std::uint64_t needed_bytes, std::uint64_t limit_bytes, int threads,
                        const char* why) {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  if (limit_bytes == 0 || needed_bytes <= limit_bytes) return;
  throw Error(ErrorKind::limit_exceeded,
              "the build needs about " + std::to_string((needed_bytes + kMiB - 1) / kMiB) +
                  " MiB of memory; the limit is " + std::to_string(limit_bytes / kMiB) +
                  " MiB; " + std::string(memory_advice(threads)) + why);
}

Error out_of_build_memory(const std::string& path) {
  return {ErrorKind::out_of_memory,
          "out of memory while building; use fewer threads (about 24 MiB each)", path};
}

}  // namespace octavo
