#include "octavo/dist/join_proof.h"

#include <algorithm>
#include <cstddef>
#include <set>

#include "octavo/builder/workers.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::uint64_t kStepBytes = std::uint64_t{16} << 20;  // between two looks at the progress

std::uint32_t crc_of_run(const CopiedRun& run, const StorageFile& file, Progress& progress) {
  std::uint32_t crc = 0;
  for (std::uint64_t done = 0; done < run.length; done += kStepBytes) {
    if (progress.is_cancelled()) {
      throw Error(ErrorKind::cancelled, "stopped while copies of parts were proven");
    }
    const std::uint64_t count = std::min(kStepBytes, run.length - done);
    const std::uint64_t begin = run.file_offset + done;
    crc = crc_of(file, begin, begin + count, crc);
    progress.advance(static_cast<std::int64_t>(count));
  }
  return crc;
}

}  // namespace

std::uint32_t crc_of_own_bytes(const JoinLayout& layout, const StorageFile& file) {
  std::uint32_t crc = 0;
  for (const Section& own : own_bytes_of(layout)) crc = crc_of(file, own.offset, own.end(), crc);
  return crc;
}

std::vector<PartPlace> damaged_copies(const JoinLayout& layout,
                                      const std::vector<PartPlace>& places,
                                      const StorageFile& file, int threads, Progress& progress) {
  std::set<BrickAt> asked;
  for (const PartPlace& place : places) asked.insert(begin_of(place));
  std::vector<const CopiedRun*> runs;
  std::uint64_t bytes = 0;
  for (const CopiedRun& run : layout.runs) {
    if (!asked.contains(begin_of(run.part))) continue;
    runs.push_back(&run);
    bytes += run.length;
  }
  const ProgressScope scope(progress, "check copies", static_cast<std::int64_t>(bytes), "bytes");
  std::vector<char> is_whole(runs.size());
  Workers workers(threads);
  workers.run([&] {
    parallel_for(std::size_t{0}, runs.size(), [&](std::size_t i) {
      is_whole[i] = checksum_matches(crc_of_run(*runs[i], file, progress), runs[i]->crc) ? 1 : 0;
    });
  });
  std::set<BrickAt> damaged;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (is_whole[i] == 0) damaged.insert(begin_of(runs[i]->part));
  }
  std::vector<PartPlace> found = places;
  std::erase_if(found, [&](const PartPlace& place) { return !damaged.contains(begin_of(place)); });
  return found;
}

}  // namespace octavo
