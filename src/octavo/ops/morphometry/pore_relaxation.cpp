#include "octavo/ops/morphometry/pore_relaxation.h"

#include <utility>

#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kClustersAtOnce = 1 << 13;

/// Calls work(row of blocks) for all rows, in parallel where there are many clusters.
template <class Work>
void for_block_rows(const PoreClusters& clusters, const PoreNetwork& network, Work work) {
  const std::int64_t rows = clusters.row_count();
  const auto count = static_cast<std::int64_t>(clusters.count());
  const std::int64_t at_once =
      std::max<std::int64_t>(1, rows * kClustersAtOnce / std::max<std::int64_t>(1, count));
  parallel_for(std::int64_t{0}, (rows + at_once - 1) / at_once, [&](std::int64_t i) {
    network.stop_if_cancelled();
    for (std::int64_t r = i * at_once; r < std::min((i + 1) * at_once, rows); ++r) work(r);
  });
}

/// Visits the rows of pores or finer clusters in a row of blocks.
template <class Finer, class Visit>
void visit_finer_rows(const Finer& finer, const Size3& size, const BlockWidths& widths,
                      const PoreClusters& clusters, std::int64_t block_row, Visit visit) {
  const std::int64_t y = block_row % clusters.size.y * widths[1];
  const std::int64_t z = block_row / clusters.size.y * widths[2];
  for (std::int64_t k = z; k < std::min(z + widths[2], size.z); ++k) {
    for (std::int64_t j = y; j < std::min(y + widths[1], size.y); ++j) visit(finer.row(j, k));
  }
}

}  // namespace

PoreRelaxation::PoreRelaxation(const PoreNetwork& network) : network_(network) {
  if (network.count() == 0) return;
  MergedPores made = merged(network);
  cluster_of_ = std::move(made.cluster_of);
  widths_ = made.widths;
  while (true) {
    Level level;
    level.clusters = std::move(made.clusters);
    const bool is_last = !level.clusters.has_links();
    if (!is_last) {
      made = merged(level.clusters, network);
      level.coarser = std::move(made.cluster_of);
      level.widths = made.widths;
    }
    level.clusters.along_x = {};  // places are for merging alone
    level.balance.resize(level.clusters.ends.size());
    level.concentration.resize(level.clusters.ends.size());
    levels_.push_back(std::move(level));
    if (is_last) break;
  }
  concentration_.resize(network.count() + 1);
}

std::size_t PoreRelaxation::cluster_count() const {
  std::size_t count = 0;
  for (const Level& level : levels_) count += level.clusters.count();
  return count;
}

const std::vector<float>& PoreRelaxation::relaxed(const std::vector<double>& balance) {
  // Those of the first color have no concentration around them yet.
  network_.for_rows([&](const PoreRow& row) {
    for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
      const auto i = static_cast<std::size_t>(pore);
      concentration_[i] = static_cast<float>(balance[i] / network_.diagonal(pore));
    }
  });
  relax_pores(balance, 1);
  gather_from_pores(balance);
  visit(0);
  const std::vector<float>& coarser = levels_.front().concentration;
  network_.for_rows([&](const PoreRow& row) {
    for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
      const auto i = static_cast<std::size_t>(pore);
      concentration_[i] += coarser[static_cast<std::size_t>(cluster_of_[i])];
    }
  });
  relax_pores(balance, 1);
  relax_pores(balance, 0);
  return concentration_;
}

void PoreRelaxation::relax_pores(const std::vector<double>& balance, int color) {
  network_.for_rows([&](const PoreRow& row) {
    network_.for_neighbor_sums(
        row, concentration_,
        [&](std::int32_t pore) { return (network_.x_of(pore) + row.y + row.z) % 2 == color; },
        [&](std::int32_t pore, double sum) {
          const auto i = static_cast<std::size_t>(pore);
          concentration_[i] = static_cast<float>((balance[i] + sum) / network_.diagonal(pore));
        });
  });
}

/// Adds up what is out of balance in each cluster: of the first color alone, since the second one
/// has just been balanced.
void PoreRelaxation::gather_from_pores(const std::vector<double>& balance) {
  Level& level = levels_.front();
  for_block_rows(level.clusters, network_, [&](std::int64_t block_row) {
    const auto r = static_cast<std::size_t>(block_row);
    std::fill(level.balance.begin() + level.clusters.row_starts[r],
              level.balance.begin() + level.clusters.row_starts[r + 1], 0.0F);
    const auto add = [&](const PoreRow& row) {
      network_.for_neighbor_sums(
          row, concentration_,
          [&](std::int32_t pore) { return (network_.x_of(pore) + row.y + row.z) % 2 == 0; },
          [&](std::int32_t pore, double sum) {
            const auto i = static_cast<std::size_t>(pore);
            const double out = network_.diagonal(pore) * static_cast<double>(concentration_[i]);
            level.balance[static_cast<std::size_t>(cluster_of_[i])] +=
                static_cast<float>(balance[i] + sum - out);
          });
    };
    visit_finer_rows(network_, network_.size(), widths_, level.clusters, block_row, add);
  });
}

void PoreRelaxation::visit(std::size_t number) {
  Level& level = levels_[number];
  if (!level.clusters.has_links()) {
    for_clusters(level, [&](std::size_t i) {
      level.concentration[i] = level.balance[i] / level.clusters.ends[i];
    });
    return;
  }
  Level& coarser = levels_[number + 1];
  for_clusters(level, [&](std::size_t i) { level.concentration[i] = 0; });
  for (int times = 0; times < 2; ++times) {
    // The second time the first color is balanced already.
    if (times == 0) relax(level, 0);
    relax(level, 1);
    gather(level, coarser);
    visit(number + 1);
    for_clusters(level, [&](std::size_t i) {
      level.concentration[i] += coarser.concentration[static_cast<std::size_t>(level.coarser[i])];
    });
    relax(level, 1);
    relax(level, 0);
  }
}

template <class Work>
void PoreRelaxation::for_clusters(const Level& level, Work work) const {
  const auto count = static_cast<std::int64_t>(level.balance.size());
  parallel_for(std::int64_t{0}, (count + kClustersAtOnce - 1) / kClustersAtOnce,
                    [&](std::int64_t part) {
                      const std::int64_t end = std::min((part + 1) * kClustersAtOnce, count);
                      for (std::int64_t i = part * kClustersAtOnce; i < end; ++i) {
                        work(static_cast<std::size_t>(i));
                      }
                    });
}

void PoreRelaxation::relax(Level& level, int color) {
  network_.stop_if_cancelled();
  const PoreClusters& clusters = level.clusters;
  for_clusters(level, [&](std::size_t i) {
    if (clusters.colors[i] != color) return;
    auto in = static_cast<double>(level.balance[i]);
    auto all = static_cast<double>(clusters.ends[i]);
    for (auto k = static_cast<std::size_t>(clusters.link_starts[i]);
         k < static_cast<std::size_t>(clusters.link_starts[i + 1]); ++k) {
      const auto conductance = static_cast<double>(clusters.conductances[k]);
      const auto other = static_cast<std::size_t>(clusters.links[k]);
      in += conductance * static_cast<double>(level.concentration[other]);
      all += conductance;
    }
    level.concentration[i] = static_cast<float>(in / all);
  });
}

void PoreRelaxation::gather(const Level& level, Level& coarser) {
  const PoreClusters& clusters = level.clusters;
  const auto left = [&](std::size_t i) {
    auto in = static_cast<double>(level.balance[i]);
    const auto own = static_cast<double>(level.concentration[i]);
    in -= static_cast<double>(clusters.ends[i]) * own;
    for (auto k = static_cast<std::size_t>(clusters.link_starts[i]);
         k < static_cast<std::size_t>(clusters.link_starts[i + 1]); ++k) {
      const auto other = static_cast<std::size_t>(clusters.links[k]);
      in += static_cast<double>(clusters.conductances[k]) *
            (static_cast<double>(level.concentration[other]) - own);
    }
    return in;
  };
  for_block_rows(coarser.clusters, network_, [&](std::int64_t block_row) {
    const auto r = static_cast<std::size_t>(block_row);
    std::fill(coarser.balance.begin() + coarser.clusters.row_starts[r],
              coarser.balance.begin() + coarser.clusters.row_starts[r + 1], 0.0F);
    const auto add = [&](const PoreRow& row) {
      for (std::int32_t one = row.begin; one < row.end; ++one) {
        const auto i = static_cast<std::size_t>(one);
        if (clusters.colors[i] != 0) continue;
        coarser.balance[static_cast<std::size_t>(level.coarser[i])] += static_cast<float>(left(i));
      }
    };
    visit_finer_rows(clusters, clusters.size, level.widths, coarser.clusters, block_row, add);
  });
}

}  // namespace octavo
