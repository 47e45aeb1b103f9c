#include "octavo/render/slice/slice_picture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "octavo/core/error.h"
#include "octavo/file/parallel_read.h"
#include "octavo/render/annotation.h"
#include "octavo/render/label_color.h"

namespace octavo {

namespace {

constexpr double kMostPixels = double(1 << 28);

/// The samples of a slice as the picture has them: [down][across], unflipped.
struct SliceSamples {
  std::int64_t across = 0;
  std::int64_t down = 0;
  std::vector<double> values;  ///< stored values

  double at(std::int64_t x, std::int64_t y) const {
    return values[static_cast<std::size_t>(y * across + x)];
  }
};

[[noreturn]] void refuse(const std::string& what, std::int64_t value, std::int64_t end) {
  throw Error(
      ErrorKind::invalid_argument,
      what + " " + std::to_string(value) + "; it must be between 0 and " + std::to_string(end - 1));
}

std::int64_t chosen_index(const FileReader& reader, const SliceOptions& options) {
  if (options.axis < 0 || options.axis > 2) refuse("axis", options.axis, 3);
  const Levels& levels = reader.levels();
  if (options.level < 0 || options.level >= levels.count()) {
    refuse("level", options.level, levels.count());
  }
  const std::int64_t end = levels.size(options.level)[options.axis];
  const std::int64_t index = options.index.value_or(end / 2);
  if (index < 0 || index >= end) refuse("slice", index, end);
  if (options.window && !(options.window->width > 0)) {
    throw Error(ErrorKind::invalid_argument, "the window's width must be greater than 0");
  }
  return index;
}

template <class T>
void gather(const std::vector<std::byte>& voxels, std::int64_t step_x, std::int64_t step_y,
            SliceSamples& slice) {
  for (std::int64_t y = 0; y < slice.down; ++y) {
    for (std::int64_t x = 0; x < slice.across; ++x) {
      T value;
      const auto at = static_cast<std::size_t>(y * step_y + x * step_x) * sizeof(T);
      std::memcpy(&value, voxels.data() + at, sizeof value);
      slice.values[static_cast<std::size_t>(y * slice.across + x)] = static_cast<double>(value);
    }
  }
}

SliceSamples read_slice(const FileReader& reader, const SliceOptions& options, std::int64_t index,
                        const SliceOrientation& orientation) {
  Box box = box_of(reader.levels().size(options.level));
  box.lo[options.axis] = index;
  box.hi[options.axis] = index + 1;
  const Size3 size = box.size();
  const VoxelType type = reader.description().type;
  const auto count = static_cast<std::size_t>(size.voxel_count());
  std::vector<std::byte> voxels(count * static_cast<std::size_t>(bytes_per_voxel(type)));
  read_parallel(reader, box, options.level, voxels.data(), options.threads);
  SliceSamples slice;
  slice.across = size[orientation.across];
  slice.down = size[orientation.down];
  slice.values.resize(count);
  const Index3 step{1, size.x, size.x * size.y};
  with_voxel_type(type, [&](auto tag) {
    gather<typename decltype(tag)::type>(voxels, step[orientation.across], step[orientation.down],
                                         slice);
  });
  return slice;
}

/// Where the pixels of one picture axis lie among the samples.
struct PixelAxis {
  std::int64_t samples = 1;
  std::int64_t pixels = 1;
  bool flips = false;

  /// The fractional sample under the center of a pixel, inside [0, samples - 1].
  double sample_at(std::int64_t pixel) const {
    const std::int64_t along = flips ? pixels - 1 - pixel : pixel;
    const double scale = static_cast<double>(samples) / static_cast<double>(pixels);
    const double sample = (static_cast<double>(along) + 0.5) * scale - 0.5;
    return std::clamp(sample, 0.0, static_cast<double>(samples - 1));
  }

  std::int64_t nearest_at(std::int64_t pixel) const {
    const std::int64_t along = flips ? pixels - 1 - pixel : pixel;
    return along * samples / pixels;
  }
};

double interpolated(const SliceSamples& slice, double x, double y) {
  const auto x0 = static_cast<std::int64_t>(x);
  const auto y0 = static_cast<std::int64_t>(y);
  const double fx = x - static_cast<double>(x0);
  const double fy = y - static_cast<double>(y0);
  const std::int64_t x1 = fx > 0 ? x0 + 1 : x0;
  const std::int64_t y1 = fy > 0 ? y0 + 1 : y0;
  const double upper = slice.at(x0, y0) + fx * (slice.at(x1, y0) - slice.at(x0, y0));
  const double lower = slice.at(x0, y1) + fx * (slice.at(x1, y1) - slice.at(x0, y1));
  return upper + fy * (lower - upper);
}

Picture draw_grey(const SliceSamples& slice, const PixelAxis& across, const PixelAxis& down,
                  const Rescale& rescale, const Window& window) {
  Picture picture = make_picture(across.pixels, down.pixels, 1);
  std::size_t i = 0;
  for (std::int64_t y = 0; y < picture.height; ++y) {
    const double sample_y = down.sample_at(y);
    for (std::int64_t x = 0; x < picture.width; ++x) {
      const double stored = interpolated(slice, across.sample_at(x), sample_y);
      picture.pixels[i++] = window.grey(rescale.to_real(stored));
    }
  }
  return picture;
}

Picture draw_labels(const SliceSamples& slice, const PixelAxis& across, const PixelAxis& down) {
  Picture picture = make_picture(across.pixels, down.pixels, 3);
  for (std::int64_t y = 0; y < picture.height; ++y) {
    for (std::int64_t x = 0; x < picture.width; ++x) {
      const double label = slice.at(across.nearest_at(x), down.nearest_at(y));
      picture.set(x, y, label_color(static_cast<std::int64_t>(label)));
    }
  }
  return picture;
}

Window window_of(const SliceSamples& slice, const Rescale& rescale) {
  std::vector<double> real(slice.values.size());
  std::transform(slice.values.begin(), slice.values.end(), real.begin(),
                 [&](double stored) { return rescale.to_real(stored); });
  return robust_window(real);
}

/// The side of a square pixel: the finer spacing, divided so that the longer side has `least_side`
/// pixels.
double chosen_pixel_mm(double across_mm, double across_spacing, double down_mm, double down_spacing,
                       std::int64_t least_side) {
  const double finest = std::min(across_spacing, down_spacing);
  const double longest = std::max(across_mm, down_mm) / finest;
  const double enlargement = std::ceil(static_cast<double>(least_side) / longest);
  return finest / std::max(1.0, enlargement);
}

}  // namespace

SlicePicture render_slice(const FileReader& reader, const SliceOptions& options) {
  const std::int64_t index = chosen_index(reader, options);
  const VolumeDescription& description = reader.description();
  const Geometry geometry = reader.levels().geometry(description.geometry, options.level);
  SlicePicture result;
  result.orientation = slice_orientation(geometry, options.axis);
  const SliceOrientation& orientation = result.orientation;

  // Size the picture before anything is read.
  const Size3 size = reader.levels().size(options.level);
  const double across_spacing = geometry.spacing_mm[static_cast<std::size_t>(orientation.across)];
  const double down_spacing = geometry.spacing_mm[static_cast<std::size_t>(orientation.down)];
  const double across_mm = across_spacing * static_cast<double>(size[orientation.across]);
  const double down_mm = down_spacing * static_cast<double>(size[orientation.down]);
  result.pixel_mm =
      chosen_pixel_mm(across_mm, across_spacing, down_mm, down_spacing, options.least_side);
  if (across_mm / result.pixel_mm * (down_mm / result.pixel_mm) > kMostPixels) {
    throw Error(ErrorKind::limit_exceeded,
                "the picture would exceed 2^28 pixels; use a coarser level");
  }
  const PixelAxis across{size[orientation.across], std::llround(across_mm / result.pixel_mm),
                         orientation.flips_across};
  const PixelAxis down{size[orientation.down], std::llround(down_mm / result.pixel_mm),
                       orientation.flips_down};

  const SliceSamples slice = read_slice(reader, options, index, orientation);
  if (description.kind == VolumeKind::labels) {
    result.picture = draw_labels(slice, across, down);
  } else {
    result.window = options.window ? *options.window : window_of(slice, description.rescale);
    result.picture = draw_grey(slice, across, down, description.rescale, result.window);
  }
  if (options.scale_bar) draw_scale_bar(result.picture, result.pixel_mm);
  if (options.sides) draw_sides(result.picture, orientation);
  return result;
}

}  // namespace octavo
