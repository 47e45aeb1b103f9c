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
constexpr int kSettlingRounds = 3;
constexpr std::size_t kFewestFacing = 12;
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
          sharpness_of(distances, edge_mm)};
}

/// The sharpness from which on a pose is beyond doubt.
double clear_sharpness(const AlignResult& result) {
  if (result.has_lines) return 0;
  return result.has_sides ? kClearSharpness : kClearSharpness - kPointBlur;
}

/// A share in percent with a decimal, rounded down: what is below a bound reads so.
double percent_below(double share) { return std::floor(1000 * share + 1e-6) / 10; }

/// What makes a pose doubtful; nothing where it is clear.
std::string doubtful_words(const AlignResult& result) {
  const PoseAgreement& is = result.agreement;
  if (result.has_lines && is.forward < kClearSights) {
    return fmt::format("{:.1f} % of the lines touch the surface; of its own more than {:.0f} % "
                       "would", percent_below(is.forward), 100 * kClearSights);
  }
  if (is.sharpness >= clear_sharpness(result)) return "";
  return fmt::format("of what comes near {:.1f} % is within half a voxel; of the same surface more "
                     "than {:.0f} % would be", percent_below(is.sharpness),
                     100 * clear_sharpness(result));
}

/// What a pose lacks to be one; nothing where it lacks nothing.
std::string lacking_words(const AlignResult& result) {
  const PoseAgreement& is = result.agreement;
  PoseAgreement needed = kMinimumAgreement;
  if (result.has_lines) needed = {.forward = kMinimumSights, .parting = 0};
  else if (!result.has_sides) needed.sharpness -= kPointBlur;
  if (is.has_both_alone) {
    needed.backward = kBothAloneBackward;
    needed.sharpness = kClearSharpness;
  } else if (!result.has_lines && is.sharpness >= clear_sharpness(result)) {
    needed.backward = kClearBackward;
  }
  const auto words = [](const char* what, double share, double minimum) {
    return fmt::format("{} {:.1f} %, not {:.0f} % or more", what, percent_below(share),
                       100 * minimum);
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

/// The distances around a mask, coarse and fine, and how its surface is spread.
class MaskMaps {
 public:
  MaskMaps(const LeveledMask& mask, const std::vector<Point3>& points, const TaskContext& context)
      : MaskMaps(mask, points, distances_of(mask, context)) {}

  PoseTarget target() const {
    return {coarse_, fine_, spread_.middle, spread_.axes, spread_.radius_mm, voxel_mm_};
  }
  PosedSurface surface() const { return {points_, fine_, voxel_mm_, edge_mm_}; }

 private:
  MaskMaps(const LeveledMask& mask, const std::vector<Point3>& points,
           const std::vector<float>& mm)
      : coarse_(mm, mask.tree.size(), mask.geometry, coarse_step(mask.tree.size())),
        fine_(mm, mask.tree.size(), mask.geometry, 1),
        points_(points),
        spread_(spread_of(points)),
        voxel_mm_(voxel_side(mask)),
        edge_mm_(voxel_edge(mask)) {}

  static std::int64_t coarse_step(const Size3& size) {
    return std::max<std::int64_t>(1, std::max({size.x, size.y, size.z}) / kCoarseSide);
  }

  DistanceGrid coarse_;
  DistanceGrid fine_;
  const std::vector<Point3>& points_;
  PointSpread spread_;
  double voxel_mm_;
  double edge_mm_;
};

/// Moves a pose of a mask on by what has a counterpart, describes and judges it.
/// result  of its pose the map, scale and iterations are taken
void settle_pose(const MaskMaps& moving, const MaskMaps& fixed, bool has_scale,
                 AlignResult& result) {
  const PosedSurface moved = moving.surface();
  const PosedSurface onto = fixed.surface();
  for (int round = 0; round < kSettlingRounds; ++round) {
    std::vector<Point3> facing = facing_points(moved, onto, result.pose.map);
    const bool is_last = facing.size() < kFewestFacing;
    if (is_last) facing.clear();
    result.pose = settled_pose(result.pose, moved.points, facing, fixed.target(), has_scale);
    if (is_last) break;
  }
  result.agreement = agreement_of(moved, onto, result.pose.map);
  result.why_none = lacking_words(result);
}

/// The pose of a mask: what moves is looked for on what stays, and where that finds none, what
/// stays on what moves. A whole has no counterpart for most of its points on a half, and points of
/// a half have theirs on the whole.
void find_mask_pose(const MaskMaps& moving, const MaskMaps& fixed, bool has_scale,
                    const TaskContext& context, AlignResult& result) {
  context.on_threads([&] {
    result.pose =
        find_pose(moving.surface().points, fixed.target(), has_scale, context.watcher());
    settle_pose(moving, fixed, has_scale, result);
    if (result.why_none.empty()) return;
    AlignResult other = result;
    const FoundPose back =
        find_pose(fixed.surface().points, moving.target(), has_scale, context.watcher());
    const auto map = inverse(back.map);
    if (!map) return;
    other.pose = {};
    other.pose.map = *map;
    other.pose.scale = 1 / back.scale;
    other.pose.iterations = back.iterations;
    settle_pose(moving, fixed, has_scale, other);
    if (other.why_none.empty()) result = other;
  });
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
  const std::int64_t moving_voxels = moving.mask ? moving.mask->tree.size().voxel_count() : 0;
  context.require_memory(
      9 * static_cast<std::uint64_t>(fixed.tree.size().voxel_count() + moving_voxels),
      "the distances");
  const std::vector<Point3> fixed_points = points_of(fixed, options.fixed);
  const MaskMaps fixed_maps(fixed, fixed_points, context);
  const PoseTarget target = fixed_maps.target();

  AlignResult result;
  result.level = fixed.level;
  result.points = features.points.size() + features.lines.size();
  result.has_lines = !features.lines.empty();
  result.has_sides = moving.mask.has_value();
  result.voxel_mm = voxel_side(fixed);
  std::vector<PosedPlace> places;
  if (moving.mask) {
    const MaskMaps moving_maps(*moving.mask, features.points, context);
    const ProgressScope scope(context.watcher(), "align", 1, "poses");
    find_mask_pose(moving_maps, fixed_maps, options.has_scale, context, result);
  } else {
    const ProgressScope scope(context.watcher(), "align", 1, "poses");
    context.on_threads([&] {
      result.pose = result.has_lines
          ? find_pose(features.lines, target, options.has_scale, context.watcher())
          : find_pose(features.points, target, options.has_scale, context.watcher());
    });
    result.agreement =
        result.has_lines
            ? agreement_of_lines(features.lines, target, voxel_edge(fixed), result.pose.map,
                                 places)
            : agreement_of(PosedPoints{features.points, features.spacing_mm},
                           fixed_maps.surface(), result.pose.map);
    result.why_none = lacking_words(result);
  }
  result.is_found = result.why_none.empty();
  if (!result.is_found) return result;
  const std::string doubt = doubtful_words(result);
  result.is_doubtful = !doubt.empty();
  if (result.is_doubtful) {
    context.warn(fmt::format("{}: the pose on {} is doubtful: {}", options.moving, options.fixed,
                             doubt));
  }
  PictureFiles pictures(context);
  if (!options.picture.path.empty()) {
    for (const Point3& p : features.points) {
      const Point3 q = result.pose.map(p);
      places.push_back({q, target.fine.at(q).mm});
    }
    pictures.add(options.picture.path,
                 pose_picture(fixed.tree, fixed.geometry, places, result.voxel_mm));
  }
  if (!options.matrix.path.empty()) write_matrix(result.pose.map, options.matrix);
  pictures.publish(options.picture.overwrite);
  return result;
}

Facts pose_facts(const AlignResult& result) {
  const FoundPose& pose = result.pose;
  FactValue::List rows;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* const linear = &pose.map.linear[3 * row];
    rows.push_back(std::array{linear[0], linear[1], linear[2], pose.map.offset[row]});
  }
  return {{"found", result.is_found},
          {"why_none", result.is_found ? FactValue() : FactValue(result.why_none)},
          {"matrix_mm", result.is_found ? FactValue(rows) : FactValue()},
          {"scale", pose.scale},
          {"agreement", result.agreement.forward},
          {"agreement_around", result.agreement.backward},
          {"sharpness", result.agreement.sharpness},
          {"parting", result.agreement.parting},
          {"doubtful", result.is_doubtful},
          {"overlap", pose.overlap},
          {"mean_mm", pose.mean_mm},
          {"p95_mm", pose.p95_mm},
          {"max_mm", pose.max_mm},
          {"iterations", pose.iterations},
          {"condition", pose.condition},
          {"points", result.points},
          {"has_lines", result.has_lines},
          {"level", result.level}};
}

}  // namespace octavo
