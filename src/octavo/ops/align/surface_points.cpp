#include "octavo/ops/align/surface_points.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr std::uint64_t kPointSeed = 25;

/// Calls visit(middle) for every face, in index space.
template <class Visit>
void visit_faces(const MaskTree& mask, Visit&& visit) {
  const Size3& size = mask.size();
  const std::int64_t plane = size.x * size.y;
  // A plane and the one behind it.
  std::vector<std::uint8_t> voxels(static_cast<std::size_t>(2 * plane));
  fill_voxels(mask, {{0, 0, 0}, {size.x, size.y, 1}}, voxels.data() + plane);
  for (std::int64_t z = 0; z < size.z; ++z) {
    std::copy_n(voxels.begin() + plane, plane, voxels.begin());
    const bool has_next = z + 1 < size.z;
    if (has_next) {
      fill_voxels(mask, {{0, 0, z + 1}, {size.x, size.y, z + 2}}, voxels.data() + plane);
    }
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::uint8_t* const here = voxels.data() + y * size.x + x;
        const Point3 p = {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        if (x + 1 < size.x && here[1] != here[0]) visit(Point3{p[0] + 0.5, p[1], p[2]});
        if (y + 1 < size.y && here[size.x] != here[0]) visit(Point3{p[0], p[1] + 0.5, p[2]});
        if (has_next && here[plane] != here[0]) visit(Point3{p[0], p[1], p[2] + 0.5});
      }
    }
  }
}

template <class Item>
void shuffle_items(std::vector<Item>& items, std::mt19937_64& random) {
  for (std::size_t i = items.size(); i > 1; --i) {
    std::swap(items[i - 1], items[static_cast<std::size_t>(random() % i)]);
  }
}

template <class Item>
std::vector<Item> spread_items(std::vector<Item> items, std::int64_t count) {
  std::mt19937_64 random(kPointSeed);
  shuffle_items(items, random);
  if (items.size() > static_cast<std::size_t>(count)) {
    items.resize(static_cast<std::size_t>(count));
  }
  return items;
}

}  // namespace

std::vector<Point3> surface_points(const MaskTree& mask, const Geometry& geometry,
                                   std::int64_t count) {
  // A sample of all faces that have gone by, each as likely as any other.
  std::mt19937_64 random(kPointSeed);
  std::vector<Point3> points;
  std::uint64_t seen = 0;
  visit_faces(mask, [&](const Point3& middle) {
    ++seen;
    if (points.size() < static_cast<std::size_t>(count)) {
      points.push_back(middle);
    } else if (const std::uint64_t at = random() % seen; at < points.size()) {
      points[static_cast<std::size_t>(at)] = middle;
    }
  });
  shuffle_items(points, random);
  for (Point3& p : points) p = geometry.to_world(p);
  return points;
}

std::vector<Point3> surface_points(const TriangleMesh& mesh, std::int64_t count) {
  const auto corner = [&](const MeshTriangle& triangle, std::size_t i) {
    const MeshPoint& p = mesh.points[triangle[i]];
    return Point3{p[0], p[1], p[2]};
  };
  std::vector<double> area_before = {0};
  for (const MeshTriangle& triangle : mesh.triangles) {
    const Point3 from = corner(triangle, 0);
    const Point3 twice = cross(difference(corner(triangle, 1), from),
                               difference(corner(triangle, 2), from));
    area_before.push_back(area_before.back() + std::sqrt(dot(twice, twice)) / 2);
  }
  if (!(area_before.back() > 0)) return {};
  std::mt19937_64 random(kPointSeed);
  const auto share = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  std::vector<Point3> points;
  for (std::int64_t i = 0; i < count; ++i) {
    const double at = share() * area_before.back();
    const auto after = std::upper_bound(area_before.begin() + 1, area_before.end() - 1, at);
    const MeshTriangle& triangle =
        mesh.triangles[static_cast<std::size_t>(after - area_before.begin()) - 1];
    const double root = std::sqrt(share());
    const double along = share();
    points.push_back(sum(scaled(corner(triangle, 0), 1 - root),
                         sum(scaled(corner(triangle, 1), root * (1 - along)),
                             scaled(corner(triangle, 2), root * along))));
  }
  return points;
}

std::vector<Point3> spread_points(std::vector<Point3> points, std::int64_t count) {
  return spread_items(std::move(points), count);
}

std::vector<SightLine> spread_lines(std::vector<SightLine> lines, std::int64_t count) {
  return spread_items(std::move(lines), count);
}

}  // namespace octavo
