// What it costs to condense label maps by 4 to 1024 workers, beside the model of the thesis.
//
// usage: bench_cost levels|ranks NAME=FILE.8vo...
//
// The workers are threads of this process, each with planes of its own, and exchange what ranks of
// an MPI job do. Every octree is compared with that of one worker.
//
//   levels  codes of each level, and their share of all: the thesis assumes B lambda^(i+1)
//   ranks   for each number of workers and either plan: the level p up to which each condenses
//           alone, codes sent to condense what is above and to harvest, messages, how often the
//           farthest codes are passed on, what is held besides, and the speed-up: processor time of
//           all over that of the busiest. Workers beyond the planes have none.
//
// Prints rows of bench/results/cost-levels.csv and cost-ranks.csv; but for the speed-up they depend
// on no machine.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include <time.h>

#include "octavo/core/error.h"
#include "octavo/dist/rank_codes.h"
#include "octavo/dist/thread_ranks.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo {
namespace {

constexpr int kWorkers[] = {1, 4, 16, 64, 256, 1024};

struct CostVolume {
  std::string name;
  VolumeDescription description;
  std::vector<std::byte> voxels;
};

CostVolume open_cost_volume(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos) {
    throw Error(ErrorKind::invalid_argument, "not NAME=FILE", argument);
  }
  const auto reader =
      FileReader::open(open_byte_source(local_storage(), argument.substr(equals + 1)));
  CostVolume volume{argument.substr(0, equals), reader->description(), {}};
  const Size3& size = volume.description.size;
  volume.voxels.resize(static_cast<std::size_t>(
      size.voxel_count() * bytes_per_voxel(volume.description.type)));
  read_parallel(*reader, {{0, 0, 0}, {size.x, size.y, size.z}}, 0, volume.voxels.data(), 0);
  return volume;
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct CostRun {
  LinearOctree octree;
  RankReport report;
  double speed_up = 1;
};

CostRun run_workers(const CostVolume& volume, int count, GatherPlan plan) {
  CostRun run;
  const VolumeDescription& description = volume.description;
  const auto plane = static_cast<std::size_t>(description.size.x * description.size.y *
                                              bytes_per_voxel(description.type));
  std::vector<double> seconds(static_cast<std::size_t>(count));
  run_thread_ranks(count, [&](Communicator& ranks) {
    std::int64_t next = 0;
    const CondensedPlanes planes = {
        description.size, [&](std::int64_t first, std::int64_t) { next = first; },
        [&](PlaneCondenser& condenser) {
          const auto at = static_cast<std::size_t>(next++) * plane;
          condenser.add_plane(description.type, std::span(volume.voxels).subspan(at, plane));
        }};
    NoProgress progress;
    RankReport own;
    const double before = thread_seconds();
    LinearOctree octree = condense_by_ranks(planes, 0, ranks, plan, progress, &own);
    seconds[static_cast<std::size_t>(ranks.rank())] = thread_seconds() - before;
    if (!ranks.is_first()) return;
    run.octree = std::move(octree);
    run.report = std::move(own);
  });
  double all = 0;
  for (const double one : seconds) all += one;
  run.speed_up = all / *std::max_element(seconds.begin(), seconds.end());
  return run;
}

/// Of the geometric series that fits the counts best (maximum likelihood): the mean level m gives
/// m / (1 + m).
double fitted_lambda(const RankReport& report) {
  double levels = 0;
  double all = 0;
  for (const LevelTraffic& level : report.levels) {
    levels += static_cast<double>(level.level) * static_cast<double>(level.codes);
    all += static_cast<double>(level.codes);
  }
  const double mean = levels / all;
  return mean / (1 + mean);
}

void print_levels(const CostVolume& volume) {
  const RankReport report = run_workers(volume, 1, GatherPlan::tree).report;
  const auto all = static_cast<double>(report.codes());
  const double lambda = fitted_lambda(report);
  for (const LevelTraffic& level : report.levels) {
    std::printf("%s,%d,%llu,%.6f,%.4f\n", volume.name.c_str(), level.level,
                static_cast<unsigned long long>(level.codes),
                static_cast<double>(level.codes) / all, lambda);
  }
}

void print_ranks(const CostVolume& volume) {
  const LinearOctree expected = run_workers(volume, 1, GatherPlan::tree).octree;
  for (const GatherPlan plan : {GatherPlan::tree, GatherPlan::mesh}) {
    for (const int count : kWorkers) {
      const CostRun run = run_workers(volume, count, plan);
      if (!(run.octree == expected)) {
        throw Error(ErrorKind::internal, "the octree of workers is another one");
      }
      const int p = run_level(volume.description.size.z, count);
      std::uint64_t condensing = 0;
      std::uint64_t harvesting = 0;
      for (const LevelTraffic& level : run.report.levels) {
        (level.level >= p ? condensing : harvesting) += level.sent;
      }
      int hops = 0;
      int busy = 0;
      for (int rank = 0; rank < count; ++rank) {
        hops = std::max(hops, hop_count(plan, rank, count));
        busy += run.report.ranks[static_cast<std::size_t>(rank)].units > 0 ? 1 : 0;
      }
      const auto all = static_cast<double>(run.report.codes());
      std::printf("%s,%s,%d,%d,%d,%llu,%.6f,%.4f,%d,%d,%llu,%.6f,%.2f\n", volume.name.c_str(),
                  plan == GatherPlan::tree ? "tree" : "mesh", count, busy, p,
                  static_cast<unsigned long long>(run.report.codes()),
                  static_cast<double>(condensing) / all, static_cast<double>(harvesting) / all,
                  2 * (count - 1), hops,
                  static_cast<unsigned long long>(run.report.bytes_sent()),
                  static_cast<double>(run.report.held()) / all, run.speed_up);
      std::fflush(stdout);
    }
  }
}

int run_cost(int count, char** arguments) {
  const std::string what = count > 1 ? arguments[1] : "";
  if (count < 3 || (what != "levels" && what != "ranks")) {
    std::fprintf(stderr, "usage: bench_cost levels|ranks NAME=FILE.8vo...\n");
    return 2;
  }
  std::puts(what == "levels"
                ? "data_set,level,codes,share,lambda"
                : "data_set,plan,workers,with_planes,level_alone,codes,condensing_share,"
                  "harvesting_share,messages,most_hops,bytes_sent,held_share,speed_up");
  for (int i = 2; i < count; ++i) {
    const CostVolume volume = open_cost_volume(arguments[i]);
    if (what == "levels") print_levels(volume);
    else print_ranks(volume);
  }
  return 0;
}

}  // namespace
}  // namespace octavo

int main(int count, char** arguments) {
  try {
    return octavo::run_cost(count, arguments);
  } catch (const octavo::Error& error) {
    std::fprintf(stderr, "bench_cost: %s\n", error.what());
    return 1;
  }
}
