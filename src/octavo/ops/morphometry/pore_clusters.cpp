#include "octavo/ops/morphometry/pore_clusters.h"

#include <cmath>
#include <limits>
#include <utility>

#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kBlockRowsAtOnce = 64;
constexpr double kMostLeft = 0.7;  // of clusters, where blocks are two wide
const double kAlike = std::sqrt(2.0);  // sides of blocks whose axes are merged at once

/// Neighbors of the clusters of some rows, one cluster after the other.
struct ClusterLinks {
  std::vector<std::int32_t> counts;  // of each cluster
  std::vector<std::int32_t> links;
  std::vector<float> conductances;
  std::vector<float> ends;
};

/// Merges what hangs together in blocks of a finer graph.
template <class Finer>
class PoreMerger {
 public:
  PoreMerger(const Finer& finer, const Size3& size, const Point3& side_mm, std::size_t count,
             const PoreNetwork& network)
      : finer_(finer), size_(size), side_(side_mm), count_(count), network_(network) {}

  MergedPores take(std::size_t numbers) {
    made_.cluster_of.assign(numbers, 0);
    find_short_axes();
    std::int64_t width = 1;
    bool is_enough = false;
    do {
      width *= 2;
      set_widths(width);
      join();
      count();
      const auto found = static_cast<double>(made_.clusters.row_starts.back());
      is_enough = found <= kMostLeft * static_cast<double>(count_);
    } while (!is_enough && 2 * static_cast<double>(width) * shortest_ <= kAlike * next_longer_);
    number();
    link();
    return std::move(made_);
  }

 private:
  std::int32_t& cluster_of(std::int32_t pore) {
    return made_.cluster_of[static_cast<std::size_t>(pore)];
  }

  /// The axes along which clusters are merged: the shortest one and those like it.
  void find_short_axes() {
    shortest_ = std::numeric_limits<double>::infinity();
    for (std::size_t a = 0; a < 3; ++a) {
      if (size_[static_cast<int>(a)] > 1) shortest_ = std::min(shortest_, side_[a]);
    }
    next_longer_ = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      if (size_[static_cast<int>(a)] == 1 || side_[a] <= kAlike * shortest_) continue;
      if (next_longer_ == 0 || side_[a] < next_longer_) next_longer_ = side_[a];
    }
  }

  void set_widths(std::int64_t width) {
    PoreClusters& made = made_.clusters;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::int64_t count = size_[static_cast<int>(a)];
      made_.widths[a] = count > 1 && side_[a] <= kAlike * shortest_ ? width : 1;
      made.size[static_cast<int>(a)] = (count + made_.widths[a] - 1) / made_.widths[a];
      made.side_mm[a] = side_[a] * static_cast<double>(made_.widths[a]);
    }
  }

  /// Calls work(first row, row after the last) for groups of rows of blocks, in parallel.
  template <class Work>
  void for_row_groups(Work work) {
    const std::int64_t rows = made_.clusters.row_count();
    const std::int64_t groups = (rows + kBlockRowsAtOnce - 1) / kBlockRowsAtOnce;
    parallel_for(std::int64_t{0}, groups, [&](std::int64_t i) {
      network_.stop_if_cancelled();
      work(i * kBlockRowsAtOnce, std::min((i + 1) * kBlockRowsAtOnce, rows));
    });
  }

  /// Visits what is finer in a row of blocks, in the order of its numbers: visit(pore, its row).
  template <class Visit>
  void visit_finer(std::int64_t block_row, Visit visit) const {
    const BlockWidths& widths = made_.widths;
    const std::int64_t y = block_row % made_.clusters.size.y * widths[1];
    const std::int64_t z = block_row / made_.clusters.size.y * widths[2];
    for (std::int64_t k = z; k < std::min(z + widths[2], size_.z); ++k) {
      for (std::int64_t j = y; j < std::min(y + widths[1], size_.y); ++j) {
        const PoreRow row = finer_.row(j, k);
        for (std::int32_t pore = row.begin; pore < row.end; ++pore) visit(pore, row);
      }
    }
  }

  std::int32_t first_of(std::int32_t pore) {
    while (cluster_of(pore) != pore) {
      cluster_of(pore) = cluster_of(cluster_of(pore));
      pore = cluster_of(pore);
    }
    return pore;
  }

  /// Lets every pore know one before it in its cluster, or itself where it is the first.
  void join() {
    for_row_groups([&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t r = begin; r < end; ++r) {
        visit_finer(r, [&](std::int32_t pore, const PoreRow&) { cluster_of(pore) = pore; });
        visit_finer(r, [&](std::int32_t pore, const PoreRow& row) {
          const Index3 place = {finer_.x_of(pore), row.y, row.z};
          finer_.visit_links(pore, row, [&](int side, std::int32_t other, double) {
            const bool is_upper = side % 2 != 0;
            const auto axis = static_cast<std::size_t>(side / 2);
            if (is_upper || place[side / 2] % made_.widths[axis] == 0) {
              return;
            }
            const std::int32_t one = first_of(pore);
            const std::int32_t two = first_of(other);
            cluster_of(std::max(one, two)) = std::min(one, two);
          });
        });
      }
    });
  }

  /// How many first ones each row of blocks has.
  void count() {
    PoreClusters& made = made_.clusters;
    const auto rows = static_cast<std::size_t>(made.row_count());
    made.row_starts.assign(rows + 1, 0);
    for_row_groups([&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t r = begin; r < end; ++r) {
        std::int32_t count = 0;
        visit_finer(r, [&](std::int32_t pore, const PoreRow&) {
          count += cluster_of(pore) == pore ? 1 : 0;
        });
        made.row_starts[static_cast<std::size_t>(r) + 1] = count;
      }
    });
    for (std::size_t r = 0; r < rows; ++r) made.row_starts[r + 1] += made.row_starts[r];
  }

  /// Gives clusters their numbers, in the order of their first pores.
  void number() {
    PoreClusters& made = made_.clusters;
    const auto count = static_cast<std::size_t>(made.row_starts.back());
    made.along_x.resize(count);
    made.colors.resize(count);
    for_row_groups([&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t r = begin; r < end; ++r) number_row(r);
    });
  }

  void number_row(std::int64_t r) {
    PoreClusters& made = made_.clusters;
    const std::int64_t across = r % made.size.y + r / made.size.y;
    std::int32_t next = made.row_starts[static_cast<std::size_t>(r)];
    // Those before are known already, by the complement of their number.
    visit_finer(r, [&](std::int32_t pore, const PoreRow&) {
      if (cluster_of(pore) != pore) {
        cluster_of(pore) = cluster_of(cluster_of(pore));
        return;
      }
      const std::int64_t x = finer_.x_of(pore) / made_.widths[0];
      const auto i = static_cast<std::size_t>(next);
      made.along_x[i] = static_cast<std::int32_t>(x);
      made.colors[i] = static_cast<std::uint8_t>((x + across) % 2);
      cluster_of(pore) = ~next++;
    });
    visit_finer(r, [&](std::int32_t pore, const PoreRow&) {
      cluster_of(pore) = ~cluster_of(pore);
    });
  }

  /// Adds up the faces between clusters.
  void link() {
    PoreClusters& made = made_.clusters;
    const std::int64_t rows = made.row_count();
    std::vector<ClusterLinks> groups(
        static_cast<std::size_t>((rows + kBlockRowsAtOnce - 1) / kBlockRowsAtOnce));
    for_row_groups([&](std::int64_t begin, std::int64_t end) {
      ClusterLinks& group = groups[static_cast<std::size_t>(begin / kBlockRowsAtOnce)];
      for (std::int64_t r = begin; r < end; ++r) link_row(r, group);
    });
    made.link_starts.reserve(made.count() + 1);
    made.link_starts.push_back(0);
    std::int64_t all = 0;
    for (const ClusterLinks& group : groups) {
      for (const std::int32_t count : group.counts) made.link_starts.push_back(all += count);
    }
    made.links.reserve(static_cast<std::size_t>(all));
    made.conductances.reserve(static_cast<std::size_t>(all));
    made.ends.reserve(made.count());
    for (ClusterLinks& group : groups) {
      made.links.insert(made.links.end(), group.links.begin(), group.links.end());
      made.conductances.insert(made.conductances.end(), group.conductances.begin(),
                               group.conductances.end());
      made.ends.insert(made.ends.end(), group.ends.begin(), group.ends.end());
      group = {};
    }
  }

  void link_row(std::int64_t r, ClusterLinks& group) {
    const PoreClusters& made = made_.clusters;
    const std::int32_t begin = made.row_starts[static_cast<std::size_t>(r)];
    const std::int32_t count = made.row_starts[static_cast<std::size_t>(r) + 1] - begin;

    // Pores by their cluster.
    std::vector<std::size_t> starts(static_cast<std::size_t>(count) + 2, 0);
    const auto slot = [&](std::int32_t pore) {
      return static_cast<std::size_t>(cluster_of(pore) - begin);
    };
    std::size_t all = 0;
    visit_finer(r, [&](std::int32_t pore, const PoreRow&) {
      ++starts[slot(pore) + 2];
      ++all;
    });
    for (std::size_t i = 2; i < starts.size(); ++i) starts[i] += starts[i - 1];
    std::vector<std::pair<std::int32_t, PoreRow>> members(all);
    visit_finer(r, [&](std::int32_t pore, const PoreRow& row) {
      members[starts[slot(pore) + 1]++] = {pore, row};
    });

    // Faces of each.
    std::vector<std::pair<std::int32_t, double>> found;
    for (std::int32_t i = 0; i < count; ++i) {
      found.clear();
      double end = 0;
      for (std::size_t k = starts[static_cast<std::size_t>(i)];
           k < starts[static_cast<std::size_t>(i) + 1]; ++k) {
        const auto& [pore, row] = members[k];
        end += finer_.to_ends(pore) * share_across(network_.axis());
        finer_.visit_links(pore, row, [&](int side, std::int32_t other, double conductance) {
          const std::int32_t to = cluster_of(other);
          if (to != begin + i) add(found, to, conductance * share_across(side / 2));
        });
      }
      std::sort(found.begin(), found.end());
      group.counts.push_back(static_cast<std::int32_t>(found.size()));
      group.ends.push_back(static_cast<float>(end));
      for (const auto& [to, conductance] : found) {
        group.links.push_back(to);
        group.conductances.push_back(static_cast<float>(conductance));
      }
    }
  }

  static void add(std::vector<std::pair<std::int32_t, double>>& found, std::int32_t to,
                  double conductance) {
    for (auto& [other, sum] : found) {
      if (other != to) continue;
      sum += conductance;
      return;
    }
    found.emplace_back(to, conductance);
  }

  double share_across(int axis) const {
    return made_.widths[static_cast<std::size_t>(axis)] == 1 ? 1 : 0.5;
  }

  const Finer& finer_;
  Size3 size_;
  Point3 side_;
  std::size_t count_;  // of what is finer
  double shortest_ = 0;
  double next_longer_ = 0;  // 0 where all are alike
  const PoreNetwork& network_;
  MergedPores made_;
};

}  // namespace

MergedPores merged(const PoreNetwork& network) {
  return PoreMerger<PoreNetwork>(network, network.size(), network.spacing_mm(), network.count(),
                                 network)
      .take(network.count() + 1);
}

MergedPores merged(const PoreClusters& finer, const PoreNetwork& network) {
  return PoreMerger<PoreClusters>(finer, finer.size, finer.side_mm, finer.count(), network)
      .take(finer.count());
}

}  // namespace octavo
