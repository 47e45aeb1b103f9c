#include "octavo/render/cubes/cube_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "octavo/render/cubes/cube_traversal.h"
#include "octavo/render/cubes/face_raster.h"
#include "octavo/render/cubes/nearest_rows.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

std::uint32_t packed(const Color& color) {
  return std::uint32_t{color[0]} | std::uint32_t{color[1]} << 8 | std::uint32_t{color[2]} << 16;
}

/// A color times a number of 256ths.
std::uint32_t dimmed(std::uint32_t pixel, std::uint32_t by) {
  const std::uint32_t red_and_blue = ((pixel & 0xff00ff) * by >> 8) & 0xff00ff;
  const std::uint32_t green = ((pixel & 0x00ff00) * by >> 8) & 0x00ff00;
  return red_and_blue | green;
}

/// How bright the faces across an index axis are, 0 .. 1: light falls from the upper left, over the
/// viewer's shoulder.
double brightness(const View& view, std::size_t axis) {
  const auto in_mm = [&](std::size_t a) {
    // The step along an index axis in the picture's own axes.
    const Place& p = view.axes[a];
    return Point3{static_cast<double>(p.x), -static_cast<double>(p.y),
                  static_cast<double>(p.depth)};
  };
  const Point3 b = in_mm((axis + 1) % 3);
  const Point3 c = in_mm((axis + 2) % 3);
  Point3 normal{b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]};
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  const double towards = normal[2] < 0 ? -1 : 1;
  constexpr Point3 kLight = {-0.40, 0.64, 0.66};
  double cosine = 0;
  for (std::size_t i = 0; i < 3; ++i) cosine += kLight[i] * normal[i] * towards / length;
  constexpr double kAmbient = 0.4;
  return kAmbient + (1 - kAmbient) * std::max(cosine, 0.0);
}

/// What all bands share.
class Scene {
 public:
  Scene(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style)
      : view_(view), depths_(view, style) {
    for (const PaintedMask& mask : masks) {
      trees_.push_back(mask.tree);
      colors_.push_back(packed(mask.color));
    }
    const int top = masks.empty() ? 0 : 2 * (masks.front().tree->rank_count() + 1);
    for (int level = 0; level <= top; ++level) shapes_.push_back(cube_shape(view, level));
    has_spines_ = style.keeps_thin && !shapes_.front().spine.empty();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (view.nearness[axis] != 0) shades_[axis] = 256 * brightness(view, axis);
    }
  }

  const View& view() const { return view_; }
  std::span<const MaskTree* const> trees() const { return trees_; }
  const CubeShape& shape(int level) const { return shapes_[static_cast<std::size_t>(level)]; }

  /// Draws those faces of a leaf whose axes have a bit in `faces`.
  template <class Rows>
  void fill(std::size_t mask, const Place& corner, const CubeShape& shape, unsigned faces,
            Rows& rows) const {
    for (int i = 0; i < shape.face_count; ++i) {
      const Face& face = shape.faces[static_cast<std::size_t>(i)];
      if ((faces >> face.axis & 1) == 0) continue;
      rows.fill(face, corner, pixel(mask, face, corner.depth + face.depth));
    }
  }

  /// Whether some cubes are so thin that they have spines.
  bool has_spines() const { return has_spines_; }

  std::uint32_t pixel(std::size_t mask, const Face& face, std::int64_t depth) const {
    return pixel(mask, shades_[static_cast<std::size_t>(face.axis)], depth);
  }

  /// Of a spine: as bright as the faces are together.
  std::uint32_t spine_pixel(std::size_t mask, const Place& corner, const CubeShape& shape,
                            unsigned faces) const {
    double area = 0;
    double shade = 0;
    for (int i = 0; i < shape.face_count; ++i) {
      const Face& face = shape.faces[static_cast<std::size_t>(i)];
      if ((faces >> face.axis & 1) == 0) continue;
      area += face.area();
      shade += face.area() * shades_[static_cast<std::size_t>(face.axis)];
    }
    const Face& largest = shape.largest_face(faces);
    if (area > 0) return pixel(mask, shade / area, corner.depth + largest.depth);
    return pixel(mask, largest, corner.depth + largest.depth);
  }

 private:
  std::uint32_t pixel(std::size_t mask, double shade, std::int64_t depth) const {
    const double near = depths_.nearness(static_cast<double>(depth));
    const double share = shade * depths_.brightness(near);
    return dimmed(colors_[mask], static_cast<std::uint32_t>(share));
  }

  View view_;
  std::vector<const MaskTree*> trees_;
  std::vector<std::uint32_t> colors_;
  std::vector<CubeShape> shapes_;   ///< by level
  std::array<double, 3> shades_{};  ///< by axis, 256 is as bright as the mask's color
  DepthFade depths_;
  bool has_spines_ = false;
};

/// Draws the leaves of a traversal into some rows.
template <class Rows>
class LeafPainter {
 public:
  LeafPainter(const Scene& scene, PixelRows& rows) : scene_(scene), rows_(rows) {}

  bool misses(const Place& corner, int level) const {
    return rows_.misses(scene_.shape(level), corner);
  }

  /// Leaves out the faces that others cover.
  void draw(std::size_t mask, const Place& corner, int level, unsigned faces) {
    const CubeShape& shape = scene_.shape(level);
    if (faces != 0 && !rows_.misses(shape, corner)) {
      scene_.fill(mask, corner, shape, faces, rows_);
    }
  }

 private:
  const Scene& scene_;
  Rows rows_;
};

/// Notes what pixels show, the nearest first, with the spines of thin leaves.
class SpinePainter {
 public:
  SpinePainter(const Scene& scene, std::int64_t begin, std::int64_t end)
      : scene_(scene),
        faces_(scene.view(), begin, end, 0, true),
        spines_(scene.view(), begin, end, 0),
        rows_(faces_, &spines_) {}

  bool misses(const Place& corner, int level) const {
    return rows_.misses(scene_.shape(level), corner);
  }

  void draw(std::size_t mask, const Place& corner, int level, unsigned faces) {
    const CubeShape& shape = scene_.shape(level);
    if (faces == 0 || rows_.misses(shape, corner)) return;
    for (int i = 0; i < shape.face_count; ++i) {
      const Face& face = shape.faces[static_cast<std::size_t>(i)];
      if ((faces >> face.axis & 1) == 0 || !rows_.fill(face, corner, next_number())) continue;
      note(mask, scene_.pixel(mask, face, corner.depth + face.depth));
    }
    if (shape.spine.empty() || !rows_.fill_spine(shape, corner, next_number())) return;
    note(mask, scene_.spine_pixel(mask, corner, shape, faces));
  }

  /// Gives the pixels of `rows` that show something its color.
  void color(PixelRows& rows) const {
    const auto mask_of = [&](std::uint32_t number) { return seen_[number - 1].mask; };
    for (std::int64_t y = rows.begin(); y < rows.end(); ++y) {
      for (std::int64_t x = 0; x < rows.width(); ++x) {
        const std::uint32_t number = seen_number(faces_.row(y)[x], spines_.row(y)[x], mask_of);
        if (number != 0) rows.row(y)[x] = seen_[number - 1].pixel;
      }
    }
  }

 private:
  struct Seen {
    std::uint32_t mask;
    std::uint32_t pixel;
  };

  std::uint32_t next_number() const { return static_cast<std::uint32_t>(seen_.size() + 1); }
  void note(std::size_t mask, std::uint32_t pixel) {
    seen_.push_back({static_cast<std::uint32_t>(mask), pixel});
  }

  const Scene& scene_;
  PixelRows faces_;
  PixelRows spines_;
  NearestRows rows_;
  std::vector<Seen> seen_;
};

void copy_rows(const PixelRows& rows, Picture& picture) {
  for (std::int64_t y = rows.begin(); y < rows.end(); ++y) {
    const std::uint32_t* const from = rows.row(y);
    std::uint8_t* to = picture.pixels.data() + y * picture.width * 3;
    for (std::int64_t x = 0; x < picture.width; ++x) {
      *to++ = static_cast<std::uint8_t>(from[x]);
      *to++ = static_cast<std::uint8_t>(from[x] >> 8);
      *to++ = static_cast<std::uint8_t>(from[x] >> 16);
    }
  }
}

/// Rows is PixelRows& or NearestRows.
template <class Rows>
Picture draw(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style,
             TraversalOrder order) {
  const Scene scene(masks, view, style);
  Picture picture = make_picture(view.width, view.height, 3);
  const std::int64_t bands = (view.height + kBandRows - 1) / kBandRows;
  parallel_for(std::int64_t{0}, bands, [&](std::int64_t band) {
    const std::int64_t begin = band * kBandRows;
    PixelRows rows(view, begin, std::min(view.height, begin + kBandRows), packed(style.background));
    if (scene.has_spines()) {
      SpinePainter painter(scene, rows.begin(), rows.end());
      CubeTraversal(scene.trees(), view, TraversalOrder::nearest_first, painter).run();
      painter.color(rows);
    } else {
      LeafPainter<Rows> painter(scene, rows);
      CubeTraversal(scene.trees(), view, order, painter).run();
    }
    copy_rows(rows, picture);
  });
  return picture;
}

}  // namespace

DepthFade::DepthFade(const View& view, const CubeStyle& style)
    : fade_(std::clamp(style.fade, 0.0, 1.0)) {
  std::int64_t nearest = view.place_of(style.shown.lo).depth;
  std::int64_t farthest = nearest;
  for (int axis = 0; axis < 3; ++axis) {
    const Place across = view.axes[static_cast<std::size_t>(axis)] * style.shown.size()[axis];
    (across.depth > 0 ? nearest : farthest) += across.depth;
  }
  farthest_ = static_cast<double>(farthest);
  per_depth_ = 1 / static_cast<double>(std::max<std::int64_t>(1, nearest - farthest));
}

double DepthFade::nearness(double depth) const {
  return std::clamp((depth - farthest_) * per_depth_, 0.0, 1.0);
}

Picture draw_cubes(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style) {
  return draw<PixelRows&>(masks, view, style, TraversalOrder::farthest_first);
}

Picture draw_nearest_cubes(std::span<const PaintedMask> masks, const View& view,
                           const CubeStyle& style) {
  return draw<NearestRows>(masks, view, style, TraversalOrder::nearest_first);
}

}  // namespace octavo
