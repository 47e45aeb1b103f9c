#include "octavo/tasks/transform_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/io/source/place_known.h"
#include "octavo/tasks/geometry_words.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr std::array kInterpolations = {"nearest", "linear", "cubic"};
constexpr std::array kAxes = {"x", "y", "z"};

const char* interpolation_name(Interpolation interpolation) {
  return kInterpolations[static_cast<std::size_t>(interpolation)];
}

[[noreturn]] void reject(const std::string& why, const std::string& path, const char* field) {
  throw Error(ErrorKind::invalid_argument, why, path).with_field(field);
}

void require_axis(int axis) {
  if (axis < 0 || axis > 2) reject("an axis is 0, 1 or 2", "", "step.axis");
}

/// Makes the plan of one step; each operator() is one kind of them.
class Planner {
 public:
  Planner(const TransformOptions& options, const FileReader& reader, const TaskContext& context)
      : path_(options.input),
        reader_(reader),
        volume_(reader.description()),
        context_(context) {
    plan_.size = volume_.size;
    plan_.geometry = volume_.geometry;
  }

  void operator()(const TranslateStep& step);
  void operator()(const TranslateMmStep& step);
  void operator()(const ShiftStep& step);
  void operator()(const RotateStep& step);
  void operator()(const MirrorStep& step);
  void operator()(const ScaleStep& step);
  void operator()(const ResampleStep& step);

  TransformPlan take() { return std::move(plan_); }

 private:
  void begin(const char* operation);
  void require_finite_origin() const;
  void turn_grid(const AxisTurn& turn, bool is_in_place);
  void scale_up(const ScaleStep& step);
  void scale_down(const ScaleStep& step);
  void scale_in_place(const ScaleStep& step);
  Affine map_back(const ResampleStep& step);
  void take_grid_of(const std::string& path);
  void warn_if_apart(bool is_moved) const;
  Interpolation interpolation_of(const std::optional<Interpolation>& asked) const;
  double stored_fill(const std::optional<double>& asked) const;
  bool is_labels() const { return volume_.kind == VolumeKind::labels; }

  const std::string& path_;
  const FileReader& reader_;
  const VolumeDescription& volume_;
  const TaskContext& context_;
  TransformPlan plan_;
};

void Planner::begin(const char* operation) {
  plan_.operation = operation;
  plan_.made_by.set("step", operation);
}

// ---- values

Interpolation Planner::interpolation_of(const std::optional<Interpolation>& asked) const {
  if (!asked) return is_labels() ? Interpolation::nearest : Interpolation::linear;
  if (is_labels() && *asked != Interpolation::nearest) {
    reject(fmt::format("interpolation {}: labels are names, between which there is nothing; they "
                       "are taken from the nearest voxel",
                       interpolation_name(*asked)),
           path_, "step.interpolation");
  }
  return *asked;
}

/// The stored value of voxels from outside.
double Planner::stored_fill(const std::optional<double>& asked) const {
  if (!asked) return is_labels() ? 0 : volume_.voxel_of(reader_.range().min);
  const double real = *asked;
  const Rescale& rescale = volume_.rescale;
  const double stored = is_labels() ? real : (real - rescale.intercept) / rescale.slope;
  if (!is_integer(volume_.type)) {
    const double voxel = static_cast<float>(stored);
    if (std::isfinite(voxel)) return voxel;
    reject(fmt::format("fill value {}: is no value of float32", number_text(real)), "",
           "step.fill");
  }
  constexpr double kSlack = 1e-6;
  const ValueRange range = value_range(volume_.type);
  const double whole = std::round(stored);
  if (std::abs(stored - whole) <= kSlack && whole >= static_cast<double>(range.min) &&
      whole <= static_cast<double>(range.max)) {
    return whole;
  }
  const auto ends = std::minmax({rescale.to_real(static_cast<double>(range.min)),
                                 rescale.to_real(static_cast<double>(range.max))});
  reject(fmt::format("fill value {}: is no value of this volume; {} voxels hold {} to {} in steps "
                     "of {}",
                     number_text(real), voxel_type_name(volume_.type), number_text(ends.first),
                     number_text(ends.second), number_text(std::abs(rescale.slope))),
         path_, "step.fill");
}

// ---- the volume moved

void Planner::operator()(const TranslateStep& step) {
  begin("translate");
  plan_.summary = "bricks copied, the origin moved";
  plan_.geometry.origin_mm = cropped(plan_.geometry, step.voxels).origin_mm;
  plan_.made_by.set("voxels", std::array{step.voxels.x, step.voxels.y, step.voxels.z});
  require_finite_origin();
}

void Planner::operator()(const TranslateMmStep& step) {
  begin("translate-mm");
  plan_.summary = "bricks copied, the origin moved";
  require_known_spacing(volume_, path_, "a translation in mm", "one in voxels");
  for (std::size_t i = 0; i < 3; ++i) plan_.geometry.origin_mm[i] += step.mm[i];
  plan_.made_by.set("mm", step.mm);
  require_finite_origin();
}

void Planner::require_finite_origin() const {
  if (is_valid(plan_.geometry)) return;
  reject("the origin would no longer be a finite number", path_, "step");
}

// ---- whole voxels moved

void Planner::operator()(const ShiftStep& step) {
  begin("shift");
  plan_.way = TransformWay::move;
  plan_.summary = "voxels shifted within the grid";
  plan_.outside = stored_fill(step.fill);
  Index3 shift = step.voxels;
  bool is_all_out = false;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t side = plan_.size[axis];
    is_all_out = is_all_out || shift[axis] >= side || shift[axis] <= -side;
    // Further out there is nothing more to drop.
    shift[axis] = std::clamp(shift[axis], -side, side);
    plan_.to_source.offset[static_cast<std::size_t>(axis)] = -static_cast<double>(shift[axis]);
  }
  plan_.shift = shift;
  plan_.made_by.set("voxels", std::array{shift.x, shift.y, shift.z});
  if (is_all_out) {
    context_.warn(fmt::format("{}: a shift by {},{},{} moves all of its {} voxels out of the grid",
                              path_, step.voxels.x, step.voxels.y, step.voxels.z,
                              size_text(plan_.size)));
  }
}

void Planner::operator()(const RotateStep& step) {
  begin("rotate");
  AxisTurn turn;
  std::vector<std::string> rotations;
  for (const AxisRotation& rotation : step.rotations) {
    require_axis(rotation.axis);
    if (rotation.degrees % 90 != 0) reject("rotations are multiples of 90 degrees", "", "step");
    turn = chained(turn, quarter_turns(rotation.axis, rotation.degrees / 90));
    rotations.push_back(
        fmt::format("{}:{}", kAxes[static_cast<std::size_t>(rotation.axis)], rotation.degrees));
  }
  plan_.made_by.set("rotate", rotations);
  plan_.summary = step.is_in_place ? "the object turned about the center of the grid"
                                   : "the grid turned, every voxel kept its place in space";
  turn_grid(turn, step.is_in_place);
}

void Planner::operator()(const MirrorStep& step) {
  begin("mirror");
  AxisTurn turn;
  std::vector<std::string> axes;
  for (const int axis : step.axes) {
    require_axis(axis);
    turn = chained(turn, mirror_along(axis));
    axes.emplace_back(kAxes[static_cast<std::size_t>(axis)]);
  }
  plan_.made_by.set("mirror", axes);
  plan_.summary = step.is_in_place ? "the object mirrored about the center of the grid"
                                   : "the grid turned, every voxel kept its place in space";
  turn_grid(turn, step.is_in_place);
}

void Planner::turn_grid(const AxisTurn& turn, bool is_in_place) {
  plan_.way = TransformWay::move;
  plan_.turn = turn;
  plan_.to_source = to_source(turn, plan_.size);
  plan_.geometry = is_in_place ? turned_object(plan_.geometry, plan_.size, turn)
                               : turned(plan_.geometry, plan_.size, turn);
  plan_.size = turned(plan_.size, turn);
  plan_.made_by.set("in_place", is_in_place);
}

// ---- grids finer and coarser

void Planner::operator()(const ScaleStep& step) {
  begin("scale");
  constexpr std::int64_t kMostFactor = 64;
  if (step.factor < 2 || step.factor > kMostFactor ||
      !std::has_single_bit(static_cast<std::uint64_t>(step.factor))) {
    reject("a scale is a power of two, 2 to 64", "", "step.factor");
  }
  plan_.made_by.set("factor", (step.is_finer ? "" : "1/") + std::to_string(step.factor));
  plan_.made_by.set("in_place", step.is_in_place);
  step.is_finer ? scale_up(step) : scale_down(step);
  if (step.is_in_place) scale_in_place(step);
  else plan_.summary += "; every voxel kept its place in space";
}

void Planner::scale_up(const ScaleStep& step) {
  const auto factor = static_cast<double>(step.factor);
  plan_.way = TransformWay::resample;
  plan_.interpolation = interpolation_of(step.interpolation);
  const double first = 0.5 / factor - 0.5;
  plan_.geometry.origin_mm = volume_.geometry.to_world({first, first, first});
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    plan_.size[axis] *= step.factor;
    plan_.geometry.spacing_mm[a] /= factor;
    plan_.to_source.linear[4 * a] = 1 / factor;
    plan_.to_source.offset[a] = first;
  }
  plan_.summary = fmt::format("{} x finer", step.factor);
}

void Planner::scale_down(const ScaleStep& step) {
  const Levels& levels = reader_.levels();
  plan_.way = TransformWay::move;
  plan_.level = std::countr_zero(static_cast<std::uint64_t>(step.factor));
  if (plan_.level >= levels.count()) {
    reject(fmt::format("scale 1/{}: the volume has only {} levels", step.factor, levels.count()),
           path_, "step.factor");
  }
  plan_.size = levels.size(plan_.level);
  plan_.geometry = levels.geometry(plan_.geometry, plan_.level);
  plan_.summary = fmt::format("level {}", plan_.level);
  for (int axis = 0; axis < 3; ++axis) {
    const int halvings = levels.halving_count(plan_.level, axis);
    if (halvings == plan_.level) continue;
    plan_.summary += fmt::format(", in which {} is halved {}", "xyz"[axis],
                                 counted_text(halvings, "time"));
  }
}

void Planner::scale_in_place(const ScaleStep& step) {
  Point3 spacing = plan_.geometry.spacing_mm;
  const auto factor = static_cast<double>(step.factor);
  for (double& mm : spacing) mm = step.is_finer ? mm * factor : mm / factor;
  plan_.geometry = recentered(volume_.geometry, volume_.size, plan_.size, spacing);
  plan_.summary += step.is_finer ? "; the object grew about the center of the grid"
                                 : "; the object shrank about the center of the grid";
}

// ---- values between voxels

void Planner::operator()(const ResampleStep& step) {
  begin(step.map_mm ? "affine" : "grid-of");
  if (!step.map_mm && step.grid_of.empty()) {
    reject("a resampling needs a map or a grid", "", "step");
  }
  plan_.way = TransformWay::resample;
  plan_.interpolation = interpolation_of(step.interpolation);
  plan_.outside = stored_fill(step.fill);
  plan_.summary = plan_.interpolation == Interpolation::nearest ? "nearest voxels taken"
                  : plan_.interpolation == Interpolation::cubic ? "interpolated (cubic)"
                                                                : "interpolated";
  const Affine back = step.map_mm ? map_back(step) : Affine{};
  if (!step.grid_of.empty()) take_grid_of(step.grid_of);
  plan_.made_by.set("interpolation", interpolation_name(plan_.interpolation));
  plan_.made_by.set("outside",
                    is_labels() ? plan_.outside : volume_.rescale.to_real(plan_.outside));
  // A voxel of the grid, where it is in space, where it came from, and which voxel that was.
  const std::optional<Affine> to_index = inverse(index_to_world(volume_.geometry));
  plan_.to_source =
      chained(chained(index_to_world(plan_.geometry), back), to_index.value_or(Affine{}));
  warn_if_apart(step.map_mm.has_value());
}

/// From the new place to the old one; the map to the new place is noted in the plan.
Affine Planner::map_back(const ResampleStep& step) {
  const std::optional<Affine> inverted = inverse(*step.map_mm);
  const std::optional<Affine> map = step.is_inverse ? inverted : step.map_mm;
  const std::optional<Affine> back = map ? inverse(*map) : std::nullopt;
  if (!back) {
    throw Error(ErrorKind::source_rejected, "the matrix has no inverse").with_field("step.map_mm");
  }
  std::vector<std::array<double, 4>> rows;
  for (std::size_t row = 0; row < 3; ++row) {
    rows.push_back({map->linear[3 * row], map->linear[3 * row + 1], map->linear[3 * row + 2],
                    map->offset[row]});
  }
  plan_.made_by.set("matrix_mm", rows);
  if (!is_spacing_known(volume_)) {
    context_.warn(path_ +
                  ": its spacing is not known; the matrix is taken for voxels of 1 mm");
  }
  return *back;
}

void Planner::take_grid_of(const std::string& path) {
  const std::shared_ptr<const FileReader> other = open_volume(path, context_);
  const VolumeDescription& grid = other->description();
  plan_.size = grid.size;
  plan_.geometry = grid.geometry;
  plan_.is_placed = is_place_known(grid);
  plan_.summary += ", on the grid of " + public_name(path);
  plan_.spacing_from = grid.metadata;
  warn_of_unknown_spacing(grid, path, volume_, path_, context_);
}

/// Warns where the new grid and the input do not meet.
void Planner::warn_if_apart(bool is_moved) const {
  if (may_meet(plan_.to_source, plan_.size, volume_.size)) return;
  context_.warn(fmt::format("{}: none of it lies in the new grid, every voxel comes from outside; "
                            "the grid fills {} mm, the input {} mm{}",
                            path_, extent_text(plan_.geometry, plan_.size),
                            extent_text(volume_.geometry, volume_.size),
                            is_moved ? " before it is moved" : ""));
}

}  // namespace

TransformPlan plan_transform(const TransformOptions& options, const FileReader& reader,
                             const TaskContext& context) {
  Planner planner(options, reader, context);
  std::visit(planner, options.step);
  return planner.take();
}

}  // namespace octavo
