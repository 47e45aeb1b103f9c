#include "octavo/mesh/coincident_points.h"

#include <bit>
#include <cstddef>
#include <functional>
#include <vector>

#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

/// Equal for equal places, and as good as random.
std::uint32_t hash_of(const MeshPoint& point) {
  std::uint64_t hash = 0;
  for (const float value : point) {
    // -0 + 0 is 0.
    hash = (hash ^ std::bit_cast<std::uint32_t>(value + 0.0f)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return static_cast<std::uint32_t>(hash);
}

/// A point, with the hash of its place.
struct HashedPoint {
  std::uint32_t hash;
  std::uint32_t number;
};

/// Points in groups by the upper bits of their hashes: so many that a table of one fits a cache.
class PointGroups {
 public:
  explicit PointGroups(std::span<const MeshPoint> points)
      : shift_(32 - group_bits(points.size())), sorted_(points.size()) {
    std::vector<std::uint32_t> hashes(points.size());
    parallel_parts(std::size_t{0}, points.size(), 1 << 14,
                   [&](std::size_t begin, std::size_t end) {
                     for (std::size_t i = begin; i < end; ++i) hashes[i] = hash_of(points[i]);
                   });
    starts_.assign((std::size_t{1} << (32 - shift_)) + 1, 0);
    for (const std::uint32_t hash : hashes) ++starts_[group_of(hash) + 1];
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      sorted_[next[group_of(hashes[i])]++] = {hashes[i], i};
    }
  }

  std::size_t count() const { return starts_.size() - 1; }
  std::span<const HashedPoint> at(std::size_t group) const {
    return {sorted_.data() + starts_[group], starts_[group + 1] - starts_[group]};
  }

 private:
  static int group_bits(std::size_t count) {
    constexpr int kPointsPerGroup = 13;  // as a power of two
    constexpr int kMost = 18;
    const int bits = static_cast<int>(std::bit_width(count)) - kPointsPerGroup;
    return bits < 1 ? 1 : bits > kMost ? kMost : bits;
  }
  std::size_t group_of(std::uint32_t hash) const { return hash >> shift_; }

  int shift_;
  std::vector<HashedPoint> sorted_;
  std::vector<std::size_t> starts_;
};

/// Counts by a table of places seen, open to the next free one.
std::uint64_t coincident_in(std::span<const HashedPoint> group,
                            std::span<const MeshPoint> points) {
  constexpr std::uint32_t kFree = 0xffffffff;
  std::vector<HashedPoint> table(std::bit_ceil(2 * group.size() + 2), HashedPoint{0, kFree});
  const std::size_t last = table.size() - 1;
  std::uint64_t count = 0;
  for (const HashedPoint& point : group) {
    std::size_t at = point.hash & last;
    while (table[at].number != kFree && (table[at].hash != point.hash ||
                                         points[table[at].number] != points[point.number])) {
      at = (at + 1) & last;
    }
    if (table[at].number == kFree) table[at] = point;
    else ++count;
  }
  return count;
}

}  // namespace

std::uint64_t coincident_points(std::span<const MeshPoint> points) {
  const PointGroups groups(points);
  return parallel_reduce(
      std::size_t{0}, groups.count(), 1, std::uint64_t{0},
      [&](std::size_t begin, std::size_t end, std::uint64_t count) {
        for (std::size_t i = begin; i < end; ++i) count += coincident_in(groups.at(i), points);
        return count;
      },
      std::plus<>());
}

}  // namespace octavo
