#include "octavo/mesh/hexahedra/cell_values.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/voxel_type.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr int kMeanBlockLevel = 6;

/// Sum and number of the finite voxels of a cell.
struct CellSum {
  double sum = 0;
  std::uint64_t count = 0;
};

/// Cells that lie in one cube of 64^3, or one cell as large or larger.
struct CellRun {
  std::size_t first = 0;
  std::size_t end = 0;
};

std::vector<CellRun> runs_of(std::span<const HexCell> cells) {
  const auto same_block = [&](const HexCell& a, const HexCell& b) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (a.corner[axis] >> kMeanBlockLevel != b.corner[axis] >> kMeanBlockLevel) return false;
    }
    return true;
  };
  std::vector<CellRun> runs;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (runs.empty() || !same_block(cells[i], cells[runs.back().first])) runs.push_back({i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

/// Reads boxes of a level as real values.
class BoxValues {
 public:
  BoxValues(const FileReader& grey, int level) : grey_(grey), level_(level) {}

  void read(const Box& box) {
    box_ = box;
    const auto count = static_cast<std::size_t>(box.size().voxel_count());
    const VoxelType type = grey_.description().type;
    bytes_.resize(count * static_cast<std::size_t>(bytes_per_voxel(type)));
    grey_.read(box, level_, bytes_.data());
    values_.resize(count);
    with_voxel_type(type, [&](auto id) {
      using T = typename decltype(id)::type;
      const T* const voxels = reinterpret_cast<const T*>(bytes_.data());
      for (std::size_t i = 0; i < count; ++i) values_[i] = static_cast<double>(voxels[i]);
    });
  }

  /// Adds the part of a cell that lies in the box.
  void add(const Box& cell, CellSum& sum) const {
    const Box part = intersection(cell, box_);
    const Size3 size = box_.size();
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
        const std::int64_t row = ((z - box_.lo.z) * size.y + y - box_.lo.y) * size.x - box_.lo.x;
        for (std::int64_t x = part.lo.x; x < part.hi.x; ++x) {
          const double value = values_[static_cast<std::size_t>(row + x)];
          if (!std::isfinite(value)) continue;
          sum.sum += value;
          ++sum.count;
        }
      }
    }
  }

 private:
  const FileReader& grey_;
  int level_;
  Box box_;
  std::vector<std::byte> bytes_;
  std::vector<double> values_;
};

Box box_of_cell(const HexCell& cell) {
  const Index3 lo = {cell.corner[0], cell.corner[1], cell.corner[2]};
  const std::int64_t side = cell.side();
  return {lo, {lo.x + side, lo.y + side, lo.z + side}};
}

void add_run(std::span<const HexCell> cells, BoxValues& values, std::vector<CellSum>& sums) {
  sums.assign(cells.size(), {});
  constexpr std::int64_t kSide = std::int64_t{1} << kMeanBlockLevel;
  Box all;
  for (const HexCell& cell : cells) all = united(all, box_of_cell(cell));
  visit_cells(all, {kSide, kSide, kSide}, [&](const Index3& at) {
    const Index3 lo = {at.x * kSide, at.y * kSide, at.z * kSide};
    values.read(intersection(all, {lo, {lo.x + kSide, lo.y + kSide, lo.z + kSide}}));
    for (std::size_t i = 0; i < cells.size(); ++i) values.add(box_of_cell(cells[i]), sums[i]);
    return true;
  });
}

/// Puts cells and what is known of them into the order of `order`.
void reorder(const std::vector<std::uint32_t>& order, std::vector<HexCell>& cells,
             CellValues& values) {
  const auto taken = [&](auto& all) {
    if (all.empty()) return;
    std::remove_reference_t<decltype(all)> sorted;
    sorted.reserve(all.size());
    for (const std::uint32_t i : order) sorted.push_back(all[i]);
    all = std::move(sorted);
  };
  taken(cells);
  taken(values.mean);
  taken(values.density_g_cm3);
  taken(values.modulus_mpa);
}

template <class Key>
std::vector<HexGroup> grouped(std::vector<HexCell>& cells, CellValues& values, Key&& key) {
  std::vector<std::uint32_t> order(cells.size());
  std::iota(order.begin(), order.end(), std::uint32_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<HexGroup> groups;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key(order[i]) != key(order[i - 1])) {
      HexGroup group;
      group.label = cells[order[i]].label;
      group.first_cell = i;
      groups.push_back(group);
    }
    groups.back().end_cell = i + 1;
  }
  reorder(order, cells, values);
  return groups;
}

}  // namespace

std::vector<float> cell_means(const FileReader& grey, int level, std::span<const HexCell> cells,
                              Progress& progress) {
  const std::vector<CellRun> runs = runs_of(cells);
  std::vector<float> means(cells.size());
  const Rescale rescale = grey.description().rescale;
  PerThread<BoxValues> values([&] { return BoxValues(grey, level); });
  const ProgressScope scope(progress, "grey values", static_cast<std::int64_t>(runs.size()),
                            "bricks");
  parallel_for(std::size_t{0}, runs.size(), [&](std::size_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "cancelled");
    std::vector<CellSum> sums;
    add_run(cells.subspan(runs[i].first, runs[i].end - runs[i].first), values.local(), sums);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const auto count = static_cast<double>(sums[k].count);
      means[runs[i].first + k] = sums[k].count == 0
                                     ? std::numeric_limits<float>::quiet_NaN()
                                     : static_cast<float>(rescale.to_real(sums[k].sum / count));
    }
    progress.advance(1);
  });
  return means;
}

std::vector<float> densities_of(std::span<const float> means, const DensityLine& line) {
  std::vector<float> densities;
  densities.reserve(means.size());
  for (const float mean : means) {
    const double density = line.slope * static_cast<double>(mean) + line.intercept;
    densities.push_back(static_cast<float>(density));
  }
  return densities;
}

std::vector<float> moduli_of(std::span<const float> densities, const ModulusPower& power) {
  std::vector<float> moduli;
  moduli.reserve(densities.size());
  for (const float density : densities) {
    const double modulus =
        power.factor * std::pow(std::max(static_cast<double>(density), 0.0), power.exponent);
    moduli.push_back(static_cast<float>(std::max(modulus, power.minimum_mpa)));
  }
  return moduli;
}

std::vector<HexGroup> group_by_label(std::vector<HexCell>& cells, CellValues& values) {
  return grouped(cells, values, [&](std::uint32_t i) { return cells[i].label; });
}

std::vector<HexGroup> group_by_modulus(std::vector<HexCell>& cells, CellValues& values,
                                       int bin_count) {
  const auto [lowest, highest] =
      std::minmax_element(values.modulus_mpa.begin(), values.modulus_mpa.end());
  const double from = *lowest;
  const double width = (static_cast<double>(*highest) - from) / bin_count;
  const auto bin_of = [&](std::uint32_t i) {
    if (!(width > 0)) return 0;
    const double bin = (static_cast<double>(values.modulus_mpa[i]) - from) / width;
    return std::min(static_cast<int>(bin), bin_count - 1);
  };
  std::vector<HexGroup> groups = grouped(
      cells, values, [&](std::uint32_t i) { return std::pair(cells[i].label, bin_of(i)); });

  // The mean of each group, cells by their volume
  for (HexGroup& group : groups) {
    HexMaterial sum;
    double volume = 0;
    for (std::uint64_t i = group.first_cell; i < group.end_cell; ++i) {
      const auto voxels = static_cast<double>(cube_volume(cells[i].level));
      sum.modulus_mpa += voxels * static_cast<double>(values.modulus_mpa[i]);
      sum.density_g_cm3 += voxels * std::max(static_cast<double>(values.density_g_cm3[i]), 0.0);
      volume += voxels;
    }
    group.material = HexMaterial{sum.modulus_mpa / volume, sum.density_g_cm3 / volume};
  }
  return groups;
}

}  // namespace octavo
