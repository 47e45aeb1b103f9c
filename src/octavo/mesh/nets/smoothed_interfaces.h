// Surfaces between labels that are smooth where that leaves the volumes of all labels as they are.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "octavo/mesh/nets/interface_mesh.h"
#include "octavo/mesh/nets/net_smoothing.h"

namespace octavo {

struct SmoothedInterfaces {
  InterfaceMesh interfaces;
  std::vector<NetOffset> offsets;  ///< of the points of the net; empty where they have not moved
};

/// The triangles of a net that is smoothed as by smoothed_offsets, but points of labels whose
/// volumes would change by more than a share of that of their voxels are moved less, in the end
/// not at all.
/// Memory  as smoothed_offsets and interface_mesh, and 4 bytes per point
SmoothedInterfaces smoothed_interfaces(const SurfaceNet& net, const SurfaceFrame& frame, int steps,
                                       double max_volume_change);

/// What the surface of each label but 0 encloses, mm3.
std::map<std::int64_t, double> enclosed_volumes(const InterfaceMesh& interfaces);

}  // namespace octavo
