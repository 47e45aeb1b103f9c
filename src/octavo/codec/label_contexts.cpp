#include "octavo/codec/label_contexts.h"

#include <algorithm>

namespace octavo {

namespace {

struct Direction {
  int x, y, z;
};

constexpr std::array<Direction, kLabelNeighbors> directions() {
  std::array<Direction, kLabelNeighbors> result{};
  std::size_t count = 0;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (x != 0 || y != 0 || z != 0) result[count++] = {x, y, z};
      }
    }
  }
  for (const int step : {-2, 2}) result[count + (step > 0)] = {step, 0, 0};
  for (const int step : {-2, 2}) result[count + 2 + (step > 0)] = {0, step, 0};
  for (const int step : {-2, 2}) result[count + 4 + (step > 0)] = {0, 0, step};
  return result;
}

constexpr std::array<Direction, kLabelNeighbors> kDirections = directions();

/// Votes of an exactly known neighbor that shares a face, an edge, a corner, or is two steps away.
constexpr std::array<int, kLabelNeighbors> exact_votes() {
  std::array<int, kLabelNeighbors> result{};
  for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
    const Direction d = kDirections[i];
    const int length = d.x * d.x + d.y * d.y + d.z * d.z;
    result[i] = length == 1 ? 12 : length == 2 ? 5 : length == 3 ? 3 : 2;
  }
  return result;
}

constexpr std::array<int, kLabelNeighbors> kExactVotes = exact_votes();

}  // namespace

LabelNeighborhood label_neighborhood(std::ptrdiff_t row_stride, std::ptrdiff_t plane_stride) {
  LabelNeighborhood result{};
  for (std::size_t digit = 0; digit < 8; ++digit) {
    const int sign_x = (digit >> 1 & 1) != 0 ? 1 : -1;
    const int sign_y = (digit & 1) != 0 ? 1 : -1;
    const int sign_z = (digit >> 2 & 1) != 0 ? 1 : -1;
    for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
      const Direction d = kDirections[i];
      result[digit][i] = sign_x * d.x + sign_y * d.y * row_stride + sign_z * d.z * plane_stride;
    }
  }
  return result;
}

int label_vote(std::size_t neighbor, LabelState state) {
  return state == kParent ? (kExactVotes[neighbor] + 1) / 2 : kExactVotes[neighbor];
}

void LabelCandidates::sort() {
  const auto end = list_.begin() + count_;
  for (auto next = list_.begin(); next != end; ++next) {
    auto place = next;
    const Candidate candidate = *next;
    for (; place != list_.begin() && (place - 1)->votes < candidate.votes; --place) {
      *place = *(place - 1);
    }
    *place = candidate;
  }
}

int LabelCandidates::share(int i) const {
  int left = 0;
  for (int j = i; j < count_; ++j) left += list_[static_cast<std::size_t>(j)].votes;
  return std::min(8 * list_[static_cast<std::size_t>(i)].votes / left, 7);
}

}  // namespace octavo
