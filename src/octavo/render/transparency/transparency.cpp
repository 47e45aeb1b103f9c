#include "octavo/render/transparency/transparency.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEmissionUnit = double(1 << 20);  // of a voxel with an opacity of 1

// Steps along the index axes as a way through the world, mm.
Point3 way_mm(const Geometry& geometry, const Direction& steps) {
  const double along[3] = {steps.x * geometry.spacing_mm[0], steps.y * geometry.spacing_mm[1],
                           steps.z * geometry.spacing_mm[2]};
  Point3 way{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t a = 0; a < 3; ++a) way[r] += geometry.direction[3 * r + a] * along[a];
  }
  return way;
}

double finest_mm(const Geometry& geometry) {
  return *std::min_element(geometry.spacing_mm.begin(), geometry.spacing_mm.end());
}

// A place on the picture, pixels.
struct ScreenSpot {
  double x = 0;
  double y = 0;
};

// The lattice of lines on a picture: (u, v) lies at origin + u * across + v * down.
struct Lattice {
  ScreenSpot origin;
  ScreenSpot across;
  ScreenSpot down;

  double area() const { return across.x * down.y - across.y * down.x; }
};

ScreenSpot spot_of(const View& view, const Place& place, double scale = 1) {
  const double unit = scale / std::ldexp(1, view.fraction_bits);
  return {static_cast<double>(place.x) * unit, static_cast<double>(place.y) * unit};
}

Lattice lattice_on(const View& view, const VoxelLines& lines) {
  Lattice lattice;
  for (std::size_t a = 0; a < 3; ++a) {
    if (lines.u_step[a] != 0 && lines.v_step[a] == 0) {
      lattice.across = spot_of(view, view.axes[a], lines.u_step[a]);
    }
    if (lines.v_step[a] != 0 && lines.u_step[a] == 0) {
      lattice.down = spot_of(view, view.axes[a], lines.v_step[a]);
    }
  }
  // The middle of voxel (0, 0, 0), which is on line (u_start, v_start).
  lattice.origin = spot_of(view, view.origin);
  const auto u0 = static_cast<double>(lines.u_start);
  const auto v0 = static_cast<double>(lines.v_start);
  for (std::size_t a = 0; a < 3; ++a) {
    const ScreenSpot half = spot_of(view, view.axes[a], 0.5);
    lattice.origin.x += half.x;
    lattice.origin.y += half.y;
  }
  lattice.origin.x -= u0 * lattice.across.x + v0 * lattice.down.x;
  lattice.origin.y -= u0 * lattice.across.y + v0 * lattice.down.y;
  // All voxels of a line must fall on one spot, to half a pixel over the volume.
  const Direction& d = lines.along;
  const Place step = view.axes[0] * d.x + view.axes[1] * d.y + view.axes[2] * d.z;
  const ScreenSpot drift = spot_of(
      view, step, static_cast<double>(std::max({lines.size.x, lines.size.y, lines.size.z})));
  if (!(std::max(std::abs(drift.x), std::abs(drift.y)) <= 0.5) || lattice.area() == 0) {
    throw Error(ErrorKind::invalid_argument, "the view does not look along lines of voxels");
  }
  return lattice;
}

// Colors between lines; a line that does not exist leaves the background as it is.
class LineField {
 public:
  LineField(const VoxelLines& lines, std::vector<LineColor> colors)
      : lines_(lines), colors_(std::move(colors)) {}

  LineColor at(double u, double v) const {
    const double u0 = std::floor(u);
    const double v0 = std::floor(v);
    const auto i = static_cast<std::int64_t>(u0);
    const auto j = static_cast<std::int64_t>(v0);
    const auto fu = static_cast<float>(u - u0);
    const auto fv = static_cast<float>(v - v0);
    // Lines across a corner stand in triangles; their cells are halved along the shorter diagonal.
    const float both = lines_.axes == 3 ? std::min(fu, fv) : fu * fv;
    const LineColor a = line(i, j);
    const LineColor b = line(i + 1, j);
    const LineColor c = line(i, j + 1);
    const LineColor d = line(i + 1, j + 1);
    LineColor mixed;
    for (std::size_t k = 0; k < 4; ++k) {
      mixed[k] =
          a[k] * (1 - fu - fv + both) + b[k] * (fu - both) + c[k] * (fv - both) + d[k] * both;
    }
    return mixed;
  }

 private:
  LineColor line(std::int64_t u, std::int64_t v) const {
    if (u < 0 || v < 0 || u >= lines_.width || v >= lines_.height) return {0, 0, 0, 1};
    return colors_[static_cast<std::size_t>(v * lines_.width + u)];
  }

  const VoxelLines& lines_;
  std::vector<LineColor> colors_;
};

std::uint8_t channel_of(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

// Draws the lattice; a pixel is the mean of as many points as it covers lines, or of one.
Picture draw_lattice(const LineField& field, const Lattice& lattice, const View& view,
                     const Color& background) {
  Picture picture = make_picture(view.width, view.height, 3);
  const double area = lattice.area();
  const double u_x = lattice.down.y / area, u_y = -lattice.down.x / area;
  const double v_x = -lattice.across.y / area, v_y = lattice.across.x / area;
  const double lines_per_pixel = std::max({std::hypot(u_x, v_x), std::hypot(u_y, v_y)});
  const int points = static_cast<int>(std::clamp(std::ceil(lines_per_pixel), 1.0, 8.0));
  parallel_for(std::int64_t{0}, view.height, [&](std::int64_t y) {
    for (std::int64_t x = 0; x < view.width; ++x) {
      std::array<double, 4> sum{};
      for (int i = 0; i < points * points; ++i) {
        const int column = i % points;
        const int row = i / points;
        const double px = static_cast<double>(x) + (column + 0.5) / points - lattice.origin.x;
        const double py = static_cast<double>(y) + (row + 0.5) / points - lattice.origin.y;
        const LineColor color = field.at(px * u_x + py * u_y, px * v_x + py * v_y);
        for (std::size_t k = 0; k < 4; ++k) sum[k] += static_cast<double>(color[k]);
      }
      std::uint8_t* const out =
          picture.pixels.data() + static_cast<std::size_t>(3 * (y * view.width + x));
      for (std::size_t k = 0; k < 3; ++k) {
        out[k] = channel_of((sum[k] + sum[3] * background[k] / 255) / (points * points));
      }
    }
  });
  return picture;
}

DensityClasses classes_of(const VolumeDescription& volume, const TransparencyOptions& options) {
  if (!options.ranges.empty()) return DensityClasses::of_ranges(volume, options.ranges);
  const auto& [low, high] = options.ramp;
  const double span = std::abs(high - low);
  const bool is_exact = is_integer(volume.type) && span == std::floor(span);
  const int steps = is_exact && span <= 65535 ? static_cast<int>(std::max(1.0, span)) : 65535;
  return DensityClasses::ramp(volume, low, high, steps);
}

// How many layers of the finest spacing one voxel on a line is thick.
double layers_per_voxel(const FileReader& reader, const LineView& view) {
  const Geometry& geometry = reader.description().geometry;
  const Point3 way = way_mm(reader.levels().geometry(geometry, view.level), view.along);
  return std::sqrt(dot(way, way)) / finest_mm(geometry);
}

// Sums as shares of the brightest, through a window.
class SumDisplay {
 public:
  /// unit  what a sum of 1 is in the window's units
  SumDisplay(const LineSums& sums, double unit, const std::optional<Window>& asked)
      : sums_(sums), unit_(unit), window_(asked ? *asked : automatic()) {
    if (!(window_.width > 0)) {
      throw Error(ErrorKind::invalid_argument, "the window's width must be greater than 0");
    }
  }

  const Window& window() const { return window_; }

  bool is_lit() const {
    return std::any_of(sums_.sums.begin(), sums_.sums.end(), [](auto sum) { return sum > 0; });
  }

  /// kept  samples of the level; what does not meet them is the background
  std::vector<LineColor> colors(const Box& kept) const {
    const bool is_grey = sums_.channels == 1;
    std::vector<std::uint8_t> met;
    if (is_grey) met = lines_through(sums_.lines, kept);
    const auto channels = static_cast<std::size_t>(sums_.channels);
    std::vector<LineColor> colors(sums_.sums.size() / channels, LineColor{0, 0, 0, 1});
    for (std::size_t i = 0; i < colors.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double sum = static_cast<double>(sums_.sums[i * channels + k % channels]) * unit_;
        const double share = (sum - window_.center) / window_.width + 0.5;
        colors[i][k] = static_cast<float>(std::max(0.0, share));
      }
      if (is_grey) {
        if (met[i] != 0) colors[i][3] = 0;
        else colors[i] = {0, 0, 0, 1};
        continue;
      }
      const float most = std::max({colors[i][0], colors[i][1], colors[i][2]});
      colors[i][3] = std::max(0.0F, 1 - most);
    }
    return colors;
  }

 private:
  // Colors start at nothing, so that their hues stay.
  Window automatic() const {
    std::vector<double> lit;
    const auto channels = static_cast<std::size_t>(sums_.channels);
    for (std::size_t i = 0; i < sums_.sums.size(); i += channels) {
      const auto first = sums_.sums.begin() + static_cast<std::ptrdiff_t>(i);
      const std::int64_t most = *std::max_element(first, first + sums_.channels);
      if (most > 0) lit.push_back(static_cast<double>(most) * unit_);
    }
    if (lit.empty()) return {0.5, 1};  // what is dark is black
    const Window window = robust_window(std::move(lit));
    const double high = window.center + window.width / 2;
    const double low = sums_.channels == 1 ? window.center - window.width / 2 : 0;
    return high > low ? Window{(low + high) / 2, high - low} : window;
  }

  const LineSums& sums_;
  double unit_;
  Window window_;
};

// Whether some voxel was drawn, also a black one.
bool has_voxel(const std::vector<LineColor>& colors) {
  return std::any_of(colors.begin(), colors.end(), [](const LineColor& color) {
    return color[3] < 1;
  });
}

// Whether some line is more than black.
bool has_light(const std::vector<LineColor>& colors) {
  return std::any_of(colors.begin(), colors.end(), [](const LineColor& color) {
    return std::max({color[0], color[1], color[2]}) > 0;
  });
}

// What a voxel of each class gives: grey by the ramp, colors by opacity.
std::vector<std::int32_t> emission_of(const DensityClasses& classes,
                                      const TransparencyOptions& options) {
  std::vector<std::int32_t> emission;
  if (options.ranges.empty()) {
    for (std::size_t class_id = 0; class_id < classes.count(); ++class_id) {
      emission.push_back(static_cast<std::int32_t>(class_id));
    }
    return emission;
  }
  emission.assign(3, 0);
  for (const DensityRange& range : options.ranges) {
    for (const std::uint8_t channel : range.color) {
      const double share = range.opacity * channel / 255;
      emission.push_back(static_cast<std::int32_t>(std::lround(kEmissionUnit * share)));
    }
  }
  return emission;
}

std::vector<ClassTransfer> transfer_of(const DensityClasses& classes,
                                       const TransparencyOptions& options, double layers) {
  const auto of_voxel = [&](double opacity) {
    return static_cast<float>(1 - std::pow(1 - std::clamp(opacity, 0.0, 1.0), layers));
  };
  std::vector<ClassTransfer> transfer(1);
  for (const DensityRange& range : options.ranges) {
    ClassTransfer& one = transfer.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) one.color[k] = static_cast<float>(range.color[k]) / 255;
    one.opacity = of_voxel(range.opacity);
  }
  while (transfer.size() < classes.count()) {
    const double share =
        static_cast<double>(transfer.size()) / static_cast<double>(classes.count() - 1);
    const auto grey = static_cast<float>(share);
    transfer.push_back({{grey, grey, grey}, of_voxel(options.ramp_opacity * share)});
  }
  return transfer;
}

}  // namespace

NearestLines nearest_lines(const Geometry& geometry, const Point3& toward) {
  NearestLines nearest;
  double best = -kInfinity;
  for (const Direction& steps : kDirections) {
    const Point3 way = way_mm(geometry, steps);
    const double cosine = dot(way, toward) / std::sqrt(dot(way, way) * dot(toward, toward));
    if (!(cosine > best)) continue;
    best = cosine;
    nearest = {steps, std::acos(std::min(1.0, cosine)) * 180 / std::numbers::pi};
  }
  return nearest;
}

ValueRamp robust_ramp(const FileReader& reader, bool is_open) {
  const VolumeDescription& volume = reader.description();
  const Window window = robust_window(reader);
  const double half = volume.rescale.slope < 0 ? -window.width / 2 : window.width / 2;
  ValueRamp ramp{window.center - half, window.center + half};
  if (!is_open) return ramp;
  for (const std::int64_t end : {reader.range().min, reader.range().max}) {
    if (volume.is_unbounded(end)) continue;
    const double value = volume.voxel_of(end);
    if ((value - ramp.high) * half > 0) ramp.high = value;
  }
  return ramp;
}

std::vector<DensityRange> hounsfield_ranges(double finest_mm, bool is_average) {
  // Opacities of a layer of 1 mm; lower where what is in front absorbs than where all only adds.
  const double flesh = is_average ? 0.004 : 0.015;
  const double bone = is_average ? 0.04 : 0.1;
  const double below_bone = std::nextafter(226.0, 0.0);
  std::vector<DensityRange> ranges = {{-250, -30, {255, 214, 160}, flesh},
                                      {-30, below_bone, {224, 96, 74}, flesh},
                                      {226, kInfinity, {255, 250, 235}, bone}};
  for (DensityRange& range : ranges) range.opacity = 1 - std::pow(1 - range.opacity, finest_mm);
  return ranges;
}

TransparencyPicture render_transparency(const FileReader& reader, const View& view,
                                        const TransparencyOptions& options, Progress& progress) {
  const VolumeDescription& volume = reader.description();
  const Levels& levels = reader.levels();
  if (options.level < 0 || options.level >= levels.count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(options.level));
  }
  const NearestLines nearest =
      nearest_lines(levels.geometry(volume.geometry, options.level), view.toward);
  const LineView lines{options.level, nearest.toward.reversed(), options.kept};
  const Lattice lattice = lattice_on(view, voxel_lines(levels.size(options.level), lines.along));
  const DensityClasses classes = classes_of(volume, options);
  const double layers = layers_per_voxel(reader, lines);
  TransparencyPicture result;
  if (options.is_average) {
    LineAverages averages = average_along_lines(reader, lines, classes,
                                                transfer_of(classes, options, layers), progress);
    result.counts = averages.counts;
    result.is_lit = result.is_seen = has_voxel(averages.colors);
    const LineField field(averages.lines, std::move(averages.colors));
    result.picture = draw_lattice(field, lattice, view, options.background);
    return result;
  }
  const bool is_grey = options.ranges.empty();
  const LineSums sums = sum_along_lines(reader, lines, classes, emission_of(classes, options),
                                        is_grey ? 1 : 3, progress);
  const double real_span = std::abs((options.ramp.high - options.ramp.low) * volume.rescale.slope);
  const double step = real_span / static_cast<double>(classes.count() - 1);
  const double unit = is_grey ? layers * finest_mm(volume.geometry) * step : layers / kEmissionUnit;
  const SumDisplay display(sums, unit, options.window);
  result.window = display.window();
  result.counts = sums.counts;
  const Box whole = box_of(levels.size(options.level));
  std::vector<LineColor> colors = display.colors(options.kept.value_or(whole));
  result.is_lit = display.is_lit();
  result.is_seen = has_light(colors);
  const LineField field(sums.lines, std::move(colors));
  result.picture = draw_lattice(field, lattice, view, options.background);
  return result;
}

}  // namespace octavo
