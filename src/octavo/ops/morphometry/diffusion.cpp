#include "octavo/ops/morphometry/diffusion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::int32_t kNoPore = -1;
constexpr std::size_t kPoresAtOnce = 1 << 15;  // a sum is made of sums of so many
constexpr double kSmallestResidual = 1e-6;     // of what flows in
constexpr std::size_t kStepsAtOnce = 1 << 20;  // between two looks whether to stop

/// The sum of sum(begin, end) over runs of pores, in their order.
template <class SumOf>
double sum_of_runs(std::size_t count, SumOf&& sum) {
  const std::size_t runs = (count + kPoresAtOnce - 1) / kPoresAtOnce;
  std::vector<double> parts(runs);
  tbb::parallel_for(std::size_t{0}, runs, [&](std::size_t i) {
    parts[i] = sum(i * kPoresAtOnce, std::min((i + 1) * kPoresAtOnce, count));
  });
  double all = 0;
  for (const double part : parts) all += part;
  return all;
}

/// Pores that lead from the first plane to the last, and how they hang together.
class PoreNetwork {
 public:
  PoreNetwork(const std::vector<std::uint8_t>& pores, const Size3& size, const Point3& spacing,
              int axis, const Progress& progress)
      : size_(size), axis_(axis), strides_{1, size.x, size.x * size.y}, progress_(progress) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double area = spacing[(a + 1) % 3] * spacing[(a + 2) % 3];
      conductance_[a] = area / spacing[a];
    }
    const std::vector<std::uint8_t> from_first = flooded(pores, 0);
    const std::vector<std::uint8_t> from_last = flooded(pores, size[axis] - 1);
    index_.assign(pores.size(), kNoPore);
    for (std::size_t i = 0; i < pores.size(); ++i) {
      if (i % kStepsAtOnce == 0) stop_if_cancelled();
      if (from_first[i] == 0 || from_last[i] == 0) continue;
      if (voxels_.size() == std::numeric_limits<std::int32_t>::max()) {
        throw Error(ErrorKind::limit_exceeded, "more than 2^31 voxels of pores");
      }
      index_[i] = static_cast<std::int32_t>(voxels_.size());
      voxels_.push_back(i);
    }
    faces_.resize(voxels_.size());
    tbb::parallel_for(std::size_t{0}, voxels_.size(), [&](std::size_t i) {
      if (i % kStepsAtOnce == 0) stop_if_cancelled();
      std::uint8_t bits = 0;
      visit_neighbors(voxels_[i], [&](int side, std::size_t neighbor) {
        if (index_[neighbor] != kNoPore) bits = static_cast<std::uint8_t>(bits | 1 << side);
      });
      const std::int64_t at = place(voxels_[i], axis_);
      if (at == 0) bits |= 64;
      if (at == size_[axis_] - 1) bits |= 128;
      faces_[i] = bits;
    });
    for (std::size_t bits = 0; bits < 256; ++bits) {
      double sum = 0;
      for (std::size_t side = 0; side < 6; ++side) {
        if ((bits >> side & 1) != 0) sum += conductance_[side / 2];
      }
      const std::size_t ends = (bits >> 6 & 1) + (bits >> 7 & 1);
      sum += static_cast<double>(ends) * to_end();
      diagonal_[bits] = sum;
    }
  }

  std::size_t count() const { return voxels_.size(); }
  std::int64_t along(std::size_t pore) const { return place(voxels_[pore], axis_); }
  bool is_first(std::size_t pore) const { return (faces_[pore] & 64) != 0; }
  bool is_last(std::size_t pore) const { return (faces_[pore] & 128) != 0; }
  double diagonal(std::size_t pore) const { return diagonal_[faces_[pore]]; }

  /// From a pore half a voxel to where its concentration is held.
  double to_end() const { return 2 * end_conductance(); }

  /// What flows out of a pore less what flows in.
  double balance(const std::vector<double>& c, std::size_t pore) const {
    const std::uint8_t bits = faces_[pore];
    double sum = diagonal_[bits] * c[pore];
    const std::size_t voxel = voxels_[pore];
    if ((bits & 1) != 0) sum -= conductance_[0] * c[pore - 1];
    if ((bits & 2) != 0) sum -= conductance_[0] * c[pore + 1];
    for (std::size_t a = 1; a < 3; ++a) {
      const auto step = static_cast<std::size_t>(strides_[a]);
      if ((bits >> (2 * a) & 1) != 0) sum -= conductance_[a] * c[pore_at(voxel - step)];
      if ((bits >> (2 * a + 1) & 1) != 0) sum -= conductance_[a] * c[pore_at(voxel + step)];
    }
    return sum;
  }

 private:
  void stop_if_cancelled() const {
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
  }
  double end_conductance() const { return conductance_[static_cast<std::size_t>(axis_)]; }
  std::size_t pore_at(std::size_t voxel) const { return static_cast<std::size_t>(index_[voxel]); }

  std::int64_t place(std::size_t voxel, int axis) const {
    return static_cast<std::int64_t>(voxel) / strides_[static_cast<std::size_t>(axis)] %
           size_[axis];
  }

  template <class Visit>
  void visit_neighbors(std::size_t voxel, Visit visit) const {
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t at = place(voxel, axis);
      const auto step = static_cast<std::size_t>(strides_[static_cast<std::size_t>(axis)]);
      if (at > 0) visit(2 * axis, voxel - step);
      if (at + 1 < size_[axis]) visit(2 * axis + 1, voxel + step);
    }
  }

  /// The pores that hang together with those of one plane.
  std::vector<std::uint8_t> flooded(const std::vector<std::uint8_t>& pores,
                                    std::int64_t plane) const {
    std::vector<std::uint8_t> reached(pores.size());
    std::vector<std::size_t> next;
    const auto reach = [&](std::size_t i) {
      if (pores[i] == 0 || reached[i] != 0) return;
      reached[i] = 1;
      next.push_back(i);
    };
    const int u = (axis_ + 1) % 3;
    const int v = (axis_ + 2) % 3;
    const auto stride = [&](int axis) { return strides_[static_cast<std::size_t>(axis)]; };
    for (std::int64_t i = 0; i < size_[u]; ++i) {
      for (std::int64_t j = 0; j < size_[v]; ++j) {
        reach(static_cast<std::size_t>(plane * stride(axis_) + i * stride(u) + j * stride(v)));
      }
    }
    for (std::int64_t steps = 0; !next.empty(); ++steps) {
      if (steps % static_cast<std::int64_t>(kStepsAtOnce) == 0) stop_if_cancelled();
      const std::size_t voxel = next.back();
      next.pop_back();
      visit_neighbors(voxel, [&](int, std::size_t neighbor) { reach(neighbor); });
    }
    return reached;
  }

  Size3 size_;
  int axis_;
  std::array<std::int64_t, 3> strides_;
  const Progress& progress_;
  Point3 conductance_{};  // of a face across each axis
  std::vector<std::int32_t> index_;
  std::vector<std::size_t> voxels_;
  std::vector<std::uint8_t> faces_;  // bits: pores on six sides, the two ends
  std::array<double, 256> diagonal_{};
};

/// Says how far a residual has fallen, by its logarithm: conjugate gradients divide it by about the
/// same at every step.
class FallingResidual {
 public:
  FallingResidual(Progress& progress, double from, double to)
      : progress_(progress), from_(from), fall_(std::log(from / to)) {}

  void reach(double squares) {
    const double share = fall_ > 0 ? std::log(from_ / std::max(squares, 1e-300)) / fall_ : 1;
    const auto parts = static_cast<std::int64_t>(kDiffusionParts * std::clamp(share, 0.0, 1.0));
    if (parts <= done_) return;
    progress_.advance(parts - done_);
    done_ = parts;
  }
  void finish() { reach(0); }

 private:
  Progress& progress_;
  double from_;
  double fall_;
  std::int64_t done_ = 0;
};

/// Concentrations at rest, and how many steps that took.
struct RestingPores {
  std::vector<double> concentration;
  int steps = 0;
};

RestingPores come_to_rest(const PoreNetwork& network, const Size3& size, int axis,
                          Progress& progress) {
  const std::size_t count = network.count();
  const auto planes = static_cast<double>(size[axis]);
  RestingPores rest;
  std::vector<double>& c = rest.concentration;
  c.resize(count);
  std::vector<double> residual(count);
  std::vector<double> way(count);
  std::vector<double> change(count);

  // From a straight slope on.
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    c[i] = 1 - (static_cast<double>(network.along(i)) + 0.5) / planes;
  });
  double inflow = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (network.is_first(i)) inflow += network.to_end() * network.to_end();
  }
  double product = sum_of_runs(count, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const double source = network.is_first(i) ? network.to_end() : 0;
      residual[i] = source - network.balance(c, i);
      way[i] = residual[i] / network.diagonal(i);
      sum += residual[i] * way[i];
    }
    return sum;
  });
  const double start = sum_of_runs(count, [&](std::size_t begin, std::size_t end) {
    double sum = 0;
    for (std::size_t i = begin; i < end; ++i) sum += residual[i] * residual[i];
    return sum;
  });
  const double wanted = kSmallestResidual * kSmallestResidual * inflow;
  FallingResidual falling(progress, start, wanted);
  const int most = 1000 + 20 * static_cast<int>(std::min<std::int64_t>(
                                 size.x + size.y + size.z, 1'000'000));
  for (; product > 0 && rest.steps < most; ++rest.steps) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    const double along = sum_of_runs(count, [&](std::size_t begin, std::size_t end) {
      double sum = 0;
      for (std::size_t i = begin; i < end; ++i) {
        change[i] = network.balance(way, i);
        sum += way[i] * change[i];
      }
      return sum;
    });
    const double step = product / along;
    const double squares = sum_of_runs(count, [&](std::size_t begin, std::size_t end) {
      double sum = 0;
      for (std::size_t i = begin; i < end; ++i) {
        c[i] += step * way[i];
        residual[i] -= step * change[i];
        sum += residual[i] * residual[i];
      }
      return sum;
    });
    if (squares <= wanted) break;
    falling.reach(squares);
    const double before = product;
    product = sum_of_runs(count, [&](std::size_t begin, std::size_t end) {
      double sum = 0;
      for (std::size_t i = begin; i < end; ++i) {
        sum += residual[i] * residual[i] / network.diagonal(i);
      }
      return sum;
    });
    const double kept = product / before;
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      way[i] = residual[i] / network.diagonal(i) + kept * way[i];
    });
  }
  falling.finish();
  return rest;
}

}  // namespace

std::optional<PoreDiffusion> pore_diffusion(const std::vector<std::uint8_t>& pores,
                                            const Size3& size, const Point3& spacing_mm, int axis,
                                            double counted_voxels, Progress& progress) {
  const PoreNetwork network(pores, size, spacing_mm, axis, progress);
  if (network.count() == 0) {
    progress.advance(kDiffusionParts);
    return std::nullopt;
  }
  const RestingPores rest = come_to_rest(network, size, axis, progress);
  double in = 0;
  double out = 0;
  for (std::size_t i = 0; i < network.count(); ++i) {
    if (network.is_first(i)) in += network.to_end() * (1 - rest.concentration[i]);
    if (network.is_last(i)) out += network.to_end() * rest.concentration[i];
  }
  const auto pore_count = static_cast<double>(
      std::count_if(pores.begin(), pores.end(), [](std::uint8_t pore) { return pore != 0; }));
  const double length = spacing_mm[static_cast<std::size_t>(axis)] *
                        static_cast<double>(size[axis]);
  const double volume = counted_voxels * spacing_mm[0] * spacing_mm[1] * spacing_mm[2];
  PoreDiffusion made;
  made.effective = 0.5 * (in + out) * length * length / volume;
  made.tortuosity = pore_count / counted_voxels / made.effective;
  made.steps = rest.steps;
  made.imbalance = std::abs(in - out) / (0.5 * (in + out));
  return made;
}

}  // namespace octavo
