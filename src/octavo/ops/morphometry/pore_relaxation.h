// What flows out of balance is made up for on all scales at once: a multigrid over clusters of
// pores, to precondition conjugate gradients with.
//
//     pores        relax ............ relax       relax: the one color of pores, then the other,
//     clusters       relax .. relax .. relax             each pore given the concentration at
//     clusters         r..r r..r                         which its flows are balanced; on the
//                                                        way up the colors take turns inversely
//
// Every coarser graph is visited twice. Its conductances are at least half of what they would be
// if all pores of a cluster had one concentration, so an error is corrected by up to twice itself,
// and what remains of it is never larger than before, in energy; two visits leave its square. The
// whole is therefore a symmetric and positive operator whatever the pores look like, which
// conjugate gradients need, and one visit alone would not promise.
//
// Concentrations are floats here: what they round off is made up for by the next step.
#pragma once

#include "octavo/ops/morphometry/pore_clusters.h"

namespace octavo {

class PoreRelaxation {
 public:
  /// Merges clusters until none hangs together with another one.
  /// network  is referred to
  /// Throws   Error{cancelled}
  /// Memory   8 bytes a pore, and 25 a cluster and 8 for each of its neighbors: a seventh as many
  ///          clusters as pores in wide ones, as many in mazes one voxel wide, and up to twice as
  ///          many where voxels are long as well
  explicit PoreRelaxation(const PoreNetwork& network);

  /// Concentrations that make up for about all of `balance`, what flows into every pore and not
  /// out of it; valid until the next call. Throws Error{cancelled}.
  const std::vector<float>& relaxed(const std::vector<double>& balance);

  std::size_t level_count() const { return levels_.size(); }
  /// Of all coarser graphs.
  std::size_t cluster_count() const;

 private:
  struct Level {
    PoreClusters clusters;
    std::vector<std::int32_t> coarser;  ///< its cluster, of each of these
    BlockWidths widths{};               ///< of blocks of the next level
    std::vector<float> balance;
    std::vector<float> concentration;
  };

  void relax_pores(const std::vector<double>& balance, int color);
  void gather_from_pores(const std::vector<double>& balance);
  void visit(std::size_t level);
  void relax(Level& level, int color);
  void gather(const Level& level, Level& coarser);
  template <class Work>
  void for_clusters(const Level& level, Work work) const;

  const PoreNetwork& network_;
  std::vector<std::int32_t> cluster_of_;  // of each pore
  BlockWidths widths_{};                  // of the blocks of the first level
  std::vector<float> concentration_;
  std::vector<Level> levels_;
};

}  // namespace octavo
