#include "octavo/render/cubes/relief_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/render/cubes/cube_traversal.h"
#include "octavo/render/cubes/face_raster.h"
#include "octavo/render/cubes/nearest_rows.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr int kBlockShift = 4;  // blocks of 16^3 samples
constexpr std::int64_t kBlockSide = std::int64_t{1} << kBlockShift;
constexpr std::uint32_t kNoFace = 0;  // of a pixel that no face has

// Light from the upper left over the viewer's shoulder, some from the viewer, some from all around.
constexpr Point3 kLight = {-0.40, 0.64, 0.66};
constexpr double kAmbient = 0.14;
constexpr double kDiffuse = 0.58;
constexpr double kHeadlight = 0.34;
constexpr double kGloss = 0.16;
constexpr double kGlossPower = 18;
constexpr double kTurnedAway = 0.35;
constexpr double kBefore = 0.7;  // voxels

/// A view with twice as many pixels along each side, on the same units.
View refined(const View& view) {
  View fine = view;
  if (view.fraction_bits < 2) return fine;
  --fine.fraction_bits;
  fine.width *= 2;
  fine.height *= 2;
  fine.pixel_mm /= 2;
  return fine;
}

/// From places in a picture back to places on the grid: a corner of a voxel has whole numbers.
class GridFromPicture {
 public:
  explicit GridFromPicture(const View& view) : origin_(view.origin) {
    const auto axis = [&](std::size_t a) {
      const Place& p = view.axes[a];
      return Point3{static_cast<double>(p.x), static_cast<double>(p.y),
                    static_cast<double>(p.depth)};
    };
    for (std::size_t a = 0; a < 3; ++a) {
      const Point3 normal = cross(axis((a + 1) % 3), axis((a + 2) % 3));
      const double volume = dot(normal, axis(a));
      rows_[a] = {normal[0] / volume, normal[1] / volume, normal[2] / volume};
    }
  }

  /// How an index grows along x, y and depth of the picture.
  const Point3& row(std::size_t axis) const { return rows_[axis]; }

  double index(std::size_t axis, const Place& place) const {
    return dot(rows_[axis],
               {static_cast<double>(place.x - origin_.x), static_cast<double>(place.y - origin_.y),
                static_cast<double>(place.depth - origin_.depth)});
  }

  /// Where the ray of a pixel meets the plane index[axis] = plane, and how deep that is.
  Point3 point(double x, double y, std::size_t axis, double plane, double& depth) const {
    const double dx = x - static_cast<double>(origin_.x);
    const double dy = y - static_cast<double>(origin_.y);
    const double dz = (plane - rows_[axis][0] * dx - rows_[axis][1] * dy) / rows_[axis][2];
    depth = dz + static_cast<double>(origin_.depth);
    Point3 at;
    for (std::size_t a = 0; a < 3; ++a) at[a] = dot(rows_[a], {dx, dy, dz});
    at[axis] = plane;
    return at;
  }

 private:
  Place origin_;
  std::array<Point3, 3> rows_;
};

/// A face that some pixel shows.
struct SeenFace {
  std::uint32_t mask = 0;
  std::uint32_t axis = 0;
  std::int64_t plane = 0;  ///< index of its corners along the axis
  std::uint32_t spine = 0;  ///< its number among spines, from 1; 0: what it shows is the face
};

/// The middle of the largest face of a leaf, of which all pixels of a spine have the light.
struct SpineMiddle {
  Point3 corner{};  ///< as corners of voxels are counted
  double depth = 0;
};

/// Notes the face at each pixel: its number in `faces`, from 1.
class FaceNoter {
 public:
  FaceNoter(const View& view, const GridFromPicture& grid, std::span<const CubeShape> shapes,
            PixelRows& rows, PixelRows* spine_rows, std::vector<SeenFace>& faces,
            std::vector<SpineMiddle>& middles)
      : view_(view),
        grid_(grid),
        shapes_(shapes),
        rows_(rows, spine_rows),
        has_spines_(spine_rows != nullptr),
        faces_(faces),
        middles_(middles) {}

  bool misses(const Place& corner, int level) const {
    return rows_.misses(shapes_[static_cast<std::size_t>(level)], corner);
  }

  void draw(std::size_t mask, const Place& corner, int level, unsigned bare) {
    const CubeShape& shape = shapes_[static_cast<std::size_t>(level)];
    if (bare == 0 || rows_.misses(shape, corner)) return;
    for (int i = 0; i < shape.face_count; ++i) {
      const Face& face = shape.faces[static_cast<std::size_t>(i)];
      if ((bare >> face.axis & 1) == 0) continue;
      if (rows_.fill(face, corner, next_number())) note(mask, face, corner, level);
    }
    if (!has_spines_ || shape.spine.empty()) return;
    if (!rows_.fill_spine(shape, corner, next_number())) return;
    const Face& face = shape.largest_face(bare);
    note(mask, face, corner, level);
    SpineMiddle middle;
    for (std::size_t a = 0; a < 3; ++a) {
      middle.corner[a] = grid_.index(a, corner) + std::ldexp(0.5, level);
    }
    middle.corner[static_cast<std::size_t>(face.axis)] =
        static_cast<double>(faces_.back().plane);
    middle.depth = static_cast<double>(corner.depth + face.depth);
    middles_.push_back(middle);
    faces_.back().spine = static_cast<std::uint32_t>(middles_.size());
  }

 private:
  std::uint32_t next_number() const { return static_cast<std::uint32_t>(faces_.size() + 1); }

  void note(std::size_t mask, const Face& face, const Place& corner, int level) {
    const auto axis = static_cast<std::size_t>(face.axis);
    const std::int64_t low = std::llround(grid_.index(axis, corner));
    const std::int64_t far_side = view_.nearness[axis] > 0 ? std::int64_t{1} << level : 0;
    faces_.push_back(
        {static_cast<std::uint32_t>(mask), static_cast<std::uint32_t>(axis), low + far_side, 0});
  }

  const View& view_;
  const GridFromPicture& grid_;
  std::span<const CubeShape> shapes_;
  NearestRows rows_;
  bool has_spines_;
  std::vector<SeenFace>& faces_;
  std::vector<SpineMiddle>& middles_;
};

/// The gradient of a smoothed field in one block.
class BlockGradient {
 public:
  BlockGradient(const ReliefField& relief, std::size_t field, const Index3& block) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      first_[axis] = block[axis] * kBlockSide;
      box.lo[axis] = first_[axis] - 1;
      box.hi[axis] = first_[axis] + kBlockSide + 2;
    }
    values_ = smoothed(relief, field, box);
  }

  /// Per sample along each axis. Requires a place in the block, in samples.
  Point3 at(const Point3& place) const {
    std::array<std::int64_t, 3> low{};
    Point3 share{};
    for (std::size_t a = 0; a < 3; ++a) {
      const double inside = std::clamp(place[a] - static_cast<double>(first_[static_cast<int>(a)]),
                                       0.0, static_cast<double>(kBlockSide));
      low[a] = std::min(static_cast<std::int64_t>(inside), kBlockSide - 1);
      share[a] = inside - static_cast<double>(low[a]);
    }
    Point3 sum{};
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::array<std::int64_t, 3> at_corner{};
      for (std::size_t a = 0; a < 3; ++a) {
        const int high = corner >> a & 1;
        weight *= high != 0 ? share[a] : 1 - share[a];
        at_corner[a] = low[a] + high + 1;
      }
      const std::int64_t center = (at_corner[2] * kSide + at_corner[1]) * kSide + at_corner[0];
      constexpr std::array<std::int64_t, 3> kSteps = {1, kSide, kSide * kSide};
      for (std::size_t a = 0; a < 3; ++a) {
        sum[a] += weight * (value(center + kSteps[a]) - value(center - kSteps[a])) / 2;
      }
    }
    return sum;
  }

 private:
  static constexpr std::int64_t kSide = kBlockSide + 3;

  double value(std::int64_t at) const {
    return static_cast<double>(values_[static_cast<std::size_t>(at)]);
  }

  Index3 first_;
  std::vector<float> values_;
};

/// What all bands share.
class ReliefScene {
 public:
  ReliefScene(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style,
              const ReliefField& field, const Box& kept)
      : view_(view), grid_(view), style_(style), field_(field), kept_(kept), depths_(view, style) {
    for (const PaintedMask& mask : masks) {
      trees_.push_back(mask.tree);
      colors_.push_back(mask.color);
    }
    const int top = masks.empty() ? 0 : 2 * (masks.front().tree->rank_count() + 1);
    for (int level = 0; level <= top; ++level) shapes_.push_back(cube_shape(view, level));
  }

  /// Draws rows begin .. end - 1 of the view: three numbers of 0 .. 255 per pixel.
  std::vector<float> draw(std::int64_t begin, std::int64_t end) const {
    const bool has_spines = style_.keeps_thin && !shapes_.front().spine.empty();
    PixelRows rows(view_, begin, end, kNoFace, has_spines);
    std::optional<PixelRows> spine_rows;
    if (has_spines) spine_rows.emplace(view_, begin, end, kNoFace);
    std::vector<SeenFace> faces;
    std::vector<SpineMiddle> middles;
    FaceNoter noter(view_, grid_, shapes_, rows, spine_rows ? &*spine_rows : nullptr, faces,
                    middles);
    CubeTraversal(trees_, view_, TraversalOrder::nearest_first, noter).run();
    if (spine_rows) {
      const auto mask_of = [&](std::uint32_t number) { return faces[number - 1].mask; };
      for (std::int64_t y = begin; y < end; ++y) {
        for (std::int64_t x = 0; x < view_.width; ++x) {
          rows.row(y)[x] = seen_number(rows.row(y)[x], spine_rows->row(y)[x], mask_of);
        }
      }
    }

    // Find where each pixel meets its face; points of one block and field follow one another.
    std::vector<Point> points = points_of(rows, faces, middles);
    const auto field_of = [&](const Point& point) {
      return field_.field_of(faces[point.face].mask);
    };
    std::sort(points.begin(), points.end(), [&](const Point& a, const Point& b) {
      return std::tuple(a.block, field_of(a), a.pixel) < std::tuple(b.block, field_of(b), b.pixel);
    });

    std::vector<float> colors(static_cast<std::size_t>(3 * view_.width * (end - begin)));
    for (std::size_t i = 0; i < colors.size(); ++i) {
      colors[i] = static_cast<float>(style_.background[i % 3]);
    }
    for (std::size_t i = 0; i < points.size();) {
      const std::uint64_t block = points[i].block;
      const std::size_t field = field_of(points[i]);
      const BlockGradient gradient(field_, field, block_at(block));
      for (; i < points.size() && points[i].block == block && field_of(points[i]) == field; ++i) {
        shade(points[i], faces, gradient, colors.data() + 3 * points[i].pixel);
      }
    }
    return colors;
  }

 private:
  struct Point {
    std::uint64_t block = 0;
    std::uint32_t pixel = 0;
    std::uint32_t face = 0;
    std::array<float, 3> place{};  ///< samples, from the block's first
    float depth = 0;               ///< 0 far .. 1 near
  };

  // Blocks begin one before the grid.
  static std::uint64_t key_of(const Index3& block) {
    return static_cast<std::uint64_t>(block.z + 1) << 42 |
           static_cast<std::uint64_t>(block.y + 1) << 21 | static_cast<std::uint64_t>(block.x + 1);
  }

  static Index3 block_at(std::uint64_t key) {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
    return {static_cast<std::int64_t>(key & kMask) - 1,
            static_cast<std::int64_t>(key >> 21 & kMask) - 1,
            static_cast<std::int64_t>(key >> 42) - 1};
  }

  static std::size_t seen_count(const PixelRows& rows) {
    std::size_t count = 0;
    for (std::int64_t y = rows.begin(); y < rows.end(); ++y) {
      const std::uint32_t* const row = rows.row(y);
      const auto is_seen = [](std::uint32_t number) { return number != kNoFace; };
      count += static_cast<std::size_t>(std::count_if(row, row + rows.width(), is_seen));
    }
    return count;
  }

  std::vector<Point> points_of(const PixelRows& rows, const std::vector<SeenFace>& faces,
                               const std::vector<SpineMiddle>& middles) const {
    std::vector<Point> points;
    points.reserve(seen_count(rows));
    const std::int64_t unit = std::int64_t{1} << view_.fraction_bits;
    for (std::int64_t y = rows.begin(); y < rows.end(); ++y) {
      const std::uint32_t* const row = rows.row(y);
      for (std::int64_t x = 0; x < view_.width; ++x) {
        if (row[x] == kNoFace) continue;
        const SeenFace& face = faces[row[x] - 1];
        SpineMiddle met;
        if (face.spine != 0) {
          met = middles[face.spine - 1];
        } else {
          met.corner = grid_.point(static_cast<double>(x * unit + unit / 2),
                                   static_cast<double>(y * unit + unit / 2), face.axis,
                                   static_cast<double>(face.plane), met.depth);
        }
        Point3 corner = met.corner;
        // Before the face, where a wall as thin as a voxel has a gradient as well.
        corner[face.axis] += kBefore * view_.nearness[face.axis];
        Point point;
        Index3 block;
        for (int a = 0; a < 3; ++a) {
          // Samples lie in the middle of voxels.
          const double sample = corner[static_cast<std::size_t>(a)] - 0.5;
          block[a] = static_cast<std::int64_t>(std::floor(sample)) >> kBlockShift;
          point.place[static_cast<std::size_t>(a)] =
              static_cast<float>(sample - static_cast<double>(block[a] * kBlockSide));
        }
        point.block = key_of(block);
        point.pixel = static_cast<std::uint32_t>((y - rows.begin()) * view_.width + x);
        point.face = row[x] - 1;
        point.depth = static_cast<float>(depths_.nearness(met.depth));
        points.push_back(point);
      }
    }
    return points;
  }

  /// The normal of a face in the picture: right, up, towards the viewer.
  Point3 face_normal(std::size_t axis) const {
    const Point3& row = grid_.row(axis);
    const double sign = row[2] < 0 ? -1 : 1;
    return unit({sign * row[0], -sign * row[1], sign * row[2]});
  }

  bool is_cut(const SeenFace& face) const {
    const int axis = static_cast<int>(face.axis);
    return field_.is_cut_at_border() &&
           (face.plane == kept_.lo[axis] || face.plane == kept_.hi[axis]);
  }

  Point3 normal_at(const Point& point, const SeenFace& face, const BlockGradient& gradient) const {
    const Point3 straight = face_normal(face.axis);
    if (is_cut(face)) return straight;
    const Index3 block = block_at(point.block);
    Point3 place{};
    for (std::size_t a = 0; a < 3; ++a) {
      place[a] = static_cast<double>(block[static_cast<int>(a)] * kBlockSide) +
                 static_cast<double>(point.place[a]);
    }
    const Point3 g = gradient.at(place);
    Point3 normal{};
    for (std::size_t a = 0; a < 3; ++a) {
      const Point3& row = grid_.row(a);
      for (std::size_t i = 0; i < 3; ++i) normal[i] -= g[a] * row[i];
    }
    normal[1] = -normal[1];
    const double length = std::sqrt(dot(normal, normal));
    if (!(length > 0) || !std::isfinite(length)) return straight;
    // Beyond a thin wall the field may rise again; then the normal is the other way round. But the
    // steps of a slanted surface have faces that are turned away from it a little.
    const double sign = dot(normal, straight) < -kTurnedAway * length ? -1 : 1;
    return {sign * normal[0] / length, sign * normal[1] / length, sign * normal[2] / length};
  }

  void shade(const Point& point, const std::vector<SeenFace>& faces, const BlockGradient& gradient,
             float* color) const {
    static const Point3 half_way = unit({kLight[0], kLight[1], kLight[2] + 1});
    const SeenFace& face = faces[point.face];
    const Point3 normal = normal_at(point, face, gradient);
    const double light = kAmbient + kDiffuse * std::max(0.0, dot(normal, kLight)) +
                         kHeadlight * std::max(0.0, normal[2]);
    const double gloss = kGloss * std::pow(std::max(0.0, dot(normal, half_way)), kGlossPower);
    const double share = depths_.brightness(static_cast<double>(point.depth));
    for (std::size_t c = 0; c < 3; ++c) {
      const double mixed = share * (light * colors_[face.mask][c] + 255 * gloss);
      color[c] = static_cast<float>(std::min(255.0, mixed));
    }
  }

  View view_;
  GridFromPicture grid_;
  CubeStyle style_;
  const ReliefField& field_;
  Box kept_;
  DepthFade depths_;
  std::vector<const MaskTree*> trees_;
  std::vector<Color> colors_;
  std::vector<CubeShape> shapes_;
};

/// The mean of `side` x `side` points for each pixel of rows begin .. end - 1.
void copy_mean(const std::vector<float>& colors, std::int64_t side, std::int64_t begin,
               std::int64_t end, Picture& picture) {
  const std::int64_t stride = 3 * picture.width * side;
  std::uint8_t* to = picture.pixels.data() + 3 * begin * picture.width;
  for (std::int64_t y = 0; y < end - begin; ++y) {
    for (std::int64_t x = 0; x < picture.width; ++x) {
      for (std::int64_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (std::int64_t v = 0; v < side; ++v) {
          for (std::int64_t u = 0; u < side; ++u) {
            const std::int64_t at = (y * side + v) * stride + 3 * (x * side + u) + c;
            sum += static_cast<double>(colors[static_cast<std::size_t>(at)]);
          }
        }
        *to++ = static_cast<std::uint8_t>(std::lround(sum / static_cast<double>(side * side)));
      }
    }
  }
}

}  // namespace

std::uint64_t relief_memory_bytes(std::int64_t width, std::int64_t height, int threads) {
  // Of a band where every point shows a cube of its own: faces, spines, points and their colors
  constexpr std::int64_t kBytesPerPixel = 200;
  const std::int64_t bands = (height + kBandRows - 1) / kBandRows;
  const std::int64_t at_once = std::min<std::int64_t>(bands, threads);
  return static_cast<std::uint64_t>(at_once) * static_cast<std::uint64_t>(kBandRows * width) *
         kBytesPerPixel;
}

Picture draw_relief(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style,
                    const ReliefField& field, const Box& kept) {
  const View fine = refined(view);
  const std::int64_t side = fine.width / view.width;
  const ReliefScene scene(masks, fine, style, field, kept);
  Picture picture = make_picture(view.width, view.height, 3);
  const std::int64_t bands = (view.height + kBandRows - 1) / kBandRows;
  parallel_for(std::int64_t{0}, bands, [&](std::int64_t band) {
    const std::int64_t begin = band * kBandRows;
    const std::int64_t end = std::min(view.height, begin + kBandRows);
    copy_mean(scene.draw(begin * side, end * side), side, begin, end, picture);
  });
  return picture;
}

}  // namespace octavo
