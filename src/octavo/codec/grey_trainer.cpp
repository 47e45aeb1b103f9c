// Learns a grey model: chooses the order of the axes and what precision to leave out, then has the
// weights of the prediction (grey_tap_trainer.cpp), contexts and frequencies
// (grey_context_trainer.cpp) learnt.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "octavo/codec/grey_codec.h"
#include "octavo/codec/grey_training.h"

namespace octavo::grey {

namespace {

constexpr int kWeightStep = 3;
constexpr int kCoarseWeightStep = 5;         ///< for models that count beside what they code
constexpr std::uint64_t kLittleBytes = 1 << 18;
constexpr std::size_t kOrderBricks = 16;  ///< bricks that orders are tried on
constexpr std::size_t kTrialBricks = 8;  ///< bricks that ways to quantise are tried on
constexpr double kWorthwhile = 0.0005;   ///< what another order must save
/// Steps of an orthonormal coefficient to try, in tenths of the maximum error.
constexpr int kDetailSteps[] = {14, 16, 18, 22};

/// Six times the median non-zero step between neighbours along x.
std::int32_t learn_threshold(const std::vector<Lesson>& lessons) {
  std::vector<std::int64_t> counts(65536);
  std::int64_t total = 0;
  for (const Lesson& lesson : lessons) {
    const auto& steps = lesson.brick.steps[0];
    const auto& samples = !steps[0].empty() ? steps[0] : !steps[1].empty() ? steps[1] : steps[2];
    for (std::size_t i = 1; i < samples.size(); i += 7) {
      const int step = std::abs(samples[i] - samples[i - 1]);
      if (step == 0) continue;
      ++counts[static_cast<std::size_t>(step)];
      ++total;
    }
  }
  if (total < 100) return 8;
  std::int64_t below = 0;
  std::int32_t median = 0;
  while (below * 2 < total) below += counts[static_cast<std::size_t>(++median)];
  return std::clamp(median * 6, 8, kMaxThreshold);
}

/// What a model is learnt from.
class School {
 public:
  School(std::span<const TrainingBrick> bricks, const AxisOrder& order)
      : bricks_(bricks), order_(order) {}

  std::span<const TrainingBrick> bricks() const { return bricks_; }
  const AxisOrder& order() const { return order_; }

  /// The lessons of codes of `voxel_step`; kept until another step is asked for.
  const std::vector<Lesson>& lessons(std::int64_t voxel_step) {
    if (voxel_step_ != voxel_step) lessons_ = make_lessons(bricks_, voxel_step, order_);
    voxel_step_ = voxel_step;
    return lessons_;
  }

 private:
  std::span<const TrainingBrick> bricks_;
  AxisOrder order_;
  std::int64_t voxel_step_ = 0;
  std::vector<Lesson> lessons_;
};

/// A kind of model.
struct Plan {
  Predictor predictor;
  Quantizer quantizer = {};
  int weight_step = kWeightStep;
};

Parameters learn(School& school, const Plan& plan) {
  Parameters p = default_parameters();
  p.axis_order = school.order();
  p.predictor = plan.predictor;
  p.quantizer = plan.quantizer;
  p.weight_step = plan.weight_step;
  const std::vector<Lesson>& lessons = school.lessons(p.quantizer.voxel_step);
  if (lessons.empty()) return p;
  p.activity_threshold = learn_threshold(lessons);
  // Coarse groups first: quantised levels are learnt on what the coarser ones leave.
  for (int group = kGroups - 1; group >= 0; --group) {
    if (p.predictor == Predictor::means) learn_mean_weights(p, lessons, group);
    else learn_weights(p, lessons, group);
  }
  learn_contexts(p, lessons);
  learn_frequencies(p, lessons);
  return p;
}

/// At most `count` of the bricks, spread evenly.
std::vector<TrainingBrick> some_of(std::span<const TrainingBrick> bricks, std::size_t count) {
  count = std::min(bricks.size(), count);
  std::vector<TrainingBrick> some;
  for (std::size_t i = 0; i < count; ++i) {
    some.push_back(bricks[(2 * i + 1) * bricks.size() / (2 * count)]);
  }
  return some;
}

/// The order of the axes whose details come out smallest on a few bricks.
AxisOrder learn_order(std::span<const TrainingBrick> bricks, const CodecSettings& settings) {
  if (settings.axis_order) return *settings.axis_order;
  if (settings.preset == Preset::fast) return kStraightOrder;
  const std::vector<TrainingBrick> few = some_of(bricks, kOrderBricks);
  AxisOrder best = kStraightOrder;
  double least = 0;
  for (const AxisOrder& order : kAxisOrders) {
    Parameters p = default_parameters();
    p.axis_order = order;
    const std::vector<Lesson> lessons = make_lessons(few, 1, order);
    if (lessons.empty()) return kStraightOrder;
    p.activity_threshold = learn_threshold(lessons);
    double cost = detail_cost(p, lessons);
    // The straight order is the fastest; another one must be worth it.
    if (order == kStraightOrder) cost *= 1 - kWorthwhile;
    if (order == kStraightOrder || cost < least) {
      least = cost;
      best = order;
    }
  }
  return best;
}

/// Bytes that a model and bricks take.
std::uint64_t cost(std::span<const TrainingBrick> bricks, const Parameters& parameters) {
  const GreyCodec codec(parameters);
  std::vector<std::uint64_t> bytes(bricks.size());
  tbb::parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
    for (const Bytes& segment : codec.encode(bricks[i].shape, bricks[i].view).segments) {
      bytes[i] += segment.size();
    }
  });
  return std::accumulate(bytes.begin(), bytes.end(), codec.serialized().size());
}

/// The ways to keep within a maximum error: rounding the voxels; or rounding the details, with
/// several steps, and correcting the voxels that end up beyond it.
std::vector<Plan> plans_for(Predictor predictor, std::int64_t max_error) {
  const std::int64_t step = 2 * max_error + 1;
  std::vector<Plan> plans = {{predictor, {step, 0, 0}}};
  if (max_error == 0) return plans;
  for (const int tenths : kDetailSteps) {
    const std::int64_t detail_step = max_error * tenths * 256 / 10;
    if (detail_step <= kMaxDetailStep) {
      plans.push_back({predictor, {1, static_cast<std::int32_t>(detail_step), step}});
    }
  }
  return plans;
}

/// The plan whose model, learnt from the bricks of the school, codes them best.
Plan best_of(School& school, const std::vector<Plan>& plans) {
  Plan best = plans.front();
  std::uint64_t least = ~std::uint64_t{0};
  for (const Plan& plan : plans) {
    const std::uint64_t bytes = cost(school.bricks(), learn(school, plan));
    if (bytes >= least) continue;
    least = bytes;
    best = plan;
  }
  return best;
}

}  // namespace

}  // namespace octavo::grey

namespace octavo {

std::unique_ptr<BrickCodec> train_grey_model(VoxelType type, std::span<const TrainingBrick> bricks,
                                             const CodecSettings& settings) {
  using namespace grey;
  if (!is_integer(type))
    throw Error(ErrorKind::invalid_argument, "float voxels have no grey codec");
  if (settings.max_error < 0 || 2 * settings.max_error + 1 > kMaxVoxelStep) {
    throw Error(ErrorKind::invalid_argument, "the maximum error is out of range");
  }
  const AxisOrder order = learn_order(bricks, settings);
  const bool is_fast = settings.preset == Preset::fast;
  std::vector<Plan> plans =
      plans_for(is_fast ? Predictor::means : Predictor::neighbours, settings.max_error);
  if (plans.size() > 1) {
    const std::vector<TrainingBrick> few = some_of(bricks, kTrialBricks);
    School trial(few, order);
    plans = {best_of(trial, plans)};
  }
  School school(bricks, order);
  Parameters best = learn(school, plans.front());
  if (is_fast || settings.max_error > 0 || bricks.size() >= kManyBricks) {
    return std::make_unique<GreyCodec>(best);
  }
  // These bricks are all there are: where they take little, the model counts.
  std::uint64_t least = cost(bricks, best);
  if (least >= kLittleBytes) return std::make_unique<GreyCodec>(best);
  for (const Plan& plan :
       {Plan{Predictor::means}, Plan{Predictor::neighbours, {}, kCoarseWeightStep}}) {
    const Parameters p = learn(school, plan);
    const std::uint64_t bytes = cost(bricks, p);
    if (bytes >= least) continue;
    least = bytes;
    best = p;
  }
  return std::make_unique<GreyCodec>(best);
}

}  // namespace octavo
