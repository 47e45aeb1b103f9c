#include "octavo/file/parallel_read.h"

#include <cstdint>
#include <exception>
#include <functional>
#include <system_error>
#include <thread>
#include <utility>

#include "octavo/codec/brick_codec.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

/// So many bricks for each thread are enough to go round.
constexpr std::int64_t kBricksPerThread = 4;

std::int64_t thread_count(int threads) {
  return threads > 0 ? threads : arena_threads();
}

void run_on_threads(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  const auto work = [&](std::int64_t i, std::int64_t) { task(i); };
  run_each(count, LoopWork(work));
}

/// Runs tasks on the threads of the caller's arena. A thread that waits takes no other work up: it
/// stands in the midst of a brick.
void run_among_threads(std::int64_t count, const std::function<void(std::int64_t)>& task) {
  if (count == 1) return task(0);
  run_isolated([&] { run_on_threads(count, task); });
}

struct ParallelReading {
  const FileReader& reader;
  const Box& box;  ///< whose array `out` is
  int level;
  void* out;
  int threads;
};

/// Where the voxels of a part go.
VoxelTarget target_of(const ParallelReading& reading, const Box& part) {
  const Index3& lo = reading.box.lo;
  const Size3 size = reading.box.size();
  const std::int64_t at =
      ((part.lo.z - lo.z) * size.y + (part.lo.y - lo.y)) * size.x + (part.lo.x - lo.x);
  const std::int64_t voxel_bytes = bytes_per_voxel(reading.reader.description().type);
  return {static_cast<std::uint8_t*>(reading.out) + at * voxel_bytes, size.x, size.x * size.y};
}

void read_bricks_of(const ParallelReading& reading, const Box& wanted) {
  const FileReader& reader = reading.reader;
  const Levels& levels = reader.levels();
  const int level = reading.level;
  const Size3 side = brick_side_at(levels, level);
  const Index3 first{wanted.lo.x / side.x, wanted.lo.y / side.y, wanted.lo.z / side.z};
  const Size3 met = cells_met(wanted, side);
  const ForEach of_parts = run_among_threads;
  for_each_parallel(reading.threads)(met.voxel_count(), [&](std::int64_t i) {
    const Index3 brick{first.x + i % met.x, first.y + i / met.x % met.y,
                       first.z + i / (met.x * met.y)};
    const Box part = intersection(wanted, brick_box_at(levels, level, brick));
    const VoxelTarget target = target_of(reading, part);
    // Where bricks alone keep the threads busy, they are read whole.
    if (met.voxel_count() < kBricksPerThread * thread_count(reading.threads)) {
      reader.read_in_tasks(part, level, target, of_parts);
    } else {
      reader.read_strided(part, level, target.voxels, target.row_stride, target.plane_stride);
    }
  });
}

/// Decodes parts of a box one after the other, each on a thread of its own, so that the caller may
/// fetch the next one meanwhile.
class PartInProgress {
 public:
  explicit PartInProgress(std::function<void(const Box& part)> decode)
      : decode_(std::move(decode)) {}

  /// Throws what decoding the part before threw.
  void begin(const Box& part) {
    wait();
    const auto decode = [this, part] {
      try {
        decode_(part);
      } catch (...) {
        failure_ = std::current_exception();
      }
    };
    try {
      thread_ = std::jthread(decode);
    } catch (const std::system_error&) {
      decode_(part);  // where the system gives no more threads
    }
  }

  void wait() {
    if (thread_.joinable()) thread_.join();
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

 private:
  std::function<void(const Box& part)> decode_;
  std::exception_ptr failure_;
  std::jthread thread_;
};

/// Decodes fetched parts of a box while the next ones come.
void read_fetched(const ParallelReading& reading,
                  const std::function<void(const Box& part)>& decode) {
  PartInProgress progress(decode);
  reading.reader.for_fetched(reading.box, reading.level, [&](const Box& part) {
    if (part.hi != reading.box.hi) return progress.begin(part);
    progress.wait();
    decode(part);
  });
}

}  // namespace

ForEach for_each_parallel(int threads) {
  return [threads](std::int64_t count, const std::function<void(std::int64_t)>& task) {
    run_in_arena(threads, [&] { run_on_threads(count, task); });
  };
}

void read_parallel(const FileReader& reader, const Box& box, int level, void* out, int threads) {
  const Levels& levels = reader.levels();
  const bool is_inside = level >= 0 && level < levels.count() && !box.is_empty() &&
                         box_of(levels.size(level)).contains(box);
  const bool is_one_task = threads == 1 && reader.source().fetched_bytes_kept() == 0;
  if (is_one_task || !is_inside) return reader.read(box, level, out);
  const ParallelReading reading{reader, box, level, out, threads};
  read_fetched(reading, [&](const Box& part) {
    if (threads != 1) return read_bricks_of(reading, part);
    const VoxelTarget target = target_of(reading, part);
    reader.read_strided(part, level, target.voxels, target.row_stride, target.plane_stride);
  });
}

}  // namespace octavo
