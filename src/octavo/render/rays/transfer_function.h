// What values look like in light: a color and an opacity for each, straight between points.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/render/picture.h"
#include "octavo/render/rays/ray_bricks.h"
#include "octavo/render/rays/ray_job.h"
#include "octavo/render/window.h"

namespace octavo {

struct TransferPoint {
  double value = 0;
  Color color{};
  double opacity = 0;  ///< of a layer, 0 .. 1

  bool operator==(const TransferPoint&) const = default;
};

/// Opacity by the steepness of values: nothing up to `low`, all of it from `high` on.
struct GradientRamp {
  double low = 0;  ///< values per mm
  double high = 0;

  bool operator==(const GradientRamp&) const = default;
};

struct TransferFunction {
  /// At least one; values never fall. Two of one value are a step. Below the first and above the
  /// last nothing changes.
  std::vector<TransferPoint> points;
  /// Thickness of a layer, mm; by default the finest spacing of the volume.
  std::optional<double> layer_mm{};
  /// Values 0 .. 1 are those of a window of the volume, others lie beside it; real values if not.
  bool is_relative = false;
  std::optional<GradientRamp> gradient{};

  bool operator==(const TransferFunction&) const = default;

  Color color_at(double value) const;
  double opacity_at(double value) const;
};

struct TransferPreset {
  std::string_view name;
  bool is_in_hu = false;
};

/// bone, skin, vessels and lung in HU; mr and lightsheet for values of any unit.
std::span<const TransferPreset> transfer_presets();

std::optional<TransferFunction> find_transfer_preset(std::string_view name);

/// One that suits values of which nothing is known: what lies low in the window is not seen.
TransferFunction usual_transfer_function();

/// The same with real values in place of shares of a window.
TransferFunction in_real_values(const TransferFunction& transfer, const Window& window);

/// A transfer function of real values.
struct SteppedTransfer {
  TransferFunction transfer;
  double layer_share = 1;  ///< a step as a share of a layer
};

/// Transfer functions for pooled values, integrated over steps from each value to each other one.
/// Most entries lie between the first point and the last of all, the others below and above.
class TransferTable {
 public:
  TransferTable(const TransferFunction& transfer, const Rescale& rescale, const PooledScale& scale,
                const SampleRange& pooled, double layer_share);
  /// Several, one after the other; values lie at the same entries in all of them.
  TransferTable(std::span<const SteppedTransfer> transfers, const Rescale& rescale,
                const PooledScale& scale, const SampleRange& pooled);

  ColorTable table() const;
  /// Where the entries of a function begin.
  static std::int32_t begin_of(std::size_t function) {
    return static_cast<std::int32_t>(function) * ColorTable::kSide * ColorTable::kSide;
  }
  /// From the first point to the last, of pooled values.
  double colored_width() const { return colored_width_; }
  /// Whether values between two have an opacity.
  bool is_seen(float lowest, float highest, std::size_t function = 0) const;

 private:
  void set_pieces(std::span<const SteppedTransfer> transfers, const Rescale& rescale,
                  const PooledScale& scale, const SampleRange& pooled);
  void add(const SteppedTransfer& stepped, const Rescale& rescale, const PooledScale& scale);
  std::int32_t entry_of(float value) const;
  double value_at(double entry) const;

  std::array<ColorTable::Piece, 3> pieces_;
  double last_value_ = 0;
  double colored_width_ = 0;
  double unused_width_ = 0;
  std::vector<float> opacities_;
  std::vector<std::uint32_t> colors_;
  std::vector<std::int32_t> seen_before_;  // by function: entries before each that have an opacity
};

}  // namespace octavo
