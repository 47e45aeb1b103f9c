
#include "octavo/codec/grey/grey_interpolation.h"
#include "octavo/codec/grey/grey_training.h"
#include "octavo/threads/parallel_for.h"

namespace octavo::grey {

std::vector<TrainingSample> make_training_samples(std::span<const TrainingBrick> bricks,
                                                  const Parameters& p) {
  const AxisOrder& order = p.axis_order;
  std::vector<TrainingSample> training(bricks.size());
  parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
    const ValueRange range = range_of(bricks[i].view);
    const int first = detailed_level(p, bricks[i].shape);
    const BrickMap map = map_brick(p.value_map, bricks[i].view, range,
                                   bricks[i].shape.first_level == 0 && first == 0);
    const SampleScale scale = SampleScale::of_voxels(range, code_scale(p, map));
    if (scale.range.min == scale.range.max) return;
    const BrickShape whole = in_order(bricks[i].shape, order);
    const BrickShape shape = shape_from(whole, first);
    training[i] = {shape, analyze<std::int16_t>(whole, bricks[i].view, scale, order, first)};
    if (scale.is_wide()) {
      training[i].brick.scale =
          SampleScale{{0, (scale.range.max - scale.range.min) >> scale.shift()}, {}, true};
    }
    training[i].brick.gaps = gaps_of(p.value_map, map, shape, scale);
  });
  std::erase_if(training,
                [](const TrainingSample& sample) { return sample.shape.level_count < 2; });
  return training;
}

namespace {

/// Puts the details of a split into work.residuals and notes its edges.
void load_split(const Stage& stage, Workspace<std::int16_t>& work,
                const Target<std::int16_t>& target) {
  load_details(work, stage, target);
  if (stage.has_edges) mark_edges(stage, work);
}

}  // namespace

void predict_split(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   const Target<std::int16_t>& target) {
  load_split(stage, work, target);
  stage_functions().narrow.predict(p, stage, work);
}

void list_split(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                const Target<std::int16_t>& target, std::vector<Symbol>& symbols) {
  load_split(stage, work, target);
  stage_functions().narrow.encode(p, stage, work, symbols);
}

void measure_split(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   const Target<std::int16_t>& target) {
  if (stage.has_edges) load_split(stage, work, target);
  stage_functions().narrow.measure(p, stage, work);
  const Size3& size = work.fine.size();
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      std::copy_n(target.samples + (z * target.size.y + y) * target.size.x, size.x,
                  work.fine.row(y, z));
    }
  }
}

void load_level(Workspace<std::int16_t>& work, const TrainingSample& sample, int level) {
  const auto next = static_cast<std::size_t>(level) + 1;
  const Size3& size = sample.shape.size[next];
  const std::vector<std::int16_t>* means = &sample.brick.coarsest;
  if (static_cast<int>(next) + 1 < sample.shape.level_count) {
    for (int axis = 2; axis >= 0; --axis) {
      const auto& step = sample.brick.steps[next][static_cast<std::size_t>(axis)];
      if (!step.empty()) means = &step;
    }
  }
  load_means(work, means->data(), size);
}

}  // namespace octavo::grey
