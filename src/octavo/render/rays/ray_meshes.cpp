#include "octavo/render/rays/ray_meshes.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/render/rays/mesh_raster.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

/// Shares of triangles that are flatter are no numbers.
constexpr double kFlattest = 1e-200;
/// Nothing nearer to the eye than this share of its distance is seen.
constexpr double kNearestShare = 1e-4;
/// What reaches so little further is not followed: rays end there as well.
constexpr double kNothingLeft = 0.005;

Point3 doubles(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

/// Where a point lies for rays: t (1, u, v), of parallel ones t = 1 and k besides.
struct HomogeneousPoint {
  Point3 at{};   // t, t u, t v
  double k = 0;  // parallel rays
};

/// From world space to the rays of a frame.
class MeshCamera {
 public:
  MeshCamera(const Geometry& geometry, const RayFrame& frame)
      : has_eye_(frame.eye_pixels > 0), eye_pixels_(frame.eye_pixels),
        step_pixels_(frame.step_pixels) {
    const Point3 across = doubles(has_eye_ ? frame.direction_across : frame.origin_across);
    const Point3 down = doubles(has_eye_ ? frame.direction_down : frame.origin_down);
    const Point3 along = doubles(frame.direction);
    const double by = 1 / dot(across, cross(down, along));
    const std::array<Point3, 3> rows = {scaled(cross(down, along), by),
                                        scaled(cross(along, across), by),
                                        scaled(cross(across, down), by)};
    // Both steps at once: world to samples, samples to rays.
    const Point3 zero = geometry.to_index({0, 0, 0});
    const Point3 first = difference(zero, doubles(frame.origin));
    for (std::size_t i = 0; i < 3; ++i) {
      offset_[i] = dot(rows[i], first);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        Point3 world{};
        world[axis] = 1;
        rows_[i][axis] = dot(rows[i], difference(geometry.to_index(world), zero));
      }
    }
  }

  HomogeneousPoint place_of(const Point3& world) const {
    const double u = dot(rows_[0], world) + offset_[0];
    const double v = dot(rows_[1], world) + offset_[1];
    const double along = dot(rows_[2], world) + offset_[2];
    if (has_eye_) return {{along, u, v}, 0};
    return {{1, u, v}, along};
  }

  bool has_eye() const { return has_eye_; }
  /// Steps from the eye along the ray through (u, v) to where it is t.
  double steps(double t, double u, double v) const {
    return t * std::sqrt(u * u + v * v + eye_pixels_ * eye_pixels_) / step_pixels_;
  }

 private:
  bool has_eye_;
  double eye_pixels_;
  double step_pixels_;
  std::array<Point3, 3> rows_{};
  Point3 offset_{};
};

/// A triangle on the picture: what is left of it in front of the eye and near the picture.
struct ScreenPolygon {
  std::array<ScreenPoint, PolygonEdges::kMostCorners> corners{};
  std::size_t count = 0;

  std::span<const ScreenPoint> span() const { return {corners.data(), count}; }
};

/// Keeps what lies where dot(plane, place) is 0 or more.
void clip_polygon(std::array<Point3, PolygonEdges::kMostCorners>& places, std::size_t& count,
                  const Point3& plane) {
  std::array<Point3, PolygonEdges::kMostCorners> kept{};
  std::size_t kept_count = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Point3& a = places[i];
    const Point3& b = places[(i + 1) % count];
    const double at_a = dot(plane, a);
    const double at_b = dot(plane, b);
    if (at_a >= 0 && kept_count < kept.size()) kept[kept_count++] = a;
    if ((at_a >= 0) != (at_b >= 0) && kept_count < kept.size()) {
      kept[kept_count++] = sum(a, scaled(difference(b, a), at_a / (at_a - at_b)));
    }
  }
  places = kept;
  count = kept_count;
}

/// middle  of the picture, pixels
ScreenPolygon screen_polygon(const std::array<HomogeneousPoint, 3>& corners, bool has_eye,
                             const ScreenPoint& middle) {
  constexpr double kFarthest = kFarthestCorner / 2;
  std::array<Point3, PolygonEdges::kMostCorners> places{};
  std::size_t count = 3;
  bool is_far = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point3& p = places[i] = corners[i].at;
    is_far = is_far || (has_eye && p[0] < kNearestShare) ||
             std::abs(p[1]) > kFarthest * p[0] || std::abs(p[2]) > kFarthest * p[0];
  }
  if (is_far) {
    // Near the eye first: what lies behind it is on no side of the picture. The plane of places
    // that are too near is that through the eye, moved by as much as clipping there would lose.
    if (has_eye) {
      for (std::size_t i = 0; i < 3; ++i) places[i][0] -= kNearestShare;
      clip_polygon(places, count, {1, 0, 0});
      for (std::size_t i = 0; i < count; ++i) places[i][0] += kNearestShare;
    }
    for (const double side : {-1.0, 1.0}) {
      clip_polygon(places, count, {kFarthest, side, 0});
      clip_polygon(places, count, {kFarthest, 0, side});
    }
  }
  ScreenPolygon polygon;
  polygon.count = count < 3 ? 0 : count;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    polygon.corners[i] = {places[i][1] / places[i][0] + middle.x,
                          places[i][2] / places[i][0] + middle.y};
  }
  return polygon;
}

/// What a triangle is along the rays that meet it: the shares of its corners there.
class TrianglePlane {
 public:
  explicit TrianglePlane(const std::array<HomogeneousPoint, 3>& corners) : corners_(corners) {
    const Point3& a = corners[0].at;
    const Point3& b = corners[1].at;
    const Point3& c = corners[2].at;
    rows_ = {cross(b, c), cross(c, a), cross(a, b)};
    determinant_ = dot(a, rows_[0]);
  }

  /// Whether it is more than a line to rays.
  bool is_seen() const { return std::abs(determinant_) > kFlattest; }

  /// The shares at (u, v), none below 0.
  Point3 shares(double u, double v) const {
    Point3 shares;
    double all = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      shares[i] = std::max(0.0, dot(rows_[i], {1, u, v}) / determinant_);
      all += shares[i];
    }
    return all > 0 ? scaled(shares, 1 / all) : Point3{1, 0, 0};
  }

  double k_at(const Point3& shares, double u, double v, const MeshCamera& camera) const {
    double k = 0;
    double t = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      k += shares[i] * corners_[i].k;
      t += shares[i] * corners_[i].at[0];
    }
    return camera.has_eye() ? camera.steps(t, u, v) : k;
  }

 private:
  const std::array<HomogeneousPoint, 3>& corners_;
  std::array<Point3, 3> rows_{};
  double determinant_ = 0;
};

/// The light on a surface: that of ray_portable.cpp, of normals in the axes of the picture.
class MeshLight {
 public:
  MeshLight(const RayLight& light, const View& view) : light_(light), view_(view) {}

  /// The color in light, 0xbbggrr, where a share of the lamp's comes. Requires a normal that has a
  /// length.
  std::uint32_t color(const Point3& normal, const Color& color, double lamp) const {
    Point3 seen = unit({dot(normal, view_.right), dot(normal, view_.up),
                        dot(normal, view_.toward)});
    if (seen[2] < 0) seen = scaled(seen, -1);
    const double lit =
        light_.ambient +
        lamp * light_.diffuse * std::max(0.0, dot(seen, doubles(light_.toward_light)));
    double shine = std::max(0.0, dot(seen, doubles(light_.halfway)));
    for (int i = 0; i < kShineSquares; ++i) shine *= shine;
    std::uint32_t packed = 0;
    for (std::size_t i = 0; i < color.size(); ++i) {
      const double share = color[i] / 255.0 * lit + lamp * light_.specular * shine;
      const long level = std::lround(std::clamp(share, 0.0, 1.0) * 255);
      packed |= static_cast<std::uint32_t>(level) << (8 * i);
    }
    return packed;
  }

 private:
  const RayLight& light_;
  const View& view_;
};

/// A triangle where it covers a pixel.
struct Fragment {
  float k = 0;
  float opacity = 0;
  std::uint32_t color = 0;
  std::uint16_t ray = 0;  // of the tile, row by row
  std::uint16_t mask = 0;
};

/// The number of each ray of a tile in its order, by row and column.
std::array<std::uint16_t, kTileRays> ray_numbers() {
  std::array<std::uint16_t, kTileRays> numbers{};
  for (std::size_t i = 0; i < kTileRays; ++i) {
    const auto row = static_cast<std::size_t>(kTileOrder.row[i]);
    numbers[row * kRayTileSide + static_cast<std::size_t>(kTileOrder.column[i])] =
        static_cast<std::uint16_t>(i);
  }
  return numbers;
}

/// The fragments of one ray as layers: what each takes of what the nearer ones let through.
void add_layers(std::span<const Fragment> fragments, std::vector<RayLayer>& layers) {
  std::array<double, kPlacesInPixel> left;
  left.fill(1);
  double before = 1;
  for (const Fragment& fragment : fragments) {
    double after = 0;
    for (std::size_t place = 0; place < kPlacesInPixel; ++place) {
      if (fragment.mask >> place & 1) left[place] *= 1 - static_cast<double>(fragment.opacity);
      after += left[place] / kPlacesInPixel;
    }
    const double opacity = 1 - after / before;
    if (opacity > 0) {
      layers.push_back({fragment.k, static_cast<float>(opacity), fragment.color});
    }
    if (after < kNothingLeft) return;
    before = after;
  }
}

/// Of a picture of rays: its triangles by tile, and their layers.
class MeshTiles {
 public:
  MeshTiles(const std::vector<RayMesh>& meshes, const RayMeshes::Options& options,
            const RayFrame& frame, std::int64_t width, std::int64_t height,
            const TileShare& share)
      : meshes_(meshes),
        options_(options),
        share_(share),
        camera_(options.geometry, frame),
        light_(frame.light, options.view),
        width_(width),
        height_(height),
        columns_(tiles_along(width)),
        rows_(tiles_along(height)),
        middle_{static_cast<double>(width) / 2, static_cast<double>(height) / 2} {
    for (const RayMesh& mesh : meshes_) {
      first_triangles_.push_back(triangle_count_);
      triangle_count_ += mesh.mesh->triangles.size();
    }
  }

  std::size_t tile_count() const { return static_cast<std::size_t>(columns_ * rows_); }

  /// Notes which triangles may cover pixels of which tiles.
  void sort(const Progress& watcher) {
    begins_.assign(tile_count() + 1, 0);
    visit_tiles(watcher, [&](std::size_t tile, std::uint32_t) { ++begins_[tile + 1]; });
    for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
    take_memory(begins_.back() * sizeof(std::uint32_t));
    triangles_.resize(begins_.back());
    std::vector<std::uint64_t> next(begins_.begin(), begins_.end() - 1);
    visit_tiles(watcher, [&](std::size_t tile, std::uint32_t triangle) {
      triangles_[next[tile]++] = triangle;
    });
  }

  TileLayers layers(std::size_t tile) {
    TileLayers result;
    std::vector<Fragment> fragments = fragments_of(tile);
    if (fragments.empty()) return result;
    // Where two are equally far the triangle with the lower number is in front.
    std::stable_sort(fragments.begin(), fragments.end(), [](const Fragment& a, const Fragment& b) {
      return a.ray != b.ray ? a.ray < b.ray : a.k < b.k;
    });
    auto first = fragments.begin();
    for (std::size_t ray = 0; ray < kTileRays; ++ray) {
      result.begins.push_back(static_cast<std::uint32_t>(result.layers.size()));
      const auto end = std::find_if(first, fragments.end(),
                                    [&](const Fragment& f) { return f.ray != ray; });
      add_layers({first, end}, result.layers);
      first = end;
    }
    result.begins.push_back(static_cast<std::uint32_t>(result.layers.size()));
    result.layers.shrink_to_fit();
    take_memory(result.layers.size() * sizeof(RayLayer) + sizeof(RayStops));
    return result;
  }

 private:
  void take_memory(std::uint64_t bytes) {
    if ((memory_ += bytes) > options_.memory_bytes) fail_memory();
  }

  [[noreturn]] void fail_memory() const {
    throw Error(ErrorKind::limit_exceeded,
                "the meshes cover so many pixels so often that lists of them take more than " +
                    bytes_text(options_.memory_bytes))
        .with_field("meshes.memory");
  }

  const RayMesh& mesh_of(std::uint32_t triangle, std::size_t& number) const {
    const auto after =
        std::upper_bound(first_triangles_.begin(), first_triangles_.end(), triangle);
    const auto mesh = static_cast<std::size_t>(after - first_triangles_.begin()) - 1;
    number = triangle - first_triangles_[mesh];
    return meshes_[mesh];
  }

  std::array<HomogeneousPoint, 3> corners_of(const TriangleMesh& mesh,
                                             const MeshTriangle& triangle) const {
    std::array<HomogeneousPoint, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      corners[i] = camera_.place_of(doubles(mesh.points[triangle[i]]));
    }
    return corners;
  }

  template <class Visit>
  void visit_tiles(const Progress& watcher, Visit&& visit) const {
    std::uint32_t number = 0;
    for (const RayMesh& mesh : meshes_) {
      for (const MeshTriangle& triangle : mesh.mesh->triangles) {
        constexpr std::uint32_t kTrianglesBetween = 1 << 16;
        if (number % kTrianglesBetween == 0 && watcher.is_cancelled()) {
          throw Error(ErrorKind::cancelled, "stopped");
        }
        const ScreenPolygon polygon =
            screen_polygon(corners_of(*mesh.mesh, triangle), camera_.has_eye(), middle_);
        if (polygon.count > 0) {
          const PolygonEdges edges(polygon.span());
          if (edges.has_area()) visit_tiles_of(edges, number, visit);
        }
        ++number;
      }
    }
  }

  template <class Visit>
  void visit_tiles_of(const PolygonEdges& edges, std::uint32_t number, Visit& visit) const {
    const auto tiles = [](const std::array<std::int64_t, 2>& pixels, std::int64_t size,
                          std::int64_t count) {
      const std::int64_t begin = std::max<std::int64_t>(pixels[0], 0) / kRayTileSide;
      const std::int64_t last = std::min(pixels[1], size) - 1;
      const std::int64_t end = last < 0 ? 0 : last / kRayTileSide + 1;
      return std::array<std::int64_t, 2>{begin, std::min(end, count)};
    };
    const auto [left, right] = tiles(edges.columns(), width_, columns_);
    const auto [top, bottom] = tiles(edges.rows(), height_, rows_);
    for (std::int64_t row = top; row < bottom; ++row) {
      for (std::int64_t column = left; column < right; ++column) {
        const auto tile = static_cast<std::size_t>(row * columns_ + column);
        if (share_.has(tile)) visit(tile, number);
      }
    }
  }

  std::vector<Fragment> fragments_of(std::size_t tile) const {
    static const std::array<std::uint16_t, kTileRays> kNumbers = ray_numbers();
    const PixelSquare square = {static_cast<std::int64_t>(tile) % columns_ * kRayTileSide,
                                static_cast<std::int64_t>(tile) / columns_ * kRayTileSide,
                                kRayTileSide};
    const std::uint64_t most = options_.memory_bytes / (4 * sizeof(Fragment));
    std::vector<Fragment> fragments;
    for (std::uint64_t i = begins_[tile]; i < begins_[tile + 1]; ++i) {
      std::size_t number = 0;
      const RayMesh& mesh = mesh_of(triangles_[i], number);
      const MeshTriangle& triangle = mesh.mesh->triangles[number];
      const std::array<HomogeneousPoint, 3> corners = corners_of(*mesh.mesh, triangle);
      const TrianglePlane plane(corners);
      if (!plane.is_seen()) continue;
      const ScreenPolygon polygon = screen_polygon(corners, camera_.has_eye(), middle_);
      const auto add = [&](std::int64_t column, std::int64_t row, std::uint32_t mask) {
        if (square.left + column >= width_ || square.top + row >= height_) return;
        Fragment fragment = fragment_at(mesh, triangle, plane,
                                        place_in(square, column, row, mask));
        fragment.ray = kNumbers[static_cast<std::size_t>(row * kRayTileSide + column)];
        fragment.mask = static_cast<std::uint16_t>(mask);
        fragments.push_back(fragment);
      };
      visit_covered(polygon.span(), square, add);
      if (fragments.size() > most) fail_memory();
    }
    return fragments;
  }

  /// The middle of the places that are covered, from that of the picture.
  ScreenPoint place_in(const PixelSquare& square, std::int64_t column, std::int64_t row,
                       std::uint32_t mask) const {
    ScreenPoint mean;
    int count = 0;
    for (std::size_t place = 0; place < kPlacesInPixel; ++place) {
      if ((mask >> place & 1) == 0) continue;
      mean.x += kPixelPlaces.x[place] / 256.0;
      mean.y += kPixelPlaces.y[place] / 256.0;
      ++count;
    }
    return {static_cast<double>(square.left + column) + mean.x / count - middle_.x,
            static_cast<double>(square.top + row) + mean.y / count - middle_.y};
  }

  Fragment fragment_at(const RayMesh& mesh, const MeshTriangle& triangle,
                       const TrianglePlane& plane, const ScreenPoint& at) const {
    const Point3 shares = plane.shares(at.x, at.y);
    const std::vector<MeshPoint>& points = mesh.mesh->points;
    const Point3 a = doubles(points[triangle[0]]);
    const Point3 face = cross(difference(doubles(points[triangle[1]]), a),
                              difference(doubles(points[triangle[2]]), a));
    const double length = std::sqrt(dot(face, face));
    Point3 smooth{};
    bool is_smooth = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const Point3 normal = doubles(mesh.normals[triangle[i]]);
      is_smooth = is_smooth && std::abs(dot(normal, face)) >= kSharpCosine * length;
      smooth = sum(smooth, scaled(normal, shares[i]));
    }
    Point3 normal = is_smooth ? smooth : face;
    if (!(dot(normal, normal) > 0)) normal = {0, 0, 1};
    Fragment fragment;
    fragment.k = static_cast<float>(plane.k_at(shares, at.x, at.y, camera_));
    fragment.opacity = static_cast<float>(mesh.opacity);
    fragment.color = light_.color(normal, mesh.color, lamp_at(points, triangle, shares));
    return fragment;
  }

  double lamp_at(const std::vector<MeshPoint>& points, const MeshTriangle& triangle,
                 const Point3& shares) const {
    if (!options_.lamp_share) return 1;
    Point3 place{};
    for (std::size_t i = 0; i < 3; ++i) {
      place = sum(place, scaled(doubles(points[triangle[i]]), shares[i]));
    }
    return options_.lamp_share(place);
  }

  const std::vector<RayMesh>& meshes_;
  const RayMeshes::Options& options_;
  TileShare share_;
  MeshCamera camera_;
  MeshLight light_;
  std::int64_t width_;
  std::int64_t height_;
  std::int64_t columns_;  // tiles
  std::int64_t rows_;
  ScreenPoint middle_;
  std::vector<std::uint64_t> first_triangles_;  // by mesh
  std::uint64_t triangle_count_ = 0;
  std::vector<std::uint64_t> begins_;     // by tile
  std::vector<std::uint32_t> triangles_;  // of all meshes one after the other
  std::atomic<std::uint64_t> memory_ = 0;
};

}  // namespace

std::optional<std::array<double, 2>> place_in_picture(const Geometry& geometry,
                                                      const RayFrame& frame, const Point3& world) {
  const HomogeneousPoint place = MeshCamera(geometry, frame).place_of(world);
  if (!(place.at[0] > kNearestShare)) return std::nullopt;
  return std::array<double, 2>{place.at[1] / place.at[0], place.at[2] / place.at[0]};
}

RayMeshes::RayMeshes(std::vector<RayMesh> meshes, const Options& options)
    : meshes_(std::move(meshes)), options_(options) {
  std::uint64_t triangles = 0;
  for (const RayMesh& mesh : meshes_) triangles += mesh.mesh->triangles.size();
  if (triangles >= std::uint64_t{1} << 32) {
    throw Error(ErrorKind::limit_exceeded, "the meshes have 2^32 triangles or more");
  }
}

std::vector<TileLayers> RayMeshes::layers(const RayFrame& frame, std::int64_t width,
                                          std::int64_t height, const Progress& watcher,
                                          const TileShare& share) const {
  MeshTiles tiles(meshes_, options_, frame, width, height, share);
  tiles.sort(watcher);
  std::vector<TileLayers> layers(tiles.tile_count());
  parallel_for(std::size_t{0}, layers.size(), [&](std::size_t i) {
    if (!watcher.is_cancelled()) layers[i] = tiles.layers(i);
  });
  if (watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
  return layers;
}

}  // namespace octavo
