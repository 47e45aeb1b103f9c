#include "octavo/codec/label/label_contexts.h"

namespace octavo {

namespace {

struct NeighborStep {
  int x, y, z;
};

consteval std::array<NeighborStep, kLabelNeighbors> directions() {
  std::array<NeighborStep, kLabelNeighbors> result{};
  std::size_t count = 0;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      if (y == 0 && z == 0) {
        for (const int x : {-2, -1, 1, 2}) result[count++] = {x, 0, 0};
      } else {
        for (const int x : {-1, 0, 1}) result[count++] = {x, y, z};
      }
    }
  }
  for (const int y : {-2, 2}) result[count++] = {0, y, 0};
  for (const int z : {-2, 2}) result[count++] = {0, 0, z};
  return result;
}

constexpr std::array<NeighborStep, kLabelNeighbors> kNeighborSteps = directions();

}  // namespace

LabelNeighborhood label_neighborhood(std::ptrdiff_t row_stride, std::ptrdiff_t plane_stride) {
  LabelNeighborhood result{};
  for (std::size_t digit = 0; digit < 8; ++digit) {
    const std::ptrdiff_t sign_x = (digit >> 1 & 1) != 0 ? 1 : -1;
    const std::ptrdiff_t sign_y = (digit & 1) != 0 ? 1 : -1;
    const std::ptrdiff_t sign_z = (digit >> 2 & 1) != 0 ? 1 : -1;
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      const NeighborStep d = kNeighborSteps[i];
      result[digit][i] = sign_x * d.x + sign_y * d.y * row_stride + sign_z * d.z * plane_stride;
    }
  }
  return result;
}

}  // namespace octavo
