#include "octavo/tasks/structure/pose_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include "octavo/render/lettering.h"

namespace octavo {

namespace {

constexpr double kPanelPixels = 420;  // the longest axis
constexpr std::int64_t kMargin = 10;
constexpr std::int64_t kTitleRows = 34;
constexpr double kLetterPixels = 15;
constexpr Color kNearColor = {80, 220, 120};
constexpr Color kWideColor = {255, 200, 40};
constexpr Color kFarColor = {255, 70, 60};

/// What is seen along an axis: the other two, to the right and down.
struct PoseView {
  int along;
  int right;
  int down;
  const char* title;
};
constexpr std::array<PoseView, 3> kPoseViews = {
    {{2, 0, 1, "along z"}, {1, 0, 2, "along y"}, {0, 1, 2, "along x"}}};

/// Voxels of the mask along each axis.
using Shadows = std::array<std::vector<std::int32_t>, 3>;

Shadows shadows_of(const MaskTree& mask) {
  const Size3& size = mask.size();
  Shadows shadows;
  for (std::size_t i = 0; i < 3; ++i) {
    shadows[i].resize(
        static_cast<std::size_t>(size[kPoseViews[i].right] * size[kPoseViews[i].down]));
  }
  std::vector<std::uint8_t> plane(static_cast<std::size_t>(size.x * size.y));
  for (std::int64_t z = 0; z < size.z; ++z) {
    fill_voxels(mask, {{0, 0, z}, {size.x, size.y, z + 1}}, plane.data());
    std::size_t at = 0;
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x, ++at) {
        if (plane[at] == 0) continue;
        ++shadows[0][at];
        ++shadows[1][static_cast<std::size_t>(z * size.x + x)];
        ++shadows[2][static_cast<std::size_t>(z * size.y + y)];
      }
    }
  }
  return shadows;
}

/// A view in its place on the picture.
struct PosePanel {
  PoseView view;
  std::int64_t left = 0;
  std::int64_t top = 0;
  std::array<double, 2> pixels_per_voxel{};
  std::array<std::int64_t, 2> sides{};
  bool is_upright = false;  ///< z grows upward

  std::int64_t row(double y) const {
    const auto at = static_cast<std::int64_t>(std::floor(y));
    return top + (is_upright ? sides[1] - 1 - at : at);
  }
};

void draw_shadow(Picture& picture, const PosePanel& panel, const std::vector<std::int32_t>& shadow,
                 std::int64_t width) {
  const std::int32_t most = std::max(1, *std::max_element(shadow.begin(), shadow.end()));
  for (std::int64_t y = 0; y < panel.sides[1]; ++y) {
    const auto row = static_cast<std::int64_t>(static_cast<double>(y) / panel.pixels_per_voxel[1]);
    for (std::int64_t x = 0; x < panel.sides[0]; ++x) {
      const auto column =
          static_cast<std::int64_t>(static_cast<double>(x) / panel.pixels_per_voxel[0]);
      const double part = static_cast<double>(shadow[static_cast<std::size_t>(
                              row * width + column)]) / most;
      const auto grey = static_cast<std::uint8_t>(24 + 180 * std::sqrt(part));
      picture.set(panel.left + x, panel.row(static_cast<double>(y)), {grey, grey, grey});
    }
  }
}

void draw_places(Picture& picture, const PosePanel& panel, const Geometry& geometry,
                 const std::vector<PosedPlace>& places, double near_mm) {
  for (const PosedPlace& place : places) {
    const Point3 index = geometry.to_index(place.place);
    const double x =
        (index[static_cast<std::size_t>(panel.view.right)] + 0.5) * panel.pixels_per_voxel[0];
    const double y =
        (index[static_cast<std::size_t>(panel.view.down)] + 0.5) * panel.pixels_per_voxel[1];
    if (!(x >= 0 && y >= 0 && x < static_cast<double>(panel.sides[0]) &&
          y < static_cast<double>(panel.sides[1]))) {
      continue;
    }
    const double mm = std::abs(place.mm);
    const Color& color =
        mm <= near_mm ? kNearColor : mm <= 2 * near_mm ? kWideColor : kFarColor;
    for (int i = 0; i < 4; ++i) {
      const std::int64_t column = panel.left + static_cast<std::int64_t>(x) + i % 2;
      picture.blend(column, panel.row(y) + i / 2, color, 0.8);
    }
  }
}

}  // namespace

Picture pose_picture(const MaskTree& mask, const Geometry& geometry,
                     const std::vector<PosedPlace>& places, double near_mm) {
  const Size3& size = mask.size();
  Point3 side_mm{};
  for (int a = 0; a < 3; ++a) {
    side_mm[static_cast<std::size_t>(a)] =
        geometry.spacing_mm[static_cast<std::size_t>(a)] * static_cast<double>(size[a]);
  }
  const double pixels_per_mm = kPanelPixels / *std::max_element(side_mm.begin(), side_mm.end());

  // Where the panels are.
  std::array<PosePanel, 3> panels;
  std::int64_t width = kMargin;
  std::int64_t height = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    PosePanel& panel = panels[i];
    panel.view = kPoseViews[i];
    panel.left = width;
    panel.top = kTitleRows;
    panel.is_upright = panel.view.down == 2;
    const std::array<int, 2> axes = {panel.view.right, panel.view.down};
    for (std::size_t a = 0; a < 2; ++a) {
      panel.pixels_per_voxel[a] =
          pixels_per_mm * geometry.spacing_mm[static_cast<std::size_t>(axes[a])];
      panel.sides[a] = std::max<std::int64_t>(
          1, static_cast<std::int64_t>(panel.pixels_per_voxel[a] *
                                       static_cast<double>(size[axes[a]])));
    }
    width += panel.sides[0] + kMargin;
    height = std::max(height, panel.sides[1]);
  }

  Picture picture = make_picture(width, height + kTitleRows + kMargin, 3);
  const Lettering letters(kLetterPixels);
  const Shadows shadows = shadows_of(mask);
  for (std::size_t i = 0; i < 3; ++i) {
    draw_shadow(picture, panels[i], shadows[i], size[panels[i].view.right]);
    draw_places(picture, panels[i], geometry, places, near_mm);
    letters.draw(picture, panels[i].left, kMargin, panels[i].view.title);
  }
  return picture;
}

}  // namespace octavo
