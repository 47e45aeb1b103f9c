#include "octavo/ops/morphometry/path_lengths.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::int64_t kVoxelsAtOnce = 1 << 16;
constexpr float kNever = std::numeric_limits<float>::infinity();

class MarchingFront {
 public:
  MarchingFront(const std::vector<std::uint8_t>& pores, const Size3& size, const Point3& spacing)
      : pores_(pores),
        size_(size),
        spacing_(spacing),
        strides_{1, size.x, size.x * size.y},
        times_(pores.size(), kNever),
        is_final_(pores.size()) {}

  void start_from_plane(int axis) {
    visit_plane(axis, 0, [&](std::size_t i) {
      if (pores_[i] == 0) return;
      times_[i] = 0;
      front_.push({0, i});
    });
  }

  void march(Progress& progress) {
    std::int64_t reached = 0;
    while (!front_.empty()) {
      const Arrival next = front_.top();
      front_.pop();
      if (is_final_[next.voxel] != 0) continue;
      is_final_[next.voxel] = 1;
      if (++reached % kVoxelsAtOnce == 0) {
        if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
        progress.advance(kVoxelsAtOnce);
      }
      visit_neighbors(next.voxel, [&](std::size_t neighbor) {
        if (pores_[neighbor] == 0 || is_final_[neighbor] != 0) return;
        const float time = arrival_at(neighbor);
        if (time >= times_[neighbor]) return;
        times_[neighbor] = time;
        front_.push({time, neighbor});
      });
    }
    progress.advance(reached % kVoxelsAtOnce);
  }

  template <class Visit>
  void visit_plane(int axis, std::int64_t at, Visit&& visit) const {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (std::int64_t i = 0; i < size_[u]; ++i) {
      for (std::int64_t j = 0; j < size_[v]; ++j) {
        visit(static_cast<std::size_t>(at * stride(axis) + i * stride(u) + j * stride(v)));
      }
    }
  }

  float time(std::size_t voxel) const { return times_[voxel]; }

 private:
  struct Arrival {
    float time;
    std::size_t voxel;
    bool operator<(const Arrival& other) const { return time > other.time; }  // the first on top
  };

  std::int64_t stride(int axis) const { return strides_[static_cast<std::size_t>(axis)]; }

  std::int64_t index_along(std::size_t voxel, int axis) const {
    return static_cast<std::int64_t>(voxel) / stride(axis) % size_[axis];
  }

  template <class Visit>
  void visit_neighbors(std::size_t voxel, Visit&& visit) const {
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t at = index_along(voxel, axis);
      const auto step = static_cast<std::size_t>(stride(axis));
      if (at > 0) visit(voxel - step);
      if (at + 1 < size_[axis]) visit(voxel + step);
    }
  }

  /// The time at which sum of ((t - t_a) / h_a)^2 over the axes that are earlier is 1.
  float arrival_at(std::size_t voxel) const {
    std::array<std::pair<double, double>, 3> earlier;  // time, 1 / h^2
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t at = index_along(voxel, axis);
      const auto step = static_cast<std::size_t>(stride(axis));
      float first = kNever;
      if (at > 0 && is_final_[voxel - step] != 0) first = times_[voxel - step];
      if (at + 1 < size_[axis] && is_final_[voxel + step] != 0) {
        first = std::min(first, times_[voxel + step]);
      }
      const double h = spacing_[static_cast<std::size_t>(axis)];
      earlier[static_cast<std::size_t>(axis)] = {static_cast<double>(first), 1 / (h * h)};
    }
    // The earliest first; one of them is final.
    if (earlier[1] < earlier[0]) std::swap(earlier[0], earlier[1]);
    if (earlier[2] < earlier[1]) std::swap(earlier[1], earlier[2]);
    if (earlier[1] < earlier[0]) std::swap(earlier[0], earlier[1]);
    double a = 0;
    double b = 0;
    double c = -1;
    double time = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& [t, weight] = earlier[i];
      if (i > 0 && t >= time) break;
      a += weight;
      b += weight * t;
      c += weight * t * t;
      time = (b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
    }
    return static_cast<float>(time);
  }

  const std::vector<std::uint8_t>& pores_;
  Size3 size_;
  Point3 spacing_;
  std::array<std::int64_t, 3> strides_;
  std::vector<float> times_;
  std::vector<std::uint8_t> is_final_;
  std::priority_queue<Arrival> front_;
};

}  // namespace

std::optional<PathLengths> path_lengths(const std::vector<std::uint8_t>& pores, const Size3& size,
                                        const Point3& spacing_mm, int axis, Progress& progress) {
  if (size[axis] < 2) return std::nullopt;
  MarchingFront front(pores, size, spacing_mm);
  front.start_from_plane(axis);
  front.march(progress);
  std::uint64_t pore_count = 0;
  std::uint64_t reached = 0;
  double total = 0;
  double shortest = HUGE_VAL;
  front.visit_plane(axis, size[axis] - 1, [&](std::size_t i) {
    if (pores[i] == 0) return;
    ++pore_count;
    const auto mm = static_cast<double>(front.time(i));
    if (!std::isfinite(mm)) return;
    ++reached;
    total += mm;
    shortest = std::min(shortest, mm);
  });
  if (reached == 0) return std::nullopt;
  const double straight =
      spacing_mm[static_cast<std::size_t>(axis)] * static_cast<double>(size[axis] - 1);
  return PathLengths{total / static_cast<double>(reached) / straight, shortest / straight,
                     static_cast<double>(reached) / static_cast<double>(pore_count)};
}

}  // namespace octavo
