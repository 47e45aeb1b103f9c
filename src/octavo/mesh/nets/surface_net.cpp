#include "octavo/mesh/nets/surface_net.h"

#include "octavo/core/memory_limit.h"

namespace octavo {

void NetCollector::add_points(std::span<const NetPoint> points) {
  net_.points.insert(net_.points.end(), points.begin(), points.end());
}

void NetCollector::add_quads(std::span<const NetQuad> quads, std::span<const LabelPair> pairs) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(pairs.size());
  for (const LabelPair& pair : pairs) {
    const auto number = static_cast<std::uint32_t>(net_.pairs.size());
    const auto [place, is_new] = pair_numbers_.emplace(pair, number);
    if (is_new) net_.pairs.push_back(pair);
    numbers.push_back(place->second);
  }
  const std::size_t first = net_.quads.size();
  net_.quads.insert(net_.quads.end(), quads.begin(), quads.end());
  for (std::size_t i = first; i < net_.quads.size(); ++i) {
    net_.quads[i].pair = numbers[net_.quads[i].pair];
  }
}

void NetCollector::finish_layer() {
  require_memory_within(net_.memory_bytes(), max_bytes_, "the surface",
                        "raise the limit, or take a coarser level");
}

}  // namespace octavo
