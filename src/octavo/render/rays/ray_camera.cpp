#include "octavo/render/rays/ray_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr double kWidestAngle = 170;

/// Over the left shoulder of the viewer: to the right, up, towards the viewer.
constexpr Point3 kTowardLight = {-0.40, 0.55, 0.80};
constexpr float kRayAmbient = 0.22f;
constexpr float kRayDiffuse = 0.78f;
constexpr float kRaySpecular = 0.16f;

/// The samples that pixels step by: columns of the inverse of a view.
struct PixelSteps {
  Point3 across{};
  Point3 down{};
  Point3 toward{};
};

Point3 pixels_of(const Place& place, double units) {
  return {static_cast<double>(place.x) / units, static_cast<double>(place.y) / units,
          static_cast<double>(place.depth) / units};
}

PixelSteps pixel_steps(const View& view) {
  const double units = std::ldexp(1.0, view.fraction_bits);
  const Point3 a = pixels_of(view.axes[0], units);
  const Point3 b = pixels_of(view.axes[1], units);
  const Point3 c = pixels_of(view.axes[2], units);
  const double by = 1 / dot(a, cross(b, c));
  const std::array<Point3, 3> rows = {scaled(cross(b, c), by), scaled(cross(c, a), by),
                                      scaled(cross(a, b), by)};
  PixelSteps steps;
  for (std::size_t i = 0; i < 3; ++i) {
    steps.across[i] = rows[i][0];
    steps.down[i] = rows[i][1];
    steps.toward[i] = rows[i][2];
  }
  return steps;
}

std::array<float, 3> floats(const Point3& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

/// How far a box reaches from the middle of the picture towards the viewer, pixels.
double depth_before(const View& view, const Box& shown) {
  const double units = std::ldexp(1.0, view.fraction_bits);
  const Point3 middle = middle_of(shown);
  double depth = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const auto step = static_cast<double>(view.axes[i].depth);
    depth += std::abs(step) * static_cast<double>(shown.size()[axis]) / units / 2 +
             step * (middle[i] - view.middle[i]) / units;
  }
  return depth;
}

void set_light(RayFrame& frame) {
  const Point3 light = unit(kTowardLight);
  frame.light.toward_light = floats(light);
  frame.light.halfway = floats(unit(sum(light, {0, 0, 1})));
  frame.light.ambient = kRayAmbient;
  frame.light.diffuse = kRayDiffuse;
  frame.light.specular = kRaySpecular;
}

}  // namespace

void set_camera(RayFrame& frame, const RayCamera& camera) {
  const View& view = camera.view;
  const bool has_eye = camera.angle_degrees != 0;
  if (has_eye && !(camera.angle_degrees > 0 && camera.angle_degrees <= kWidestAngle)) {
    throw Error(ErrorKind::invalid_argument, "the angle of a view must be above 0 and at most 170")
        .with_field("angle_degrees");
  }
  const PixelSteps steps = pixel_steps(view);
  const double step_pixels = camera.step_mm / view.pixel_mm;
  frame.step_pixels = static_cast<float>(step_pixels);

  // An eye looks at the middle of the picture, or the image plane lies half a step before it: each
  // sample stands in the middle of the step that it stands for.
  Point3 middle;
  for (int axis = 0; axis < 3; ++axis) {
    middle[static_cast<std::size_t>(axis)] = view.middle[static_cast<std::size_t>(axis)] - 0.5;
    frame.low[static_cast<std::size_t>(axis)] = static_cast<float>(camera.shown.lo[axis]) - 0.5f;
    frame.high[static_cast<std::size_t>(axis)] = static_cast<float>(camera.shown.hi[axis]) - 0.5f;
  }
  if (has_eye) {
    const double half = camera.angle_degrees * std::numbers::pi / 360;
    const double distance =
        static_cast<double>(view.height) / 2 / std::tan(half) * camera.zoom;
    frame.eye_pixels = static_cast<float>(distance);
    frame.origin = floats(sum(middle, scaled(steps.toward, distance)));
    frame.origin_across = frame.origin_down = {};
    frame.direction = floats(scaled(steps.toward, -distance));
    frame.direction_across = floats(steps.across);
    frame.direction_down = floats(steps.down);
  } else {
    frame.eye_pixels = 0;
    const double depth = depth_before(view, camera.shown) + step_pixels / 2;
    frame.origin = floats(sum(middle, scaled(steps.toward, depth)));
    frame.origin_across = floats(steps.across);
    frame.origin_down = floats(steps.down);
    frame.direction = floats(scaled(steps.toward, -step_pixels));
    frame.direction_across = frame.direction_down = {};
  }

  // Gradients are differences over two samples; those of the picture are per step.
  const double by = 0.5 * step_pixels;
  for (std::size_t i = 0; i < 3; ++i) {
    frame.gradient[i] = static_cast<float>(by * steps.across[i]);
    frame.gradient[3 + i] = static_cast<float>(-by * steps.down[i]);
    frame.gradient[6 + i] = static_cast<float>(by * steps.toward[i]);
  }
  set_light(frame);

  // As far as places are rounded.
  const auto& size = frame.bricks.size;
  frame.margin = 1 / 256.0f + 1e-6f * static_cast<float>(std::max({size[0], size[1], size[2]}));
}

std::int64_t brick_nearness(const RayFrame& frame, const Index3& brick) {
  std::int64_t nearness = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (frame.eye_pixels > 0) {
      const auto eye = static_cast<std::int64_t>(std::floor(frame.origin[i])) >> frame.bricks.shift;
      nearness += std::abs(brick[axis] - eye);
    } else {
      nearness += frame.direction[i] > 0 ? brick[axis] : -brick[axis];
    }
  }
  return nearness;
}

}  // namespace octavo
