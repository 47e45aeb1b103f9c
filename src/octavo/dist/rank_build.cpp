#include "octavo/dist/rank_build.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "octavo/builder/build_memory.h"
#include "octavo/builder/build_setup.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/dist/clipped_bytes.h"
#include "octavo/dist/proven_source.h"
#include "octavo/dist/rank_seal.h"
#include "octavo/file/write/writer.h"

namespace octavo {

namespace {

constexpr std::chrono::milliseconds kLookAgain{50};

/// The groups of one rank, round by round.
class RankRounds {
 public:
  RankRounds(const RankJob& job, RankFiles& files, Workers& workers, GroupTrainer& trainer,
             PlaneSource& source)
      : job_(job),
        files_(files),
        workers_(workers),
        trainer_(trainer),
        sink_(job.header, job.outline.levels),
        reader_(job.outline.planes(source), job.outline.levels, job.progress,
                job.outline.float_voxels(), first_plane_of(job.plan, group_of(0)),
                job.plan.source.size.z, job.ranks.size()),
        encoder_(job.outline.levels, 0, job.outline.description.codec_type(), workers, sink_,
                 job.progress, job.outline.bound),
        next_byte_(files.first_byte) {}

  /// While groups of a round get their places, those of the next one are encoded.
  PlacedGroups run() {
    const std::int64_t left = job_.plan.group_count - files_.first_group;
    const std::int64_t rounds = (left + job_.ranks.size() - 1) / job_.ranks.size();
    for (std::int64_t round = 0; round < rounds; ++round) {
      start(round);
      if (round > 0) place(round - 1);
    }
    if (rounds > 0) place(rounds - 1);
    encoder_.finish();
    return std::move(placed_);
  }

  double read_seconds() const { return reader_.read_seconds(); }

 private:
  std::int64_t group_of(std::int64_t round) const {
    return files_.first_group + round * job_.ranks.size() + job_.ranks.rank();
  }

  bool has_group(std::int64_t round) const { return group_of(round) < job_.plan.group_count; }

  void start(std::int64_t round) {
    if (!has_group(round)) return;
    const std::int64_t group = group_of(round);
    const VoxelBlock block = reader_.next(workers_);
    encoder_.check();
    if (group == 0) require_first_voxels(job_.plan, block, trainer_.first());
    const Model& model = group == 0 ? trainer_.first() : trainer_.train(block);
    sink_.expect({block.first_plane / job_.outline.levels.brick_side(0).z,
                  static_cast<std::uint64_t>(group)});
    encoder_.start(model, block, true, [this] { reader_.release(); });
  }

  // Collective: the lengths of all groups of a round give each its place.
  void place(std::int64_t round) {
    std::optional<EncodedGroup> group;
    while (has_group(round) && !group) {
      encoder_.check();
      group = sink_.take(kLookAgain);
      if (!group) workers_.help();
    }
    const std::uint64_t length = group ? group->level_0_bytes() : 0;
    const RankSums sums = job_.ranks.sum_before({&length, 1});
    const std::uint64_t first_byte =
        checked_add(next_byte_, sums.before.front(), "the file");
    next_byte_ = checked_add(next_byte_, sums.all.front(), "the file");
    if (!group) return;
    placed_.emplace(group_of(round), files_.journal->place(*group, *files_.growing, first_byte,
                                                           job_.outline.levels));
  }

  const RankJob& job_;
  RankFiles& files_;
  Workers& workers_;
  GroupTrainer& trainer_;
  GroupSink sink_;
  GroupReader reader_;
  TierEncoder encoder_;
  std::uint64_t next_byte_;  ///< of level 0, behind the rounds that have their places
  PlacedGroups placed_;
};

// The files that the planes of a rank's groups are made of, each once.
std::vector<SourceStamp> own_files(const BuildPlan& plan, const PlaneSource& source,
                                   const Communicator& ranks, std::int64_t first_group) {
  std::vector<SourceStamp> own;
  std::set<std::string> seen;
  for (std::int64_t group = first_group + ranks.rank(); group < plan.group_count;
       group += ranks.size()) {
    for (SourceStamp& file : files_of(plan, source, first_plane_of(plan, group),
                                      first_plane_of(plan, group + 1))) {
      if (seen.insert(file.path).second) own.push_back(std::move(file));
    }
  }
  return own;
}

// Of each brick one sample goes up, that of the first level above it.
RankReport report_of(const Levels& levels, GatherPlan gather,
                     const std::vector<RankShare>& shares) {
  RankReport report{gather, {}, shares};
  for (int level = 0; level < levels.count(); ++level) {
    LevelTraffic row{level, static_cast<std::uint64_t>(levels.size(level).voxel_count()), 0};
    for (std::size_t rank = 0; level == kTierLevels && rank < shares.size(); ++rank) {
      const int hops = hop_count(gather, static_cast<int>(rank), static_cast<int>(shares.size()));
      row.sent += static_cast<std::uint64_t>(hops) * shares[rank].top_codes;
    }
    report.levels.push_back(row);
  }
  return report;
}

// Two groups are held encoded besides what a build holds.
std::uint64_t rank_memory_bytes(const VolumeDescription& volume, int threads, double max_error) {
  const auto planes =
      static_cast<std::uint64_t>(group_planes(levels_of(volume), volume.type));
  const std::uint64_t encoded =
      checked_mul(2 * planes, plane_bytes(volume), "the memory of encoded groups");
  return checked_add(build_memory_bytes(volume, threads, max_error), encoded,
                     "the memory of a rank");
}

BuildResult build(const BuildPlan& plan, PlaneSource& source, Communicator& ranks,
                  Storage& storage, const std::string& path, const RankBuildOptions& options,
                  Progress& progress, RankReport* report) {
  const auto start = std::chrono::steady_clock::now();
  // Whether this rank may work by the plan, and the name is free
  BuildResult result;
  result.threads = build_threads(options.work.threads);
  require_codec(plan);
  require_planned(plan, source.description());
  require_rank_memory(source, plan.options.max_error, options.work);
  if (ranks.is_first()) check_target(storage, path, options.overwrite);

  // What earlier jobs left
  const BuildOutline outline = outline_of(plan, source, progress);
  const FileHeader header = header_of(plan, outline);
  RankShare share;
  const RankJob job{plan, outline, header, ranks, storage, path, options, progress, share};
  RankFiles files = open_rank_files(ranks, storage, path, plan, outline.levels,
                                    rank_head(plan, outline, header),
                                    options.discards_interrupted);
  result.resumed_planes = first_plane_of(plan, files.first_group);

  const UnchangedFiles files_read(own_files(plan, source, ranks, files.first_group), progress);

  // Round by round, then what stands above all groups
  const std::int64_t own_groups =
      (plan.group_count - files.first_group + ranks.size() - 1 - ranks.rank()) / ranks.size();
  const ProgressScope scope(progress, "build", 2 * own_groups * plan.planes_per_group,
                            "plane passes");
  Workers workers(result.threads);
  GroupTrainer trainer(outline.description, outline.levels, workers, outline.settings);
  trainer.begin_with(plan.first_model);
  PlacedGroups groups;
  {
    RankRounds rounds(job, files, workers, trainer, source);
    groups = rounds.run();
    result.read_seconds = rounds.read_seconds();
  }
  const ClippedVoxels clipped = clipped_of(outline, options.work.on_clipped);
  // What was changed while it was read is in no file.
  files_read.require_still();
  groups.merge(files.groups);
  for (const auto& [number, placed] : groups) share.top_codes += placed.group.parents.size();
  share.units = groups.size();
  seal_by_ranks(job, workers, trainer.first(), trainer.settings(), files, groups, result);

  // The file has its name once rank 0 says so
  share.processor_seconds = processor_seconds();
  const std::vector<RankShare> shares = collect_shares(ranks, share);
  for (const Bytes& of_rank : ranks.collect(clipped_bytes(clipped))) {
    ByteSpan bytes = of_rank;
    add_clipped(take_clipped(bytes, "the clipped voxels of a rank"), result.clipped);
  }
  if (report != nullptr) *report = report_of(outline.levels, options.gather, shares);
  ranks.barrier();
  result.raw_bytes = checked_mul(static_cast<std::uint64_t>(plan.source.size.z),
                                 plane_bytes(plan.source), "the volume");
  result.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

void require_rank_memory(const PlaneSource& source, double max_error, const PartWork& work) {
  const int threads = build_threads(work.threads);
  check_build_memory(
      rank_memory_bytes(source.description(), threads, max_error) + source.resident_bytes(),
      work.max_memory_bytes, threads,
      "; ranks encode whole groups; the parts of a plan may encode bands of them, which need "
      "less");
}

BuildResult build_by_ranks(const BuildPlan& plan, PlaneSource& source, Communicator& ranks,
                           Storage& storage, const std::string& path,
                           const RankBuildOptions& options, Progress& progress,
                           RankReport* report) {
  try {
    return build(plan, source, ranks, storage, path, options, progress, report);
  } catch (const std::bad_alloc&) {
    throw out_of_build_memory(path);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::internal) throw error.with_path(path);
    throw;
  }
}

}  // namespace octavo
