#include "bench/peers/contest.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench/common/measure.h"
#include "bench/peers/run.h"

namespace octavo::bench {
namespace {

struct Contest {
  Peer* peer = nullptr;
  Row encode;
  Row decode;
  RunResult last;

  double spent_seconds() const {
    double sum = 0;
    for (const double seconds : encode.seconds) sum += seconds;
    for (const double seconds : decode.seconds) sum += seconds;
    return sum;
  }
  /// True when one more run of average length stays within the budget, or none was made.
  bool has_time(double budget_seconds) const {
    const auto runs = static_cast<double>(encode.seconds.size());
    return runs == 0 || spent_seconds() * (runs + 1) / runs <= budget_seconds;
  }
};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_wanted(const std::string& name, const ContestSettings& settings) {
  return (settings.only.empty() || contains(settings.only, name)) &&
         !contains(settings.without, name);
}

std::vector<Contest> enter(const Peers& peers, const RawVolume& volume,
                           const ContestSettings& settings) {
  std::vector<Contest> contests;
  for (const auto& peer : peers) {
    if (!is_wanted(peer->name(), settings) || !peer->supports(volume)) continue;
    Contest contest;
    contest.peer = peer.get();
    contest.encode.data_set = volume.name;
    contest.encode.raw_bytes = volume.voxels.size();
    contest.encode.voxel_count = static_cast<std::uint64_t>(volume.size.voxel_count());
    contest.decode = contest.encode;
    contest.encode.operation = "encode " + peer->name();
    contest.decode.operation = "decode " + peer->name();
    peer->prepare(volume);
    contests.push_back(std::move(contest));
  }
  return contests;
}

void note(Row& row, const Effort& effort, std::uint64_t byte_count) {
  row.seconds.push_back(effort.seconds);
  row.peak_memory_bytes = std::max(row.peak_memory_bytes, effort.peak_memory_bytes);
  row.bytes = byte_count;
}

void run_once(Contest& contest, const RawVolume& volume, std::int64_t max_error) {
  contest.last = run_in_child(*contest.peer, volume, max_error);
  note(contest.encode, contest.last.encode, contest.last.byte_count);
  note(contest.decode, contest.last.decode, contest.last.byte_count);
}

void print(const Row& row, const RunResult& result, std::int64_t max_error,
           const std::string& commit) {
  const double bits = static_cast<double>(row.bytes) * 8 / static_cast<double>(row.voxel_count);
  std::printf("%s,%.4f,%lld,%lld,", csv_line(row, commit).c_str(), bits,
              static_cast<long long>(max_error), static_cast<long long>(result.measured_error));
  if (std::isfinite(result.psnr_db)) std::printf("%.2f", result.psnr_db);
  std::printf("\n");
}

}  // namespace

std::string contest_header() {
  return csv_header() + ",bits_per_voxel,max_error,measured_error,psnr_db";
}

void run_contest(const Peers& peers, const RawVolume& volume, std::int64_t max_error,
                 const ContestSettings& settings) {
  std::vector<Contest> contests = enter(peers, volume, settings);
  for (int round = 0; round < settings.rounds; ++round) {
    for (Contest& contest : contests) {
      if (contest.has_time(settings.budget_seconds)) run_once(contest, volume, max_error);
    }
  }
  for (const Contest& contest : contests) {
    print(contest.encode, contest.last, max_error, settings.commit);
    print(contest.decode, contest.last, max_error, settings.commit);
  }
  std::fflush(stdout);
}

}  // namespace octavo::bench
