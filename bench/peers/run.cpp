#include "bench/peers/run.h"

#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>

#include "bench/common/measure.h"
#include "bench/peers/voxel_errors.h"
#include "octavo/core/error.h"

namespace octavo::bench {
namespace {

Effort measured(const std::function<void()>& work) {
  malloc_trim(0);  // memory that was freed before would hide what `work` needs
  const bool has_peak = reset_peak_memory();
  const std::uint64_t before = resident_memory_bytes();
  Effort effort;
  const double start = cpu_seconds();
  work();
  effort.seconds = cpu_seconds() - start;
  if (has_peak) effort.peak_memory_bytes = std::max(peak_memory_bytes(), before) - before;
  return effort;
}

RunResult run_here(Peer& peer, const RawVolume& volume, std::int64_t max_error) {
  RawVolume decoded = volume;
  std::fill(decoded.voxels.begin(), decoded.voxels.end(), std::uint8_t{0});
  Encoded encoded;
  RunResult result;
  result.encode = measured([&] { encoded = peer.encode(volume); });
  result.byte_count = encoded.byte_count();
  result.decode = measured([&] { peer.decode(encoded, decoded); });
  const VoxelErrors errors = errors_of(volume, decoded);
  result.measured_error = errors.max_error;
  result.psnr_db = psnr_db(volume, errors);
  require(errors.max_error <= max_error, "a voxel is further from its source than allowed");
  return result;
}

/// Runs and writes the result to `out`. Never returns.
[[noreturn]] void be_child(Peer& peer, const RawVolume& volume, std::int64_t max_error, int out) {
  int status = 1;
  try {
    const RunResult result = run_here(peer, volume, max_error);
    if (write(out, &result, sizeof result) == sizeof result) status = 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s on %s: %s\n", peer.name().c_str(), volume.name.c_str(), error.what());
  }
  _exit(status);
}

}  // namespace

RunResult run_in_child(Peer& peer, const RawVolume& volume, std::int64_t max_error) {
  std::array<int, 2> ends{};
  require(pipe(ends.data()) == 0, "pipe");
  malloc_trim(0);
  std::fflush(nullptr);
  const pid_t child = fork();
  require(child >= 0, "fork");
  if (child == 0) be_child(peer, volume, max_error, ends[1]);
  close(ends[1]);
  RunResult result;
  const bool is_whole = read(ends[0], &result, sizeof result) == sizeof result;
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  require(is_whole && WIFEXITED(status) && WEXITSTATUS(status) == 0,
          (peer.name() + " on " + volume.name).c_str());
  return result;
}

}  // namespace octavo::bench
