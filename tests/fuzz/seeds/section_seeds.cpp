// What stands in a file, section by section.

#include <algorithm>
#include <array>
#include <iterator>

#include "fuzz/brick_input.h"
#include "fuzz/seeds/seed_folder.h"
#include "octavo/codec/grey/grey_model.h"
#include "octavo/file/open_file.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo::fuzz {

namespace {

constexpr std::size_t kLargestFile = 16 << 10;
constexpr std::size_t kMostBricks = 2;  ///< of a tier

ByteSpan section(ByteSpan file, const Section& at) { return file.subspan(at.offset, at.length); }

void save_head(SeedFolder& seeds, ByteSpan file, const OpenFile& opened) {
  Bytes header = {1};
  put_bytes(header, file.first(kHeaderBytes));
  put_bytes(header, file.last(kTrailerBytes));
  seeds.save("header", header);

  const FileHeader& h = opened.header();
  Bytes directory = {0};
  put(directory, h.pages.end());
  put(directory, h.directory.offset);
  put_bytes(directory, section(file, h.directory));
  seeds.save("directory", directory);

  Bytes index;
  put_bytes(index, file.first(kHeaderBytes));
  put_bytes(index, section(file, h.root));
  put_bytes(index, section(file, h.pages));
  seeds.save("index", index);

  seeds.save("metadata", section(file, h.metadata));
}

void save_slab_trailers(SeedFolder& seeds, ByteSpan file, const OpenFile& opened) {
  const Levels& levels = opened.levels();
  const Size3 grid = levels.brick_grid(0);
  if (grid.x * grid.y > UINT8_MAX) return;
  for (std::int64_t slab = 0; slab < grid.z; ++slab) {
    Bytes trailer = {1, static_cast<std::uint8_t>(grid.x * grid.y),
                     static_cast<std::uint8_t>(levels.brick_box(0, {0, 0, slab}).size().z)};
    put_bytes(trailer,
              file.subspan(opened.root().slab_trailer_offset(slab),
                           opened.root().slab_trailer_bytes[static_cast<std::size_t>(slab)]));
    seeds.save("slab_trailer", trailer);
  }
}

std::uint8_t number_of(VoxelType type) {
  const auto found = std::find(kTypes.begin(), kTypes.end(), type);
  return static_cast<std::uint8_t>(found - kTypes.begin());
}

void save_models(SeedFolder& seeds, const OpenFile& opened) {
  const VolumeDescription& volume = opened.description();
  for (std::uint32_t i = 0; i < opened.root().models.size(); ++i) {
    const Bytes model = opened.read_piece(opened.model_piece(i));
    const std::uint8_t type = number_of(volume.coded_type());
    if (volume.kind == VolumeKind::labels) {
      Bytes of_labels = {2, type};
      put_bytes(of_labels, model);
      seeds.save("label_streams", of_labels);
      continue;
    }
    Bytes of_grey = {4, type, static_cast<std::uint8_t>(opened.header().detail_level)};
    put_bytes(of_grey, model);
    seeds.save("grey_streams", of_grey);

    const grey::ValueMap map = grey::parse_parameters(model).value_map;
    Bytes values = {3};
    grey::put_value_map(values, map);
    put(values, static_cast<std::int32_t>(map.lattice.voxel_of(map.first)));
    put(values, static_cast<std::int32_t>(map.lattice.voxel_of(map.first + 100)));
    grey::put_brick_map(values, {map.lattice.step > 1, !map.used.empty(), {}});
    seeds.save("grey_streams", values);
  }
}

/// The list at the front of segment 1 of a brick whose level 0 has parts.
void save_part_list(SeedFolder& seeds, const OpenFile& opened, const BrickEntry& entry,
                    const BrickBytes& brick) {
  const auto level_count = static_cast<std::size_t>(opened.levels().tier_level_count(entry.tier));
  const auto parts = opened.codec(entry.model)
                         ->open_parts(brick_shape(opened.levels(), entry.tier, entry.brick),
                                      opened.description().type, entry.range,
                                      std::span(brick.segments).first(level_count));
  if (!parts) return;
  Bytes list = {0, static_cast<std::uint8_t>(parts->parts().size())};
  put_bytes(list, brick.segments[1]);
  seeds.save("grey_streams", list);
}

void save_brick(SeedFolder& seeds, const OpenFile& opened, const BrickEntry& entry) {
  const BrickBytes brick = opened.read_segments(entry, 0);
  const int level_count = opened.levels().tier_level_count(entry.tier);
  Bytes pieces = {static_cast<std::uint8_t>(level_count - 1)};
  for (std::size_t i = 0; i + 1 < entry.pieces.size(); ++i) {
    put(pieces, static_cast<std::uint16_t>(brick.pieces[i].size()));
  }
  for (std::size_t i = 0; i < entry.pieces.size(); ++i) put_bytes(pieces, brick.pieces[i]);
  seeds.save("pieces", pieces);
  if (opened.description().kind == VolumeKind::grey) save_part_list(seeds, opened, entry, brick);
}

void save_tier(SeedFolder& seeds, const OpenFile& opened, int tier) {
  std::size_t count = 0;
  visit_cells(box_of(opened.levels().brick_grid(tier)), {1, 1, 1}, [&](const Index3& at) {
    const BrickEntry entry = opened.entry_at(tier, at);
    if (entry.is_uniform()) return true;
    save_brick(seeds, opened, entry);
    return ++count < kMostBricks;
  });
}

}  // namespace

void save_sections(SeedFolder& seeds, const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const Bytes file{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const OpenFile opened(byte_source_of(file, path.string()), {});
  save_head(seeds, file, opened);
  save_slab_trailers(seeds, file, opened);
  save_models(seeds, opened);
  for (int tier = 0; tier < opened.levels().tier_count(); ++tier) save_tier(seeds, opened, tier);
  if (file.size() > kLargestFile) return;
  for (const char* target : {"open", "reader"}) seeds.save(target, file);
  Bytes for_salvage = {1};
  put_bytes(for_salvage, file);
  seeds.save("salvage", for_salvage);
}

}  // namespace octavo::fuzz
