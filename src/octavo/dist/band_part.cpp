#include "octavo/dist/band_part.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "octavo/builder/band_encoder.h"
#include "octavo/builder/build_memory.h"
#include "octavo/builder/build_setup.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/core/error.h"
#include "octavo/dist/proven_source.h"

namespace octavo {

namespace {

/// Passes on bricks alone: a band has model, digests and end of its own.
class BandSink final : public BrickSink {
 public:
  explicit BandSink(BrickSink& sink) : sink_(sink) {}
  void add_model(const Bytes&) override {}
  void add_brick(int tier, const EncodedBrick& brick) override { sink_.add_brick(tier, brick); }
  void add_plane_digests(std::span<const Sha256Digest>) override {}
  void end_group(std::uint32_t) override {}

 private:
  BrickSink& sink_;
};

void require_place(const BuildPlan& plan, const PartPlace& place) {
  const bool is_there = place.first_group >= 0 && place.first_group < plan.group_count &&
                        place.end_group == place.first_group + 1 && place.first_brick >= 0 &&
                        place.first_brick < place.end_brick &&
                        place.end_brick <= layer_bricks_of(plan);
  if (is_there) return;
  throw Error(ErrorKind::invalid_argument,
              place_text(place) + " of " + std::to_string(plan.group_count) + " groups asked for");
}

void require_lossless(const BuildOutline& outline) {
  if (outline.writing.max_error == 0 && outline.bound.detail_level == 0) return;
  throw Error(ErrorKind::invalid_argument,
              "parts share no group whose voxels change (a max error, details left out): its "
              "planes are hashed as they come out, in one process; plan parts of whole groups");
}

/// What of its group a part reads and gives.
BrickShare share_of(const BuildPlan& plan, const Levels& levels, const PartPlace& place) {
  const std::int64_t planes = first_plane_of(plan, place.end_group) -
                              first_plane_of(plan, place.first_group);
  const Size3 grid = levels.brick_grid(0);
  const auto [first_plane, end_plane] = hashed_planes(place, planes, grid.x * grid.y);
  return {static_cast<std::size_t>(place.first_brick), static_cast<std::size_t>(place.end_brick),
          first_plane, end_plane, place.first_group > 0};
}

/// Bytes of so many whole bricks of a source.
std::uint64_t bytes_of_bricks(const VolumeDescription& volume, std::int64_t count) {
  const std::int64_t voxels = levels_of(volume).brick_side(0).voxel_count();
  return static_cast<std::uint64_t>(count * voxels * bytes_per_voxel(volume.type));
}

}  // namespace

void require_bands(const PlaneSource& source, const BuildOptions& options) {
  BuildOutline outline = outline_build(source.description(), options);
  const VoxelType type = source.description().type;
  if (is_integer(type)) take_bounds(outline, options, {});
  require_lossless(outline);
  const std::int64_t planes = group_planes(outline.levels, type);
  if (planes > outline.levels.brick_side(0).z) {
    throw Error(ErrorKind::invalid_argument,
                "a group of this volume is " + std::to_string(planes) +
                    " planes, several layers of bricks: parts share only groups of one layer; "
                    "plan parts of whole groups");
  }
  if (!source.can_seek()) {
    throw Error(ErrorKind::invalid_argument,
                "this source can only be read from its start on: parts share no group of it; plan "
                "parts of whole groups");
  }
}

void require_bands(const BuildPlan& plan, const PlaneSource& source) {
  require_bands(source, plan.options);
  require_lossless(outline_of(plan));
}

std::uint64_t band_share_bytes(const VolumeDescription& volume, std::int64_t bands) {
  const Size3 grid = levels_of(volume).brick_grid(0);
  const std::int64_t layer_bricks = grid.x * grid.y;
  const std::int64_t shares = std::min(bands, layer_bricks);
  return bytes_of_bricks(volume, (layer_bricks + shares - 1) / shares);
}

void build_band(const BuildPlan& plan, PlaneSource& source, const PartPlace& place,
                Storage& storage, const std::string& path, const PartWork& work,
                Progress& progress) {
  // Whether it is the source that was planned
  require_place(plan, place);
  require_codec(plan);
  if (source.description().size != plan.source.size) require_planned(plan, source.description());
  const std::int64_t group = place.first_group;
  const std::int64_t first_plane = first_plane_of(plan, group);
  const std::int64_t end_plane = first_plane_of(plan, group + 1);
  const UnchangedFiles files(files_of(plan, source, first_plane, end_plane), progress);
  require_planned(plan, source.description());
  require_bands(plan, source);

  // What memory holds of it
  const int threads = build_threads(work.threads);
  BuildOptions limited = plan.options;
  limited.max_memory_bytes = work.max_memory_bytes;
  limited.band_bytes = work.band_bytes;
  const std::int64_t bricks = place.end_brick - place.first_brick;
  const std::uint64_t band_bytes =
      share_band_bytes(source, limited, threads, bytes_of_bricks(plan.source, bricks));
  const std::int64_t planes = end_plane - first_plane;
  const ProgressScope scope(progress, "part", planes + planes * bricks / layer_bricks_of(plan),
                            "plane passes");

  // The planes, and the model that all bands of the group come to
  const BuildOutline outline = outline_of(plan, source, progress);
  const Levels& levels = outline.levels;
  const RunStart start{first_plane / levels.brick_side(0).z, static_cast<std::uint64_t>(group),
                       place.first_brick, place.end_brick};
  PartPlace of_plan = place;
  of_plan.plan = plan.id;
  PartWriter writer(storage, path, header_of(plan, outline), levels, of_plan, start);
  Workers workers(threads, work.threads_of_all);
  GroupTrainer trainer(outline.description, levels, workers, outline.settings);
  trainer.begin_with(plan.first_model);
  BandCut cut = band_cut(outline, band_bytes);
  cut.share = share_of(plan, levels, place);
  const auto bands = std::make_shared<BandReader>(outline.planes(source), levels, first_plane,
                                                  end_plane, cut, progress);
  const VoxelBlock& block = bands->group();
  if (group == 0) require_first_voxels(plan, block, trainer.first());
  const Model model = group == 0 ? trainer.first()
                                 : trainer.train(bands->training_bricks(), block.type);

  // Its bricks
  writer.add_model(model.serialized);
  BandSink sink(writer);
  BandEncoder encoder(outline, workers, sink, storage, folder_of(path), progress);
  encoder.encode(bands, model);
  writer.end_band(block.crc, bands->share_digests());
  writer.set_clipped(clipped_of(outline, work.on_clipped));
  // What was changed while it was read is in no part.
  files.require_still();
  writer.finish();
}

}  // namespace octavo
