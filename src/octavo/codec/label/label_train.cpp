
#include <set>

#include "octavo/codec/label/label_codec.h"
#include "octavo/codec/label/label_octant.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label/label_trainer.h"
#include "octavo/codec/label/label_walk.h"
#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

// Learns from one brick after the other.
class ModelLearner {
 public:
  explicit ModelLearner(VoxelType type) : type_(type) { check_label_type(type); }

  void learn(const BrickShape& shape, const LabelPyramid& pyramid) {
    if (labels_.size() <= kMaxPalette) {
      labels_.insert(pyramid.labels.begin(), pyramid.labels.end());
    }
    if (pyramid.is_uniform() || pyramid.labels.size() > kMaxLabelSlots) return;
    label_walk_functions().observe(start_, shape, pyramid, samples_, thread_label_work());
  }

  std::unique_ptr<BrickCodec> finish() {
    if (labels_.size() > kMaxPalette) labels_.clear();
    LabelWeightSet set = start_.weights;
    // Each network learns by itself.
    parallel_for(std::size_t{0}, kLabelNets, [&](std::size_t net) {
      const LabelSamples& kept = samples_.of(net);
      set[net] = trained(set[net], kept.list(), kept.seen_count(), {.step = kLabelWeightStep});
    });
    std::vector<std::int64_t> palette(labels_.begin(), labels_.end());
    return std::make_unique<LabelCodec>(type_, LabelModel(std::move(palette), set));
  }

 private:
  VoxelType type_;
  LabelModel start_{{}, label_start_weights()};
  std::set<std::int64_t> labels_;
  LabelSampleCollector samples_;
};

}  // namespace

std::unique_ptr<BrickCodec> train_label_model(VoxelType type,
                                              std::span<const TrainingBrick> bricks) {
  ModelLearner learner(type);
  for (const TrainingBrick& brick : bricks) {
    learner.learn(brick.shape, build_label_pyramid(brick.shape, brick.view));
  }
  return learner.finish();
}

std::unique_ptr<BrickCodec> train_label_words(VoxelType type, std::span<const BrickShape> shapes,
                                              const TakeWords& take) {
  ModelLearner learner(type);
  LabelWords words;
  LabelPyramid pyramid;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    take(i, words);
    build_label_pyramid(shapes[i], words, pyramid);
    learner.learn(shapes[i], pyramid);
  }
  return learner.finish();
}

}  // namespace octavo
