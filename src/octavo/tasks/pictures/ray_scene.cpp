// The scene of modes volume, mip, minip, mean and iso.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/render/numbers.h"
#include "octavo/render/rays/file_samples.h"
#include "octavo/render/rays/mesh_shadow.h"
#include "octavo/render/rays/ray_camera.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/render/rays/ray_picture.h"
#include "octavo/render/rays/ray_refine.h"
#include "octavo/render/rays/transfer_fit.h"
#include "octavo/tasks/files/finite_voxels.h"
#include "octavo/tasks/pictures/ray_memory.h"
#include "octavo/tasks/pictures/ray_mode.h"
#include "octavo/tasks/pictures/render_scene.h"
#include "octavo/tasks/pictures/scene_light.h"
#include "octavo/tasks/pictures/scene_looks.h"
#include "octavo/tasks/pictures/scene_meshes.h"
#include "octavo/tasks/pictures/transfer_file.h"
#include "octavo/tasks/value_ranges.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// Gradients below so many shares of the colored values are soft.
constexpr double kSoftShare = 0.02;
/// Means along rays that differ by no larger share of the values are one: they are rounded sums.
constexpr double kRoundedShare = 1e-4;

/// Meshes cut steps into parts that give less each, but together as much.
constexpr float kUnlitBesideMeshes = 1.0f / 8192;

std::unique_ptr<SceneLooks> make_looks(const RenderOptions& asked, const FileReader& reader,
                                       int level, const TaskContext& context) {
  if (asked.mask.empty() && asked.label_map.empty()) return nullptr;
  return std::make_unique<SceneLooks>(asked, reader, level, context);
}

/// Of one that lies inside an isosurface: 1/20 of the light comes through.
constexpr double kExtinctionOfCell = 3;
/// Where light is shaded more of it comes from all around.
constexpr float kShadedAmbient = 0.42f;
constexpr float kShadedDiffuse = 0.72f;
constexpr int kLegendColors = 64;

/// More steps than rays of the largest volumes take.
constexpr double kMostRaySteps = 1 << 18;

/// From sample to sample: the finest spacing, but where an axis is so thin beside the others that
/// rays along these would take forever.
double ray_step_mm(const Point3& spacing, const Size3& size) {
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double side = spacing[static_cast<std::size_t>(axis)] * static_cast<double>(size[axis]);
    squared += side * side;
  }
  return std::max(*std::min_element(spacing.begin(), spacing.end()),
                  std::sqrt(squared) / kMostRaySteps);
}

class RayScene final : public RenderScene {
 public:
  RayScene(const std::shared_ptr<const FileReader>& reader, const RenderOptions& options,
           const TaskContext& context, const CastField& cast)
      : cast_(cast),
        reader_(reader),
        asked_(options),
        context_(context),
        mode_(ray_mode_of(options.mode)),
        level_(options.level.value_or(0)),
        shown_(kept_box(options.cuts, *reader, level_)),
        grown_(shown_),
        removed_(removed_boxes(options, *reader)),
        geometry_(reader->levels().geometry(reader->description().geometry, level_)),
        has_values_(has_finite_voxels(*reader)),
        meshes_(options, reader->description().geometry, fitted(), context),
        looks_(make_looks(options, *reader, level_, context)),
        source_(reader, level_),
        bricks_(source_,
                ray_brick_options({options, *reader, meshes_, looks_.get(), source_}, context)) {
    const VolumeDescription& volume = reader_->description();
    if (without_boxes(shown_, removed_).empty()) {
      throw Error(ErrorKind::invalid_argument, "the cuts leave no voxel of the volume")
          .with_field("cuts");
    }
    if (looks_) looks_->warn_of_missing(asked_, context_);
    rescale_ = volume.rescale;
    if (rescale_.slope == 0) {
      throw Error(ErrorKind::invalid_argument,
                  "the volume's rescale slope is 0: all its voxels have one real value",
                  options.input);
    }
    step_mm_ = ray_step_mm(geometry_.spacing_mm, reader_->levels().size(level_));
    sign_ = seeks_lowest(asked_.mode, rescale_) ? -1.0f : 1.0f;
    if (asked_.transfer || mode_ == RayMode::volume) choose_transfer();
    if (mode_ == RayMode::iso) choose_isovalue();
    set_bounds();
    if (asked_.has_ambient_shade || asked_.has_shadows) make_light();
  }

  Box shown() const override { return shown_; }
  Box fitted() const override { return kept_box(asked_.cuts, *reader_, 0); }
  void grow_to(std::int64_t planes) override { grown_.hi.z = planes; }

  Picture draw(const View& view, const Color& background) override {
    RayFrame frame;
    frame.mode = mode_;
    frame.bricks = bricks_.tables();
    frame.has_cell_gradients = asked_.is_moving;
    if (!meshes_.is_empty()) frame.unlit_weight = kUnlitBesideMeshes;
    frame.sign = sign_;
    frame.isovalue = isovalue_;
    if (table_) frame.table = table_->table();
    if (looks_) frame.looks = looks_->table();
    frame.table.gradient_begin = gradient_begin_;
    frame.table.gradient_rise = gradient_rise_;
    set_camera(frame,
               {view, shown_, asked_.angle_degrees.value_or(0), step_mm_, asked_.zoom});
    const double colored = table_ ? table_->colored_width() : 0;
    frame.light.soft_gradient = static_cast<float>(kSoftShare * colored);

    const KeptVoxels kept(grown_, removed_, reader_->levels().size(level_));
    frame.cuts = kept.cuts();
    const RayRegion grown = region(grown_);
    frame.low = grown.low;
    frame.high = grown.high;
    if (light_) context_.on_threads([&] { set_shade(frame, view); });
    RayMeshes::Options of_meshes{geometry_, view, layer_bytes()};
    if (mesh_shadow_) of_meshes.lamp_share = [this](const Point3& at) { return lamp_share(at); };
    const RayMeshes surfaces(meshes_.meshes(), of_meshes);
    if (!meshes_.is_empty()) frame.meshes = &surfaces;
    const RayRefinement refinement{asked_.is_adaptive, asked_.has_smooth_edges};
    const Picture picture = refined_picture(
        frame, view.width, view.height, refinement,
        [this](const RayFrame& of, std::int64_t width, std::int64_t height) {
          return cast_frame(of, width, height);
        },
        [&](const RayField& field) {
          warn_of_nothing(field);
          return look_of(field, background);
        });
    if (picture.pixels.empty()) return {};
    set_texts(frame, view);
    ++pictures_;
    return picture;
  }

  std::vector<LegendRow> legend() const override {
    std::vector<LegendRow> rows = meshes_.legend();
    if (looks_) {
      for (LegendRow& row : looks_->legend()) rows.push_back(std::move(row));
    }
    const std::string unit = unit_of(reader_->description());
    if (mode_ == RayMode::iso) {
      const Color color = asked_.transfer ? transfer_.color_at(*asked_.isovalue)
                                          : RayLook().surface;
      rows.push_back({color, "\u2265 " + with_unit(*asked_.isovalue, unit)});
    } else if (mode_ != RayMode::volume) {
      for (const int end : {1, -1}) {
        const std::uint8_t grey = end > 0 ? 255 : 0;
        rows.push_back({{grey, grey, grey},
                        with_unit(window_->center + end * window_->width / 2, unit)});
      }
    }
    return rows;
  }

  /// Colors over the background, the most opaque as they are.
  std::optional<ColorLegend> color_legend() const override {
    if (mode_ != RayMode::volume) return std::nullopt;
    const double low = transfer_.points.front().value;
    const double high = transfer_.points.back().value;
    if (!(low < high)) return std::nullopt;
    double most = 0;
    for (const TransferPoint& point : transfer_.points) most = std::max(most, point.opacity);
    ColorLegend legend;
    for (int i = 0; i < kLegendColors; ++i) {
      const double value = low + (high - low) * (i + 0.5) / kLegendColors;
      const double share = most > 0 ? std::sqrt(transfer_.opacity_at(value) / most) : 0;
      const Color color = transfer_.color_at(value);
      Color mixed;
      for (std::size_t c = 0; c < 3; ++c) {
        const double behind = asked_.background[c];
        mixed[c] = static_cast<std::uint8_t>(std::lround(behind + (color[c] - behind) * share));
      }
      legend.colors.push_back(mixed);
    }
    const double step = (high - low) / 10;
    const std::string unit = unit_of(reader_->description());
    legend.ends = {place_number(low, step), with_unit(place_number(high, step), unit)};
    return legend;
  }

  std::vector<PlacedText> texts() const override { return texts_; }

  RenderCounts counts() const override {
    RenderCounts counts;
    counts.decoded_bricks = bricks_.loaded_count() + loaded_elsewhere_;
    counts.window = window_;
    counts.rays = rays_;
    counts.rays.pictures = pictures_;
    if (pictures_ > 0) {
      counts.rays.samples /= pictures_;
      counts.rays.frame_seconds /= static_cast<double>(pictures_);
    }
    return counts;
  }

 private:
  RayField cast_frame(const RayFrame& frame, std::int64_t width, std::int64_t height) {
    RayField field;
    RayFrame with_bricks = frame;
    with_bricks.bricks = bricks_.tables();
    context_.on_threads([&] {
      field = cast_ ? cast_(bricks_, with_bricks, regions(frame), width, height)
                    : cast_rays(bricks_, with_bricks, regions(frame), width, height,
                                follow_rays_function(), context_.watcher());
    });
    loaded_elsewhere_ += field.loaded_elsewhere;
    if (!field.tiles.empty()) {
      rays_.samples += field.samples;
      rays_.frame_seconds += field.cast_seconds;
    }
    return field;
  }

  RayLook look_of(const RayField& field, const Color& background) {
    RayLook look;
    if (looks_ && mode_ == RayMode::iso) {
      look.surface_of = [this](std::uint16_t of, const Color& otherwise) {
        return looks_->color_of(of, otherwise);
      };
    }
    look.mode = mode_;
    look.background = background;
    look.sign = sign_;
    if (asked_.transfer && mode_ == RayMode::iso) {
      look.surface = transfer_.color_at(*asked_.isovalue);
    }
    if (mode_ == RayMode::extreme || mode_ == RayMode::mean) {
      choose_window(field);
      look.window = *window_;
      look.to_real = real_of_pooled();
    }
    return look;
  }

  TransferFunction in_volume(const TransferFunction& transfer) const {
    if (!transfer.is_relative) return transfer;
    const Window stored = robust_window(*reader_);
    const double low = rescale_.to_real(stored.center - stored.width / 2);
    const double high = rescale_.to_real(stored.center + stored.width / 2);
    return in_real_values(transfer, {(low + high) / 2, std::abs(high - low)});
  }

  std::vector<double> typical_values() const {
    std::vector<double> values = sampled_values(*reader_);
    for (double& value : values) value = rescale_.to_real(value);
    return values;
  }

  void require_unit(const std::string& name) const {
    for (const TransferPreset& preset : transfer_presets()) {
      if (preset.name == name && preset.is_in_hu) {
        require_hu(reader_->description(), asked_.input, "the preset " + name, context_,
                   "transfer.preset");
      }
    }
  }

  void choose_transfer() {
    if (asked_.transfer) {
      transfer_ = read_transfer(*asked_.transfer);
      require_unit(*asked_.transfer);
    } else {
      transfer_ = unit_of(reader_->description()) == "HU" ? *find_transfer_preset("skin")
                                                          : fitted_transfer(typical_values());
    }
    transfer_ = in_volume(transfer_);
    const auto stepped = [&](const TransferFunction& transfer) {
      return SteppedTransfer{transfer, step_mm_ / transfer.layer_mm.value_or(finest_mm())};
    };
    std::vector<SteppedTransfer> transfers = {stepped(transfer_)};
    if (looks_) {
      for (const AskedLabelLook& look : asked_.label_looks) require_unit(look.transfer);
      for (const TransferFunction& of_label : looks_->functions()) {
        label_transfers_.push_back(in_volume(of_label));
        transfers.push_back(stepped(label_transfers_.back()));
      }
    }
    table_.emplace(transfers, rescale_, bricks_.scale(), bricks_.range());
    if (transfer_.gradient) {
      const double pooled_per_step = bricks_.scale().scale / std::abs(rescale_.slope) * step_mm_;
      const GradientRamp& ramp = *transfer_.gradient;
      gradient_begin_ = static_cast<float>(ramp.low * pooled_per_step);
      gradient_rise_ = static_cast<float>(1 / ((ramp.high - ramp.low) * pooled_per_step));
    }
  }

  std::uint64_t layer_bytes() const {
    return context_.max_memory_bytes != 0 ? context_.max_memory_bytes / kLayerShare
                                          : std::uint64_t{1} << 30;
  }

  /// What is shown ends where it does on level 0, not where samples of the level do.
  RayRegion region(const Box& samples) const {
    return region_within(region_of(samples),
                         region_at_level(fitted(), reader_->levels(), level_));
  }

  std::vector<RayRegion> regions(const RayFrame& frame) const {
    std::vector<RayRegion> regions;
    for (const Box& box : without_boxes(grown_, removed_)) regions.push_back(region(box));
    return front_to_back(std::move(regions), frame);
  }

  void make_light() {
    SceneMatter matter;
    matter.kept = kept_box(asked_.cuts, *reader_, 0);
    for (const AskedBox& box : asked_.removed) {
      matter.removed.push_back(box_within(box, reader_->levels().size(0)));
    }
    if (mode_ == RayMode::iso) {
      const double isovalue = *asked_.isovalue;
      matter.has_gradient = true;
      matter.extinction = [this, isovalue](const SceneMatter::Cell& cell) {
        if (looks_ && looks_->function_of(cell.look) < 0) return 0.0;
        // How much of the cell lies inside, by how far the surface is.
        const double ahead = cell.gradient > 0
                                 ? (cell.value - isovalue) / (cell.gradient * cell.side_mm)
                             : cell.value >= isovalue ? 1.0 : -1.0;
        return std::clamp(0.5 + ahead, 0.0, 1.0) * kExtinctionOfCell / cell.side_mm;
      };
    } else {
      matter.has_gradient = transfer_.gradient.has_value();
      matter.is_nan_empty = true;
      matter.extinction = [this](const SceneMatter::Cell& cell) { return extinction_of(cell); };
    }
    if (looks_) {
      matter.looks = [this](int level) { return make_looks(asked_, *reader_, level, context_); };
    }
    light_ = scene_light(*reader_, level_, matter, context_);
  }

  /// In volumes, per mm.
  double extinction_of(const SceneMatter::Cell& cell) const {
    const int function = looks_ ? looks_->function_of(cell.look) : 0;
    if (function < 0) return 0;
    const TransferFunction& transfer =
        function == 0 ? transfer_ : label_transfers_[static_cast<std::size_t>(function - 1)];
    double opacity = transfer.opacity_at(cell.value);
    if (const auto& ramp = transfer_.gradient) {
      opacity *= std::clamp((cell.gradient - ramp->low) / (ramp->high - ramp->low), 0.0, 1.0);
    }
    const double layer = transfer.layer_mm.value_or(finest_mm());
    return -std::log1p(-std::min(opacity, 0.9999)) / layer;
  }

  /// On the threads of the context.
  void set_shade(RayFrame& frame, const View& view) {
    if (asked_.has_shadows) {
      Point3 toward{};
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& lamp = frame.light.toward_light;
        toward[i] = static_cast<double>(lamp[0]) * view.right[i] +
                    static_cast<double>(lamp[1]) * view.up[i] +
                    static_cast<double>(lamp[2]) * view.toward[i];
      }
      light_->set_lamp(toward, context_.watcher());
      if (!meshes_.is_empty()) {
        mesh_shadow_ = std::make_unique<MeshShadow>(
            meshes_.meshes(),
            MeshShadow::Options{geometry_, toward, step_mm_ / 2, layer_bytes()},
            context_.watcher());
      }
    }
    frame.light.ambient = kShadedAmbient;
    frame.light.diffuse = kShadedDiffuse;
    frame.shade = light_->table(geometry_, asked_.has_ambient_shade);
    frame.shade.meshes = mesh_shadow_.get();
  }

  /// Of places on meshes.
  double lamp_share(const Point3& world) const {
    const double passed = light_->passed_to_lamp(world) * mesh_shadow_->passed(world);
    return kDeepestShadow + (1 - kDeepestShadow) * passed;
  }

  void set_texts(const RayFrame& frame, const View& view) {
    texts_.clear();
    for (const AskedMark& mark : asked_.marks) {
      const auto place = place_in_picture(geometry_, frame, mark.at_mm);
      if (!place || mark.text.empty()) continue;
      texts_.push_back({(*place)[0] + static_cast<double>(view.width) / 2,
                        (*place)[1] + static_cast<double>(view.height) / 2, mark.text});
    }
  }

  double finest_mm() const {
    const Point3& spacing = reader_->description().geometry.spacing_mm;
    return *std::min_element(spacing.begin(), spacing.end());
  }

  void choose_isovalue() {
    // As in surfaces: of whole values it lies half a step before the first that is reached.
    const VolumeDescription& volume = reader_->description();
    const ValueWindow reached =
        stored_window({*asked_.isovalue, AskedRange{}.highest}, volume, false);
    double stored = sign_ > 0 ? reached.lowest : reached.highest;
    if (is_integer(volume.type)) {
      stored = sign_ > 0 ? std::ceil(stored) - 0.5 : std::floor(stored) + 0.5;
    }
    isovalue_ = static_cast<float>(bricks_.scale().pooled(stored)) * sign_;
    if (!has_values_) {
      throw Error(ErrorKind::invalid_argument, "no voxel has a finite value", asked_.input);
    }
    const SampleRange range = source_.range();
    const bool is_above = isovalue_ > std::max(static_cast<float>(bricks_.range().lowest) * sign_,
                                               static_cast<float>(bricks_.range().highest) * sign_);
    if (is_above) {
      const auto [low, high] =
          std::minmax({rescale_.to_real(range.lowest), rescale_.to_real(range.highest)});
      throw Error(ErrorKind::invalid_argument,
                  fmt::format("no voxel is at or above {}; values run from {} to {}",
                              number_text(*asked_.isovalue), number_text(low), number_text(high)),
                  asked_.input)
          .with_field("isovalue.range");
    }
  }

  void set_bounds() {
    const bool has_cells = mode_ == RayMode::iso || mode_ == RayMode::volume;
    const auto bound_of = [this](float lowest, float highest, LookSet looks) {
      const float most = sign_ > 0 ? highest : -lowest;
      switch (mode_) {
        case RayMode::extreme:
          return looks != 0 ? most : -std::numeric_limits<float>::infinity();
        case RayMode::iso: return has_values_ && looks != 0 && most >= isovalue_ ? 1.0f : 0.0f;
        case RayMode::mean: return looks != 0 ? 1.0f : 0.0f;
        default: return has_values_ && is_any_seen(lowest, highest, looks) ? 1.0f : 0.0f;
      }
    };
    bricks_.set_bounds(LookBoundOf(bound_of), has_cells);
  }

  bool is_any_seen(float lowest, float highest, LookSet looks) const {
    if (!looks_) return table_->is_seen(lowest, highest);
    for (std::size_t function = 0; function <= label_transfers_.size(); ++function) {
      const bool is_there = (looks >> function & 1) != 0;
      if (is_there && table_->is_seen(lowest, highest, function)) return true;
    }
    return false;
  }

  Rescale real_of_pooled() const {
    const PooledScale& pooled = bricks_.scale();
    return {rescale_.slope / pooled.scale, rescale_.to_real(pooled.offset)};
  }

  /// All pictures of a series have the window of the first one.
  void choose_window(const RayField& field) {
    if (!window_) window_ = asked_.window;
    if (window_) return;
    std::vector<double> values = ray_values(field, mode_, sign_);
    for (double& value : values) value = real_of_pooled().to_real(value);
    window_ = robust_window(std::move(values));
    if (mode_ != RayMode::mean) return;
    const SampleRange pooled = bricks_.range();
    const double most = std::abs(real_of_pooled().slope) *
                        std::max(std::abs(pooled.lowest), std::abs(pooled.highest));
    if (window_->width >= kRoundedShare * most) return;
    window_ = window_of_one(window_->center);
  }

  bool is_anything_seen(const RayField& field) const {
    if (!has_values_) return false;
    for (const RayTile& tile : field.tiles) {
      for (const float gathered : tile.gathered) {
        if (mode_ == RayMode::extreme ? std::isfinite(gathered) : gathered > 0) return true;
      }
    }
    return false;
  }

  void warn_of_nothing(const RayField& field) {
    if (!is_anything_seen(field) && !std::exchange(is_nothing_told_, true)) {
      context_.warn(asked_.input + ": no voxel is seen; the picture is empty");
    }
  }

  CastField cast_;
  std::shared_ptr<const FileReader> reader_;
  const RenderOptions& asked_;
  const TaskContext& context_;
  RayMode mode_;
  int level_;
  Box shown_;
  Box grown_;  // what of it is drawn now
  std::vector<Box> removed_;
  Geometry geometry_;
  bool has_values_;  // false: every voxel is NaN or infinite, and none is seen
  SceneMeshes meshes_;
  std::unique_ptr<SceneLooks> looks_;
  FileSamples source_;
  RayBricks bricks_;
  Rescale rescale_;
  double step_mm_ = 1;
  float sign_ = 1;
  float isovalue_ = 0;
  TransferFunction transfer_;
  std::vector<TransferFunction> label_transfers_;
  std::optional<TransferTable> table_;
  float gradient_begin_ = 0;
  float gradient_rise_ = 0;
  std::unique_ptr<RayShade> light_;
  std::unique_ptr<MeshShadow> mesh_shadow_;  // of the lamp of the last picture
  std::vector<PlacedText> texts_;
  std::optional<Window> window_;  // real values
  RayCounts rays_;
  std::int64_t pictures_ = 0;
  std::int64_t loaded_elsewhere_ = 0;
  bool is_nothing_told_ = false;
};

}  // namespace

bool is_ray_mode(RenderMode mode) {
  return mode != RenderMode::cubes && mode != RenderMode::surface &&
         mode != RenderMode::transparency;
}

int ray_level(const Levels& levels, const Geometry& geometry, double pixel_mm) {
  int level = 0;
  while (level + 1 < levels.count()) {
    const Point3 spacing = levels.geometry(geometry, level + 1).spacing_mm;
    if (*std::max_element(spacing.begin(), spacing.end()) > pixel_mm) break;
    ++level;
  }
  return level;
}

std::unique_ptr<RenderScene> make_ray_scene(const std::shared_ptr<const FileReader>& reader,
                                            const RenderOptions& options,
                                            const TaskContext& context,
                                            const CastField& cast) {
  if (reader->description().kind == VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "rays are of grey values, and this is a label map",
                options.input)
        .with_field("mode");
  }
  return std::make_unique<RayScene>(reader, options, context, cast);
}

}  // namespace octavo
