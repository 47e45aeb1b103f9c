#include "octavo/mesh/nets/smoothed_interfaces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>

#include "octavo/mesh/enclosed_volumes.h"

namespace octavo {

namespace {

constexpr int kGentlerRounds = 4;  // after which points are not moved at all
constexpr float kGentler = 0.5f;

/// The labels whose volumes change by more than a share.
std::set<std::int64_t> changed_labels(const std::map<std::int64_t, double>& volumes,
                                      const std::map<std::int64_t, double>& expected,
                                      double max_change) {
  std::set<std::int64_t> changed;
  for (const auto& [label, volume] : volumes) {
    const double right = expected.at(label);
    if (std::abs(volume - right) > max_change * right) changed.insert(label);
  }
  return changed;
}

}  // namespace

std::map<std::int64_t, double> enclosed_volumes(const InterfaceMesh& interfaces) {
  const std::vector<double> of_pair =
      volumes_of_groups(interfaces.mesh, interfaces.pairs.size(),
                        [&](std::size_t i) { return interfaces.pair_of[i]; });
  std::map<std::int64_t, double> volumes;
  for (std::size_t i = 0; i < of_pair.size(); ++i) {
    volumes[interfaces.pairs[i][0]] += of_pair[i];
    volumes[interfaces.pairs[i][1]] -= of_pair[i];
  }
  volumes.erase(0);
  return volumes;
}

SmoothedInterfaces smoothed_interfaces(const SurfaceNet& net, const SurfaceFrame& frame, int steps,
                                       double max_volume_change) {
  SmoothedInterfaces result;
  if (steps > 0) result.offsets = smoothed_offsets(net, steps);
  result.interfaces = interface_mesh(net, result.offsets, frame);
  if (steps <= 0) return result;
  std::map<std::int64_t, double> expected;
  for (const auto& [label, count] : voxel_counts(net, frame.is_mirrored())) {
    expected[label] = static_cast<double>(count) * frame.voxel_volume();
  }
  for (int round = 0;; ++round) {
    const std::set<std::int64_t> changed =
        changed_labels(enclosed_volumes(result.interfaces), expected, max_volume_change);
    if (changed.empty()) return result;
    std::vector<bool> is_changed(net.points.size());
    for (const NetQuad& quad : net.quads) {
      const auto& [inside, outside] = net.pairs[quad.pair];
      if (!changed.contains(inside) && !changed.contains(outside)) continue;
      for (const std::uint32_t point : quad.corners) is_changed[point] = true;
    }
    const float share = round < kGentlerRounds ? kGentler : 0;
    bool is_moved = false;
    for (std::size_t i = 0; i < is_changed.size(); ++i) {
      if (!is_changed[i]) continue;
      for (float& value : result.offsets[i]) {
        is_moved = is_moved || value != 0;
        value *= share;
      }
    }
    if (!is_moved) return result;
    result.interfaces = interface_mesh(net, result.offsets, frame);
  }
}

}  // namespace octavo
