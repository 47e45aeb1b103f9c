#include "octavo/dist/parts.h"

#include <algorithm>
#include <chrono>
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
#include "octavo/core/text.h"
#include "octavo/dist/proven_source.h"

namespace octavo {

namespace {

std::string groups_text(std::int64_t first, std::int64_t end) {
  return end - first == 1 ? "group " + std::to_string(first)
                          : "groups " + std::to_string(first) + " to " + std::to_string(end - 1);
}

std::vector<PartPlace> gaps_of(const BuildPlan& plan,
                               const std::vector<std::shared_ptr<PartFile>>& sorted) {
  std::vector<PartPlace> gaps;
  std::int64_t at = 0;
  const auto close = [&](std::int64_t begin) {
    if (begin > at) gaps.push_back({plan.id, at, begin});
  };
  for (const auto& part : sorted) {
    close(part->place().first_group);
    at = std::max(at, part->place().end_group);
  }
  close(plan.group_count);
  return gaps;
}

bool comes_before(const std::shared_ptr<PartFile>& a, const std::shared_ptr<PartFile>& b) {
  return a->place().first_group < b->place().first_group;
}

/// Proves that sorted parts are of the plan and hold each of its groups once.
void require_all(const BuildPlan& plan, const std::vector<std::shared_ptr<PartFile>>& parts,
                 const std::string& path) {
  std::int64_t at = 0;
  for (const auto& part : parts) {
    const PartPlace& place = part->place();
    if (place.plan != plan.id) {
      throw Error(ErrorKind::invalid_argument, "is a part of another plan", part->path());
    }
    if (place.first_group >= place.end_group || place.end_group > plan.group_count) {
      throw Error(ErrorKind::corrupt, "holds groups that the plan does not have", part->path());
    }
    if (place.first_group < at) {
      throw Error(ErrorKind::invalid_argument,
                  "holds " + groups_text(place.first_group, std::min(at, place.end_group)) +
                      ", which another part holds as well; give each part once",
                  part->path());
    }
    at = place.end_group;
  }
  const std::vector<PartPlace> gaps = gaps_of(plan, parts);
  if (gaps.empty()) return;
  std::string text;
  for (const PartPlace& gap : gaps) {
    text += (text.empty() ? "" : ", ") + groups_text(gap.first_group, gap.end_group);
  }
  throw Error(ErrorKind::io, "no part holds " + text + " of " + std::to_string(plan.group_count),
              path);
}

std::int64_t first_layer_of(const BuildPlan& plan, const Levels& levels, std::int64_t group) {
  return first_plane_of(plan, group) / levels.brick_side(0).z;
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
    const VoxelBlock block = reader.next();
    encoder.check();
    const Model& model = work.trainer.train(block);
    if (group == 0) require_first_voxels(work.plan, block, model);
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
    const Model& model = work.trainer.train(bands->training_bricks(), bands->group().type);
    if (group == 0) require_first_voxels(work.plan, bands->group(), model);
    encoder.encode(bands, model);
  }
}

}  // namespace

void build_part(const BuildPlan& plan, PlaneSource& source, std::int64_t first_group,
                std::int64_t end_group, Storage& storage, const std::string& path,
                const PartWork& work, Progress& progress) {
  if (first_group < 0 || first_group >= end_group || end_group > plan.group_count) {
    throw Error(ErrorKind::invalid_argument,
                groups_text(first_group, end_group) + " of " + std::to_string(plan.group_count) +
                    " asked for");
  }
  require_codec(plan);
  if (source.description().size != plan.source.size) require_planned(plan, source.description());
  const std::int64_t first_plane = first_plane_of(plan, first_group);
  const std::int64_t end_plane = first_plane_of(plan, end_group);
  const std::vector<SourceStamp> files = files_of(plan, source, first_plane, end_plane);
  // Which file was changed says more than what is other than planned
  require_unchanged(files);
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
  if (first_group > 0) trainer.begin_with(plan.first_model);
  const GroupWork groups{plan,    outline, outline.planes(source), workers, trainer, writer,
                         storage, folder_of(path), progress};
  if (band_bytes > 0) encode_groups_in_bands(groups, first_group, end_group, band_bytes);
  else encode_groups(groups, first_group, end_group);
  clipped_of(outline, work.on_clipped);
  // What was changed while it was read is in no part.
  require_unchanged(files);
  writer.finish();
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
  std::uint64_t bytes = 0;
  for (const auto& part : parts) bytes += part->stream_bytes();
  const WatchedParts watched(parts, progress);
  const ProgressScope scope(progress, "join",
                            leave_out ? 0 : static_cast<std::int64_t>(bytes), "bytes");

  // What the parts hold, proven and summed up in the order of the bricks
  BuildResult result;
  result.threads = build_threads(work.threads);
  double squared_error = 0;
  Workers workers(result.threads);
  std::vector<std::byte> samples;
  WriterOptions writing = outline.writing;
  writing.overwrite = overwrite;
  if (leave_out) {
    writing.leave_out = [&](const PlacedStream& placed) {
      leave_out(*parts[placed.run], placed.stream, placed.bytes);
    };
  }
  for (const auto& part : parts) {
    part->require_groups(levels, first_layer_of(plan, levels, part->place().first_group));
    squared_error = part->add_errors(squared_error);
    writing.runs.push_back(part);
  }

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
