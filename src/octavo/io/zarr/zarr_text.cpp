#include "octavo/io/zarr/zarr_text.h"

#include <array>
#include <string_view>
#include <vector>

#include "octavo/core/json_text.h"
#include "octavo/core/sha256.h"

namespace octavo {

namespace {

/// An object of two members that zarr describes chunks, keys and codecs by.
JsonObject named(std::string_view name, const JsonObject& configuration) {
  return JsonObject().set("name", name).set("configuration", configuration);
}

std::array<std::int64_t, 3> in_zyx(const Size3& size) { return {size.z, size.y, size.x}; }
std::array<double, 3> in_zyx(const Point3& point) { return {point[2], point[1], point[0]}; }

JsonObject bytes_codec() { return named("bytes", JsonObject().set("endian", "little")); }

JsonObject checksum_codec() { return JsonObject().set("name", "crc32c"); }

/// What a chunk goes through.
std::vector<JsonObject> chunk_codecs(VoxelType type, const ZarrGrid& grid) {
  std::vector<JsonObject> codecs = {bytes_codec()};
  if (grid.compression == ZarrCompression::zstd) {
    codecs.push_back(
        named("zstd", JsonObject().set("level", 5).set("checksum", grid.has_checksums)));
    return codecs;
  }
  if (grid.compression == ZarrCompression::blosc) {
    codecs.push_back(named("blosc", JsonObject()
                                        .set("cname", "zstd")
                                        .set("clevel", 5)
                                        .set("shuffle", "shuffle")
                                        .set("typesize", bytes_per_voxel(type))
                                        .set("blocksize", 0)));
  }
  if (grid.has_checksums) codecs.push_back(checksum_codec());
  return codecs;
}

/// A world position along the axes of the grid.
Point3 along_axes(const Geometry& geometry, const Point3& world) {
  Point3 place{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t row = 0; row < 3; ++row) {
      place[axis] += geometry.direction[3 * row + axis] * world[row];
    }
  }
  return place;
}

JsonObject dataset_of(const Geometry& geometry, int number) {
  JsonObject scale;
  scale.set("type", "scale").set("scale", in_zyx(geometry.spacing_mm));
  JsonObject translation;
  translation.set("type", "translation")
      .set("translation", in_zyx(along_axes(geometry, geometry.origin_mm)));
  return JsonObject()
      .set("path", std::to_string(number))
      .set("coordinateTransformations", std::vector<JsonObject>{scale, translation});
}

/// The names of labels, and their colors, as viewers of OME-Zarr look for them.
JsonObject image_label(const LabelNames& names) {
  std::vector<JsonObject> colors;
  std::vector<JsonObject> properties;
  for (const auto& [label, name] : names.all()) {
    properties.push_back(JsonObject().set("label-value", label).set("name", name.name));
    if (!name.color) continue;
    std::vector<int> rgba(name.color->begin(), name.color->end());
    rgba.push_back(255);
    colors.push_back(JsonObject().set("label-value", label).set("rgba", rgba));
  }
  JsonObject object;
  if (!colors.empty()) object.set("colors", colors);
  if (!properties.empty()) object.set("properties", properties);
  return object;
}

/// All that OME-Zarr has no place for.
JsonObject octavo_attribute(const FileReader& reader, int first_level) {
  const VolumeDescription& volume = reader.description();
  const Geometry geometry = reader.levels().geometry(volume.geometry, first_level);
  JsonObject object;
  object.set("content", volume.kind == VolumeKind::labels ? "label map" : "grey values")
      .set("origin_mm", geometry.origin_mm)
      .set("spacing_mm", geometry.spacing_mm)
      .set("direction", geometry.direction)
      .set("slope", volume.rescale.slope)
      .set("intercept", volume.rescale.intercept);
  if (first_level == 0) object.set("voxels_sha256", hex_text(reader.voxel_digest()));
  if (volume.metadata.is_readable()) {
    object.set_json("metadata", volume.metadata.without_identity().text());
  }
  return object;
}

}  // namespace

Size3 ZarrGrid::file_size() const {
  if (!shard_chunks) return chunk;
  return {chunk.x * shard_chunks->x, chunk.y * shard_chunks->y, chunk.z * shard_chunks->z};
}

std::string zarr_array_text(VoxelType type, const Size3& size, const ZarrGrid& grid) {
  std::vector<JsonObject> codecs = chunk_codecs(type, grid);
  if (grid.shard_chunks) {
    const std::vector<JsonObject> index = {bytes_codec(), checksum_codec()};
    codecs = {named("sharding_indexed", JsonObject()
                                            .set("chunk_shape", in_zyx(grid.chunk))
                                            .set("codecs", codecs)
                                            .set("index_codecs", index)
                                            .set("index_location", "end"))};
  }
  const JsonObject keys = named("default", JsonObject().set("separator", "/"));
  return JsonObject()
      .set("zarr_format", 3)
      .set("node_type", "array")
      .set("shape", in_zyx(size))
      .set("data_type", voxel_type_name(type))
      .set("chunk_grid",
           named("regular", JsonObject().set("chunk_shape", in_zyx(grid.file_size()))))
      .set("chunk_key_encoding", keys)
      .set("fill_value", 0)
      .set("codecs", codecs)
      .set("dimension_names", std::array{"z", "y", "x"})
      .set("attributes", JsonObject())
      .text();
}

std::string ome_group_text(const FileReader& reader, int first_level, int end_level,
                           const std::string& name) {
  const VolumeDescription& volume = reader.description();
  const Levels& levels = reader.levels();
  std::vector<JsonObject> axes;
  for (const char* const axis : {"z", "y", "x"}) {
    JsonObject one;
    one.set("name", axis).set("type", "space");
    if (volume.metadata.is_spacing_known()) one.set("unit", "millimeter");
    axes.push_back(one);
  }
  std::vector<JsonObject> datasets;
  for (int level = first_level; level < end_level; ++level) {
    datasets.push_back(
        dataset_of(levels.geometry(volume.geometry, level), level - first_level));
  }
  const std::vector<JsonObject> multiscales = {
      JsonObject().set("name", name).set("axes", axes).set("datasets", datasets)};
  JsonObject ome;
  ome.set("version", "0.5").set("multiscales", multiscales);
  if (volume.kind == VolumeKind::labels) {
    ome.set("image-label", image_label(volume.metadata.facts().labels));
  }
  return JsonObject()
      .set("zarr_format", 3)
      .set("node_type", "group")
      .set("attributes",
           JsonObject().set("ome", ome).set("octavo", octavo_attribute(reader, first_level)))
      .text();
}

int end_of_shown_levels(const Levels& levels, const ZarrGrid& grid) {
  const Size3& chunk = grid.chunk;
  int level = 0;
  while (level + 1 < levels.count()) {
    const Size3 size = levels.size(level);
    if (size.x <= chunk.x && size.y <= chunk.y && size.z <= chunk.z) break;
    ++level;
  }
  return level + 1;
}

}  // namespace octavo
