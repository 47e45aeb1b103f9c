#include "octavo/tasks/transform_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/place_known.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/ops/grid/rotation.h"
#include "octavo/tasks/geometry_words.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/range_words.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr std::array kAxes = {"x", "y", "z"};
constexpr const char* kGridTurned = "the grid turned, every voxel kept its place in space";

[[noreturn]] void reject(const std::string& why, const std::string& path, const char* field) {
  throw Error(ErrorKind::invalid_argument, why, path).with_field(field);
}

/// The name of a step, as the metadata of its result hold it.
const char* name_of(const TransformStep& step) {
  constexpr std::array kStepNames = {"translate", "translate-mm", "shift",  "rotate",
                                     "mirror",    "scale",        "affine"};
  static_assert(kStepNames.size() == std::variant_size_v<TransformStep>);
  return kStepNames[step.index()];
}

/// "1,0.5,-3"
std::string numbers_text(const Point3& numbers) {
  return exact_text(numbers[0]) + "," + exact_text(numbers[1]) + "," + exact_text(numbers[2]);
}

/// "z:90", "1,1,0:30"
std::string rotation_text(const AxisRotation& rotation) {
  std::string axis = numbers_text(rotation.axis);
  for (std::size_t a = 0; a < 3; ++a) {
    Point3 along{};
    along[a] = 1;
    if (rotation.axis == along) axis = kAxes[a];
  }
  return axis + ":" + exact_text(rotation.degrees);
}

/// A turn of the grid that goes on while steps only turn it: its size is found once, for all of
/// them together.
struct TurnRun {
  bool is_in_place = false;
  Rotation rotation = kNoRotation;
  // What it began with.
  TransformWay way = TransformWay::copy;
  Size3 size;
  Geometry geometry;
  Affine to_source;
  AxisTurn turn;
  Index3 shift;
};

/// Makes the plan step by step; each operator() is one kind of them.
class Planner {
 public:
  Planner(const TransformOptions& options, const FileReader& reader, const TaskContext& context)
      : options_(options),
        path_(options.input),
        reader_(reader),
        volume_(reader.description()),
        context_(context) {
    plan_.size = volume_.size;
    plan_.geometry = volume_.geometry;
  }

  void add(const TransformStep& step);
  TransformPlan finish();

  void operator()(const TranslateStep& step);
  void operator()(const TranslateMmStep& step);
  void operator()(const ShiftStep& step);
  void operator()(const RotateStep& step);
  void operator()(const MirrorStep& step);
  void operator()(const ScaleStep& step);
  void operator()(const AffineStep& step);

 private:
  void end_run();
  void move_origin(const Point3& origin_mm);
  void turn_grid(const Rotation& rotation, bool is_in_place);
  void require_in_place(bool is_in_place) const;
  void scale_up(const ScaleStep& step);
  void scale_down(const ScaleStep& step);
  void scale_in_place(const ScaleStep& step, const Geometry& geometry, const Size3& size);
  void settle_object_map();
  void take_grid_of(const std::string& path);
  void note_steps();
  void warn_if_apart();
  void warn_of_unknown_mm(const char* what);
  Interpolation interpolation_of(const std::optional<Interpolation>& asked) const;
  double stored_fill(const std::optional<double>& asked) const;
  bool is_labels() const { return volume_.kind == VolumeKind::labels; }
  void use(TransformWay way) { plan_.way = std::max(plan_.way, way); }

  const TransformOptions& options_;
  const std::string& path_;
  const FileReader& reader_;
  const VolumeDescription& volume_;
  const TaskContext& context_;
  TransformPlan plan_;
  std::optional<TurnRun> run_;
  /// From new places to old ones, mm: of matrices that are not yet part of plan_.to_source.
  std::optional<Affine> object_map_;
  std::vector<std::string> summaries_;
  std::vector<JsonObject> notes_;  // of each step
  std::vector<std::string> texts_;
  bool has_warned_of_mm_ = false;
};

// ---- values

Interpolation Planner::interpolation_of(const std::optional<Interpolation>& asked) const {
  if (!asked) return is_labels() ? Interpolation::nearest : Interpolation::linear;
  if (is_labels() && *asked != Interpolation::nearest) {
    reject(fmt::format("interpolation {}: labels are names, between which there is nothing; they "
                       "are taken from the nearest voxel",
                       word_of(*asked)),
           path_, "step.interpolation");
  }
  return *asked;
}

/// The stored value of voxels from outside.
double Planner::stored_fill(const std::optional<double>& asked) const {
  if (!asked && is_labels()) return 0;
  if (!asked) {
    const ValueRange stored = reader_.range();
    return volume_.voxel_of(
        volume_.code_near(volume_.rescale.slope < 0 ? stored.max : stored.min));
  }
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
  const OutsideWords words = outside_words(real, ends.first, ends.second);
  reject(fmt::format("fill value {}: is no value of this volume; {} voxels hold {} to {} in steps "
                     "of {}",
                     words.value, voxel_type_name(volume_.type), words.lowest, words.highest,
                     number_text(std::abs(rescale.slope))),
         path_, "step.fill");
}

// ---- the volume moved

/// Gives the grid another origin, which a turn that goes on keeps.
void Planner::move_origin(const Point3& origin_mm) {
  if (run_) {
    for (std::size_t i = 0; i < 3; ++i) {
      run_->geometry.origin_mm[i] += origin_mm[i] - plan_.geometry.origin_mm[i];
    }
  }
  plan_.geometry.origin_mm = origin_mm;
  summaries_.emplace_back("the origin moved");
  if (is_valid(plan_.geometry)) return;
  reject("the origin would no longer be a finite number", path_, "step");
}

void Planner::operator()(const TranslateStep& step) {
  notes_.back().set("voxels", std::array{step.voxels.x, step.voxels.y, step.voxels.z});
  texts_.back() += fmt::format(" {},{},{}", step.voxels.x, step.voxels.y, step.voxels.z);
  settle_object_map();
  move_origin(cropped(plan_.geometry, step.voxels).origin_mm);
}

void Planner::operator()(const TranslateMmStep& step) {
  notes_.back().set("mm", step.mm);
  texts_.back() += " " + numbers_text(step.mm);
  require_known_spacing(volume_, path_, "a translation in mm", "one in voxels");
  settle_object_map();
  Point3 origin = plan_.geometry.origin_mm;
  for (std::size_t i = 0; i < 3; ++i) origin[i] += step.mm[i];
  move_origin(origin);
}

// ---- whole voxels moved

void Planner::operator()(const ShiftStep& step) {
  end_run();
  use(TransformWay::move);
  summaries_.emplace_back("voxels shifted within the grid");
  // Further out there is nothing more to drop, whatever is to follow.
  constexpr std::int64_t kMost = std::int64_t{1} << 40;
  Affine map;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t voxels = std::clamp(step.voxels[axis], -kMost, kMost);
    plan_.shift[axis] += voxels;
    map.offset[static_cast<std::size_t>(axis)] = -static_cast<double>(voxels);
  }
  plan_.to_source = chained(map, plan_.to_source);
  notes_.back().set("voxels", std::array{step.voxels.x, step.voxels.y, step.voxels.z});
  texts_.back() += fmt::format(" {},{},{}", step.voxels.x, step.voxels.y, step.voxels.z);
}

void Planner::operator()(const RotateStep& step) {
  std::vector<std::string> rotations;
  Rotation all = kNoRotation;
  for (const AxisRotation& rotation : step.rotations) {
    const Point3& axis = rotation.axis;
    const bool is_axis = std::isfinite(axis[0]) && std::isfinite(axis[1]) &&
                         std::isfinite(axis[2]) && axis != Point3{0, 0, 0};
    if (!is_axis) reject("the axis of a rotation has three finite numbers, not all 0", "", "step");
    if (!std::isfinite(rotation.degrees)) reject("an angle is a finite number", "", "step");
    all = chained(all, rotation_about(axis, rotation.degrees));
    rotations.push_back(rotation_text(rotation));
    texts_.back() += " " + rotations.back();
  }
  notes_.back().set("rotate", rotations).set("in_place", step.is_in_place);
  turn_grid(all, step.is_in_place);
  summaries_.emplace_back(step.is_in_place ? "the object turned about the center of the grid"
                                           : kGridTurned);
}

void Planner::operator()(const MirrorStep& step) {
  AxisTurn turn;
  std::vector<std::string> axes;
  for (const int axis : step.axes) {
    if (axis < 0 || axis > 2) reject("an axis is 0, 1 or 2", "", "step.axis");
    turn = chained(turn, mirror_along(axis));
    axes.emplace_back(kAxes[static_cast<std::size_t>(axis)]);
    texts_.back() += " " + axes.back();
  }
  notes_.back().set("mirror", axes).set("in_place", step.is_in_place);
  turn_grid(rotation_of(turn), step.is_in_place);
  summaries_.emplace_back(step.is_in_place ? "the object mirrored about the center of the grid"
                                           : kGridTurned);
}

void Planner::turn_grid(const Rotation& rotation, bool is_in_place) {
  if (is_in_place) texts_.back() += " in place";
  require_in_place(is_in_place);
  if (run_ && run_->is_in_place != is_in_place) end_run();
  if (!run_) {
    settle_object_map();
    run_ = TurnRun{is_in_place,    kNoRotation,     plan_.way,  plan_.size,
                   plan_.geometry, plan_.to_source, plan_.turn, plan_.shift};
  }
  run_->rotation = chained(run_->rotation, rotation);
  const TurnedGrid grid = turned_grid(run_->geometry, run_->size, run_->rotation, is_in_place);
  plan_.size = grid.size;
  plan_.geometry = grid.geometry;
  plan_.to_source = chained(grid.to_source, run_->to_source);
  plan_.way = run_->way;
  const std::optional<AxisTurn> turn = as_turn(run_->rotation);
  use(turn ? TransformWay::move : TransformWay::resample);
  if (!turn) {
    warn_of_unknown_mm("the rotation");
    return;
  }
  plan_.turn = chained(run_->turn, *turn);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::int64_t shift = run_->shift[turn->from[a]];
    plan_.shift[axis] = turn->is_reversed[a] ? -shift : shift;
  }
}

/// On the grid of another file a step that leaves every voxel in its place does nothing.
void Planner::require_in_place(bool is_in_place) const {
  if (is_in_place || options_.grid_of.empty()) return;
  reject("where every voxel keeps its place in space, the grid of another file undoes the step", "",
         "step.is_in_place");
}

/// What comes next does not turn the grid, or turns it in another way.
void Planner::end_run() {
  settle_object_map();
  run_.reset();
}

// ---- grids finer and coarser

void Planner::operator()(const ScaleStep& step) {
  constexpr std::int64_t kMostFactor = 64;
  if (step.factor < 2 || step.factor > kMostFactor ||
      !std::has_single_bit(static_cast<std::uint64_t>(step.factor))) {
    reject("a scale is a power of two, 2 to 64", "", "step.factor");
  }
  const std::string factor = (step.is_finer ? "" : "1/") + std::to_string(step.factor);
  notes_.back().set("factor", factor).set("in_place", step.is_in_place);
  texts_.back() += " " + factor + (step.is_in_place ? " in place" : "");
  require_in_place(step.is_in_place);
  end_run();
  plan_.is_scaled = true;
  const Geometry geometry = plan_.geometry;
  const Size3 size = plan_.size;
  step.is_finer ? scale_up(step) : scale_down(step);
  if (step.is_in_place) scale_in_place(step, geometry, size);
  else summaries_.back() += "; every voxel kept its place in space";
}

void Planner::scale_up(const ScaleStep& step) {
  const auto factor = static_cast<double>(step.factor);
  use(TransformWay::resample);
  const double first = 0.5 / factor - 0.5;
  plan_.geometry.origin_mm = plan_.geometry.to_world({first, first, first});
  Affine map;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    // Later steps may cut the grid again; what no number holds cannot be.
    constexpr std::int64_t kMost = std::int64_t{1} << 40;
    if (plan_.size[axis] > kMost / step.factor) {
      throw Error(ErrorKind::limit_exceeded,
                  fmt::format("{} voxels, {} x finer: every axis must be between 1 and {}",
                              plan_.size[axis], step.factor, kMaxAxis),
                  path_);
    }
    plan_.size[axis] *= step.factor;
    plan_.geometry.spacing_mm[a] /= factor;
    map.linear[4 * a] = 1 / factor;
    map.offset[a] = first;
  }
  plan_.to_source = chained(map, plan_.to_source);
  summaries_.push_back(fmt::format("{} x finer", step.factor));
}

void Planner::scale_down(const ScaleStep& step) {
  if (plan_.way != TransformWay::copy) {
    reject(fmt::format("a scale of 1/{} is a level of the file: it goes before the steps that move "
                       "voxels, and there is one of it",
                       step.factor),
           path_, "step.factor");
  }
  const Levels& levels = reader_.levels();
  use(TransformWay::move);
  plan_.level = std::countr_zero(static_cast<std::uint64_t>(step.factor));
  if (plan_.level >= levels.count()) {
    reject(fmt::format("scale 1/{}: the volume has only {} levels", step.factor, levels.count()),
           path_, "step.factor");
  }
  plan_.size = levels.size(plan_.level);
  plan_.geometry = levels.geometry(plan_.geometry, plan_.level);
  std::string& summary = summaries_.emplace_back(fmt::format("level {}", plan_.level));
  for (int axis = 0; axis < 3; ++axis) {
    const int halvings = levels.halving_count(plan_.level, axis);
    if (halvings == plan_.level) continue;
    summary += fmt::format(", in which {} is halved {}", "xyz"[axis],
                           counted_text(halvings, "time"));
  }
}

/// geometry, size  of the grid before
void Planner::scale_in_place(const ScaleStep& step, const Geometry& geometry, const Size3& size) {
  Point3 spacing = plan_.geometry.spacing_mm;
  const auto factor = static_cast<double>(step.factor);
  for (double& mm : spacing) mm = step.is_finer ? mm * factor : mm / factor;
  plan_.geometry = recentered(geometry, size, plan_.size, spacing);
  summaries_.back() += step.is_finer ? "; the object grew about the center of the grid"
                                     : "; the object shrank about the center of the grid";
}

// ---- the object moved, and other grids

void Planner::operator()(const AffineStep& step) {
  const std::optional<Affine> inverted = inverse(step.map_mm);
  const std::optional<Affine> map = step.is_inverse ? inverted : step.map_mm;
  const std::optional<Affine> back = map ? inverse(*map) : std::nullopt;
  if (!back) {
    throw Error(ErrorKind::source_rejected, "the matrix has no inverse").with_field("step.map_mm");
  }
  std::vector<std::array<double, 4>> rows;
  for (std::size_t row = 0; row < 3; ++row) {
    rows.push_back({map->linear[3 * row], map->linear[3 * row + 1], map->linear[3 * row + 2],
                    map->offset[row]});
    for (const double number : rows.back()) texts_.back() += " " + exact_text(number);
  }
  notes_.back().set("matrix_mm", rows);
  use(TransformWay::resample);
  run_.reset();
  object_map_ = object_map_ ? chained(*back, *object_map_) : *back;
  summaries_.emplace_back("the object moved by a matrix");
  warn_of_unknown_mm("the matrix");
}

/// A voxel of the grid, where it is in space, where it came from, and which voxel that was.
void Planner::settle_object_map() {
  if (!object_map_) return;
  const Affine to_world = index_to_world(plan_.geometry);
  const Affine to_index = inverse(to_world).value_or(Affine{});
  plan_.to_source = chained(chained(chained(to_world, *object_map_), to_index), plan_.to_source);
  object_map_.reset();
}

void Planner::take_grid_of(const std::string& path) {
  const std::shared_ptr<const FileReader> other = open_volume(path, context_);
  const VolumeDescription& grid = other->description();
  const Affine to_index = inverse(index_to_world(plan_.geometry)).value_or(Affine{});
  const Affine place = chained(index_to_world(grid.geometry), object_map_.value_or(Affine{}));
  plan_.to_source = chained(chained(place, to_index), plan_.to_source);
  object_map_.reset();
  use(TransformWay::resample);
  plan_.size = grid.size;
  plan_.geometry = grid.geometry;
  plan_.is_placed = is_place_known(grid);
  plan_.spacing_from = grid.metadata;
  warn_of_unknown_spacing(grid, path, volume_, path_, context_);
}

/// Once, however many steps count in mm.
void Planner::warn_of_unknown_mm(const char* what) {
  if (is_spacing_known(volume_) || std::exchange(has_warned_of_mm_, true)) return;
  context_.warn(fmt::format("{}: its spacing is not known; {} is taken for voxels of 1 mm", path_,
                            what));
}

/// Warns where the new grid and the input do not meet.
void Planner::warn_if_apart() {
  plan_.is_apart = !may_meet(plan_.to_source, plan_.size, reader_.levels().size(plan_.level));
  if (!plan_.is_apart) return;
  const auto* const shift =
      options_.steps.size() == 1 ? std::get_if<ShiftStep>(&options_.steps.front()) : nullptr;
  if (shift != nullptr && options_.grid_of.empty()) {
    const Index3& by = shift->voxels;
    const Point3 numbers = {static_cast<double>(by.x), static_cast<double>(by.y),
                            static_cast<double>(by.z)};
    context_.warn(fmt::format("{}: a shift by {} moves all of its {} voxels out of the grid", path_,
                              point_text(numbers, ","), size_text(plan_.size)));
    return;
  }
  context_.warn(fmt::format("{}: none of it lies in the new grid, every voxel comes from outside; "
                            "the grid fills {} mm, the input {} mm{}",
                            path_, extent_text(plan_.geometry, plan_.size),
                            extent_text(volume_.geometry, volume_.size),
                            options_.steps.empty() ? "" : " before it is moved"));
}

// ---- all steps

void Planner::add(const TransformStep& step) {
  notes_.emplace_back();
  texts_.emplace_back(name_of(step));
  plan_.operation += (plan_.operation.empty() ? "" : ", ") + texts_.back();
  std::visit(*this, step);
}

/// What the metadata say: of one step its settings, of several a list of texts.
void Planner::note_steps() {
  const bool has_grid = !options_.grid_of.empty();
  const bool is_only_scale =
      options_.steps.size() == 1 && std::holds_alternative<ScaleStep>(options_.steps.front());
  if (options_.steps.empty()) plan_.operation = "grid-of";
  const bool is_object_on_grid =
      options_.steps.size() == 1 && std::holds_alternative<AffineStep>(options_.steps.front());
  if (options_.steps.size() > 1 || (has_grid && options_.steps.size() == 1 && !is_object_on_grid)) {
    if (has_grid) texts_.emplace_back("grid-of");
    plan_.made_by.set("step", "steps").set("steps", texts_);
  } else {
    plan_.made_by.set("step", plan_.operation);
    if (!notes_.empty()) {
      for (const JsonMember& member : notes_.front().members()) {
        plan_.made_by.set_json(member.name, member.json);
      }
    }
  }
  if (plan_.way != TransformWay::resample || (is_only_scale && !has_grid)) return;
  plan_.made_by.set("interpolation", word_of(plan_.interpolation));
  plan_.made_by.set("outside",
                    is_labels() ? plan_.outside : volume_.rescale.to_real(plan_.outside));
}

TransformPlan Planner::finish() {
  if (options_.steps.empty() && options_.grid_of.empty()) {
    reject("a transform needs a step or the grid of another file", "", "steps");
  }
  if (!options_.grid_of.empty()) take_grid_of(options_.grid_of);
  settle_object_map();
  const Interpolation interpolation = interpolation_of(options_.interpolation);
  plan_.outside = stored_fill(options_.fill);
  if (plan_.way == TransformWay::copy) summaries_.front().insert(0, "bricks copied, ");
  if (plan_.way == TransformWay::resample) {
    plan_.interpolation = interpolation;
    summaries_.emplace_back(interpolation == Interpolation::nearest ? "nearest voxels taken"
                            : interpolation == Interpolation::cubic ? "interpolated (cubic)"
                                                                    : "interpolated");
  }
  for (const std::string& text : summaries_) {
    plan_.summary += (plan_.summary.empty() ? "" : "; ") + text;
  }
  if (!options_.grid_of.empty()) {
    plan_.summary += ", on the grid of " + public_name(options_.grid_of);
  }
  note_steps();
  warn_if_apart();
  return std::move(plan_);
}

}  // namespace

TransformPlan plan_transform(const TransformOptions& options, const FileReader& reader,
                             const TaskContext& context) {
  Planner planner(options, reader, context);
  for (const TransformStep& step : options.steps) planner.add(step);
  return planner.finish();
}

}  // namespace octavo
