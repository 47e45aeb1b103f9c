#include "octavo/tasks/structure/align.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/ops/align/surface_points.h"
#include "octavo/ops/distance/distance_passes.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/pictures/picture_files.h"
#include "octavo/tasks/structure/moving_surface.h"
#include "octavo/tasks/structure/pose_picture.h"
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

/// Mean edge of the voxels of a mask.
double voxel_edge(const LeveledMask& mask) {
  const Point3& spacing = mask.geometry.spacing_mm;
  return (spacing[0] + spacing[1] + spacing[2]) / 3;
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

/// What moves, by its points or lines; of a mask with its distances.
struct MovingSide {
  MovingFeatures features;
  std::optional<LeveledMask> mask;
};

MovingSide open_moving(const std::string& path, const TaskContext& context) {
  MovingSide side;
  if (is_moving_mask(path)) {
    side.mask = open_leveled(path, context);
    side.features.points = points_of(*side.mask, path);
  } else {
    side.features = read_features(path, kMostPoints, context);
  }
  return side;
}

/// The share of lines of sight that touch the surface within a voxel, and where each is nearest.
PoseAgreement agreement_of_lines(const std::vector<SightLine>& lines, const PoseTarget& target,
                                 double edge_mm, const Affine& map,
                                 std::vector<PosedPlace>& places) {
  const SightReach reach = sight_reach(target);
  std::vector<double> distances;
  std::size_t agreeing = 0;
  for (const SightLine& line : lines) {
    const NearestSight near = nearest_sight(target.fine, {map(line.from), map(line.to)}, reach);
    places.push_back({near.place, near.distance.mm});
    distances.push_back(near.distance.mm);
    if (std::abs(near.distance.mm) <= target.voxel_mm) ++agreeing;
  }
  return {static_cast<double>(agreeing) / static_cast<double>(lines.size()), 0,
          sharpness_of(distances, edge_mm), 1};
}

/// The sharpness from which on a pose is beyond doubt.
double clear_sharpness(const AlignResult& result) {
  if (result.has_lines) return 0;
  return result.has_sides ? kClearSharpness : kClearSharpness - kPointBlur;
}

/// What a pose lacks to be one; nothing where it lacks nothing.
std::string lacking_words(const AlignResult& result) {
  const PoseAgreement& is = result.agreement;
  PoseAgreement needed = kMinimumAgreement;
  if (result.has_lines) needed = {kMinimumSights, 0, 0, 0};
  else if (!result.has_sides) needed.sharpness -= kPointBlur;
  if (!result.has_lines && is.sharpness >= clear_sharpness(result)) {
    needed.backward = kClearBackward;
  }
  const auto words = [](const char* what, double share, double minimum) {
    return fmt::format("{} {:.0f} %, not {:.0f} % or more", what, 100 * share, 100 * minimum);
  };
  if (is.forward < needed.forward) {
    return words(result.has_lines ? "the share of lines that touch the surface is"
                                  : "the share of the first surface that agrees is",
                 is.forward, needed.forward);
  }
  if (is.backward < needed.backward) {
    return words("the share of the second surface that agrees around there is", is.backward,
                 needed.backward);
  }
  if (is.sharpness < needed.sharpness) {
    return words("the surfaces merely come near each other: the share within half a voxel is",
                 is.sharpness, needed.sharpness);
  }
  if (is.parting < needed.parting) {
    return words("each has parts of its own on all sides: the share of these that a plane parts is",
                 is.parting, needed.parting);
  }
  return "";
}

void check_outputs(const AlignOptions& options) {
  require_apart({options.matrix.path, options.picture.path});
  for (const Output* output : {&options.matrix, &options.picture}) {
    if (output->path.empty()) continue;
    require_free(*output);
    require_no_input(output->path, {options.moving, options.fixed});
  }
  if (!options.picture.path.empty()) require_png(options.picture.path);
  if (!is_octavo_path(options.matrix.path)) return;
  throw Error(ErrorKind::invalid_argument, "the matrix is a text file, not a volume",
              options.matrix.path)
      .with_field("matrix.path");
}

}  // namespace

AlignResult align(const AlignOptions& options, const TaskContext& context) {
  check_outputs(options);
  const LeveledMask fixed = open_leveled(options.fixed, context);
  const MovingSide moving = open_moving(options.moving, context);
  const MovingFeatures& features = moving.features;
  const Size3 size = fixed.tree.size();
  const std::int64_t moving_voxels = moving.mask ? moving.mask->tree.size().voxel_count() : 0;
  context.require_memory(9 * static_cast<std::uint64_t>(size.voxel_count()) +
                             8 * static_cast<std::uint64_t>(moving_voxels),
                         "the distances");
  const std::vector<Point3> fixed_points = points_of(fixed, options.fixed);

  // The maps of distances.
  std::vector<float> mm = distances_of(fixed, context);
  const std::int64_t longest = std::max({size.x, size.y, size.z});
  const std::int64_t step = std::max<std::int64_t>(1, longest / kCoarseSide);
  const DistanceGrid coarse(mm, size, fixed.geometry, step);
  const DistanceGrid fine(mm, size, fixed.geometry, 1);
  mm = {};

  // The pose.
  AlignResult result;
  result.level = fixed.level;
  result.points = features.points.size() + features.lines.size();
  result.has_lines = !features.lines.empty();
  result.has_sides = moving.mask.has_value();
  result.voxel_mm = voxel_side(fixed);
  const PointSpread spread = spread_of(fixed_points);
  const PoseTarget target{coarse,      fine, spread.middle, spread.axes, spread.radius_mm,
                          result.voxel_mm};
  {
    const ProgressScope scope(context.watcher(), "align", 1, "poses");
    context.on_threads([&] {
      result.pose = result.has_lines
          ? find_pose(features.lines, target, options.has_scale, context.watcher())
          : find_pose(features.points, target, options.has_scale, context.watcher());
    });
  }

  // Whether it is one.
  std::vector<PosedPlace> places;
  const PosedSurface onto = {fixed_points, fine, result.voxel_mm, voxel_edge(fixed)};
  if (result.has_lines) {
    result.agreement =
        agreement_of_lines(features.lines, target, onto.edge_mm, result.pose.map, places);
  } else if (moving.mask) {
    const LeveledMask& mask = *moving.mask;
    const DistanceGrid own(distances_of(mask, context), mask.tree.size(), mask.geometry, 1);
    result.agreement =
        agreement_of({features.points, own, voxel_side(mask), voxel_edge(mask)}, onto,
                     result.pose.map);
  } else {
    result.agreement = agreement_of(PosedPoints{features.points, features.spacing_mm}, onto,
                                    result.pose.map);
  }
  result.why_none = lacking_words(result);
  result.is_found = result.why_none.empty();
  if (!result.is_found) return result;
  result.is_doubtful = result.agreement.sharpness < clear_sharpness(result);
  if (result.is_doubtful) {
    context.warn(fmt::format("{}: the pose is doubtful: of what comes near {} {:.0f} % is within "
                             "half a voxel; of the same surface more than {:.0f} % would be",
                             options.moving, options.fixed, 100 * result.agreement.sharpness,
                             100 * clear_sharpness(result)));
  }
  PictureFiles pictures(context);
  if (!options.picture.path.empty()) {
    for (const Point3& p : features.points) {
      const Point3 q = result.pose.map(p);
      places.push_back({q, fine.at(q).mm});
    }
    pictures.add(options.picture.path,
                 pose_picture(fixed.tree, fixed.geometry, places, result.voxel_mm));
  }
  if (!options.matrix.path.empty()) write_matrix(result.pose.map, options.matrix);
  pictures.publish(options.picture.overwrite);
  return result;
}

}  // namespace octavo
