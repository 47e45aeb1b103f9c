#include "octavo/mesh/nets/surface_net.h"

#include "octavo/core/memory_limit.h"
#include "octavo/mesh/mesh_room.h"

namespace octavo {

void NetCollector::add_points(std::span<const NetPoint> points) {
  make_room(net_.points, points.size());
  net_.points.insert(net_.points.end(), points.begin(), points.end());
}

void NetCollector::add_pairs(std::span<const LabelPair> pairs) {
  net_.pairs.insert(net_.pairs.end(), pairs.begin(), pairs.end());
}

void NetCollector::add_quads(std::span<const NetQuad> quads) {
  make_room(net_.quads, quads.size());
  net_.quads.insert(net_.quads.end(), quads.begin(), quads.end());
}

void NetCollector::finish_layer() {
  require_memory_within(net_.memory_bytes(), max_bytes_, "the surface",
                        "raise the limit, or take a coarser level");
}

}  // namespace octavo
