#include "octavo/ops/morphometry/diffusion.h"

#include <algorithm>
#include <cmath>

#include "octavo/ops/morphometry/pore_relaxation.h"

namespace octavo {

namespace {

constexpr std::uint64_t kBytesPerPore = 41;      // of the network, its vectors and relaxation
constexpr std::uint64_t kMostGridBytes = 100;    // of coarser graphs, a pore
constexpr std::uint64_t kNetworkVoxelBytes = 5;  // while it is put up

/// Steps beside one for each plane along x, y and z, what conjugate gradients need without any
/// help: the multigrid makes it a few dozen, so nothing that comes to rest is cut short.
constexpr std::int64_t kMostRestSteps = 1000;
constexpr std::int64_t kMostPlaneSteps = 1'000'000;
/// The least that a step leaves of the flux as it is reckoned along the way: gains that are rounded
/// never make it 0, which errors are shares of.
constexpr double kMinimumFluxKept = 1e-3;

/// Says how far an error has fallen, by its logarithm: conjugate gradients divide it by about the
/// same at every step.
class FallingError {
 public:
  explicit FallingError(Progress& progress) : progress_(progress) {}

  void reach(double error) {
    if (first_ == 0) first_ = error;
    const double fall = std::log(first_ / kDiffusionError);
    const double share = fall > 0 ? std::log(first_ / error) / fall : 1;
    advance_to(static_cast<std::int64_t>(kDiffusionParts * std::clamp(share, 0.0, 1.0)));
  }
  void finish() { advance_to(kDiffusionParts); }

 private:
  void advance_to(std::int64_t parts) {
    if (parts <= done_) return;
    progress_.advance(parts - done_);
    done_ = parts;
  }

  Progress& progress_;
  double first_ = 0;
  std::int64_t done_ = 0;
};

/// Concentrations in pores that come to rest.
class RestingPores {
 public:
  RestingPores(const PoreNetwork& network, Progress& progress)
      : network_(network), relaxation_(network), falling_(progress) {
    const std::size_t numbers = network.count() + 1;
    concentration_.resize(numbers);
    balance_.resize(numbers);
    change_.resize(numbers);
    way_.resize(numbers);
  }

  /// Steps until the flux is known.
  void come_to_rest() {
    start();
    flux_ = flux();
    const Size3& size = network_.size();
    const std::int64_t most =
        kMostRestSteps + std::min(size.x + size.y + size.z, kMostPlaneSteps);
    double product = relax(0);
    error_ = product / flux_;
    for (; steps_ < most && error_ > kDiffusionError; ++steps_) {
      falling_.reach(error_);
      const double along = change_along_way();
      const double step = product / along;
      move(step);
      // The energy falls by what the step is known to gain.
      flux_ = std::max(flux_ - step * product, kMinimumFluxKept * flux_);
      product = relax(along);
      error_ = product / flux_;
    }
    flux_ = flux();
    falling_.finish();
  }

  double flux_between_ends() const { return flux_; }
  int steps() const { return steps_; }
  double error() const { return error_; }

 private:
  /// A straight slope, and what is out of balance.
  void start() {
    const auto planes = static_cast<double>(network_.size()[network_.axis()]);
    network_.for_rows([&](const PoreRow& row) {
      for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
        const auto place = static_cast<double>(network_.along(pore, row));
        concentration_[static_cast<std::size_t>(pore)] = 1 - (place + 0.5) / planes;
      }
    });
    network_.for_rows([&](const PoreRow& row) {
      network_.for_neighbor_sums(row, concentration_, all_, [&](std::int32_t pore, double sum) {
        const auto i = static_cast<std::size_t>(pore);
        const double source = network_.is_first(pore) ? network_.end_conductance() : 0;
        balance_[i] = source + sum - network_.diagonal(pore) * concentration_[i];
      });
    });
  }

  /// Sets the way of the next step; returns the relaxed times the balance, an estimate of how much
  /// larger than at rest the energy is.
  /// along  the change along the way before times that way; 0 before the first step
  double relax(double along) {
    const std::vector<float>& relaxed = relaxation_.relaxed(balance_);
    const auto times = [&](const std::vector<double>& other) {
      return network_.sum_of_rows([&](const PoreRow& row) {
        double sum = 0;
        for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
          const auto i = static_cast<std::size_t>(pore);
          sum += static_cast<double>(relaxed[i]) * other[i];
        }
        return sum;
      });
    };
    // So that the ways stay conjugate though what is relaxed is rounded.
    const auto kept = along > 0 ? static_cast<float>(-times(change_) / along) : 0.0F;
    network_.for_rows([&](const PoreRow& row) {
      for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
        const auto i = static_cast<std::size_t>(pore);
        way_[i] = relaxed[i] + kept * way_[i];
      }
    });
    return times(balance_);
  }

  double change_along_way() {
    return network_.sum_of_rows([&](const PoreRow& row) {
      double sum = 0;
      network_.for_neighbor_sums(row, way_, all_, [&](std::int32_t pore, double neighbors) {
        const auto i = static_cast<std::size_t>(pore);
        const auto own = static_cast<double>(way_[i]);
        change_[i] = network_.diagonal(pore) * own - neighbors;
        sum += own * change_[i];
      });
      return sum;
    });
  }

  void move(double step) {
    network_.for_rows([&](const PoreRow& row) {
      for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
        const auto i = static_cast<std::size_t>(pore);
        concentration_[i] += step * static_cast<double>(way_[i]);
        balance_[i] -= step * change_[i];
      }
    });
  }

  /// The sum of conductance * difference^2 over all faces, and the ends.
  double flux() const {
    return network_.sum_of_rows([&](const PoreRow& row) {
      double sum = 0;
      for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
        const double own = concentration_[static_cast<std::size_t>(pore)];
        network_.visit_links(pore, row, [&](int side, std::int32_t other, double conductance) {
          if (side % 2 == 0) return;  // each face once
          const double fall = own - concentration_[static_cast<std::size_t>(other)];
          sum += conductance * fall * fall;
        });
        if (network_.is_first(pore)) sum += network_.end_conductance() * (1 - own) * (1 - own);
        if (network_.is_last(pore)) sum += network_.end_conductance() * own * own;
      }
      return sum;
    });
  }

  static constexpr auto all_ = [](std::int32_t) { return true; };

  const PoreNetwork& network_;
  PoreRelaxation relaxation_;
  FallingError falling_;
  std::vector<double> concentration_;
  std::vector<double> balance_;  // of every pore: what flows in, less what flows out
  std::vector<double> change_;   // of the balance, along the way
  std::vector<float> way_;
  double flux_ = 0;
  double error_ = 0;
  int steps_ = 0;
};

}  // namespace

std::optional<PoreDiffusion> pore_diffusion(const std::vector<std::uint8_t>& pores,
                                            const Size3& size, const Point3& spacing_mm, int axis,
                                            double counted_voxels, Progress& progress) {
  const PoreNetwork network(pores, size, spacing_mm, axis, progress);
  if (network.count() == 0) {
    progress.advance(kDiffusionParts);
    return std::nullopt;
  }
  RestingPores rest(network, progress);
  rest.come_to_rest();
  const auto pore_count = static_cast<double>(
      std::count_if(pores.begin(), pores.end(), [](std::uint8_t pore) { return pore != 0; }));
  const double length = spacing_mm[static_cast<std::size_t>(axis)] *
                        static_cast<double>(size[axis]);
  const double volume = counted_voxels * spacing_mm[0] * spacing_mm[1] * spacing_mm[2];
  PoreDiffusion made;
  made.effective = rest.flux_between_ends() * length * length / volume;
  made.tortuosity = pore_count / counted_voxels / made.effective;
  made.steps = rest.steps();
  made.error = rest.error();
  return made;
}

std::uint64_t pore_diffusion_bytes(std::uint64_t voxels, std::uint64_t pore_count) {
  return kNetworkVoxelBytes * voxels + (kBytesPerPore + kMostGridBytes) * pore_count;
}

}  // namespace octavo
