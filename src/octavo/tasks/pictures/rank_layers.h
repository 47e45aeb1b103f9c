// Meshes in a picture of rays by ranks: each layer comes to the rank through whose nodes the ray
// runs there.
//
//     tiles / ranks   each finds the layers of its share of the tiles   -> the ranks that take them
//     rank            casts the rays of a run of nodes through the layers that lie in it
//
// A rank holds the triangles of all meshes, and no layers but those of its own tiles and runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/dist/communicator.h"
#include "octavo/render/rays/octree_nodes.h"
#include "octavo/render/rays/ray_meshes.h"
#include "octavo/render/rays/ray_regions.h"

namespace octavo {

/// A picture that ranks share. Views, which must outlive it.
struct RankPicture {
  const RayFrame& frame;  ///< with its meshes and the tables of bricks
  std::span<const RayRegion> regions;  ///< that rays cross
  std::int64_t width = 0;
  std::int64_t height = 0;
};

/// Octree nodes that follow each other in the order in which rays come to them, of one rank.
struct NodeRun {
  int rank = 0;
  std::vector<OctreeNode> nodes;
};

/// The tiles of a picture that have layers.
struct RunTiles {
  std::vector<std::size_t> numbers;  ///< each once, in no order
  std::vector<TileLayers> layers;
};

/// Layers by run; only of runs that have some. As large as the layers are, however many runs and
/// tiles there are.
using RunLayers = std::map<std::size_t, RunTiles>;

/// Collective: the layers of the frame's meshes that lie in this rank's runs. Of modes other than
/// volume, which have meshes in front of what was gathered, all of them at rank 0, as of run 0.
/// runs  of all ranks, in their order, which hold every brick of the grid once
/// Uses the threads of the caller's arena. Throws as RayMeshes::layers and Communicator
RunLayers layers_of_runs(const RankPicture& picture, const std::vector<NodeRun>& runs,
                         Communicator& ranks, const Progress& watcher);

}  // namespace octavo
