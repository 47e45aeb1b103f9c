// What checksums cost: their time beside that of decoding a file.
//
// usage: bench_checksums [--commit ID] [--rounds N] FILE.8vo...
//
// Both are timed in turn on one thread, in processor time; the whole file is decoded from memory
// with nothing cached, and its bytes are summed once. The goal is kMaxShare: the exit status is 1
// where the fastest round of checksums takes more of the fastest round of decoding.

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"

namespace octavo::bench {
namespace {

constexpr double kMaxShare = 0.03;

double processor_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

template <class F>
double processor_seconds_of(const F& work) {
  const double began = processor_seconds();
  work();
  return processor_seconds() - began;
}

Bytes bytes_of_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorKind::io, "cannot open", path);
  return {std::istreambuf_iterator<char>(in), {}};
}

void compare(const std::string& path, const Settings& settings) {
  const Bytes bytes = bytes_of_file(path);
  ReaderOptions no_cache;
  no_cache.cache_bytes = 0;
  const auto reader = FileReader::open(byte_source_of(bytes, path), no_cache);
  const Size3 size = reader->levels().size(0);

  Row decoding;
  decoding.data_set = std::filesystem::path(path).stem().string();
  decoding.operation = "decode";
  decoding.bytes = bytes.size();
  decoding.voxel_count = static_cast<std::uint64_t>(size.voxel_count());
  decoding.raw_bytes = decoding.voxel_count *
                       static_cast<std::uint64_t>(bytes_per_voxel(reader->description().type));
  Row checking = decoding;
  checking.operation = "checksum";

  Bytes voxels(decoding.raw_bytes);
  for (int round = 0; round < settings.rounds; ++round) {
    decoding.seconds.push_back(
        processor_seconds_of([&] { reader->read(box_of(size), 0, voxels.data()); }));
    checking.seconds.push_back(processor_seconds_of([&] {
      volatile std::uint32_t crc = crc32c(bytes);
      static_cast<void>(crc);
    }));
  }
  std::cout << csv_line(decoding, settings.commit) << "\n";
  std::cout << csv_line(checking, settings.commit) << std::endl;

  const double share = *std::min_element(checking.seconds.begin(), checking.seconds.end()) /
                       *std::min_element(decoding.seconds.begin(), decoding.seconds.end());
  std::printf("goal B5: %s: checksums take %.2f %% of the time of decoding\n",
              decoding.data_set.c_str(), 100 * share);
  if (share > kMaxShare) {
    throw Error(ErrorKind::limit_exceeded, "checksums cost more than 3 % of decoding", path);
  }
}

void run(int count, char** words) {
  Settings settings;
  const std::vector<std::string> files = take_settings(count, words, settings);
  if (files.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_checksums [--commit ID] [--rounds N] FILE.8vo...");
  }
  std::cout << csv_header() << "\n";
  for (const std::string& file : files) compare(file, settings);
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_checksums", [=] { octavo::bench::run(count, words); });
}
