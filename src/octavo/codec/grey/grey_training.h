// What the parts of the grey trainer share: training samples, their traversal, and the parts.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_brick.h"

namespace octavo::grey {

inline constexpr std::size_t kFewSamples = 200;  ///< too few to learn the weights of a class

/// As many are a sample of a larger group; fewer may be all there is.
inline constexpr std::size_t kManyBricks = 32;

/// A training brick as 16-bit samples; of a wider range the highest 16 bits.
struct TrainingSample {
  BrickShape shape;  ///< in the codec's axes
  AnalyzedBrick<std::int16_t> brick;
};

/// Those of `bricks` that hold more than one code of the quantizer, value map and axis order of p.
std::vector<TrainingSample> make_training_samples(std::span<const TrainingBrick> bricks,
                                                  const Parameters& p);

/// The samples of the level above `level` as the encoder has them, ready in the work space.
void load_level(Workspace<std::int16_t>& work, const TrainingSample& sample, int level);

/// One of the parts that a level is coded in.
struct PartNumber {
  std::int64_t number = 0;
  std::int64_t count = 1;
};

/// The ways to work on a split whose means stand in the work space. All leave work.fine as a
/// decoder will have it; but `measure` leaves the true samples, which suits exact details alone.
///   predict    work.residuals holds the residuals of all pairs
///   list       the same, and appends the symbols; the magnitudes are those of the split
///   measure    work.activities and work.limits are those of all pairs
void predict_split(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   const Target<std::int16_t>& target);
void list_split(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                const Target<std::int16_t>& target, std::vector<Symbol>& symbols);
void measure_split(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   const Target<std::int16_t>& target);

/// Runs a level of a training sample through its splits as the encoder does, part by part:
/// `work_on(stage, work, target, part)` shall leave work.fine as a decoder has it. When details are
/// quantized the coarser levels are run first.
/// reach  how much of the margins of work.means work_on looks at
template <class WorkOn>
void walk_level(const Parameters& p, const TrainingSample& sample, int level, Margins reach,
                WorkOn&& work_on) {
  Workspace<std::int16_t>& work = thread_workspace<std::int16_t>();
  const bool is_exact = p.quantizer.detail_step == 0;
  const int coarsest = sample.shape.level_count - 2;
  load_level(work, sample, is_exact ? level : coarsest);
  for (int at = is_exact ? level : coarsest; at >= level; --at) {
    PartNumber number;
    if (at == 0) number.count = part_count(sample.shape, p.cut_axes);
    for_each_part(
        work, sample.shape, p.cut_axes, at, sample.brick.hints(p),
        [&](const Part& part, const BrickHints& hints) {
          run_level(work, part, sample.brick.scale, p, at, hints, reach,
                    [&](const Stage& stage, const Split& split) {
                      if (stage.pairs.voxel_count() == 0) return;
                      const auto target =
                          target_of(sample.brick, sample.shape, part, at, split.axis);
                      if (at == level) work_on(stage, work, target, number);
                      else predict_split(p, stage, work, target);
                    });
          ++number.number;
        });
  }
}

/// The same for one that looks at no more of the margins than the predictor does.
template <class WorkOn>
void walk_level(const Parameters& p, const TrainingSample& sample, int level, WorkOn&& work_on) {
  walk_level(p, sample, level, reach_of(p.predictor), work_on);
}

/// The logarithm to base 2 of n > 0 in 1/256, linear between powers of two.
inline std::uint64_t logarithm(std::uint64_t n) {
  const int whole = bit_length(n) - 1;
  return (static_cast<std::uint64_t>(whole) << 8) + ((n << 8 >> whole) - 256);
}

/// In-brick levels whose details use the weights of a group.
constexpr int levels_of_group(int group) { return group < 2 ? 1 : kTierLevels; }

/// Learns p.weights of a level group; needs those of the coarser groups when details are quantized.
void learn_weights(Parameters& p, const std::vector<TrainingSample>& training, int group);

/// Brings p.weights of a level group, learned from other samples, nearer to what these ask for;
/// takes fewer of them than learning does.
void refine_weights(Parameters& p, const std::vector<TrainingSample>& training, int group);

/// Brings p.weights to multiples of p.weight_step.
void coarsen_weights(Parameters& p);

/// Learns p.mean_weights of a level group, as above.
void learn_mean_weights(Parameters& p, const std::vector<TrainingSample>& training, int group);

/// The bits that the details of level 0 need, up to a factor and a constant, when predicted by
/// weights learned from a few of them; compares orders of the axes.
double detail_cost(Parameters p, const std::vector<TrainingSample>& training);

/// Bits, in units of 1/65536, that the residuals of level 0 take.
struct TableCost {
  std::int64_t own_bits = 0;    ///< under tables of their own
  std::int64_t given_bits = 0;  ///< under p.frequencies

  /// What the latter are more, as a part of the former.
  double excess() const {
    if (own_bits == 0) return 0;
    return static_cast<double>(given_bits) / static_cast<double>(own_bits) - 1;
  }
};

/// Learns p.context_weights; needs the weights of the prediction. Gives the costs before that.
/// share  one in so many of the training samples is enough
TableCost learn_contexts(Parameters& p, const std::vector<TrainingSample>& training,
                         std::size_t share);

/// The same costs, of the same samples, alone.
TableCost table_cost(const Parameters& p, const std::vector<TrainingSample>& training,
                     std::size_t share);

/// Learns p.frequencies, and p.edge_frequencies where edges are told apart; needs all weights.
/// share: as above
void learn_frequencies(Parameters& p, const std::vector<TrainingSample>& training,
                       std::size_t share);

}  // namespace octavo::grey
