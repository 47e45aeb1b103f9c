// Pores merged into clusters, and these again: the coarser graphs of a multigrid.
//
// A cluster is what hangs together within a block two pores, or two clusters, wide along each axis:
// what a wall parts stays apart, however thin the wall.
//
//     x x|x .      a a|b .      conductance between two clusters: that of the faces between
//     x x|x .      a a|b .      them, halved where the block is two wide across the face, since
//     ---+---      ---+---      the centers are twice as far apart
//     . x|. x      . a|. c
//
// Blocks are wide along the axes whose side is at most sqrt(2) of the shortest, so that those of
// a coarse axis come later. Where that leaves more than 70 % as many clusters, blocks are 4, 8, ...
// wide along them, as long as they stay shorter than along the others: in sparse pores there would
// be too many graphs otherwise. Clusters are numbered row by row of blocks. Neighbors are in blocks
// that share a face: the sum of the places of a block along x, y and z is even for the one and odd
// for the other, so a half of the clusters can be relaxed at once.
//
// Source  D. Braess, Towards algebraic multigrid for elliptic problems of second order, Computing
//         55 (1995), for what is halved; Y. Notay, An aggregation-based algebraic multigrid
//         method, Electronic Transactions on Numerical Analysis 37 (2010)
#pragma once

#include "octavo/ops/morphometry/pore_network.h"

namespace octavo {

/// Widths of blocks along x, y and z: 1, or a power of two.
using BlockWidths = std::array<std::int64_t, 3>;

/// One coarser graph.
struct PoreClusters {
  Size3 size;  ///< in blocks
  Point3 side_mm{};
  std::vector<std::int32_t> row_starts;   ///< of rows of blocks along x, and the end
  std::vector<std::int32_t> along_x;      ///< place of its block, for each cluster; may be let go
  std::vector<std::uint8_t> colors;       ///< whether the places along x, y and z sum up to odd
  std::vector<std::int64_t> link_starts;  ///< of each cluster, and the end
  std::vector<std::int32_t> links;        ///< neighbors
  std::vector<float> conductances;        ///< to these
  std::vector<float> ends;                ///< conductance to where concentrations are held

  std::size_t count() const { return colors.size(); }
  bool has_links() const { return !links.empty(); }
  std::int64_t row_count() const { return size.y * size.z; }
  PoreRow row(std::int64_t y, std::int64_t z) const {
    const auto at = static_cast<std::size_t>(z * size.y + y);
    return {y, z, row_starts[at], row_starts[at + 1]};
  }
  std::int64_t x_of(std::int32_t cluster) const {
    return along_x[static_cast<std::size_t>(cluster)];
  }
  double to_ends(std::int32_t cluster) const {
    return static_cast<double>(ends[static_cast<std::size_t>(cluster)]);
  }

  /// Visits the neighbors of a cluster: visit(side, neighbor, conductance), as PoreNetwork.
  template <class Visit>
  void visit_links(std::int32_t cluster, const PoreRow& row, Visit visit) const {
    const auto i = static_cast<std::size_t>(cluster);
    for (std::int64_t k = link_starts[i]; k < link_starts[i + 1]; ++k) {
      const std::int32_t other = links[static_cast<std::size_t>(k)];
      visit(side_of(cluster, other, row), other,
            static_cast<double>(conductances[static_cast<std::size_t>(k)]));
    }
  }

 private:
  /// On which side of a cluster another one is that is linked to it.
  int side_of(std::int32_t cluster, std::int32_t other, const PoreRow& row) const {
    if (other >= row.begin && other < row.end) return x_of(other) < x_of(cluster) ? 0 : 1;
    const bool is_lower = other < row.begin;
    const std::int64_t y = is_lower ? row.y - 1 : row.y + 1;
    const bool is_along_y = y >= 0 && y < size.y && other >= this->row(y, row.z).begin &&
                            other < this->row(y, row.z).end;
    return (is_along_y ? 2 : 4) + (is_lower ? 0 : 1);
  }
};

/// A coarser graph, and of each pore or cluster of the finer one that it is in.
struct MergedPores {
  PoreClusters clusters;
  std::vector<std::int32_t> cluster_of;
  BlockWidths widths{};
};

/// Merges pores; that of number 0 is in no cluster.
/// network  also says whether to stop: throws Error{cancelled}
/// Memory   4 bytes a pore, and of every cluster 29, and 8 for each of its neighbors; at first
///          twice as much for the latter
MergedPores merged(const PoreNetwork& network);

/// Merges clusters.
/// network  of the pores that they are of
MergedPores merged(const PoreClusters& finer, const PoreNetwork& network);

}  // namespace octavo
