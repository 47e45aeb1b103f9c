#include "octavo/tasks/files/probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "octavo/core/error.h"
#include "octavo/core/nearest_voxel.h"
#include "octavo/core/text.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

double read_sample(const FileReader& reader, const Index3& index, int level) {
  const Box box = {index, {index.x + 1, index.y + 1, index.z + 1}};
  return with_voxel_type(reader.description().type, [&](auto tag) {
    typename decltype(tag)::type voxel{};
    reader.read(box, level, &voxel);
    return static_cast<double>(voxel);
  });
}

/// The brick whose subtree holds a sample.
Index3 brick_position(const Levels& levels, const Index3& index, int level) {
  const int tier = Levels::tier_of(level);
  const int first = Levels::first_level(tier);
  const Size3 side = levels.brick_side(tier);
  Index3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const int halvings = levels.halving_count(level, axis) - levels.halving_count(first, axis);
    position[axis] = (index[axis] << halvings) / side[axis];
  }
  return position;
}

ProbedVoxel probed(const FileReader& reader, const Index3& index, int level) {
  const Geometry geometry = reader.levels().geometry(reader.description().geometry, level);
  ProbedVoxel voxel;
  voxel.index = index;
  voxel.world_mm = geometry.to_world({static_cast<double>(index.x), static_cast<double>(index.y),
                                      static_cast<double>(index.z)});
  voxel.stored = read_sample(reader, index, level);
  // A sample of level k is a cube of level k; its digits are those of its place on the level's
  // grid.
  voxel.code = {level, interleave(index)};
  voxel.root_level = universe_level(reader.levels().size(level)) + level;
  voxel.brick =
      reader.brick(Levels::tier_of(level), brick_position(reader.levels(), index, level));
  return voxel;
}

Index3 nearest_index(const Geometry& geometry, const Point3& world_mm) {
  const Point3 index = geometry.to_index(world_mm);
  const auto rounded = [](double v) {
    constexpr double kFar = 1e15;
    return nearest_voxel(std::clamp(v, -kFar, kFar));
  };
  return {rounded(index[0]), rounded(index[1]), rounded(index[2])};
}

/// asked  where it is not by its index, the place that was asked for
void require_inside(const Index3& index, const Size3& size, const std::string& asked = "") {
  if (box_of(size).contains(index)) return;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{}voxel {},{},{} lies outside the volume of {} voxels", asked, index.x,
                          index.y, index.z, size_text(size)));
}

}  // namespace

ProbeResult probe(const ProbeOptions& options, const TaskContext& context) {
  if (options.indices.empty() && options.positions_mm.empty()) {
    throw Error(ErrorKind::invalid_argument, "a probe needs a position");
  }
  const auto reader = open_volume(options.input, context);
  require_level(reader->levels(), options.level);
  const VolumeDescription& volume = reader->description();
  const Size3& size = reader->levels().size(options.level);
  std::vector<Index3> indices = options.indices;
  for (const Index3& index : indices) require_inside(index, size);
  if (!options.positions_mm.empty()) {
    require_known_spacing(volume, options.input, "a place in mm", "one in voxels");
  }
  for (const Point3& mm : options.positions_mm) {
    const Geometry geometry = reader->levels().geometry(volume.geometry, options.level);
    indices.push_back(nearest_index(geometry, mm));
    require_inside(indices.back(), size, point_text(mm, ",") + " mm: ");
  }
  ProbeResult result{volume, {}};
  for (const Index3& index : indices) {
    result.voxels.push_back(probed(*reader, index, options.level));
  }
  return result;
}

}  // namespace octavo
