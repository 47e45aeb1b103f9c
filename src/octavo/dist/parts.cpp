#include "octavo/dist/parts.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "octavo/builder/band_encoder.h"
#include "octavo/builder/build_memory.h"
#include "octavo/builder/build_setup.h"
#include "octavo/builder/coarse_tiers.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/core/memory_advice.h"
#include "octavo/core/memory_limit.h"
#include "octavo/core/text.h"
#include "octavo/dist/banded_group.h"
#include "octavo/dist/proven_source.h"
#include "octavo/file/storage/unchanged.h"

namespace octavo {

namespace {

/// Adds what lies between two bricks: of groups that have bands, at most, on both sides.
void add_gap(const BrickAt& from, const BrickAt& to, const BuildPlan& plan,
             std::vector<PartPlace>& gaps) {
  BrickAt at = from;
  if (at.second > 0 && at < to) {
    const bool ends_here = at.first == to.first;
    gaps.push_back({plan.id, at.first, at.first + 1, at.second,
                    ends_here ? to.second : layer_bricks_of(plan)});
    at = ends_here ? to : BrickAt{at.first + 1, 0};
  }
  if (at.first < to.first) gaps.push_back({plan.id, at.first, to.first});
  at.first = std::max(at.first, to.first);
  if (at < to) gaps.push_back({plan.id, to.first, to.first + 1, at.second, to.second});
}

std::vector<PartPlace> gaps_of(const BuildPlan& plan,
                               const std::vector<std::shared_ptr<PartFile>>& sorted) {
  std::vector<PartPlace> gaps;
  const std::int64_t layer_bricks = layer_bricks_of(plan);
  BrickAt at = {0, 0};
  for (const auto& part : sorted) {
    add_gap(at, begin_of(part->place()), plan, gaps);
    at = std::max(at, end_of(part->place(), layer_bricks));
  }
  add_gap(at, {plan.group_count, 0}, plan, gaps);
  return gaps;
}

bool comes_before(const std::shared_ptr<PartFile>& a, const std::shared_ptr<PartFile>& b) {
  return begin_of(a->place()) < begin_of(b->place());
}

/// The first bricks of a place, up to a brick that is not behind its end.
PartPlace first_of(const PartPlace& place, const BrickAt& end, std::int64_t layer_bricks) {
  PartPlace first = place;
  const BrickAt last = std::min(end, end_of(place, layer_bricks));
  if (place.is_band()) first.end_brick = last.second > 0 ? last.second : layer_bricks;
  else first.end_group = last.first + (last.second > 0 ? 1 : 0);
  return first;
}

/// Proves that sorted parts are of the plan and hold each of its groups once.
void require_all(const BuildPlan& plan, const std::vector<std::shared_ptr<PartFile>>& parts,
                 const std::string& path) {
  const std::int64_t layer_bricks = layer_bricks_of(plan);
  BrickAt at = {0, 0};
  for (const auto& part : parts) {
    const PartPlace& place = part->place();
    if (place.plan != plan.id) {
      throw Error(ErrorKind::invalid_argument, "is a part of another plan", part->path());
    }
    if (place.first_group >= place.end_group || place.end_group > plan.group_count ||
        place.end_brick > layer_bricks) {
      throw Error(ErrorKind::corrupt, "holds groups that the plan does not have", part->path());
    }
    if (begin_of(place) < at) {
      throw Error(ErrorKind::invalid_argument,
                  "holds " + place_text(first_of(place, at, layer_bricks)) +
                      ", which another part holds as well; give each part once",
                  part->path());
    }
    at = end_of(place, layer_bricks);
  }
  const std::vector<PartPlace> gaps = gaps_of(plan, parts);
  if (gaps.empty()) return;
  std::string text;
  for (const PartPlace& gap : gaps) text += (text.empty() ? "" : ", ") + place_text(gap);
  throw Error(ErrorKind::io,
              "no part holds " + text + " of " + std::to_string(plan.group_count) + " groups",
              path);
}

std::int64_t first_layer_of(const BuildPlan& plan, const Levels& levels, std::int64_t group) {
  return first_plane_of(plan, group) / levels.brick_side(0).z;
}

/// What the file consists of, in its order: parts, and groups of which several parts have bands.
using Runs = std::vector<std::shared_ptr<const EncodedRun>>;

/// parts  sorted, with their groups proven; header and levels outlive the runs
Runs runs_of(const std::vector<std::shared_ptr<PartFile>>& parts, const FileHeader& header,
             const Levels& levels) {
  Runs runs;
  for (auto part = parts.begin(); part != parts.end();) {
    if (!(*part)->place().is_band()) {
      runs.push_back(*part++);
      continue;
    }
    const std::int64_t group = (*part)->place().first_group;
    const auto end = std::find_if(part, parts.end(), [&](const auto& other) {
      return other->place().first_group != group;
    });
    runs.push_back(std::make_shared<BandedGroup>(
        std::vector<std::shared_ptr<PartFile>>(part, end), header, levels));
    part = end;
  }
  return runs;
}

/// Tells of the streams of parts that a stream of a run consists of.
void tell_left_out(const EncodedRun& run, const PlacedStream& placed, const LeaveOut& leave_out) {
  const auto* const banded = dynamic_cast<const BandedGroup*>(&run);
  if (banded == nullptr) {
    leave_out(dynamic_cast<const PartFile&>(run), placed.stream, placed.bytes);
    return;
  }
  std::uint64_t offset = placed.bytes.offset;
  for (const auto& band : banded->bands()) {
    if (!band->is_joined(placed.stream)) continue;
    Section bytes = band->stream(placed.stream);
    bytes.offset = std::exchange(offset, offset + bytes.length);
    leave_out(*band, placed.stream, bytes);
  }
}

/// What encodes the groups of a part.
struct GroupWork {
  const BuildPlan& plan;
  const BuildOutline& outline;
  PlaneSource& planes;
  Workers& workers;
  GroupTrainer& trainer;
  PartWriter& writer;
  Storage& storage;
  std::string folder;  ///< of scratch files
  Progress& progress;
};

/// As in a whole build the next group is read and trained on while one is encoded.
void encode_groups(const GroupWork& work, std::int64_t first_group, std::int64_t end_group) {
  const BuildOutline& outline = work.outline;
  GroupReader reader(work.planes, outline.levels, work.progress, outline.float_voxels(),
                     first_plane_of(work.plan, first_group), first_plane_of(work.plan, end_group));
  TierEncoder encoder(outline.levels, 0, outline.description.codec_type(), work.workers,
                      work.writer, work.progress, outline.bound);
  for (std::int64_t group = first_group; group < end_group; ++group) {
    const VoxelBlock block = reader.next(work.workers);
    encoder.check();
    if (group == 0) require_first_voxels(work.plan, block, work.trainer.first());
    const Model& model = group == 0 ? work.trainer.first() : work.trainer.train(block);
    encoder.start(model, block, true, [&reader] { reader.release(); });
  }
  encoder.finish();
}

void encode_groups_in_bands(const GroupWork& work, std::int64_t first_group,
                            std::int64_t end_group, std::uint64_t band_bytes) {
  const BandCut cut = band_cut(work.outline, band_bytes);
  BandEncoder encoder(work.outline, work.workers, work.writer, work.storage, work.folder,
                      work.progress);
  for (std::int64_t group = first_group; group < end_group; ++group) {
    const auto bands = std::make_shared<BandReader>(
        work.planes, work.outline.levels, first_plane_of(work.plan, group),
        first_plane_of(work.plan, group + 1), cut, work.progress);
    if (group == 0) require_first_voxels(work.plan, bands->group(), work.trainer.first());
    const Model& model =
        group == 0 ? work.trainer.first()
                   : work.trainer.train(bands->training_bricks(), bands->group().type);
    encoder.encode(bands, model);
  }
}

}  // namespace

void build_part(const BuildPlan& plan, PlaneSource& source, std::int64_t first_group,
                std::int64_t end_group, Storage& storage, const std::string& path,
                const PartWork& work, Progress& progress) {
  if (first_group < 0 || first_group >= end_group || end_group > plan.group_count) {
    throw Error(ErrorKind::invalid_argument,
                place_text({0, first_group, end_group}) + " of " +
                    std::to_string(plan.group_count) + " asked for");
  }
  require_codec(plan);
  if (source.description().size != plan.source.size) require_planned(plan, source.description());
  const std::int64_t first_plane = first_plane_of(plan, first_group);
  const std::int64_t end_plane = first_plane_of(plan, end_group);
  // Which file was changed says more than what is other than planned
  const UnchangedFiles files(files_of(plan, source, first_plane, end_plane), progress);
  require_planned(plan, source.description());
  const int threads = build_threads(work.threads);
  BuildOptions limited = plan.options;
  limited.max_memory_bytes = work.max_memory_bytes;
  limited.band_bytes = work.band_bytes;
  const std::uint64_t band_bytes = band_bytes_of(source, limited, threads);
  const ProgressScope scope(progress, "part", 2 * (end_plane - first_plane), "plane passes");

  const BuildOutline outline = outline_of(plan, source, progress);
  const Levels& levels = outline.levels;
  PartWriter writer(storage, path, header_of(plan, outline), levels,
                    {plan.id, first_group, end_group},
                    {first_layer_of(plan, levels, first_group),
                     static_cast<std::uint64_t>(first_group)});
  Workers workers(threads, work.threads_of_all);
  GroupTrainer trainer(outline.description, levels, workers, outline.settings);
  trainer.begin_with(plan.first_model);
  const GroupWork groups{plan,    outline, outline.planes(source), workers, trainer, writer,
                         storage, folder_of(path), progress};
  if (band_bytes > 0) encode_groups_in_bands(groups, first_group, end_group, band_bytes);
  else encode_groups(groups, first_group, end_group);
  writer.set_clipped(clipped_of(outline, work.on_clipped));
  // What was changed while it was read is in no part.
  files.require_still();
  writer.finish();
}

Error no_room_for(const std::string& path, std::uint64_t needed_bytes, std::uint64_t free_bytes,
                  const std::string& more) {
  constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20;
  return {ErrorKind::io,
          "no room: " + std::to_string(needed_bytes / kMebibyte + 1) + " MiB are needed, " +
              std::to_string(free_bytes / kMebibyte) + " MiB are free" + more,
          path};
}

std::vector<PartPlace> missing_groups(const BuildPlan& plan,
                                      const std::vector<std::shared_ptr<PartFile>>& parts) {
  std::vector<std::shared_ptr<PartFile>> sorted = parts;
  std::ranges::sort(sorted, comes_before);
  return gaps_of(plan, sorted);
}

BuildResult join_parts(const BuildPlan& plan, std::vector<std::shared_ptr<PartFile>> parts,
                       Storage& storage, const std::string& path, bool overwrite,
                       const PartWork& work, Progress& progress) {
  return lay_out_parts(plan, std::move(parts), storage, path, overwrite, work, progress, {});
}

BuildResult lay_out_parts(const BuildPlan& plan, std::vector<std::shared_ptr<PartFile>> parts,
                          Storage& storage, const std::string& path, bool overwrite,
                          const PartWork& work, Progress& progress, const LeaveOut& leave_out) {
  const auto start = std::chrono::steady_clock::now();
  require_codec(plan);
  std::ranges::sort(parts, comes_before);
  require_all(plan, parts, path);
  const BuildOutline outline = outline_of(plan);
  const Levels& levels = outline.levels;
  const int threads = build_threads(work.threads);
  try {
    require_memory_within(join_memory_bytes(plan.source, threads), work.max_memory_bytes,
                          "the join", memory_advice(threads));
  } catch (const Error& error) {
    throw error.with_path(path);
  }
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part->joined_bytes();
  if (!leave_out) {
    const std::optional<DiskSpace> disk = storage.disk_space(folder_of(path));
    if (disk && disk->free_bytes < bytes) {
      throw with_unchanged(storage, no_room_for(path, bytes, disk->free_bytes), path);
    }
  }
  const WatchedParts watched(parts, progress);
  const ProgressScope scope(progress, "join",
                            leave_out ? 0 : static_cast<std::int64_t>(bytes), "bytes");

  // What the parts hold, proven and summed up in the order of the bricks
  BuildResult result;
  result.threads = threads;
  double squared_error = 0;
  Workers workers(result.threads);
  std::vector<std::byte> samples;
  WriterOptions writing = outline.writing;
  writing.overwrite = overwrite;
  if (leave_out) {
    writing.leave_out = [&](const PlacedStream& placed) {
      tell_left_out(*writing.runs[placed.run], placed, leave_out);
    };
  }
  for (const auto& part : parts) {
    part->require_groups(levels, first_layer_of(plan, levels, part->place().first_group));
    squared_error = part->add_errors(squared_error);
    // Each band of a group counts those of the whole group.
    if (part->place().first_brick == 0) add_clipped(part->clipped(), result.clipped);
  }
  if (result.clipped.count > 0 && work.on_clipped) work.on_clipped(result.clipped);
  const FileHeader header = header_of(plan, outline);
  writing.runs = runs_of(parts, header, levels);

  // The file: level 0, the tiers above, and what seals it
  const auto writer = FileWriter::create(storage, path, outline.description, levels,
                                         plan.content_hash, writing);
  {
    TierEncoder encoder(levels, 0, outline.description.codec_type(), workers, *writer, progress,
                        outline.bound);
    for (const auto& part : parts) {
      for (const JournalGroup& group : part->groups()) encoder.restore_parents(group.parents);
    }
    samples = encoder.take_parents();
  }
  GroupTrainer trainer(outline.description, levels, workers, outline.settings);
  trainer.begin_with(plan.first_model);
  encode_coarse_tiers({outline.description, levels, workers, *writer, progress}, trainer.first(),
                      trainer.settings(), std::move(samples));
  result.max_error = outline.writing.max_error;
  result.coding = outline.description.coding;
  if (plan.options.keep_details > 0) {
    const WrittenErrors errors = writer->written_errors();
    result.max_error = static_cast<double>(errors.max_steps);
    result.detail_errors = detail_errors_of(errors, outline.description);
  }
  writer->set_metadata(recorded_metadata(outline.original, plan.options, result.detail_errors));
  writer->finish();
  result.file_bytes = writer->bytes_written();
  result.raw_bytes = checked_mul(
      static_cast<std::uint64_t>(plan.source.size.voxel_count()),
      static_cast<std::uint64_t>(bytes_per_voxel(plan.source.type)), "the volume");
  result.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace octavo
