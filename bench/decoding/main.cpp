// Decoding of whole .8vo files: all bricks of level 0, one after the other, out of memory.
//
// usage: bench_decoding [--commit ID] [--rounds N] [--seconds S] FILE.8vo...
//
// Each of N rounds (5) decodes every file in turn, as often as S seconds (0.2) allow, so that what
// a busy machine does to one file it does to the others. Times are CPU seconds of the one thread
// that works; nothing is cached. The CSV's bytes are those of the file. Voxels of files that claim
// the same digest are proven equal by a checksum before anything is timed.

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"

namespace octavo::bench {
namespace {

struct DecodingSettings : Settings {
  double seconds = 0.2;
  std::vector<std::string> paths;
};

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A file in memory, and what was measured of it.
struct Contender {
  std::shared_ptr<const FileReader> reader;
  Row row;
};

Contender load(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorKind::io, "cannot be read", path);
  Bytes bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  Contender contender;
  contender.row.bytes = bytes.size();
  contender.reader =
      FileReader::open(byte_source_of(std::move(bytes), path), {.cache_bytes = 0});
  const VolumeDescription& volume = contender.reader->description();
  contender.row.data_set = path.substr(path.find_last_of('/') + 1);
  contender.row.operation = "decode";
  contender.row.voxel_count = static_cast<std::uint64_t>(volume.size.voxel_count());
  contender.row.raw_bytes =
      contender.row.voxel_count * static_cast<std::uint64_t>(bytes_per_voxel(volume.type));
  return contender;
}

/// Calls f(voxels) for the bytes of every brick.
template <class F>
void for_each_brick(const FileReader& reader, F&& f) {
  const Size3 side = reader.levels().brick_side(0);
  const std::int64_t voxel_bytes = bytes_per_voxel(reader.description().type);
  Bytes voxels(static_cast<std::size_t>(side.voxel_count() * voxel_bytes));
  visit_cells(box_of(reader.levels().size(0)), side, [&](const Index3& at) {
    reader.read_brick(reader.brick(0, at), 0, voxels.data());
    const std::int64_t count = reader.levels().brick_box(0, at).size().voxel_count();
    f(ByteSpan(voxels).first(static_cast<std::size_t>(count * voxel_bytes)));
    return true;
  });
}

void prove(const std::vector<Contender>& contenders) {
  std::map<Sha256Digest, std::uint32_t> checksums;
  for (const Contender& contender : contenders) {
    std::uint32_t checksum = 0;
    for_each_brick(*contender.reader,
                   [&](ByteSpan voxels) { checksum = crc32c(voxels, checksum); });
    const auto [known, is_new] =
        checksums.try_emplace(contender.reader->voxel_digest(), checksum);
    if (!is_new && known->second != checksum) {
      throw Error(ErrorKind::internal, "holds other voxels than its digest says",
                  contender.row.data_set);
    }
  }
}

/// Seconds of one decoding.
double decoding_seconds(const FileReader& reader, double minimum) {
  int count = 0;
  const double start = cpu_seconds();
  double elapsed = 0;
  do {
    for_each_brick(reader, [](ByteSpan) {});
    ++count;
    elapsed = cpu_seconds() - start;
  } while (elapsed < minimum);
  return elapsed / count;
}

DecodingSettings parse(int count, char** words) {
  DecodingSettings settings;
  const std::vector<std::string> others = take_settings(count, words, settings);
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (others[i] == "--seconds" && i + 1 < others.size())
      settings.seconds = std::stod(others[++i]);
    else settings.paths.push_back(others[i]);
  }
  if (settings.paths.empty()) {
    throw Error(
        ErrorKind::invalid_argument,
        "usage: bench_decoding [--commit ID] [--rounds N] [--seconds S] FILE.8vo...");
  }
  return settings;
}

void run(const DecodingSettings& settings) {
  std::vector<Contender> contenders;
  for (const std::string& path : settings.paths) contenders.push_back(load(path));
  prove(contenders);
  for (int round = 0; round < settings.rounds; ++round) {
    for (Contender& contender : contenders) {
      contender.row.seconds.push_back(decoding_seconds(*contender.reader, settings.seconds));
    }
  }
  std::cout << csv_header() << "\n";
  for (Contender& contender : contenders) {
    contender.row.peak_memory_bytes = peak_memory_bytes();
    std::cout << csv_line(contender.row, settings.commit) << "\n";
    std::fprintf(stderr, "%-40s %8.1f MB/s\n", contender.row.data_set.c_str(),
                 static_cast<double>(contender.row.raw_bytes) / 1e6 /
                     median(contender.row.seconds));
  }
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_decoding", [&] {
    octavo::bench::run(octavo::bench::parse(count, words));
  });
}
