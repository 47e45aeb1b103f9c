#include <set>

#include "octavo/codec/label/label_codec.h"
#include "octavo/codec/label/label_octant.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label/label_trainer.h"
#include "octavo/codec/label/label_walk.h"

namespace octavo {

std::unique_ptr<BrickCodec> train_label_model(VoxelType type,
                                              std::span<const TrainingBrick> bricks) {
  check_label_type(type);
  LabelWeightSet set = label_start_weights();
  const LabelModel start({}, set);
  std::set<std::int64_t> labels;
  LabelSampleCollector samples;
  for (const TrainingBrick& brick : bricks) {
    const LabelPyramid pyramid = build_label_pyramid(brick.shape, brick.view);
    if (labels.size() <= kMaxPalette) labels.insert(pyramid.labels.begin(), pyramid.labels.end());
    if (pyramid.is_uniform() || pyramid.labels.size() > kMaxLabelSlots) continue;
    label_walk_functions().observe(start, brick.shape, pyramid, samples, thread_label_work());
  }
  if (labels.size() > kMaxPalette) labels.clear();
  for (std::size_t net = 0; net < kLabelNets; ++net) {
    const LabelSamples& kept = samples.of(net);
    set[net] = trained(set[net], kept.list(), kept.seen_count(), {.step = kLabelWeightStep});
  }
  std::vector<std::int64_t> palette(labels.begin(), labels.end());
  return std::make_unique<LabelCodec>(type, LabelModel(std::move(palette), set));
}

}  // namespace octavo
