#include "octavo/mesh/nets/interface_decimation.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "octavo/mesh/decimation.h"
#include "octavo/mesh/measured_deviation.h"
#include "octavo/mesh/quiet_progress.h"
#include "octavo/mesh/triangle_limit.h"
#include "octavo/mesh/triangle_tree.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNoNumber = 0xffffffff;
constexpr double kCloser = 0.4;  // of the deviation of surfaces that cross others
constexpr int kCloserRounds = 3;  // after which they stay as they are

/// The surface between two labels.
struct Patch {
  std::vector<std::uint32_t> points;  // of the full mesh, by those of `mesh`
  std::vector<std::uint32_t> locked;  // points of `mesh`
  TriangleMesh mesh;
  Decimated reduced;
  bool is_crossing = false;  // it does so before
  int rounds = 0;            // that it was done again
};

class InterfaceDecimation {
 public:
  InterfaceDecimation(const InterfaceMesh& full, double max_deviation_mm, const Geometry& geometry,
                      Progress& progress)
      : full_(full),
        max_deviation_mm_(max_deviation_mm),
        geometry_(geometry),
        progress_(progress),
        quiet_(progress),
        is_kept_(full.mesh.triangles.size()) {}

  DecimatedInterfaces reduced() {
    find_kept();
    make_patches();
    // Smoothed surfaces may cross where voxels are thin; more triangles do not help there.
    const std::vector<std::uint32_t> before =
        crossing_triangles(TriangleTree(full_.mesh), progress_);
    for (const std::uint32_t triangle : before) {
      patches_[full_.pair_of[triangle]].is_crossing = true;
    }
    {
      const ProgressScope scope(progress_, "fewer triangles",
                                static_cast<std::int64_t>(patches_.size()), "surfaces");
      std::vector<std::uint32_t> all(patches_.size());
      std::iota(all.begin(), all.end(), std::uint32_t{0});
      reduce(all);
    }
    while (true) {
      DecimatedInterfaces result{joined(), 0};
      const std::vector<std::uint32_t> crossing =
          crossing_triangles(TriangleTree(result.interfaces.mesh), progress_);
      result.crossing_triangles = crossing.size();
      if (!reduce_closer(result.interfaces, crossing)) return result;
    }
  }

 private:
  /// Triangles around points at which a label touches itself.
  void find_kept() {
    std::vector<bool> is_touching(full_.mesh.points.size());
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        if ((full_.fans[i] >> 4 * k & 15) != 0) is_touching[full_.mesh.triangles[i][k]] = true;
      }
    }
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      const MeshTriangle& t = full_.mesh.triangles[i];
      is_kept_[i] = is_touching[t[0]] || is_touching[t[1]] || is_touching[t[2]];
    }
  }

  void make_patches() {
    // The surface that each point lies within; those of several, or of triangles that are kept,
    // are locked.
    const auto kept = static_cast<std::uint32_t>(full_.pairs.size());
    std::vector<std::uint32_t> owners(full_.mesh.points.size(), kNoNumber);
    std::vector<bool> is_locked(full_.mesh.points.size());
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      const std::uint32_t owner = is_kept_[i] ? kept : full_.pair_of[i];
      for (const std::uint32_t point : full_.mesh.triangles[i]) {
        if (owners[point] == kNoNumber) owners[point] = owner;
        is_locked[point] = is_locked[point] || owner == kept || owners[point] != owner;
      }
    }
    std::vector<std::vector<std::uint32_t>> triangles(full_.pairs.size());
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      if (!is_kept_[i]) triangles[full_.pair_of[i]].push_back(static_cast<std::uint32_t>(i));
    }
    patches_.resize(full_.pairs.size());
    std::vector<std::uint32_t> numbers(full_.mesh.points.size(), kNoNumber);
    for (std::size_t pair = 0; pair < patches_.size(); ++pair) {
      Patch& patch = patches_[pair];
      for (const std::uint32_t triangle : triangles[pair]) {
        MeshTriangle& added = patch.mesh.triangles.emplace_back(full_.mesh.triangles[triangle]);
        for (std::uint32_t& point : added) {
          std::uint32_t& number = numbers[point];
          if (number == kNoNumber) {
            number = static_cast<std::uint32_t>(patch.points.size());
            patch.points.push_back(point);
            patch.mesh.points.push_back(full_.mesh.points[point]);
            if (is_locked[point]) patch.locked.push_back(number);
          }
          point = number;
        }
      }
      for (const std::uint32_t point : patch.points) numbers[point] = kNoNumber;
    }
  }

  /// Surfaces side by side, the largest first.
  void reduce(std::vector<std::uint32_t>& pairs) {
    const auto size_of = [this](std::uint32_t pair) {
      return patches_[pair].mesh.triangles.size();
    };
    std::stable_sort(pairs.begin(), pairs.end(), [&](std::uint32_t a, std::uint32_t b) {
      return size_of(a) > size_of(b);
    });
    std::atomic<std::size_t> next = 0;
    parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t) {
      const std::uint32_t pair = pairs[next++];
      // Whoever waits within a surface takes up no other one.
      run_isolated([&] { reduce(patches_[pair]); });
      progress_.advance(1);
    });
  }

  void reduce(Patch& patch) {
    double deviation = patch.rounds < kCloserRounds ? max_deviation_mm_ : 0;
    for (int round = 0; round < patch.rounds; ++round) deviation *= kCloser;
    patch.reduced = decimate(patch.mesh, {deviation, geometry_, patch.locked}, quiet_);
  }

  /// Reduces the surfaces that some triangles belong to again; false where none is left that could
  /// be reduced less.
  bool reduce_closer(const InterfaceMesh& mesh, const std::vector<std::uint32_t>& crossing) {
    std::vector<std::uint32_t> pairs;
    for (const std::uint32_t triangle : crossing) pairs.push_back(mesh.pair_of[triangle]);
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    std::erase_if(pairs, [this](std::uint32_t pair) {
      return patches_[pair].is_crossing || patches_[pair].rounds == kCloserRounds;
    });
    if (pairs.empty()) return false;
    const ProgressScope scope(progress_, "fewer triangles", static_cast<std::int64_t>(pairs.size()),
                              "surfaces");
    for (const std::uint32_t pair : pairs) ++patches_[pair].rounds;
    reduce(pairs);
    return true;
  }

  /// All surfaces as one mesh.
  InterfaceMesh joined() const {
    InterfaceMesh made;
    made.pairs = full_.pairs;
    std::vector<std::uint32_t> numbers(full_.mesh.points.size(), kNoNumber);
    const auto number_of = [&](std::uint32_t point) {
      std::uint32_t& number = numbers[point];
      if (number == kNoNumber) {
        number = static_cast<std::uint32_t>(made.mesh.points.size());
        made.mesh.points.push_back(full_.mesh.points[point]);
      }
      return number;
    };
    for (std::size_t i = 0; i < is_kept_.size(); ++i) {
      if (!is_kept_[i]) continue;
      const MeshTriangle& t = full_.mesh.triangles[i];
      made.mesh.triangles.push_back({number_of(t[0]), number_of(t[1]), number_of(t[2])});
      made.pair_of.push_back(full_.pair_of[i]);
      made.fans.push_back(full_.fans[i]);
    }
    for (std::size_t pair = 0; pair < patches_.size(); ++pair) {
      const Patch& patch = patches_[pair];
      const TriangleMesh& mesh = patch.reduced.mesh;
      std::vector<std::uint32_t> own(mesh.points.size(), kNoNumber);
      for (std::size_t i = 0; i < patch.locked.size(); ++i) {
        own[patch.reduced.locked[i]] = number_of(patch.points[patch.locked[i]]);
      }
      for (std::size_t i = 0; i < own.size(); ++i) {
        if (own[i] != kNoNumber) continue;
        own[i] = static_cast<std::uint32_t>(made.mesh.points.size());
        made.mesh.points.push_back(mesh.points[i]);
      }
      for (const MeshTriangle& t : mesh.triangles) {
        made.mesh.triangles.push_back({own[t[0]], own[t[1]], own[t[2]]});
        made.pair_of.push_back(static_cast<std::uint32_t>(pair));
        made.fans.push_back(0);
      }
    }
    return made;
  }

  const InterfaceMesh& full_;
  double max_deviation_mm_;
  const Geometry& geometry_;
  Progress& progress_;
  QuietProgress quiet_;
  std::vector<bool> is_kept_;  // triangles
  std::vector<Patch> patches_;
};

/// The surface of each pair for itself.
std::vector<TriangleMesh> surfaces_of(const InterfaceMesh& interfaces) {
  const std::vector<std::uint32_t>& pair_of = interfaces.pair_of;
  std::vector<std::uint32_t> by_pair(pair_of.size());
  std::iota(by_pair.begin(), by_pair.end(), std::uint32_t{0});
  std::stable_sort(by_pair.begin(), by_pair.end(), [&](std::uint32_t a, std::uint32_t b) {
    return pair_of[a] < pair_of[b];
  });
  std::vector<TriangleMesh> surfaces(interfaces.pairs.size());
  std::vector<std::uint32_t> numbers(interfaces.mesh.points.size());
  std::vector<std::uint32_t> owners(interfaces.mesh.points.size(), kNoNumber);
  for (const std::uint32_t triangle : by_pair) {
    const std::uint32_t pair = pair_of[triangle];
    TriangleMesh& surface = surfaces[pair];
    MeshTriangle& added = surface.triangles.emplace_back(interfaces.mesh.triangles[triangle]);
    for (std::uint32_t& point : added) {
      if (owners[point] != pair) {
        owners[point] = pair;
        numbers[point] = static_cast<std::uint32_t>(surface.points.size());
        surface.points.push_back(interfaces.mesh.points[point]);
      }
      point = numbers[point];
    }
  }
  return surfaces;
}

/// How far surfaces between two labels lie from the full ones, at most `known`.
double measured_deviation_of(const InterfaceMesh& full, const InterfaceMesh& reduced, double known,
                             double margin, const Progress& progress) {
  const std::vector<TriangleMesh> before = surfaces_of(full);
  const std::vector<TriangleMesh> after = surfaces_of(reduced);
  std::vector<double> deviations(before.size());
  parallel_for(std::size_t{0}, before.size(), [&](std::size_t pair) {
    if (before[pair].triangles.empty()) return;
    deviations[pair] = after[pair].triangles.empty()
                           ? known
                           : measured_deviation(before[pair], after[pair], known, margin, progress);
  });
  return *std::max_element(deviations.begin(), deviations.end());
}

}  // namespace

DecimatedInterfaces decimate_interfaces(const InterfaceMesh& full, double max_deviation_mm,
                                        const Geometry& geometry, Progress& progress) {
  return InterfaceDecimation(full, max_deviation_mm, geometry, progress).reduced();
}

LimitedInterfaces decimate_interfaces_to(const InterfaceMesh& full, std::uint64_t limit,
                                         const Geometry& geometry, Progress& progress) {
  DeviationSearch search = search_to(limit, full.mesh, geometry);
  const auto reduce = [&](const DecimatedInterfaces& base, double deviation) {
    return decimate_interfaces(base.interfaces, deviation, geometry, progress);
  };
  const auto count = [](const DecimatedInterfaces& tried) {
    return tried.interfaces.mesh.triangles.size();
  };
  auto found = searched_surface(search, DecimatedInterfaces{full, 0}, reduce, count);
  LimitedInterfaces limited;
  limited.triangle_count = search.fewest();
  if (!found) return limited;
  limited.is_reached = true;
  limited.reduced = std::move(found->first);
  limited.triangle_count = limited.reduced.interfaces.mesh.triangles.size();
  if (limited.triangle_count == full.mesh.triangles.size()) return limited;
  limited.max_deviation_mm =
      measured_deviation_of(full, limited.reduced.interfaces, found->second,
                            measuring_margin_mm(geometry), progress);
  return limited;
}

}  // namespace octavo
