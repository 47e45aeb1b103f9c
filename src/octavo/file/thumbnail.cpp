#include "octavo/file/thumbnail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "octavo/core/label_color.h"
#include "octavo/file/fixed_png.h"

namespace octavo {

namespace {

constexpr double kMostPixels = 256;

// An index axis in the picture.
struct PictureAxis {
  int index = 0;
  bool is_mirrored = false;  // its index falls to the right, or downwards
};

struct PictureView {
  int across = 0;  // the index axis through the picture
  PictureAxis columns;
  PictureAxis rows;
};

double extent_mm(const VolumeDescription& volume, int axis) {
  return static_cast<double>(volume.size[axis]) *
         volume.geometry.spacing_mm[static_cast<std::size_t>(axis)];
}

// A coronal plane, seen from the front. Of flat volumes, whose coronal planes are strips, the plane
// of their two longer sides.
PictureView view_of(const VolumeDescription& volume) {
  // Which index axes run to the left (0), to the back (1) and to the head (2) of a patient
  const auto component = [&](int world, int axis) {
    return volume.geometry.direction[static_cast<std::size_t>(3 * world + axis)];
  };
  const auto is_steeper = [&](int world, int a, int b) {
    return std::abs(component(world, a)) > std::abs(component(world, b));
  };
  int head = 2;
  for (const int axis : {1, 0}) {
    if (is_steeper(2, axis, head)) head = axis;
  }
  const int lower = head == 0 ? 1 : 0;
  const int upper = head == 2 ? 1 : 2;
  const int back = is_steeper(1, lower, upper) ? lower : upper;
  const int left = lower + upper - back;

  // Through which of them to look
  const auto is_thin = [&](int axis) {
    return 4 * extent_mm(volume, axis) < extent_mm(volume, back);
  };
  PictureView view;
  view.across = back;
  if (is_thin(head)) view.across = head;
  const bool is_thinner = !is_thin(head) || extent_mm(volume, left) < extent_mm(volume, head);
  if (is_thin(left) && is_thinner) view.across = left;

  // The left of the patient is on the right, the head above
  const PictureAxis of_back{back, component(1, back) < 0};
  view.columns = view.across == left ? of_back : PictureAxis{left, component(0, left) < 0};
  view.rows = view.across == head ? of_back : PictureAxis{head, !(component(2, head) < 0)};
  return view;
}

double pitch_mm(const FileReader& reader, int level, int axis) {
  return std::ldexp(
      reader.description().geometry.spacing_mm[static_cast<std::size_t>(axis)],
      reader.levels().halving_count(level, axis));
}

// The first level whose samples are as long as the smallest pixel, or single, along both axes.
int level_of(const FileReader& reader, const PictureView& view, double minimum_mm) {
  const auto is_coarse = [&](int level, int axis) {
    return pitch_mm(reader, level, axis) >= minimum_mm || reader.levels().size(level)[axis] == 1;
  };
  int level = 0;
  while (!is_coarse(level, view.columns.index) || !is_coarse(level, view.rows.index)) ++level;
  return level;
}

// Along an axis of the picture, the index of the sample that each pixel shows.
std::vector<std::int64_t> samples_along(const FileReader& reader, int level,
                                        const PictureAxis& axis, double pixel_mm) {
  const VolumeDescription& volume = reader.description();
  const auto count = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(extent_mm(volume, axis.index) / pixel_mm + 0.5));
  const int halvings = reader.levels().halving_count(level, axis.index);
  std::vector<std::int64_t> samples;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t voxel = (2 * i + 1) * volume.size[axis.index] / (2 * count);
    samples.push_back(voxel >> halvings);
  }
  if (axis.is_mirrored) std::reverse(samples.begin(), samples.end());
  return samples;
}

struct PictureSamples {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<double> values;  // [row][column]; every voxel type fits
};

PictureSamples samples_of(const FileReader& reader) {
  // What is seen, and in which pixels
  const VolumeDescription& volume = reader.description();
  const PictureView view = view_of(volume);
  const int columns_axis = view.columns.index;
  const int rows_axis = view.rows.index;
  const double minimum_mm =
      std::max(extent_mm(volume, columns_axis), extent_mm(volume, rows_axis)) / kMostPixels;
  const int level = level_of(reader, view, minimum_mm);
  const double pixel_mm =
      std::max(minimum_mm, std::min(pitch_mm(reader, level, columns_axis),
                                  pitch_mm(reader, level, rows_axis)));
  const auto columns = samples_along(reader, level, view.columns, pixel_mm);
  const auto rows = samples_along(reader, level, view.rows, pixel_mm);

  // The middle plane
  Box box = box_of(reader.levels().size(level));
  box.lo[view.across] =
      volume.size[view.across] / 2 >> reader.levels().halving_count(level, view.across);
  box.hi[view.across] = box.lo[view.across] + 1;
  const Size3 size = box.size();
  Bytes plane(static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(volume.type)));
  reader.read(box, level, plane.data());

  PictureSamples picture{columns.size(), rows.size(), {}};
  picture.values.reserve(columns.size() * rows.size());
  const std::array<std::int64_t, 3> strides = {1, size.x, size.x * size.y};
  const std::int64_t column_stride = strides[static_cast<std::size_t>(columns_axis)];
  const std::int64_t row_stride = strides[static_cast<std::size_t>(rows_axis)];
  with_voxel_type(volume.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const T* const samples = reinterpret_cast<const T*>(plane.data());
    for (const std::int64_t row : rows) {
      for (const std::int64_t column : columns) {
        picture.values.push_back(
            static_cast<double>(samples[row * row_stride + column * column_stride]));
      }
    }
  });
  return picture;
}

// From black to white what lies between the lowest and the highest hundredth.
PngPixels greys_of(const PictureSamples& picture, bool is_negative) {
  PngPixels pixels{picture.width, picture.height, 1, Bytes(picture.values.size())};
  std::vector<double> ordered;
  std::copy_if(picture.values.begin(), picture.values.end(), std::back_inserter(ordered),
               [](double value) { return std::isfinite(value); });
  if (ordered.empty()) return pixels;
  std::sort(ordered.begin(), ordered.end());
  const std::size_t off = ordered.size() / 100;
  double low = ordered[off];
  double high = ordered[ordered.size() - 1 - off];
  if (low == high) {
    low = ordered.front();
    high = ordered.back();
  }
  if (low == high) return pixels;
  std::transform(picture.values.begin(), picture.values.end(), pixels.values.begin(),
                 [&](double value) -> std::uint8_t {
                   if (std::isnan(value)) return 0;
                   const double share = 255 * (std::clamp(value, low, high) - low) / (high - low);
                   const auto shade = static_cast<std::uint8_t>(share + 0.5);
                   return is_negative ? static_cast<std::uint8_t>(255 - shade) : shade;
                 });
  return pixels;
}

PngPixels colors_of(const PictureSamples& picture) {
  PngPixels pixels{picture.width, picture.height, 3, {}};
  pixels.values.reserve(3 * picture.values.size());
  for (const double value : picture.values) {
    const LabelColor color = label_color(static_cast<std::int64_t>(value));
    pixels.values.insert(pixels.values.end(), color.begin(), color.end());
  }
  return pixels;
}

}  // namespace

Bytes thumbnail_of(const FileReader& reader) {
  const PictureSamples picture = samples_of(reader);
  const VolumeDescription& volume = reader.description();
  return encode_fixed_png(volume.kind == VolumeKind::labels
                              ? colors_of(picture)
                              : greys_of(picture, volume.rescale.slope < 0));
}

bool has_true_thumbnail(const FileReader& reader) {
  return reader.thumbnail() == thumbnail_of(reader);
}

}  // namespace octavo
