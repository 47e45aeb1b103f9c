#include "octavo/ops/similarity/cube_turns.h"

#include <algorithm>
#include <cstdlib>

namespace octavo {

namespace {

constexpr int kMostDiagonals = 4;
constexpr std::array<std::array<int, 3>, 6> kAxisOrders = {
    {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};

}  // namespace

CubeTurns::CubeTurns(int side) : side_(side) {
  const auto place_of = [side](const std::array<int, 3>& p) {
    return static_cast<std::uint16_t>((p[2] * side + p[1]) * side + p[0]);
  };
  for (int turn = 0; turn < kCubeTurns; ++turn) {
    const auto& order = kAxisOrders[static_cast<std::size_t>(turn / 8)];
    std::vector<std::uint16_t>& places = places_[static_cast<std::size_t>(turn)];
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const std::array<int, 3> p = {x, y, z};
          std::array<int, 3> from{};
          for (std::size_t a = 0; a < 3; ++a) {
            const int along = p[static_cast<std::size_t>(order[a])];
            from[a] = (turn >> a & 1) != 0 ? side - 1 - along : along;
          }
          places.push_back(place_of(from));
        }
      }
    }
  }
  // From the corners inward, evenly spread where there are more than enough.
  const int orbits = side / 2;
  const int kept = std::min(orbits, kMostDiagonals);
  for (int i = 0; i < kept; ++i) {
    const int near = i * orbits / kept;
    std::array<std::uint16_t, 8> diagonal{};
    for (int corner = 0; corner < 8; ++corner) {
      std::array<int, 3> p{};
      for (int a = 0; a < 3; ++a) {
        p[static_cast<std::size_t>(a)] = (corner >> a & 1) != 0 ? side - 1 - near : near;
      }
      diagonal[static_cast<std::size_t>(corner)] = place_of(p);
    }
    diagonals_.push_back(diagonal);
  }
}

void CubeTurns::invariants(std::span<const std::int32_t> cube, std::int32_t mean,
                           std::span<std::int32_t> out) const {
  const auto [min, max] = std::minmax_element(cube.begin(), cube.end());
  out[0] = *min - mean;
  out[1] = *max - mean;
  std::size_t at = 2;
  for (const auto& diagonal : diagonals_) {
    for (std::size_t i = 0; i < 8; ++i) out[at + i] = cube[diagonal[i]] - mean;
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(at),
              out.begin() + static_cast<std::ptrdiff_t>(at + 8));
    at += 8;
  }
}

int CubeTurns::matching_turn(std::span<const std::int32_t> cube, std::int32_t mean,
                             std::span<const std::int32_t> other, std::int32_t other_mean,
                             std::int32_t most) const {
  const std::int32_t shift = mean - other_mean;
  const auto is_near = [&](std::size_t i, std::uint16_t from) {
    return std::abs(cube[i] - other[from] - shift) <= most;
  };
  for (int turn = 0; turn < kCubeTurns; ++turn) {
    const std::span<const std::uint16_t> from = places(turn);
    bool is_match = true;
    for (std::size_t i = 0; is_match && i < from.size(); ++i) is_match = is_near(i, from[i]);
    if (is_match) return turn;
  }
  return -1;
}

}  // namespace octavo
