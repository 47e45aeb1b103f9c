#include "octavo/mesh/hexahedra/hex_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "hex_samples.h"
#include "octavo/core/vectors.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::hex_mesh_of;

constexpr std::array<HexMethod, 3> kMethods = {HexMethod::uniform, HexMethod::octree,
                                               HexMethod::conforming};

Geometry mirrored_geometry() {
  Geometry geometry;
  geometry.spacing_mm = {0.5, 0.75, 2};
  geometry.origin_mm = {10, -20, 30};
  geometry.direction = {0, 1, 0, 1, 0, 0, 0, 0, 1};  // determinant -1
  return geometry;
}

double determinant_of(const Point3& a, const Point3& b, const Point3& c) {
  return dot(cross(a, b), c);
}

/// The smallest determinant at the corners of an element that have three sides.
double lowest_jacobian(HexShape shape, const std::vector<Point3>& p) {
  double lowest = INFINITY;
  const auto add = [&](std::size_t at, std::size_t a, std::size_t b, std::size_t c) {
    lowest = std::min(lowest, determinant_of(difference(p[a], p[at]), difference(p[b], p[at]),
                                             difference(p[c], p[at])));
  };
  if (shape == HexShape::tetrahedron) add(0, 1, 2, 3);
  for (std::size_t i = 0; i < 4 && shape != HexShape::tetrahedron; ++i) {
    add(i, (i + 1) % 4, (i + 3) % 4, shape == HexShape::pyramid ? 4 : i + 4);
    if (shape == HexShape::hexahedron) add(i + 4, (i + 3) % 4 + 4, (i + 1) % 4 + 4, i);
  }
  return lowest;
}

std::vector<Point3> node_places(const HexMesh& mesh) {
  std::vector<Point3> places;
  mesh.visit_nodes([&](const Point3& place) { places.push_back(place); });
  return places;
}

std::uint64_t inside_count(const DenseLabels& labels) {
  return static_cast<std::uint64_t>(std::count_if(labels.voxels.begin(), labels.voxels.end(),
                                                  [](auto label) { return label != 0; }));
}

TEST(HexMesh, VolumesArePositiveAndThatOfTheVoxelsInMirroredGridsAsWell) {
  std::mt19937 random(31);
  for (int run = 0; run < 6; ++run) {
    const DenseLabels labels = testing::random_labels({20, 17, 12}, testing::kHexLabels, random);
    for (const Geometry& geometry : {Geometry(), mirrored_geometry()}) {
      for (const HexMethod method : kMethods) {
        const HexMesh mesh = hex_mesh_of(labels, method, geometry);
        const std::vector<Point3> places = node_places(mesh);
        ASSERT_EQ(places.size(), mesh.node_count());
        std::uint64_t count = 0;
        mesh.visit_all_elements([&](HexShape shape, std::span<const std::uint32_t> nodes, auto) {
          ++count;
          std::vector<Point3> corners;
          for (const std::uint32_t node : nodes) corners.push_back(places.at(node));
          EXPECT_GT(lowest_jacobian(shape, corners), 0);
        });
        EXPECT_EQ(count, mesh.element_count());
        const HexQuality quality = mesh.quality();
        const Point3& spacing = geometry.spacing_mm;
        const double voxels =
            static_cast<double>(inside_count(labels)) * spacing[0] * spacing[1] * spacing[2];
        EXPECT_NEAR(quality.total_volume_mm3, voxels, 1e-9 * voxels);
        EXPECT_GT(quality.percentile(0), 0.05);
        EXPECT_LE(quality.percentile(100), 1 + 1e-12);
      }
    }
  }
}

TEST(HexMesh, NodesLieAtTheCornersOfVoxels) {
  DenseLabels labels({3, 3, 3});
  labels.at({1, 2, 0}) = 1;
  Geometry geometry;
  geometry.spacing_mm = {2, 3, 4};
  geometry.origin_mm = {100, 0, 0};
  const std::vector<Point3> places = node_places(hex_mesh_of(labels, HexMethod::uniform, geometry));
  const std::set<Point3> expected = {{101, 4.5, -2}, {103, 4.5, -2}, {101, 7.5, -2},
                                     {103, 7.5, -2}, {101, 4.5, 2},  {103, 4.5, 2},
                                     {101, 7.5, 2},  {103, 7.5, 2}};
  EXPECT_EQ(std::set<Point3>(places.begin(), places.end()), expected);
}

/// Faces of voxels with nothing behind.
std::uint64_t border_faces(const DenseLabels& labels) {
  std::uint64_t count = 0;
  testing::for_each_voxel(labels.size, [&](const Index3& p) {
    if (labels.at(p) == 0) return;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-1, 1}) {
        Index3 beside = p;
        beside[axis] += step;
        if (!box_of(labels.size).contains(beside) || labels.at(beside) == 0) ++count;
      }
    }
  });
  return count;
}

std::vector<std::vector<std::uint32_t>> faces_of(HexShape shape,
                                                 std::span<const std::uint32_t> n) {
  if (shape == HexShape::tetrahedron) {
    return {{n[0], n[1], n[2]}, {n[0], n[1], n[3]}, {n[1], n[2], n[3]}, {n[0], n[2], n[3]}};
  }
  if (shape == HexShape::pyramid) {
    return {{n[0], n[1], n[2], n[3]},
            {n[0], n[1], n[4]},
            {n[1], n[2], n[4]},
            {n[2], n[3], n[4]},
            {n[3], n[0], n[4]}};
  }
  return {{n[0], n[1], n[2], n[3]}, {n[4], n[5], n[6], n[7]}, {n[0], n[1], n[5], n[4]},
          {n[1], n[2], n[6], n[5]}, {n[2], n[3], n[7], n[6]}, {n[3], n[0], n[4], n[7]}};
}

double area_of(const std::vector<std::uint32_t>& face, const std::vector<Point3>& places) {
  double area = 0;
  for (std::size_t i = 2; i < face.size(); ++i) {
    const Point3 normal = cross(difference(places[face[i - 1]], places[face[0]]),
                                difference(places[face[i]], places[face[0]]));
    area += std::sqrt(dot(normal, normal)) / 2;
  }
  return area;
}

TEST(HexMesh, FacesOfAConformingMeshHaveAnElementOnEachSideButAtTheBorder) {
  std::mt19937 random(77);
  for (int run = 0; run < 12; ++run) {
    const DenseLabels labels = testing::random_labels({19, 16, 22}, testing::kHexLabels, random);
    const HexMesh mesh = hex_mesh_of(labels, HexMethod::conforming);
    EXPECT_EQ(mesh.hanging_count(), 0u);
    const std::vector<Point3> places = node_places(mesh);
    std::map<std::vector<std::uint32_t>, std::vector<std::vector<std::uint32_t>>> faces;
    mesh.visit_all_elements([&](HexShape shape, std::span<const std::uint32_t> nodes, auto) {
      for (const auto& face : faces_of(shape, nodes)) {
        auto key = face;
        std::sort(key.begin(), key.end());
        faces[key].push_back(face);
      }
    });
    double alone = 0;
    for (const auto& [key, sides] : faces) {
      ASSERT_LE(sides.size(), 2u);
      if (sides.size() == 1) alone += area_of(sides[0], places);
    }
    EXPECT_NEAR(alone, static_cast<double>(border_faces(labels)), 1e-6);
  }
}

TEST(HexMesh, SideFacesCoverTheSidesAndLookOutward) {
  const DenseLabels labels({8, 6, 4}, 1);
  DenseLabels with_grain = labels;
  with_grain.at({0, 0, 0}) = 2;
  for (const Geometry& geometry : {Geometry(), mirrored_geometry()}) {
    for (const HexMethod method : kMethods) {
      const HexMesh mesh = hex_mesh_of(with_grain, method, geometry);
      const std::vector<Point3> places = node_places(mesh);
      const Point3 middle = mesh.place_of({4, 3, 2});
      std::array<double, 6> areas{};
      mesh.visit_side_faces([&](int side, std::span<const std::uint32_t> nodes) {
        const std::vector<std::uint32_t> face(nodes.begin(), nodes.end());
        areas[static_cast<std::size_t>(side)] += area_of(face, places);
        const Point3 normal = cross(difference(places[face[1]], places[face[0]]),
                                    difference(places[face[2]], places[face[0]]));
        EXPECT_GT(dot(normal, difference(places[face[0]], middle)), 0);
      });
      const Point3& s = geometry.spacing_mm;
      const std::array<double, 3> expected = {24 * s[1] * s[2], 32 * s[0] * s[2], 48 * s[0] * s[1]};
      for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(areas[i], expected[i / 2], 1e-9);
    }
  }
}

// ---- The patch test: a linear displacement is the solution of a mesh whose border has it.

using Stiffness = std::array<std::array<double, 24>, 24>;

/// Of a cube of side 1 with Young's modulus 1 and Poisson's ratio 0.3.
Stiffness cube_stiffness() {
  constexpr double kNu = 0.3;
  constexpr double kLambda = kNu / ((1 + kNu) * (1 - 2 * kNu));
  constexpr double kMu = 1 / (2 * (1 + kNu));
  Stiffness k{};
  const double gauss = 0.5 / std::sqrt(3.0);
  for (int point = 0; point < 8; ++point) {
    std::array<double, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = 0.5 + ((point >> axis & 1) != 0 ? gauss : -gauss);
    }
    std::array<Point3, 8> slope{};
    for (std::size_t i = 0; i < 8; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        slope[i][axis] = 1;
        for (std::size_t other = 0; other < 3; ++other) {
          const double up = kHexCorners[i][other] != 0 ? 1 : 0;
          const double value = up != 0 ? at[other] : 1 - at[other];
          slope[i][axis] *= other == axis ? 2 * up - 1 : value;
        }
      }
    }
    for (std::size_t i = 0; i < 24; ++i) {
      for (std::size_t j = 0; j < 24; ++j) {
        const Point3& a = slope[i / 3];
        const Point3& b = slope[j / 3];
        double value = kLambda * a[i % 3] * b[j % 3] + kMu * a[j % 3] * b[i % 3];
        if (i % 3 == j % 3) value += kMu * dot(a, b);
        k[i][j] += value / 8;
      }
    }
  }
  return k;
}

/// Solves by conjugate gradients for the nodes that are free, hanging ones as means of others.
class PatchTest {
 public:
  explicit PatchTest(const HexMesh& mesh) : mesh_(mesh), count_(mesh.node_count()) {
    const auto& bounds = mesh.bounds();
    mesh.corners().visit([&](const GridPoint& point, std::uint32_t) {
      bool at_border = false;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        at_border = at_border || point[axis] == bounds[0][axis] || point[axis] == bounds[1][axis];
      }
      is_held_.push_back(at_border);
      places_.push_back({static_cast<double>(point[0]), static_cast<double>(point[1]),
                         static_cast<double>(point[2])});
    });
    mesh.corners().visit_hanging([&](const GridPoint& point, std::uint32_t number) {
      hanging_.emplace_back(number, mesh.corners().masters_of(point));
    });
  }

  static Point3 linear(const Point3& p) {
    return {0.3 * p[0] - 0.1 * p[1] + 0.2 * p[2], 0.05 * p[0] + 0.4 * p[1] - 0.3 * p[2],
            -0.2 * p[0] + 0.15 * p[1] + 0.1 * p[2]};
  }

  /// The largest difference from the linear displacement.
  double largest_error() {
    std::vector<Point3> u(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      if (is_held_[i]) u[i] = linear(places_[i]);
    }
    std::vector<Point3> r = applied(u);
    for (Point3& value : r) value = {-value[0], -value[1], -value[2]};
    std::vector<Point3> p = r;
    double rr = product(r, r);
    const double end = rr * 1e-26;
    for (int step = 0; step < 2000 && rr > end; ++step) {
      const std::vector<Point3> ap = applied(p);
      const double alpha = rr / product(p, ap);
      for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t a = 0; a < 3; ++a) {
          u[i][a] += alpha * p[i][a];
          r[i][a] -= alpha * ap[i][a];
        }
      }
      const double next = product(r, r);
      for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t a = 0; a < 3; ++a) p[i][a] = r[i][a] + next / rr * p[i][a];
      }
      rr = next;
    }
    spread(u);
    double largest = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Point3 error = difference(u[i], linear(places_[i]));
      for (const double value : error) largest = std::max(largest, std::abs(value));
    }
    return largest;
  }

  std::size_t free_count() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_ - hanging_.size(); ++i) count += is_held_[i] ? 0u : 1u;
    return count;
  }

 private:
  static double product(const std::vector<Point3>& a, const std::vector<Point3>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
    return sum;
  }

  /// Hanging nodes from their masters.
  void spread(std::vector<Point3>& u) const {
    for (const auto& [node, masters] : hanging_) {
      u[node] = {};
      for (int i = 0; i < masters.count; ++i) {
        for (std::size_t a = 0; a < 3; ++a) {
          u[node][a] += u[masters.nodes[static_cast<std::size_t>(i)]][a] / masters.count;
        }
      }
    }
  }

  /// The forces at the free nodes.
  std::vector<Point3> applied(std::vector<Point3> u) const {
    static const Stiffness k = cube_stiffness();
    spread(u);
    std::vector<Point3> f(count_);
    mesh_.visit_all_elements(
        [&](HexShape, std::span<const std::uint32_t> nodes, std::uint64_t cell) {
          const double side = mesh_.cells()[cell].side();
          for (std::size_t i = 0; i < 24; ++i) {
            double sum = 0;
            for (std::size_t j = 0; j < 24; ++j) sum += k[i][j] * u[nodes[j / 3]][j % 3];
            f[nodes[i / 3]][i % 3] += side * sum;
          }
        });
    for (const auto& [node, masters] : hanging_) {
      for (int i = 0; i < masters.count; ++i) {
        for (std::size_t a = 0; a < 3; ++a) {
          f[masters.nodes[static_cast<std::size_t>(i)]][a] += f[node][a] / masters.count;
        }
      }
      f[node] = {};
    }
    for (std::size_t i = 0; i < count_; ++i) {
      if (is_held_[i]) f[i] = {};
    }
    return f;
  }

  const HexMesh& mesh_;
  std::size_t count_;
  std::vector<bool> is_held_;
  std::vector<Point3> places_;
  std::vector<std::pair<std::uint32_t, HexMasters>> hanging_;
};

TEST(HexMesh, ALinearDisplacementIsExactOnRandomBalancedTrees) {
  std::mt19937 random(2024);
  for (int run = 0; run < 20; ++run) {
    // A box without holes, whose inside falls into leaves of several levels by grains of labels.
    DenseLabels labels({16, 16, 16}, 1);
    for (int grain = 0; grain < 1 + run / 4; ++grain) {
      const auto at = [&] { return 3 + static_cast<std::int64_t>(random() % 10); };
      labels.at({at(), at(), at()}) = 2;
    }
    const HexMesh mesh = hex_mesh_of(labels, HexMethod::octree);
    ASSERT_GT(mesh.hanging_count(), 0u);
    PatchTest test(mesh);
    ASSERT_GT(test.free_count(), 0u);
    EXPECT_LT(test.largest_error(), 1e-9) << "run " << run;
  }
}

}  // namespace
}  // namespace octavo
