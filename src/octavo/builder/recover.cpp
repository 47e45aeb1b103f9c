#include "octavo/builder/recover.h"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include "octavo/builder/build_outline.h"
#include "octavo/builder/coarse_tiers.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/brick_check.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/whole_bricks.h"
#include "octavo/file/write/writer.h"

namespace octavo {

namespace {

std::string without_ending(const std::string& path, const std::string& ending) {
  return path.ends_with(ending) ? path.substr(0, path.size() - ending.size()) : path;
}

// The name of the file that a growing one was to become: without the dot and ".tmp-PID". Nothing
// when it is the name of no growing file.
std::optional<std::string> target_of(const std::string& growing) {
  const std::string base = base_name_of(growing);
  constexpr std::string_view kBeforeNumber = ".tmp-";
  const std::size_t end = base.rfind(kBeforeNumber);
  if (!base.starts_with('.') || end == std::string::npos || end == 0) return std::nullopt;
  if (!temporary_type(std::string_view(base).substr(end + kBeforeNumber.size()))) {
    return std::nullopt;
  }
  return growing.substr(0, growing.size() - base.size()) + base.substr(1, end - 1);
}

// Says why none of the growing files and journals in `names` can be read.
void explain_unread(Storage& storage, const std::vector<std::string>& names,
                    const std::vector<std::string>& held) {
  if (!held.empty()) {
    throw Error(ErrorKind::io,
                "is being built by a program that still runs, or may not be locked and written by "
                "this one",
                held.front());
  }
  for (const std::string& name : names) {
    if (!name.ends_with(kJournalEnding)) continue;
    const std::string growing = without_ending(name, kJournalEnding);
    if (storage.exists(growing)) {
      throw Error(ErrorKind::corrupt,
                  "the start of its journal is damaged, and nothing else tells what is whole; "
                  "build it again from its source",
                  growing);
    }
    throw Error(ErrorKind::io, "the file that the journal belongs to is gone; nothing can be "
                               "repaired", growing);
  }
}

std::int64_t whole_layers(const InterruptedBuild& build) {
  const auto groups = proven_groups(build);
  return groups.empty() ? 0 : groups.back().group.end_layer;
}

// The interrupted build of that name which got furthest.
std::optional<InterruptedBuild> find_build(Storage& storage, const std::string& input) {
  const std::string growing = without_ending(input, kJournalEnding);
  const auto named_target = target_of(growing);
  const std::string target = named_target.value_or(input);
  const auto is_other = [&](const std::string& name) {
    const std::string base = base_name_of(without_ending(name, kJournalEnding));
    return named_target && base != base_name_of(growing);
  };
  std::vector<std::string> held;
  std::vector<InterruptedBuild> builds = find_interrupted(storage, target, &held);
  std::erase_if(builds, [&](const auto& build) { return is_other(build.file->path()); });
  if (builds.empty()) {
    std::vector<std::string> names = list_temporaries(storage, target);
    std::erase_if(held, is_other);
    std::erase_if(names, is_other);
    explain_unread(storage, names, held);
    if (!named_target && !names.empty()) {
      throw Error(ErrorKind::io,
                  "no such file, and " + base_name_of(names.front()) +
                      " beside it is of work that still runs, or that was ended before it kept a "
                      "journal of what is whole: nothing can be repaired; start it anew",
                  input);
    }
    return std::nullopt;
  }
  if (builds.size() == 1) return std::move(builds.front());
  std::vector<std::int64_t> layers;
  for (const InterruptedBuild& build : builds) layers.push_back(whole_layers(build));
  return std::move(builds[static_cast<std::size_t>(std::ranges::max_element(layers) -
                                                   layers.begin())]);
}

// Tells the file from the one that the build would have made, and from less whole ones.
std::uint32_t content_hash_of(const FileHeader& header, std::int64_t planes) {
  return static_cast<std::uint32_t>(header.build_id) ^ static_cast<std::uint32_t>(planes);
}

// Puts the samples of the bricks of a tier in voxel order.
class Parents {
 public:
  Parents(const Levels& levels, TierEncoder& encoder) : encoder_(encoder) {
    layer_bricks_ = levels.brick_grid(0).x * levels.brick_grid(0).y;
  }
  void add(std::int64_t parent) {
    layer_.push_back(parent);
    if (static_cast<std::int64_t>(layer_.size()) < layer_bricks_) return;
    encoder_.restore_parents(layer_);
    layer_.clear();
  }

 private:
  TierEncoder& encoder_;
  std::int64_t layer_bricks_;
  std::vector<std::int64_t> layer_;
};

// The metadata with the errors of the details that whole planes lack.
Metadata with_errors(const VolumeDescription& description, WrittenErrors errors,
                     const WholeBricks& bricks) {
  VolumeDescription whole = description;
  whole.size.z = planes_in(bricks.levels(), bricks.layer_count());
  errors.squared = bricks.squared_error();
  Metadata metadata = description.metadata;
  CodingNote coding = metadata.facts().coding.value_or(CodingNote{});
  coding.detail_errors = detail_errors_of(errors, whole);
  metadata.set_coding(coding);
  return metadata;
}

SealResult seal(InterruptedBuild build, Storage& storage, const std::string& output,
                const SealOptions& options, Progress& progress) {
  // What is whole, and what takes the place of the rest
  if (!options.overwrite) reject_interrupted(storage, output);
  SealResult result;
  result.input = build.file->path();
  WholeBricks bricks(std::move(build));
  const Levels& levels = bricks.levels();
  const Size3 grid = levels.brick_grid(0);
  VolumeDescription description = bricks.header().description;
  const bool is_grey = description.kind == VolumeKind::grey;
  const std::int64_t low = is_grey ? description.code_near(bricks.range().min) : 0;
  result.plane_count = description.size.z;
  result.whole_planes = planes_in(levels, bricks.layer_count());
  result.fill = description.voxel_of(low);
  if (result.whole_planes < result.plane_count) {
    RepairNote repaired;
    repaired.missing_planes = {result.whole_planes, result.plane_count - 1};
    repaired.fill = result.fill;
    description.metadata.set_repaired(repaired);
  }

  // The whole layers, then uniform ones.
  const ProgressScope scope(progress, "repair", grid.z, "layers");
  WriterOptions writing;
  writing.overwrite = options.overwrite;
  writing.discards_interrupted = options.overwrite;
  writing.max_error = bricks.header().max_error;
  writing.has_thumbnail = bricks.settings().find(kThumbnailSetting) != std::string::npos;
  writing.detail_level = bricks.header().detail_level;
  const auto writer =
      FileWriter::create(storage, output, description, levels,
                         content_hash_of(bricks.header(), result.whole_planes), writing);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Workers workers(options.threads > 0 ? options.threads : cores);
  const VoxelType type = description.codec_type();
  TierEncoder encoder(levels, 0, type, workers, *writer, progress);
  Parents parents(levels, encoder);
  EncodedBrick missing{{low, low}, uniform_parent(description, low), 0, {}};
  missing.segments.resize(static_cast<std::size_t>(levels.tier_level_count(0)));
  // Of whole layers they are known; the planes of others are all alike.
  const Sha256Digest missing_plane = uniform_plane_digest(description, low);
  const auto digests_of = [&](std::int64_t layer) -> std::vector<Sha256Digest> {
    const Box planes = levels.brick_box(0, {0, 0, layer});
    if (layer >= bricks.layer_count()) {
      return {static_cast<std::size_t>(planes.size().z), missing_plane};
    }
    const auto first = bricks.plane_digests().begin();
    return {first + planes.lo.z, first + planes.hi.z};
  };
  std::optional<Model> first_model;
  for (std::int64_t layer = 0; layer < grid.z; ++layer) {
    const bool is_whole = layer < bricks.layer_count();
    for (std::int64_t place = 0; place < grid.x * grid.y; ++place) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while repairing");
      if (is_whole && bricks.has_model()) {
        const Bytes model = bricks.model();
        if (!first_model) {
          const VoxelType coded = description.coded_type();
          first_model =
              make_model(parse_model(description.kind, coded, description.coding, model,
                                     writing.detail_level),
                         coded, description.coding, writing.detail_level);
        }
        writer->add_model(model);
      }
      const EncodedBrick brick = is_whole ? bricks.next() : missing;
      if (place == 0) writer->add_plane_digests(digests_of(layer));
      writer->add_brick(0, brick);
      parents.add(brick.parent);
    }
    progress.advance(1);
  }

  // The tiers above
  CodecSettings settings;
  settings.axis_order = first_model->encoder->axis_order();
  settings.max_error = bricks.header().max_error > 0 ? 1 : 0;
  encode_coarse_tiers({description, levels, workers, *writer, progress}, *first_model, settings,
                      encoder.take_parents());
  if (writing.detail_level > 0) {
    writer->set_metadata(with_errors(description, writer->written_errors(), bricks));
  }
  writer->finish();
  result.file_bytes = writer->bytes_written();
  return result;
}

}  // namespace

bool is_growing_name(const std::string& path) {
  return target_of(without_ending(path, kJournalEnding)).has_value();
}

std::optional<SealResult> seal_interrupted(Storage& storage, const std::string& input,
                                           const std::string& output, const SealOptions& options,
                                           Progress& progress) {
  auto build = find_build(storage, input);
  if (!build) return std::nullopt;
  return seal(std::move(*build), storage, output, options, progress);
}

}  // namespace octavo
