// Random access to an .8vo file: how many single voxels, boxes and slices a second, nothing cached.
//
// usage: bench_access [--commit ID] [--rounds N] [--threads N] [--seconds S] FILE.8vo
//
// Positions are drawn from a fixed seed. "Cold" means that the reader keeps no decoded bricks:
// every request reads, checks and decodes its bricks anew (the operating system may hold the file
// itself). Each operation is run N times (5) for S seconds; the CSV's median_s is the time of one
// request, of the processor where one thread reads, so that other work on the machine counts less;
// bytes are those of the voxels it returns. The first request of each kind is compared
// with the same voxels cut from a whole brick layer.

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <random>
#include <thread>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo::bench {
namespace {

struct AccessSettings : Settings {
  double seconds = 2;
  std::string path;
};

/// As long as the volume.
inline constexpr std::int64_t kWhole = kMaxAxis;

struct Request {
  const char* operation;
  Size3 sides;
};

/// A box of at most such sides at a random place.
Box random_box(const Size3& size, const Size3& sides, std::mt19937_64& random) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t length = std::min(sides[axis], size[axis]);
    box.lo[axis] = std::uniform_int_distribution<std::int64_t>(0, size[axis] - length)(random);
    box.hi[axis] = box.lo[axis] + length;
  }
  return box;
}

Bytes read_box(const FileReader& reader, const Box& box) {
  const std::int64_t voxel_bytes = bytes_per_voxel(reader.description().type);
  Bytes out(static_cast<std::size_t>(box.size().voxel_count() * voxel_bytes));
  reader.read(box, 0, out.data());
  return out;
}

/// Proves one random box against the planes it was cut from.
void prove(const FileReader& reader, const Size3& sides) {
  std::mt19937_64 random(7);
  const Size3 size = reader.description().size;
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(reader.description().type));
  const Box box = random_box(size, sides, random);
  const Bytes cut = read_box(reader, box);
  const auto row_bytes = static_cast<std::size_t>(box.size().x) * voxel_bytes;
  const std::uint8_t* row = cut.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    const Bytes plane = read_box(reader, {{0, 0, z}, {size.x, size.y, z + 1}});
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, row += row_bytes) {
      const auto first = static_cast<std::size_t>(y * size.x + box.lo.x) * voxel_bytes;
      if (std::memcmp(row, plane.data() + first, row_bytes) != 0) {
        throw Error(ErrorKind::internal, "a box differs from the planes it was cut from");
      }
    }
  }
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Requests done in `seconds` by `threads` threads together.
/// elapsed  seconds of the processor where one thread reads
std::int64_t requests_done(const FileReader& reader, const Size3& sides,
                           const AccessSettings& settings, std::uint64_t seed, double& elapsed) {
  std::atomic<std::int64_t> done = 0;
  const double start = now_seconds();
  const double cpu_start = cpu_seconds();
  std::vector<std::thread> threads;
  for (int i = 0; i < settings.threads; ++i) {
    threads.emplace_back([&, i] {
      std::mt19937_64 random(seed + static_cast<std::uint64_t>(i) * 1000003);
      do {
        read_box(reader, random_box(reader.description().size, sides, random));
        ++done;
      } while (now_seconds() - start < settings.seconds);
    });
  }
  for (std::thread& thread : threads) thread.join();
  elapsed = settings.threads == 1 ? cpu_seconds() - cpu_start : now_seconds() - start;
  return done;
}

void measure(const FileReader& reader, const Request& request, const AccessSettings& settings) {
  Row row;
  row.threads = settings.threads;
  row.data_set = settings.path.substr(settings.path.find_last_of('/') + 1);
  row.operation = request.operation;
  const Size3& size = reader.description().size;
  row.voxel_count =
      static_cast<std::uint64_t>(std::min(request.sides.x, size.x) *
                                 std::min(request.sides.y, size.y) *
                                 std::min(request.sides.z, size.z));
  row.bytes =
      row.voxel_count * static_cast<std::uint64_t>(bytes_per_voxel(reader.description().type));
  row.raw_bytes = row.bytes;
  reset_peak_memory();
  for (std::uint64_t run = 0; run < static_cast<std::uint64_t>(settings.rounds); ++run) {
    double elapsed = 0;
    const std::int64_t done = requests_done(reader, request.sides, settings, run + 1, elapsed);
    row.seconds.push_back(elapsed / static_cast<double>(done));
  }
  row.peak_memory_bytes = peak_memory_bytes();
  std::cout << csv_line(row, settings.commit) << std::endl;
  std::fprintf(stderr, "%-20s %10.1f per second\n", request.operation, 1 / median(row.seconds));
}

AccessSettings parse(int count, char** words) {
  AccessSettings settings;
  const std::vector<std::string> others = take_settings(count, words, settings);
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (others[i] == "--seconds" && i + 1 < others.size())
      settings.seconds = std::stod(others[++i]);
    else settings.path = others[i];
  }
  if (settings.path.empty()) {
    throw Error(
        ErrorKind::invalid_argument,
        "usage: bench_access [--commit ID] [--rounds N] [--threads N] [--seconds S] FILE.8vo");
  }
  return settings;
}

void run(const AccessSettings& settings) {
  ReaderOptions options;
  options.cache_bytes = 0;
  const auto source = open_byte_source(local_storage(), settings.path);
  const auto reader = FileReader::open(source, options);
  constexpr Request kRequests[] = {
      {"read voxel cold", {1, 1, 1}},           {"read box 32 cold", {32, 32, 32}},
      {"read box 192 cold", {192, 192, 192}},   {"read slice z cold", {kWhole, kWhole, 1}},
      {"read slice y cold", {kWhole, 1, kWhole}}, {"read slice x cold", {1, kWhole, kWhole}}};
  std::cout << csv_header() << "\n";
  for (const Request& request : kRequests) {
    prove(*reader, {std::min<std::int64_t>(request.sides.x, 32),
                    std::min<std::int64_t>(request.sides.y, 32),
                    std::min<std::int64_t>(request.sides.z, 32)});
    measure(*reader, request, settings);
  }
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  using namespace octavo::bench;
  return run_named("bench_access", [=] { run(parse(count, words)); });
}
