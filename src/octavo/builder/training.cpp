#include "octavo/builder/training.h"

#include <algorithm>
#include <numeric>

#include "octavo/codec/refine_model.h"

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

}  // namespace

std::vector<std::size_t> training_choice(std::span<const std::int64_t> voxel_counts,
                                         std::int64_t full_voxel_count) {
  std::vector<std::size_t> candidates(voxel_counts.size());
  std::iota(candidates.begin(), candidates.end(), std::size_t{0});
  if (candidates.size() <= kTrainingBricks) return candidates;

  // The thin bricks of the border are not typical.
  const auto is_sliver = [&](std::size_t brick) {
    return 2 * voxel_counts[brick] < full_voxel_count;
  };
  const auto slivers =
      static_cast<std::size_t>(std::count_if(candidates.begin(), candidates.end(), is_sliver));
  if (candidates.size() - slivers >= kTrainingBricks) std::erase_if(candidates, is_sliver);
  if (candidates.size() <= kTrainingBricks) return candidates;

  // One brick out of each of 32 equal parts, at multiples of the golden ratio inside it: out of
  // step with the rows of the brick grid.
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < kTrainingBricks; ++i) {
    const std::uint64_t inside = i * 2654435769u & 0xffffffffu;
    chosen.push_back(candidates[((i << 32) + inside) * candidates.size() / kTrainingBricks >> 32]);
  }
  return chosen;
}

std::vector<TrainingBrick> training_bricks_of(const Levels& levels, int tier,
                                              const VoxelBlock& block) {
  const std::vector<TrainingBrick> candidates = candidates_of(levels, tier, block);
  std::vector<std::int64_t> voxel_counts;
  for (const TrainingBrick& brick : candidates) {
    voxel_counts.push_back(brick.view.size.voxel_count());
  }
  std::vector<TrainingBrick> chosen;
  for (const std::size_t i :
       training_choice(voxel_counts, levels.brick_side(tier).voxel_count())) {
    chosen.push_back(candidates[i]);
  }
  return chosen;
}

std::unique_ptr<BrickCodec> train_on_choice(std::span<const TrainingBrick> chosen, VoxelType type,
                                            VolumeKind kind, const CodecSettings& settings,
                                            const std::optional<SampleCoding>& coding,
                                            const BrickCodec* first) {
  if (!is_integer(type)) return train_exact_model(chosen, settings, *coding);
  if (first != nullptr) return refine_model(*first, type, chosen, settings);
  return train_model(kind, type, chosen, settings);
}

std::unique_ptr<BrickCodec> train_on(const Levels& levels, int tier, const VoxelBlock& block,
                                     VolumeKind kind, const CodecSettings& settings,
                                     const std::optional<SampleCoding>& coding,
                                     const BrickCodec* first) {
  return train_on_choice(training_bricks_of(levels, tier, block), block.type, kind, settings,
                         coding, first);
}

}  // namespace octavo
