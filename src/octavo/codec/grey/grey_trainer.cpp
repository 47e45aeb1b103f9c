// Learns a grey model: chooses the order of the axes and what precision to leave out, then has the
// weights of the prediction (grey_tap_trainer.cpp, grey_mean_trainer.cpp), contexts and frequencies
// (grey_context_trainer.cpp) learned.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "octavo/codec/grey/grey_codec.h"
#include "octavo/codec/grey/grey_training.h"
#include "octavo/codec/grey/voxel_walk.h"
#include "octavo/codec/refine_model.h"
#include "octavo/threads/parallel_for.h"

namespace octavo::grey {

namespace {

constexpr int kWeightStep = 3;
constexpr int kCoarseWeightStep = 5;         ///< for models that count beside what they code
constexpr std::uint64_t kLittleBytes = 1 << 18;
constexpr std::size_t kOrderBricks = 16;  ///< bricks with crops that orders are tried on
constexpr std::size_t kCropsOfBrick = 4;  ///< at most
constexpr std::int64_t kCropSide = 32;
constexpr std::size_t kRefiningBricks = 16;  ///< bricks that another group's model is refined on
constexpr std::size_t kFewBricks = 8;        ///< fewer are trained on in full
/// What tables of another group may cost above those of a group's own, and what refined weights may
/// save: up to 0.3 % and 0.1 % in one scan, 0.5 % or more where its content changes.
constexpr double kOtherTables = 0.005;
constexpr double kOtherWeights = 0.002;
constexpr double kWorthwhile = 0.0005;   ///< what another order must save
constexpr double kMuchBackground = 0.4;  ///< of the voxels, where edges are told apart
constexpr std::int64_t kBackgroundRows = 5;  ///< one in so many is counted
/// What cuts may cost that were not asked for, in thousandths, and bricks that they are counted on.
constexpr std::uint64_t kMaxCutCost = 7;
constexpr std::size_t kCutBricks = 8;
/// Steps of an orthonormal coefficient to try, in tenths of the maximum error.
constexpr int kDetailSteps[] = {14, 16, 18, 22};

/// Six times the median non-zero step between neighbors along x.
std::int32_t learn_threshold(const std::vector<TrainingSample>& training) {
  std::vector<std::int64_t> counts(65536);
  std::int64_t total = 0;
  for (const TrainingSample& sample : training) {
    const auto& steps = sample.brick.steps[0];
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

/// What a model is learned from.
class TrainingSet {
 public:
  TrainingSet(std::span<const TrainingBrick> bricks, const AxisOrder& order, const ValueMap& map,
              std::uint8_t cut_axes, int detail_level)
      : bricks_(bricks) {
    start_.axis_order = order;
    start_.value_map = map;
    start_.cut_axes = cut_axes;
    start_.detail_level = detail_level;
  }

  std::span<const TrainingBrick> bricks() const { return bricks_; }
  /// Default parameters but for the order of the axes, the value map and the cuts.
  const Parameters& start() const { return start_; }
  void leave_whole() { start_.cut_axes = 0; }

  /// The training samples for the voxel step of p; kept until another step is asked for.
  const std::vector<TrainingSample>& training(const Parameters& p) {
    if (voxel_step_ != p.quantizer.voxel_step) training_ = make_training_samples(bricks_, p);
    voxel_step_ = p.quantizer.voxel_step;
    return training_;
  }

 private:
  std::span<const TrainingBrick> bricks_;
  Parameters start_ = default_parameters();
  std::int64_t voxel_step_ = 0;
  std::vector<TrainingSample> training_;
};

/// A kind of model.
struct Plan {
  Predictor predictor;
  Quantizer quantizer = {};
  int weight_step = kWeightStep;
  bool has_edges = false;
};

/// Contexts and tables are learned from one in so many training samples: two where they are many.
std::size_t share_of(const std::vector<TrainingSample>& training, std::size_t many) {
  return training.size() < many ? 1 : 2;
}

Parameters learn(TrainingSet& set, const Plan& plan) {
  Parameters p = set.start();
  p.predictor = plan.predictor;
  p.quantizer = plan.quantizer;
  p.weight_step = plan.weight_step;
  p.has_edges = plan.has_edges;
  const std::vector<TrainingSample>& training = set.training(p);
  if (training.empty()) return p;
  p.activity_threshold = learn_threshold(training);
  // Coarse groups first: quantized levels are learned on what the coarser ones leave.
  for (int group = kGroups - 1; group >= 0; --group) {
    if (p.predictor == Predictor::means) learn_mean_weights(p, training, group);
    else learn_weights(p, training, group);
  }
  const std::size_t share = share_of(training, kManyBricks);
  learn_contexts(p, training, share);
  learn_frequencies(p, training, share);
  return p;
}

/// The same model with coarser weights, which take fewer bytes.
Parameters coarsened(Parameters p, TrainingSet& set) {
  p.weight_step = kCoarseWeightStep;
  coarsen_weights(p);
  const std::vector<TrainingSample>& training = set.training(p);
  learn_frequencies(p, training, share_of(training, kManyBricks));
  return p;
}

/// Whether the tables of a model come of samples; those of a group without any are the default.
bool has_learned(const Parameters& p) {
  return p.frequencies != default_parameters().frequencies;
}

/// A model of the kind of another group's, whose weights are the start; nothing where the content
/// of these bricks is another, or where they are few: weights fitted to all of their samples serve
/// them better.
std::optional<Parameters> refined(TrainingSet& set, const Parameters& start) {
  const ValueMap& map = set.start().value_map;
  if (!has_learned(start) || map.lattice.step != start.value_map.lattice.step ||
      map.used.empty() != start.value_map.used.empty()) {
    return std::nullopt;
  }
  Parameters p = start;
  p.value_map = map;
  const std::vector<TrainingSample>& training = set.training(p);
  if (training.size() < kFewBricks) return std::nullopt;
  const std::size_t share = share_of(training, kRefiningBricks);
  const TableCost before = table_cost(p, training, share);
  if (before.excess() > kOtherTables) return std::nullopt;
  for (int group = kGroups - 1; group >= 0; --group) {
    if (p.predictor == Predictor::means) learn_mean_weights(p, training, group);
    else refine_weights(p, training, group);
  }
  const TableCost after = learn_contexts(p, training, share);
  if (static_cast<double>(after.own_bits) <
      static_cast<double>(before.own_bits) * (1 - kOtherWeights)) {
    return std::nullopt;
  }
  learn_frequencies(p, training, share);
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

/// The level 0 of a box of a brick, at its low or high end of each axis: bits of `corner` as in a
/// HalvingMask.
TrainingBrick crop_of(const TrainingBrick& brick, unsigned corner) {
  TrainingBrick crop = brick;
  BrickShape& shape = crop.shape;
  shape.level_count = 2;
  shape.halving[1] = 0;
  const std::int64_t steps[3] = {1, brick.view.row_stride, brick.view.plane_stride};
  std::int64_t first = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t size = brick.view.size[axis];
    const bool is_high = (corner >> axis & 1) != 0;
    const std::int64_t at = is_high ? std::max<std::int64_t>(size - kCropSide, 0) & ~1 : 0;
    const std::int64_t length = std::min(size - at, kCropSide);
    if (at + length < size) shape.weights.last[axis] = shape.weights.each[axis];
    crop.view.size[axis] = shape.size[0][axis] = length;
    first += at * steps[axis];
  }
  shape.size[1] = halved(shape.size[0], shape.halving[0]);
  crop.view.voxels =
      static_cast<const std::byte*>(brick.view.voxels) + first * bytes_per_voxel(brick.view.type);
  return crop;
}

/// Crops of a few bricks: more of each where these are few, from corners that share no face.
std::vector<TrainingBrick> crops_of(std::span<const TrainingBrick> bricks) {
  constexpr unsigned kCorners[kCropsOfBrick] = {0, 3, 5, 6};
  const std::vector<TrainingBrick> few = some_of(bricks, kOrderBricks);
  std::vector<TrainingBrick> crops;
  for (std::size_t i = 0; i < few.size(); ++i) {
    const BrickShape& shape = few[i].shape;
    if (shape.level_count < 2) continue;
    const bool is_little = shape.size[0].x <= kCropSide && shape.size[0].y <= kCropSide &&
                           shape.size[0].z <= kCropSide;
    const std::size_t count =
        is_little ? 1 : std::clamp<std::size_t>(kOrderBricks / few.size(), 1, kCropsOfBrick);
    for (std::size_t k = 0; k < count; ++k) {
      crops.push_back(crop_of(few[i], kCorners[(i + k) % kCropsOfBrick]));
    }
  }
  return crops;
}

/// The order of the axes whose details come out smallest on a few crops.
AxisOrder learn_order(std::span<const TrainingBrick> bricks, const CodecSettings& settings,
                      const ValueMap& map) {
  if (settings.axis_order) return *settings.axis_order;
  if (settings.preset == Preset::fast) return kStraightOrder;
  const std::vector<TrainingBrick> crops = crops_of(bricks);
  AxisOrder best = kStraightOrder;
  double minimum = 0;
  for (const AxisOrder& order : kAxisOrders) {
    Parameters p = default_parameters();
    p.axis_order = order;
    p.value_map = map;
    const std::vector<TrainingSample> training = make_training_samples(crops, p);
    if (training.empty()) return kStraightOrder;
    p.activity_threshold = learn_threshold(training);
    double cost = detail_cost(p, training);
    // The straight order is the fastest; another one must be worth it.
    if (order == kStraightOrder) cost *= 1 - kWorthwhile;
    if (order == kStraightOrder || cost < minimum) {
      minimum = cost;
      best = order;
    }
  }
  return best;
}

/// Bytes that bricks take.
std::uint64_t brick_cost(std::span<const TrainingBrick> bricks, const GreyCodec& codec) {
  std::vector<std::uint64_t> bytes(bricks.size());
  parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
    for (const Bytes& segment : codec.encode(bricks[i].shape, bricks[i].view).segments) {
      bytes[i] += segment.size();
    }
  });
  return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0});
}

/// Bytes that a model and bricks take.
std::uint64_t cost(std::span<const TrainingBrick> bricks, const Parameters& parameters) {
  const GreyCodec codec(parameters);
  return codec.serialized().size() + brick_cost(bricks, codec);
}

/// The ways to keep within a maximum error: rounding the voxels; or rounding the details, with
/// several steps, and correcting the voxels that end up beyond it.
std::vector<Plan> plans_for(Predictor predictor, std::int64_t max_error) {
  const std::int64_t step = 2 * max_error + 1;
  std::vector<Plan> plans = {{predictor, {step, 0, 0}}};
  for (const int tenths : kDetailSteps) {
    const std::int64_t detail_step = max_error * tenths * 256 / 10;
    if (detail_step <= kMaxDetailStep) {
      plans.push_back({predictor, {1, static_cast<std::int32_t>(detail_step), step}});
    }
  }
  return plans;
}

/// Which part of the voxels of these bricks, by some of their rows, holds the smallest value of its
/// brick.
double background_share(std::span<const TrainingBrick> bricks) {
  std::int64_t background = 0;
  std::int64_t voxels = 0;
  for (const TrainingBrick& brick : bricks) {
    const std::int64_t min = range_of(brick.view).min;
    std::int64_t number = 0;
    for_each_row(brick.view, [&](const auto* row) {
      if (number++ % kBackgroundRows != 0) return;
      for (std::int64_t x = 0; x < brick.view.size.x; ++x) background += row[x] == min;
      voxels += brick.view.size.x;
    });
  }
  return static_cast<double>(background) / static_cast<double>(std::max<std::int64_t>(voxels, 1));
}

/// Learns a lossless model of these bricks, of the kind that codes them best.
/// predictor  what suits the preset
Parameters learn_lossless(TrainingSet& set, Predictor predictor) {
  const bool has_edges = background_share(set.bricks()) >= kMuchBackground;
  const Parameters usual = learn(set, {predictor, {}, kWeightStep, has_edges});
  const bool may_be_all = set.bricks().size() < kManyBricks;
  if (predictor == Predictor::means || (!has_edges && !may_be_all)) return usual;
  std::uint64_t minimum = cost(set.bricks(), usual);
  if (minimum >= kLittleBytes) return usual;
  // The model counts beside bricks that are few, or hold little.
  Parameters best = usual;
  for (const Parameters& p :
       {learn(set, {Predictor::means, {}, kWeightStep, has_edges}), coarsened(usual, set)}) {
    const std::uint64_t bytes = cost(set.bricks(), p);
    if (bytes >= minimum) continue;
    minimum = bytes;
    best = p;
  }
  return best;
}

/// The axes that are cut for an access.
std::uint8_t cut_axes_of(const CodecSettings& settings) {
  if (settings.detail_level > 0) return 0;
  const Access by_preset = settings.preset == Preset::fast ? Access::slices : Access::none;
  switch (settings.access.value_or(by_preset)) {
    case Access::none: return 0;
    case Access::slices: return 6;
    case Access::boxes: return 7;
  }
  return 0;
}

/// Whether the cuts of a model cost too much. Its weights and tables, learned with the cuts, do for
/// whole bricks as well: what they would gain from tables of their own is a small part of the
/// difference.
bool cuts_too_much(std::span<const TrainingBrick> bricks, const Parameters& cut) {
  const std::vector<TrainingBrick> few = some_of(bricks, kCutBricks);
  Parameters whole = cut;
  whole.cut_axes = 0;
  const std::uint64_t bytes = brick_cost(few, GreyCodec(whole));
  return brick_cost(few, GreyCodec(cut)) > bytes + bytes * kMaxCutCost / 1000;
}

/// A model, and the bytes that it and the bricks take.
struct CostedModel {
  Parameters parameters;
  std::uint64_t bytes = ~std::uint64_t{0};
};

/// Learns a model that keeps within a maximum error, in the way that rounds these bricks best.
CostedModel learn_rounding(TrainingSet& set, Predictor predictor, std::int64_t max_error) {
  CostedModel best;
  for (const Plan& plan : plans_for(predictor, max_error)) {
    const Parameters p = learn(set, plan);
    const std::uint64_t bytes = cost(set.bricks(), p);
    if (bytes < best.bytes) best = {p, bytes};
  }
  return best;
}

/// Learns a model that keeps within a maximum error. Rounding hides which values do not occur, and
/// that they are few: where that saves more than it does, nothing is rounded.
/// gaps  what a lossless model would know of the values
Parameters learn_lossy(TrainingSet& set, Predictor predictor, std::int64_t max_error,
                       const ValueMap& gaps) {
  const CostedModel rounding = learn_rounding(set, predictor, max_error);
  if (gaps.is_empty() && !has_few_values(set.bricks())) return rounding.parameters;
  TrainingSet whole(set.bricks(), set.start().axis_order, gaps, set.start().cut_axes,
                    set.start().detail_level);
  const Parameters lossless = learn_lossless(whole, predictor);
  return cost(set.bricks(), lossless) < rounding.bytes ? lossless : rounding.parameters;
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
  const bool has_parts = settings.access.value_or(Access::none) != Access::none;
  if (settings.detail_level < 0 || settings.detail_level >= kTierLevels ||
      (settings.detail_level > 0 && (settings.max_error > 0 || has_parts))) {
    throw Error(ErrorKind::invalid_argument,
                "details are left out below a level from 1 to 5, without maximum error and parts");
  }
  const bool is_fast = settings.preset == Preset::fast;
  const bool is_lossless = settings.max_error == 0;
  const Predictor predictor = is_fast ? Predictor::means : Predictor::neighbors;
  const ValueMap gaps = learn_value_map(bricks, !is_fast);
  // Voxels that may change have no values of their own.
  ValueMap map = is_lossless ? gaps : ValueMap{};
  const AxisOrder order = learn_order(bricks, settings, map);
  // Means take any value between.
  if (settings.detail_level > 0) map.used.clear();
  TrainingSet set(bricks, order, map, cut_axes_of(settings), settings.detail_level);
  const auto learn_best = [&] {
    return is_lossless ? learn_lossless(set, predictor)
                       : learn_lossy(set, predictor, settings.max_error, gaps);
  };
  Parameters best = learn_best();
  if (!settings.access && best.cut_axes != 0 && cuts_too_much(bricks, best)) {
    set.leave_whole();
    best = learn_best();
  }
  return std::make_unique<GreyCodec>(best);
}

std::unique_ptr<BrickCodec> refine_grey_model(const BrickCodec& first, VoxelType type,
                                              std::span<const TrainingBrick> bricks,
                                              const CodecSettings& settings) {
  using namespace grey;
  const Parameters& start = dynamic_cast<const GreyCodec&>(first).parameters();
  ValueMap map;
  if (start.quantizer.is_lossless()) {
    map = learn_value_map(bricks, settings.preset != Preset::fast && start.detail_level == 0);
  }
  const std::vector<TrainingBrick> few = some_of(bricks, kRefiningBricks);
  TrainingSet set(few, start.axis_order, map, start.cut_axes, start.detail_level);
  if (const auto p = refined(set, start)) return std::make_unique<GreyCodec>(*p);
  CodecSettings same_order = settings;
  same_order.axis_order = start.axis_order;
  return train_grey_model(type, bricks, same_order);
}

}  // namespace octavo
