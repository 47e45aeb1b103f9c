#include "octavo/builder/training.h"

#include <algorithm>

namespace octavo {

namespace {

std::vector<TrainingBrick> candidates_of(const Levels& levels, int tier, const VoxelBlock& block) {
  std::vector<TrainingBrick> candidates;
  for (const Index3& brick : bricks_of(levels, tier, block)) {
    const BrickView view = view_of(block, levels.brick_box(tier, brick));
    if (!is_uniform(view)) candidates.push_back({brick_shape(levels, tier, brick), view});
  }
  return candidates;
}

/// Leaves out the thin bricks of the border, which are not typical, as long as enough others
/// remain.
void drop_slivers(std::vector<TrainingBrick>& candidates, const Size3& full) {
  const auto is_sliver = [&](const TrainingBrick& brick) {
    return 2 * brick.view.size.voxel_count() < full.voxel_count();
  };
  const auto slivers =
      static_cast<std::size_t>(std::count_if(candidates.begin(), candidates.end(), is_sliver));
  if (candidates.size() - slivers >= kTrainingBricks) std::erase_if(candidates, is_sliver);
}

}  // namespace

std::unique_ptr<BrickCodec> train_on(const Levels& levels, int tier, const VoxelBlock& block,
                                     VolumeKind kind, const CodecSettings& settings) {
  std::vector<TrainingBrick> candidates = candidates_of(levels, tier, block);
  if (candidates.size() > kTrainingBricks) drop_slivers(candidates, levels.brick_side(tier));
  if (candidates.size() <= kTrainingBricks) {
    return train_model(kind, block.type, candidates, settings);
  }
  std::vector<TrainingBrick> chosen;
  for (std::size_t i = 0; i < kTrainingBricks; ++i) {
    // One brick out of each of 32 equal parts, at multiples of the golden ratio inside it: out of
    // step with the rows of the brick grid.
    const std::uint64_t inside = i * 2654435769u & 0xffffffffu;
    chosen.push_back(candidates[((i << 32) + inside) * candidates.size() / kTrainingBricks >> 32]);
  }
  return train_model(kind, block.type, chosen, settings);
}

}  // namespace octavo
