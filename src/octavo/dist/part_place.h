// Which groups a part holds, or which bricks of one group.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <utility>

namespace octavo {

/// Whole groups, or a band: a run of the bricks of one group, in file order. Only groups of a
/// single layer have bands.
struct PartPlace {
  std::uint64_t plan = 0;  ///< BuildPlan::id
  std::int64_t first_group = 0;
  std::int64_t end_group = 0;    ///< of a band first_group + 1
  std::int64_t first_brick = 0;
  std::int64_t end_brick = 0;    ///< of whole groups 0

  bool is_band() const { return end_brick > 0; }
  bool operator==(const PartPlace&) const = default;
};

/// A brick by its group and its place there.
using BrickAt = std::pair<std::int64_t, std::int64_t>;

inline BrickAt begin_of(const PartPlace& place) { return {place.first_group, place.first_brick}; }

/// Behind the last brick: where what follows begins.
/// layer_bricks  of a group that has bands
inline BrickAt end_of(const PartPlace& place, std::int64_t layer_bricks) {
  const bool ends_inside = place.is_band() && place.end_brick < layer_bricks;
  return ends_inside ? BrickAt{place.first_group, place.end_brick} : BrickAt{place.end_group, 0};
}

/// The planes of its layer that a band hashes: by number in the layer, first and end. Bands that
/// tile the bricks tile the planes.
inline std::pair<std::int64_t, std::int64_t> hashed_planes(const PartPlace& band,
                                                           std::int64_t planes,
                                                           std::int64_t layer_bricks) {
  return {planes * band.first_brick / layer_bricks, planes * band.end_brick / layer_bricks};
}

/// "group 3", "groups 3 to 5", "bricks 100 to 199 of group 3".
std::string place_text(const PartPlace& place);

}  // namespace octavo
