// Which real values a grey picture shows: from black to white.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "octavo/file/reader.h"

namespace octavo {

/// Values up to center - width/2 are black, from center + width/2 on white. In real units.
struct Window {
  double center = 0;
  double width = 1;
  bool operator==(const Window&) const = default;

  /// 0 .. 255; NaN is black.
  std::uint8_t grey(double value) const;
};

struct WindowPreset {
  std::string_view name;
  Window window;
};

/// The usual windows of CT, in Hounsfield units.
std::span<const WindowPreset> window_presets();

std::optional<Window> find_window_preset(std::string_view name);

/// The window from the 0.5th to the 99.5th percentile of `values`, so that a few bright or dark
/// voxels do not decide; the whole range where those two are equal, and that of window_of_one where
/// all are. Values that are not finite do not count.
Window robust_window(std::vector<double> values);

/// The window for pictures of one value, from 0 to it: what is more than nothing is white.
Window window_of_one(double value);

/// The stored values of the finest level of a volume that has at most 2^21 samples.
/// Throws what the reader throws.
std::vector<double> sampled_values(const FileReader& reader);

/// The same of the stored values of a volume, as a level of at most 2^21 samples has them.
/// Throws what the reader throws.
Window robust_window(const FileReader& reader);

}  // namespace octavo
