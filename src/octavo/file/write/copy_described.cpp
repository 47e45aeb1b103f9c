#include "octavo/file/write/copy_described.h"

#include <cmath>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/open_file.h"
#include "octavo/file/write/interrupted.h"
#include "octavo/file/write/writer.h"

namespace octavo {

namespace {

void require_same_volume(const VolumeDescription& a, const VolumeDescription& b) {
  const bool is_same = a.kind == b.kind && a.type == b.type && a.size == b.size &&
                       a.rescale == b.rescale && a.coding == b.coding;
  if (!is_same) throw Error(ErrorKind::invalid_argument, "a description of another volume");
}

// The brick as it stands in the file.
EncodedBrick brick_of(const OpenFile& file, int tier, const Index3& position) {
  const BrickEntry entry = file.entry_at(tier, position);
  EncodedBrick brick;
  brick.range = entry.range;
  // Bricks of exact floats have no error, nor a step to count it in.
  if (entry.max_error > 0) {
    brick.max_error = std::llround(entry.max_error / error_step(file.header()));
  }
  const BrickBytes bytes = file.read_segments(entry, 0);
  const auto level_count = static_cast<std::size_t>(file.levels().tier_level_count(tier));
  for (std::size_t i = 0; i < level_count; ++i) {
    brick.segments.emplace_back(bytes.segments[i].begin(), bytes.segments[i].end());
  }
  return brick;
}

// Parts that still hold: the build id of the copy is another one, and its place may be. The writer
// makes a thumbnail anew.
void add_parts(const OpenFile& file, const VolumeDescription& description, FileWriter& writer) {
  const bool is_moved = !(description.geometry == file.description().geometry);
  const std::uint32_t lost = kRestPart | (is_moved ? kVoxelPart : 0);
  for (const PartEntry& entry : file.parts()) {
    if (entry.tag == kThumbnailTag || (entry.flags & lost) != 0) continue;
    const auto copy = [&file, entry](const auto& sink) { file.copy_part(entry, sink); };
    writer.add_part({entry.tag, entry.flags, copy});
  }
}

}  // namespace

std::uint64_t copy_described(std::shared_ptr<const ByteSource> source,
                             const VolumeDescription& description, Storage& storage,
                             const std::string& path, bool overwrite, Progress& progress) {
  // The same volume, under a name that is free
  const OpenFile file(std::move(source), {});
  require_same_volume(file.description(), description);
  if (!overwrite) reject_interrupted(storage, path);
  WriterOptions options;
  options.overwrite = overwrite;
  options.discards_interrupted = overwrite;
  options.max_error = file.header().max_error;
  options.has_thumbnail = file.find_part(kThumbnailTag) != nullptr;
  options.detail_level = file.header().detail_level;
  const Levels& levels = file.levels();
  // The lower half of a build id is the hash of the first voxels.
  const auto content_hash = static_cast<std::uint32_t>(file.header().build_id);
  const auto writer =
      FileWriter::create(storage, path, description, levels, content_hash, options);

  // Models and bricks, in the order of the file
  const ProgressScope scope(progress, "copy", levels.brick_count(0), "bricks");
  const std::vector<ModelRef>& models = file.root().models;
  std::size_t model = 0;
  // Models stand before the layer they begin with; the one behind all layers before tier 1.
  const auto add_model_of = [&](std::int64_t layer) {
    if (model == models.size() || models[model].first_slab != layer) return;
    writer->add_model(file.read_piece(file.model_piece(static_cast<std::uint32_t>(model))));
    ++model;
  };
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    const Size3 grid = levels.brick_grid(tier);
    const std::vector<Index3> order = layer_order(grid);
    if (tier == 1) add_model_of(levels.brick_grid(0).z);
    for (std::int64_t layer = 0; layer < grid.z; ++layer) {
      if (tier == 0) {
        add_model_of(layer);
        writer->add_plane_digests(file.slab_trailer(layer).plane_digests);
      }
      for (const Index3& place : order) {
        if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
        writer->add_brick(tier, brick_of(file, tier, {place.x, place.y, layer}));
        if (tier == 0) progress.advance(1);
      }
    }
  }
  add_parts(file, description, *writer);
  writer->finish();
  return writer->bytes_written();
}

}  // namespace octavo
