#include "octavo/ops/align/pose_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/ops/grid/rotation.h"
#include "octavo/ops/measure/measure.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr double kSlopeVoxels = 2;    // to either side, for the condition
constexpr std::size_t kUnknowns = 7;  // turn, shift, logarithm of the scale
using PoseRow = std::array<double, kUnknowns>;
using PoseMatrix = std::array<PoseRow, kUnknowns>;

/// p becomes scale * turn * (p - pivot) + place.
struct Pose {
  Rotation turn = kNoRotation;
  double scale = 1;
  Point3 place{};
  double cost = 0;
  int iterations = 0;
};

Point3 turned_point(const Rotation& m, const Point3& p) {
  return {m[0] * p[0] + m[1] * p[1] + m[2] * p[2], m[3] * p[0] + m[4] * p[1] + m[5] * p[2],
          m[6] * p[0] + m[7] * p[1] + m[8] * p[2]};
}

/// The turn of a unit quaternion.
Rotation turn_of(double w, double x, double y, double z) {
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

/// The turn around a vector, by its length in radians.
Rotation turn_around(const Point3& v) {
  const double angle = std::sqrt(dot(v, v));
  const double share = angle > 1e-12 ? std::sin(angle / 2) / angle : 0.5;
  return turn_of(std::cos(angle / 2), share * v[0], share * v[1], share * v[2]);
}

/// The 24 turns that lay axes onto axes.
std::vector<Rotation> axis_turns() {
  std::vector<Rotation> turns;
  constexpr std::array<std::array<std::size_t, 3>, 6> kOrders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  for (std::size_t order = 0; order < 6; ++order) {
    for (int signs = 0; signs < 8; ++signs) {
      const bool is_odd_order = order >= 3;
      const bool is_mirrored = ((signs & 1) + (signs >> 1 & 1) + (signs >> 2 & 1)) % 2 == 1;
      if (is_odd_order != is_mirrored) continue;
      Rotation turn{};
      for (std::size_t row = 0; row < 3; ++row) {
        turn[3 * row + kOrders[order][row]] = (signs >> row & 1) != 0 ? -1 : 1;
      }
      turns.push_back(turn);
    }
  }
  return turns;
}

/// Turns that cover all of them evenly, the identity first.
std::vector<Rotation> spread_turns(int count) {
  std::vector<Rotation> turns = {turn_of(1, 0, 0, 0)};
  // A spiral over the sphere of quaternions; M. Alexa, Super-Fibonacci spirals, 2022.
  const double phi = std::numbers::sqrt2;
  constexpr double kPsi = 1.533751168755204288118041;
  for (int i = 0; i < count; ++i) {
    const double s = i + 0.5;
    const double r = std::sqrt(s / count);
    const double other = std::sqrt(1 - s / count);
    const double alpha = 2 * std::numbers::pi * s / phi;
    const double beta = 2 * std::numbers::pi * s / kPsi;
    turns.push_back(turn_of(r * std::sin(alpha), r * std::cos(alpha), other * std::sin(beta),
                            other * std::cos(beta)));
  }
  return turns;
}

/// Solves a symmetric positive system of `n` unknowns by Cholesky's method; false where it is not.
bool solve_positive(PoseMatrix m, const PoseRow& right, std::size_t n, PoseRow& solution) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double value = m[i][j];
      for (std::size_t k = 0; k < j; ++k) value -= m[i][k] * m[j][k];
      if (i == j) {
        if (!(value > 0)) return false;
        m[i][i] = std::sqrt(value);
      } else {
        m[i][j] = value / m[j][j];
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    double value = right[i];
    for (std::size_t k = 0; k < i; ++k) value -= m[i][k] * solution[k];
    solution[i] = value / m[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) solution[i] -= m[k][i] * solution[k];
    solution[i] /= m[i][i];
  }
  return true;
}

/// Largest over smallest eigenvalue, by repeated products and solutions.
double condition_of(const PoseMatrix& m, std::size_t n) {
  PoseRow up{};
  PoseRow down{};
  for (std::size_t i = 0; i < n; ++i) {
    up[i] = 1 + 0.1 * static_cast<double>(i);
    down[i] = 1 - 0.1 * static_cast<double>(i);
  }
  double largest = 0;
  double smallest = 0;
  const auto normalize = [&](PoseRow& v) {
    double length = 0;
    for (std::size_t i = 0; i < n; ++i) length += v[i] * v[i];
    length = std::sqrt(length);
    for (std::size_t i = 0; i < n; ++i) v[i] /= length;
    return length;
  };
  for (int step = 0; step < 60; ++step) {
    PoseRow product_up{};
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) product_up[i] += m[i][j] * up[j];
    }
    up = product_up;
    largest = normalize(up);
    PoseRow solved{};
    if (!solve_positive(m, down, n, solved)) return HUGE_VAL;
    down = solved;
    smallest = 1 / normalize(down);
  }
  return largest / smallest;
}

/// What is laid onto the target: either points or lines.
struct PosedFeatures {
  std::span<const Point3> points;
  std::span<const SightLine> lines;

  std::size_t count() const { return points.size() + lines.size(); }
};

class PoseSolver {
 public:
  PoseSolver(const PosedFeatures& features, const Point3& pivot, const PoseTarget& target,
             bool has_scale)
      : features_(features), pivot_(pivot), target_(target), n_(has_scale ? 7 : 6) {}

  /// What a stage works with.
  struct Stage {
    const DistanceGrid& grid;
    std::size_t points;
    double cut_mm;  // c
    int steps;
    double settled;  // ends where a step takes away less than this share of the cost
  };

  void improve(Pose& pose, const Stage& stage) const {
    PoseMatrix m{};
    PoseRow right{};
    Expected expected;
    pose.cost = system(pose, stage, m, right, expected);
    double damping = 1e-3;
    for (int step = 0; step < stage.steps; ++step) {
      ++pose.iterations;
      PoseMatrix damped = m;
      for (std::size_t i = 0; i < n_; ++i) damped[i][i] += damping * m[i][i] + 1e-12;
      PoseRow change{};
      if (!solve_positive(damped, right, n_, change)) return;
      Pose next = moved(pose, change);
      PoseMatrix next_m{};
      PoseRow next_right{};
      next.cost = system(next, stage, next_m, next_right, expected);
      if (next.cost < pose.cost) {
        const bool is_done = pose.cost - next.cost < stage.settled * pose.cost;
        pose = next;
        m = next_m;
        right = next_right;
        damping = std::max(1e-7, damping * 0.2);
        if (is_done) return;
      } else {
        damping *= 8;
        if (damping > 1e6) return;
      }
    }
  }

  /// Of the system at a pose, with slopes over some voxels: single ones turn to and fro on the
  /// steps of a surface, and would seem to hold a ball.
  double condition(const Pose& pose, const Stage& stage) const {
    PoseMatrix m{};
    for (std::size_t i = 0; i < features_.count(); ++i) {
      const NearestSight feature = placed(pose, i, stage.grid);
      const double r = feature.distance.mm / pose.scale;
      const Point3 slope = smooth_slope(stage.grid, feature.place);
      add_products(row_of(pose, feature.place, slope, r), weight_of(r, stage.cut_mm), m);
    }
    mirror_products(m);
    return condition_of(m, n_);
  }

  /// A feature where a pose puts it: a point, or the place of a line that is nearest.
  /// expected_mm  where along its line, if something is known of that
  NearestSight placed(const Pose& pose, std::size_t i, const DistanceGrid& grid,
                      std::optional<double> expected_mm = std::nullopt) const {
    const auto place_of = [&](const Point3& p) {
      return sum(scaled(turned_point(pose.turn, difference(p, pivot_)), pose.scale), pose.place);
    };
    if (!features_.lines.empty()) {
      const SightLine& line = features_.lines[i];
      return nearest_sight(grid, {place_of(line.from), place_of(line.to)}, sight_reach(target_),
                           expected_mm);
    }
    const Point3 place = place_of(features_.points[i]);
    return {place, grid.at(place), 0};
  }

 private:
  /// Where along each line the surface was nearest the last time; empty before.
  using Expected = std::vector<double>;

  /// The cost, and the system of normal equations; turns and scales count in radii of the target.
  double system(const Pose& pose, const Stage& stage, PoseMatrix& m, PoseRow& right,
                Expected& expected) const {
    const double cut2 = stage.cut_mm * stage.cut_mm;
    double cost = 0;
    const std::size_t count = std::min(stage.points, features_.count());
    const bool is_first = expected.empty();
    if (is_first && !features_.lines.empty()) expected.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const NearestSight feature =
          is_first ? placed(pose, i, stage.grid) : placed(pose, i, stage.grid, expected[i]);
      if (!expected.empty()) expected[i] = feature.along_mm;
      const GridDistance& d = feature.distance;
      // Distances in the size of the points, or a scale of 0 would be best.
      const double r = d.mm / pose.scale;
      const double r2 = r * r;
      cost += cut2 * r2 / (cut2 + r2);
      const double weight = weight_of(r, stage.cut_mm);
      const PoseRow row = row_of(pose, feature.place, d.slope, r);
      add_products(row, weight, m);
      for (std::size_t a = 0; a < n_; ++a) right[a] -= weight * row[a] * r;
    }
    mirror_products(m);
    return cost / static_cast<double>(count);
  }

  static double weight_of(double r, double cut_mm) {
    const double cut2 = cut_mm * cut_mm;
    const double root = cut2 / (cut2 + r * r);
    return root * root;
  }

  /// How a distance of r grows with each unknown.
  PoseRow row_of(const Pose& pose, const Point3& place, const Point3& grown, double r) const {
    const Point3 arm = difference(place, pose.place);
    const Point3 slope = scaled(grown, 1 / pose.scale);
    const Point3 by_turn = scaled(cross(arm, slope), 1 / target_.radius_mm);
    return {by_turn[0], by_turn[1], by_turn[2], slope[0], slope[1], slope[2],
            (dot(arm, slope) - r) / target_.radius_mm};
  }

  /// The lower half of a sum of products.
  void add_products(const PoseRow& row, double weight, PoseMatrix& m) const {
    for (std::size_t a = 0; a < n_; ++a) {
      for (std::size_t b = 0; b <= a; ++b) m[a][b] += weight * row[a] * row[b];
    }
  }
  void mirror_products(PoseMatrix& m) const {
    for (std::size_t a = 0; a < n_; ++a) {
      for (std::size_t b = a + 1; b < n_; ++b) m[a][b] = m[b][a];
    }
  }

  Point3 smooth_slope(const DistanceGrid& grid, const Point3& place) const {
    const double step = kSlopeVoxels * target_.voxel_mm;
    Point3 slope{};
    for (std::size_t a = 0; a < 3; ++a) {
      Point3 before = place;
      Point3 behind = place;
      before[a] -= step;
      behind[a] += step;
      slope[a] = (grid.at(behind).mm - grid.at(before).mm) / (2 * step);
    }
    return slope;
  }

  Pose moved(const Pose& pose, const PoseRow& change) const {
    Pose next = pose;
    const double per_radius = 1 / target_.radius_mm;
    next.turn = chained(pose.turn, turn_around({change[0] * per_radius, change[1] * per_radius,
                                                change[2] * per_radius}));
    next.place = sum(pose.place, {change[3], change[4], change[5]});
    next.scale *= std::exp(std::clamp(change[6] * per_radius, -0.2, 0.2));
    return next;
  }

  PosedFeatures features_;
  Point3 pivot_;
  const PoseTarget& target_;
  std::size_t n_;
};

/// The best `count` of poses improved in a stage; the first of equal ones.
std::vector<Pose> improved(const PoseSolver& solver, std::vector<Pose> poses,
                           const PoseSolver::Stage& stage, std::size_t count,
                           Progress& progress) {
  parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    solver.improve(poses[i], stage);
  });
  std::stable_sort(poses.begin(), poses.end(),
                   [](const Pose& a, const Pose& b) { return a.cost < b.cost; });
  // Poses that came to the same place count once.
  std::vector<Pose> kept;
  for (const Pose& pose : poses) {
    if (kept.size() == count) break;
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const Pose& other) {
      double turns = 0;
      for (std::size_t i = 0; i < 9; ++i) turns += pose.turn[i] * other.turn[i];
      const Point3 apart = difference(pose.place, other.place);
      return turns > 2.99 && dot(apart, apart) < stage.cut_mm * stage.cut_mm;
    });
    if (is_new) kept.push_back(pose);
  }
  return kept;
}

void measure_residuals(std::size_t count, const PoseSolver& solver, const Pose& pose,
                       const PoseTarget& target, FoundPose& found) {
  std::vector<double> near;
  for (std::size_t i = 0; i < count; ++i) {
    const double mm = std::abs(solver.placed(pose, i, target.fine).distance.mm);
    if (mm <= 2 * target.voxel_mm) near.push_back(mm);
  }
  found.overlap = static_cast<double>(near.size()) / static_cast<double>(count);
  if (near.empty()) return;
  std::sort(near.begin(), near.end());
  for (const double mm : near) found.mean_mm += mm / static_cast<double>(near.size());
  found.p95_mm = near[static_cast<std::size_t>(0.95 * static_cast<double>(near.size() - 1))];
  found.max_mm = near.back();
}

/// Poses to begin with: own axes onto those of the target, turned in all ways.
/// is_shifted  and shifted along these axes: what is cut off leaves the middle elsewhere
std::vector<Pose> starting_poses(const PointSpread& own, const PoseTarget& target, bool has_scale,
                                 bool is_shifted) {
  Rotation to_axes{};
  Rotation from_axes{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      to_axes[3 * i + j] = own.axes[i][j];
      from_axes[3 * i + j] = target.axes[j][i];
    }
  }
  std::vector<Pose> poses;
  for (const auto& more : spread_turns(30)) {
    for (const auto& turn : axis_turns()) {
      Pose pose;
      pose.turn = chained(chained(chained(to_axes, turn), from_axes), more);
      if (has_scale) pose.scale = target.radius_mm / std::max(own.radius_mm, 1e-9);
      pose.place = target.middle;
      poses.push_back(pose);
      if (!is_shifted) continue;
      for (const Point3& axis : target.axes) {
        for (const double way : {-0.5, 0.5}) {
          pose.place = sum(target.middle, scaled(axis, way * target.radius_mm));
          poses.push_back(pose);
        }
      }
    }
  }
  return poses;
}

FoundPose described(const PoseSolver& solver, const Pose& pose, const PoseSolver::Stage& last,
                    const Point3& pivot, const PoseTarget& target) {
  FoundPose found;
  found.scale = pose.scale;
  for (std::size_t i = 0; i < 9; ++i) found.map.linear[i] = pose.scale * pose.turn[i];
  found.map.offset = difference(pose.place, turned_point(found.map.linear, pivot));
  found.iterations = pose.iterations;
  found.condition = solver.condition(pose, last);
  measure_residuals(last.points, solver, pose, target, found);
  return found;
}

FoundPose found_pose(const PosedFeatures& features, const PointSpread& own,
                     const PoseTarget& target, bool has_scale, Progress& progress) {
  const PoseSolver solver(features, own.middle, target, has_scale);
  const double voxel = target.voxel_mm;
  const double radius = target.radius_mm;
  // A line costs as many looks at the map as forty points.
  const bool has_lines = !features.lines.empty();
  std::vector<Pose> poses = starting_poses(own, target, has_scale, !has_lines);
  const auto improve = [&](std::size_t points, std::size_t lines, const DistanceGrid& grid,
                           double cut_mm, int steps, std::size_t kept) {
    poses = improved(solver, std::move(poses),
                     {grid, has_lines ? lines : points, cut_mm, steps, 1e-3}, kept,
                     progress);
  };
  improve(100, 60, target.coarse, radius / 4, has_lines ? 4 : 0, has_lines ? 200 : 900);
  improve(150, 100, target.coarse, radius / 5, 12, has_lines ? 40 : 80);
  improve(500, 200, target.coarse, radius / 12, 15, has_lines ? 12 : 16);
  improve(1500, 400, target.fine, std::max(3 * voxel, radius / 40), 20, 3);
  improve(3000, 800, target.fine, 1.5 * voxel, 25, 1);
  // As rough as the surfaces are: all that is near has to count alike.
  FoundPose rough;
  measure_residuals(features.count(), solver, poses.front(), target, rough);
  const double cut = std::clamp(3 * rough.mean_mm, 0.7 * voxel, 3 * voxel);
  const PoseSolver::Stage last{target.fine, features.count(), cut, 25, 1e-6};
  poses = improved(solver, std::move(poses), last, 1, progress);

  return described(solver, poses.front(), last, own.middle, target);
}

}  // namespace

SightReach sight_reach(const PoseTarget& target) {
  constexpr double kRadii = 2.5;
  return {target.middle, kRadii * target.radius_mm};
}

PointSpread spread_of(std::span<const Point3> points) {
  PointSpread spread;
  const double share = 1 / static_cast<double>(points.size());
  for (const Point3& p : points) spread.middle = sum(spread.middle, scaled(p, share));
  RegionMeasure shape;
  for (const Point3& p : points) {
    const Point3 d = difference(p, spread.middle);
    const std::array<double, 6> products = {d[0] * d[0], d[1] * d[1], d[2] * d[2],
                                            d[0] * d[1], d[0] * d[2], d[1] * d[2]};
    for (std::size_t i = 0; i < 6; ++i) shape.covariance[i] += products[i] * share;
  }
  spread.radius_mm =
      std::sqrt(shape.covariance[0] + shape.covariance[1] + shape.covariance[2]);
  spread.axes = principal_axes(shape, Geometry{}).axes;
  spread.axes[2] = cross(spread.axes[0], spread.axes[1]);
  return spread;
}

FoundPose settled_pose(const FoundPose& found, std::span<const Point3> points,
                       std::span<const Point3> facing, const PoseTarget& target, bool has_scale) {
  const Point3 pivot = spread_of(points).middle;
  Pose pose;
  pose.scale = found.scale;
  for (std::size_t i = 0; i < 9; ++i) pose.turn[i] = found.map.linear[i] / found.scale;
  pose.place = found.map(pivot);
  pose.iterations = found.iterations;
  const double voxel = target.voxel_mm;
  const PoseSolver by_facing({facing, {}}, pivot, target, has_scale);
  for (const double cut : {2.0, 1.0}) {
    if (facing.empty()) break;
    by_facing.improve(pose, {target.fine, facing.size(), cut * voxel, 15, 1e-5});
  }
  const PoseSolver by_all({points, {}}, pivot, target, has_scale);
  return described(by_all, pose, {target.fine, points.size(), voxel, 0, 0}, pivot, target);
}

FoundPose find_pose(std::span<const Point3> points, const PoseTarget& target, bool has_scale,
                    Progress& progress) {
  return found_pose({points, {}}, spread_of(points), target, has_scale, progress);
}

FoundPose find_pose(std::span<const SightLine> lines, const PoseTarget& target, bool has_scale,
                    Progress& progress) {
  const SightMiddle middle = middle_of(lines);
  const PointSpread own = {middle.middle, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, middle.radius_mm};
  return found_pose({{}, lines}, own, target, has_scale, progress);
}

}  // namespace octavo
