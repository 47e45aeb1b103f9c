#include <set>

#include "octavo/codec/label_codec.h"
#include "octavo/codec/label_pyramid.h"
#include "octavo/codec/label_trainer.h"
#include "octavo/codec/label_truth.h"
#include "octavo/codec/label_walk.h"

namespace octavo {

namespace {

using SampleSet = std::array<LabelSamples, kLabelNets>;

/// Takes the truth for every answer and keeps the networks' questions.
class TrainingIo : public LabelTruth {
 public:
  TrainingIo(const LabelPyramid& pyramid, SampleSet& samples)
      : LabelTruth(pyramid), samples_(samples) {}

  bool ask(LabelAsk, bool truth, Probability) { return truth; }
  void observe(LabelAsk kind, const LabelQuestion& question, bool answer) {
    samples_[static_cast<std::size_t>(kind)].add(question, answer);
  }

 private:
  SampleSet& samples_;
};

void collect(const LabelModel& model, const BrickShape& shape, const LabelPyramid& pyramid,
             SampleSet& samples) {
  TrainingIo io(pyramid, samples);
  LabelWalk<TrainingIo> walk(model, {pyramid.labels.front(), pyramid.labels.back()}, io);
  LabelGrid grid = walk.root();
  for (int level = shape.level_count - 1; level >= 0; --level) {
    io.enter(level);
    grid = walk.descend(grid, shape, level);
  }
}

}  // namespace

std::unique_ptr<BrickCodec> train_label_model(VoxelType type,
                                              std::span<const TrainingBrick> bricks) {
  check_label_type(type);
  LabelWeightSet set = label_start_weights();
  const LabelModel start({}, set);
  std::set<std::int64_t> labels;
  SampleSet samples;
  for (const TrainingBrick& brick : bricks) {
    const LabelPyramid pyramid = build_label_pyramid(brick.shape, brick.view);
    if (labels.size() <= kMaxPalette) labels.insert(pyramid.labels.begin(), pyramid.labels.end());
    if (!pyramid.is_uniform()) collect(start, brick.shape, pyramid, samples);
  }
  if (labels.size() > kMaxPalette) labels.clear();
  for (std::size_t net = 0; net < kLabelNets; ++net) {
    set[net] = trained(set[net], samples[net], kLabelWeightStep);
  }
  std::vector<std::int64_t> palette(labels.begin(), labels.end());
  return std::make_unique<LabelCodec>(type, LabelModel(std::move(palette), set));
}

}  // namespace octavo
