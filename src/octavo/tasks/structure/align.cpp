#include "octavo/tasks/structure/align.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/ops/align/surface_points.h"
#include "octavo/ops/distance/distance_passes.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr std::int64_t kMostVoxels = std::int64_t{1} << 26;
constexpr std::int64_t kMostPoints = 6000;
constexpr std::int64_t kCoarseSide = 64;  // samples of the longest axis of the coarse map

/// A mask at the finest level that has few enough voxels.
struct LeveledMask {
  std::shared_ptr<const FileReader> reader;
  MaskTree tree;
  Geometry geometry;
  int level = 0;
};

LeveledMask open_leveled(const std::string& path, const TaskContext& context) {
  LeveledMask mask;
  mask.reader = open_labels(path, context, kAsMask);
  require_known_spacing(mask.reader->description(), path, "a pose in mm");
  const Levels& levels = mask.reader->levels();
  while (levels.size(mask.level).voxel_count() > kMostVoxels) ++mask.level;
  mask.tree = read_mask(*mask.reader, mask.level, any_label(), context);
  mask.geometry = levels.geometry(mask.reader->description().geometry, mask.level);
  return mask;
}

std::vector<Point3> points_of(const LeveledMask& mask, const std::string& path) {
  std::vector<Point3> points = surface_points(mask.tree, mask.geometry, kMostPoints);
  if (!points.empty()) return points;
  throw Error(ErrorKind::invalid_argument, "the mask has no surface: it is empty or full", path);
}

/// Distances of the voxels of a mask to its surface.
std::vector<float> distances_of(const LeveledMask& mask, const TaskContext& context) {
  const ProgressScope scope(context.watcher(), "distance", mask.tree.size().z, "planes");
  std::vector<float> mm;
  context.on_threads([&] {
    mm = signed_distances(mask.tree, {DistanceTo::faces, mask.geometry.spacing_mm},
                          context.watcher());
  });
  return mm;
}

double voxel_side(const LeveledMask& mask) {
  const Point3& spacing = mask.geometry.spacing_mm;
  return std::cbrt(spacing[0] * spacing[1] * spacing[2]);
}

void write_matrix(const Affine& map, const Output& output) {
  std::string text;
  for (std::size_t row = 0; row < 3; ++row) {
    text += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", map.linear[3 * row],
                        map.linear[3 * row + 1], map.linear[3 * row + 2], map.offset[row]);
  }
  text += "0 0 0 1\n";
  PendingFile file(local_storage(), output.path);
  file.append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  file.seal();
  file.publish(output.overwrite);
}

}  // namespace

AlignResult align(const AlignOptions& options, const TaskContext& context) {
  if (!options.matrix.path.empty()) {
    require_free(options.matrix);
    require_no_input(options.matrix.path, {options.moving, options.fixed});
  }
  const LeveledMask fixed = open_leveled(options.fixed, context);
  const LeveledMask moving = open_leveled(options.moving, context);
  const Size3 size = fixed.tree.size();
  const Size3 moving_size = moving.tree.size();
  context.require_memory(9 * static_cast<std::uint64_t>(size.voxel_count()) +
                             8 * static_cast<std::uint64_t>(moving_size.voxel_count()),
                         "the distances");
  const std::vector<Point3> fixed_points = points_of(fixed, options.fixed);
  const std::vector<Point3> points = points_of(moving, options.moving);

  // The maps of distances.
  std::vector<float> mm = distances_of(fixed, context);
  const std::int64_t longest = std::max({size.x, size.y, size.z});
  const std::int64_t step = std::max<std::int64_t>(1, longest / kCoarseSide);
  const DistanceGrid coarse(mm, size, fixed.geometry, step);
  const DistanceGrid fine(mm, size, fixed.geometry, 1);
  mm = {};

  AlignResult result;
  result.level = fixed.level;
  result.points = points.size();
  result.voxel_mm = voxel_side(fixed);
  const PointSpread spread = spread_of(fixed_points);
  const PoseTarget target{coarse,      fine, spread.middle, spread.axes, spread.radius_mm,
                          result.voxel_mm};
  {
    const ProgressScope scope(context.watcher(), "align", 1, "poses");
    context.on_threads([&] {
      result.pose = find_pose(points, target, options.has_scale, context.watcher());
    });
  }

  const DistanceGrid own(distances_of(moving, context), moving_size, moving.geometry, 1);
  result.agreement = agreement_of({points, own, voxel_side(moving)},
                                  {fixed_points, fine, result.voxel_mm}, result.pose.map);
  result.is_found = result.agreement.forward >= kMinimumAgreement.forward &&
                    result.agreement.backward >= kMinimumAgreement.backward;
  if (result.is_found && !options.matrix.path.empty()) {
    write_matrix(result.pose.map, options.matrix);
  }
  return result;
}

}  // namespace octavo
