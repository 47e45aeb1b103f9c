// Learns a grey model: prediction weights by reweighted least squares, context weights by
// non-negative least squares, token frequencies by counting.

#include <tbb/parallel_for.h>

#include <cmath>

#include "octavo/codec/grey_brick.h"
#include "octavo/codec/grey_codec.h"
#include "octavo/codec/grey_portable.h"
#include "octavo/codec/least_squares.h"

namespace octavo::grey {

namespace {

constexpr std::size_t kTapBricks = 16;         ///< bricks that weights are learnt from
constexpr std::int64_t kTapSamples = 60000;   ///< per split axis and level group
constexpr std::int64_t kContextSamples = 20000;
constexpr std::size_t kFewSamples = 200;       ///< too few to learn weights of a class
constexpr std::int32_t kMaxDifference = 32000;
constexpr int kWeightStep = 3;
constexpr double kTapRidge = 1e-4;
constexpr double kContextRidge = 1e-4;

using Brick = AnalyzedBrick<std::int16_t>;

struct Lesson {
  BrickShape shape;
  Brick brick;
};

/// Non-uniform training bricks as 16-bit samples; of wider ranges the highest 16 bits.
std::vector<Lesson> make_lessons(std::span<const TrainingBrick> bricks) {
  std::vector<Lesson> lessons(bricks.size());
  tbb::parallel_for(std::size_t{0}, bricks.size(), [&](std::size_t i) {
    const ValueRange range = range_of(bricks[i].view);
    if (range.min == range.max) return;
    lessons[i] = {bricks[i].shape, analyze<std::int16_t>(bricks[i].shape, bricks[i].view, range)};
    const SampleScale scale{range};
    if (scale.is_wide()) {
      lessons[i].brick.scale = SampleScale{{0, (range.max - range.min) >> scale.shift()}};
    }
  });
  std::erase_if(lessons, [](const Lesson& lesson) { return lesson.shape.level_count < 2; });
  return lessons;
}

/// At most `count` lessons, spread evenly but out of step with the brick grid.
std::vector<const Lesson*> spread(const std::vector<Lesson>& lessons, std::size_t count) {
  count = std::min(count, lessons.size());
  std::vector<const Lesson*> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t jitter = i * 2654435769u & 0xffffffffu;  // multiples of the golden ratio
    chosen.push_back(&lessons[((i << 32) + jitter) * lessons.size() / count >> 32]);
  }
  return chosen;
}

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
  return std::max(8, median * 6);
}

/// A reproducible thinning: keeps about `wanted` of `total` items.
class Thinning {
 public:
  Thinning(std::int64_t wanted, std::int64_t total, std::uint32_t seed)
      : limit_(wanted >= total
                   ? ~0u
                   : static_cast<std::uint32_t>(wanted * (std::int64_t{1} << 32) / total)),
        state_(seed * 2654435761u + 12345u) {}
  bool keeps_next() {
    state_ = state_ * 1664525u + 1013904223u;
    return (state_ ^ state_ >> 15) <= limit_;
  }

 private:
  std::uint32_t limit_;
  std::uint32_t state_;
};

/// The samples of the level above `level` as the encoder's walk has them, ready in the work space.
void load_level(Workspace<std::int16_t>& work, const Lesson& lesson, int level) {
  const auto next = static_cast<std::size_t>(level) + 1;
  const Size3& size = lesson.shape.size[next];
  const std::vector<std::int16_t>* means = &lesson.brick.coarsest;
  if (static_cast<int>(next) + 1 < lesson.shape.level_count) {
    for (int axis = 2; axis >= 0; --axis) {
      const auto& step = lesson.brick.steps[next][static_cast<std::size_t>(axis)];
      if (!step.empty()) means = &step;
    }
  }
  load_means(work, means->data(), size);
}

/// Runs the true samples of a level through the splits with a training mode.
template <class MakeMode>
void walk_level(const Parameters& p, const Lesson& lesson, int level, MakeMode&& make_mode) {
  Workspace<std::int16_t>& work = thread_workspace<std::int16_t>();
  load_level(work, lesson, level);
  run_level(work, lesson.shape, lesson.brick.scale, level, lesson.brick.cells_or_null(),
            [&](const Stage& stage, const Split& split) {
              if (stage.pairs.voxel_count() == 0) return;
              const auto& samples =
                  lesson.brick
                      .steps[static_cast<std::size_t>(level)][static_cast<std::size_t>(split.axis)];
              auto mode =
                  make_mode(stage, Truth<std::int16_t>{samples.data(), split.fine_size}, work);
              portable::run_stage(p, stage, work, mode);
            });
}

/// What a training mode has in common with encoding.
struct TruthMode {
  Truth<std::int16_t> truth;
  int axis;
  RowBuffers<std::int16_t>& row;
  void take(RowBuffers<std::int16_t>&, int) const {}
  std::int32_t learn_detail(int x, std::int64_t y, std::int64_t z, std::int32_t prediction) {
    const std::int32_t d = portable::true_detail(truth, axis, x, y, z);
    row.residual[x] = d - prediction;
    return d;
  }
};

/// Neighbourhoods and details of one activity class.
struct TapSamples {
  std::vector<std::int16_t> features;
  std::vector<std::int32_t> details;
};
using ClassSamples = std::array<TapSamples, kClasses>;

struct TapMode : TruthMode {
  Thinning thinning;
  ClassSamples& samples;
  std::int32_t detail(int x, std::int64_t y, std::int64_t z, std::int32_t prediction,
                      const std::int16_t* at, std::int32_t mean) {
    const std::int32_t d = learn_detail(x, y, z, prediction);
    const std::uint8_t activity = row.activity[x];
    if (activity == 0 || !thinning.keeps_next()) return d;
    TapSamples& s = samples[activity];
    for (int r = 0; r < TapRows<std::int16_t>::kCount[axis]; ++r) {
      const std::int16_t* taps = at + TapRows<std::int16_t>::kOffsets[axis][r];
      for (int i = 0; i < 8; ++i) {
        s.features.push_back(
            static_cast<std::int16_t>(std::clamp(taps[i] - mean, -kMaxDifference, kMaxDifference)));
      }
    }
    s.details.push_back(d);
    return d;
  }
  void put(RowBuffers<std::int16_t>&, int, std::int64_t, std::int64_t) const {}
};

/// Least squares, then once more with weights 1 / (1 + |residual|): closer to least absolute
/// residuals, which is what the bits follow.
std::vector<double> fit_taps(const TapSamples& samples, int taps) {
  std::vector<float> weights;
  std::vector<double> fitted;
  for (int round = 0; round < 2; ++round) {
    NormalEquations equations(taps);
    accumulate(equations, samples.features, samples.details, weights);
    fitted = solve(equations, kTapRidge);
    if (round == 1) break;
    weights.resize(samples.details.size());
    const std::vector<float> w(fitted.begin(), fitted.end());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      auto residual = static_cast<float>(samples.details[i]);
      const std::int16_t* f = samples.features.data() + i * w.size();
      for (std::size_t k = 0; k < w.size(); ++k) residual -= w[k] * static_cast<float>(f[k]);
      weights[i] = 1.0f / (std::fabs(residual) + 1.0f);
    }
  }
  return fitted;
}

void set_weights(std::int16_t* weights, const std::vector<double>& fitted, int axis, int step) {
  std::int32_t sum = 0;
  for (int tap = 0; tap < tap_count(axis); ++tap) {
    if (tap == centre_tap(axis)) continue;
    const double scaled = fitted[static_cast<std::size_t>(tap)] * (1 << kWeightBits) / (1 << step);
    const auto limit = static_cast<double>(16000 >> step);
    const auto rounded = static_cast<std::int32_t>(std::lround(std::clamp(scaled, -limit, limit)));
    weights[tap] = static_cast<std::int16_t>(rounded * (1 << step));
    sum += weights[tap];
  }
  // The centre takes the rest, so that weights sum to zero; what 16 bits cannot hold is not worth
  // having.
  if (sum < -32767 || sum > 32767) {
    std::fill_n(weights, kMaxTaps, std::int16_t{0});
    return;
  }
  weights[centre_tap(axis)] = static_cast<std::int16_t>(-sum);
}

int levels_of_group(int group) { return group < 2 ? 1 : kTierLevels; }

void learn_weights(Parameters& p, const std::vector<const Lesson*>& lessons, int group) {
  std::vector<std::array<ClassSamples, 3>> by_lesson(lessons.size());
  tbb::parallel_for(std::size_t{0}, lessons.size(), [&](std::size_t i) {
    const Lesson& lesson = *lessons[i];
    for (int level = group; level < group + levels_of_group(group); ++level) {
      if (level + 1 >= lesson.shape.level_count) break;
      const std::int64_t wanted = kTapSamples / static_cast<std::int64_t>(lessons.size());
      walk_level(p, lesson, level,
                 [&](const Stage& stage, const Truth<std::int16_t>& truth,
                     Workspace<std::int16_t>& work) {
                   const Thinning thinning(wanted, stage.pairs.voxel_count(),
                                           static_cast<std::uint32_t>(i) + 1);
                   return TapMode{{truth, stage.axis, work.row}, thinning,
                                  by_lesson[i][static_cast<std::size_t>(stage.axis)]};
                 });
    }
  });
  tbb::parallel_for(0, 3 * (kClasses - 1), [&](int task) {
    const int axis = task % 3;
    const int activity = 1 + task / 3;
    TapSamples all;
    for (auto& lesson : by_lesson) {
      TapSamples& s = lesson[static_cast<std::size_t>(axis)][static_cast<std::size_t>(activity)];
      all.features.insert(all.features.end(), s.features.begin(), s.features.end());
      all.details.insert(all.details.end(), s.details.begin(), s.details.end());
      s = {};
    }
    if (all.details.size() < kFewSamples) return;
    set_weights(p.weights[group][axis][activity], fit_taps(all, tap_count(axis)), axis,
                p.weight_step);
  });
}

/// Features and residual magnitudes that contexts are learnt from.
struct ContextSamples {
  std::vector<std::array<float, kFeatures>> features;
  std::vector<float> magnitudes;
};

struct ContextMode : TruthMode {
  Thinning thinning;
  ContextSamples& samples;
  const SampleGrid<std::int16_t>* magnitude_grids;
  std::int32_t detail(int x, std::int64_t y, std::int64_t z, std::int32_t prediction,
                      const std::int16_t*, std::int32_t) {
    return learn_detail(x, y, z, prediction);
  }
  void put(RowBuffers<std::int16_t>& r, int coded, std::int64_t y, std::int64_t z) {
    const MagnitudeRows near = portable::magnitude_rows(magnitude_grids, axis, y, z, r.zeros + 4);
    for (int i = 0; i < coded; ++i) {
      const int x = r.order[i];
      if (!thinning.keeps_next()) continue;
      const auto f = [](std::int32_t v) { return static_cast<float>(v); };
      samples.features.push_back(
          {f(r.gradient_along[x]), f(r.curvature_along[x]), f(r.gradient_across[x]),
           f(near.sibling[0][x]), f(near.sibling[1][x]), 1.0f, f(near.up[x + 2]), f(near.up[x - 2]),
           f(near.up[x]), f(near.up[x - 1]), f(near.up[x + 1]), f(near.back[x]),
           f(near.back[x - 1]), f(near.back[x + 1]), f(near.back_up[x]), f(near.back_down[x])});
      samples.magnitudes.push_back(f(std::min(std::abs(r.residual[x]), kMaxMagnitude)));
    }
  }
};

/// Normal equations of all features, in double precision.
struct ContextEquations {
  std::vector<double> matrix = std::vector<double>(kFeatures * kFeatures);
  std::vector<double> right = std::vector<double>(kFeatures);
};

/// With `foresight` (not null) a sample weighs 1 / (what these weights foresee)^2: relative errors
/// count.
ContextEquations accumulate_contexts(const ContextSamples& samples,
                                     const std::vector<double>* foresight) {
  ContextEquations equations;
  for (std::size_t i = 0; i < samples.magnitudes.size(); ++i) {
    std::array<double, kFeatures> f;
    for (std::size_t k = 0; k < kFeatures; ++k) f[k] = static_cast<double>(samples.features[i][k]);
    double weight = 1;
    if (foresight != nullptr) {
      double foreseen = 0;
      for (std::size_t k = 0; k < kFeatures; ++k) foreseen += (*foresight)[k] * f[k];
      weight = 1 / (foreseen * foreseen + 0.05);
    }
    for (std::size_t k = 0; k < kFeatures; ++k) {
      const double scaled = f[k] * weight;
      if (scaled == 0) continue;
      equations.right[k] += scaled * static_cast<double>(samples.magnitudes[i]);
      for (std::size_t j = 0; j < kFeatures; ++j) {
        equations.matrix[k * kFeatures + j] += scaled * f[j];
      }
    }
  }
  return equations;
}

/// The solution with the inactive features held at zero.
std::vector<double> solve_active(ContextEquations equations,
                                 const std::array<bool, kFeatures>& is_active) {
  for (std::size_t k = 0; k < kFeatures; ++k) {
    if (!is_active[k]) equations.right[k] = 0;
    for (std::size_t j = 0; j < kFeatures; ++j) {
      if (is_active[k] && is_active[j]) continue;
      equations.matrix[k * kFeatures + j] = k == j ? 1 : 0;
    }
  }
  eliminate(kFeatures, equations.matrix, equations.right, kContextRidge);
  return equations.right;
}

/// Non-negative weights that foresee the magnitude: features whose weight turns negative drop out.
std::vector<double> fit_contexts(const ContextSamples& samples) {
  std::vector<double> weights(kFeatures, 0.0);
  for (int round = 0; round < 3; ++round) {
    const ContextEquations equations = accumulate_contexts(samples, round > 0 ? &weights : nullptr);
    std::array<bool, kFeatures> is_active;
    is_active.fill(true);
    for (int attempt = 0; attempt < kFeatures; ++attempt) {
      const std::vector<double> fitted = solve_active(equations, is_active);
      bool dropped = false;
      for (std::size_t k = 0; k < kFeatures; ++k) {
        if (!is_active[k] || fitted[k] >= 0) continue;
        is_active[k] = false;
        dropped = true;
      }
      if (dropped) continue;
      for (std::size_t k = 0; k < kFeatures; ++k) weights[k] = is_active[k] ? fitted[k] : 0.0;
      break;
    }
  }
  return weights;
}

void learn_contexts(Parameters& p, const std::vector<const Lesson*>& lessons) {
  std::vector<std::array<std::array<ContextSamples, 3>, kGroups>> by_lesson(lessons.size());
  tbb::parallel_for(std::size_t{0}, lessons.size(), [&](std::size_t i) {
    const Lesson& lesson = *lessons[i];
    for (int level = 0; level + 1 < lesson.shape.level_count; ++level) {
      const std::int64_t wanted = kContextSamples / static_cast<std::int64_t>(lessons.size());
      walk_level(
          p, lesson, level,
          [&](const Stage& stage, const Truth<std::int16_t>& truth, Workspace<std::int16_t>& work) {
            const Thinning thinning(wanted, stage.pairs.voxel_count(),
                                    static_cast<std::uint32_t>(i) + 77);
            auto& samples = by_lesson[i][static_cast<std::size_t>(stage.group)]
                                     [static_cast<std::size_t>(stage.axis)];
            return ContextMode{{truth, stage.axis, work.row}, thinning, samples, work.magnitudes};
          });
    }
  });
  tbb::parallel_for(0, kGroups * 3, [&](int task) {
    ContextSamples all;
    for (auto& lesson : by_lesson) {
      auto& s = lesson[static_cast<std::size_t>(task / 3)][static_cast<std::size_t>(task % 3)];
      all.features.insert(all.features.end(), s.features.begin(), s.features.end());
      all.magnitudes.insert(all.magnitudes.end(), s.magnitudes.begin(), s.magnitudes.end());
    }
    if (all.magnitudes.size() < kFewSamples) return;
    const std::vector<double> weights = fit_contexts(all);
    for (std::size_t k = 0; k < kFeatures; ++k) {
      p.context_weights[task / 3][task % 3][k] =
          std::clamp(static_cast<std::int32_t>(std::lround(weights[k] * 256)), 0, 8191);
    }
  });
}

using Counts = std::array<std::array<std::array<std::int64_t, kTokens>, kContexts>, kTableSets>;

Counts count_tokens(const Parameters& p, const std::vector<Lesson>& lessons) {
  std::vector<Counts> by_lesson(lessons.size());
  tbb::parallel_for(std::size_t{0}, lessons.size(), [&](std::size_t i) {
    const Lesson& lesson = lessons[i];
    Workspace<std::int16_t>& work = thread_workspace<std::int16_t>();
    std::vector<Symbol> symbols;
    for (int level = 0; level + 1 < lesson.shape.level_count; ++level) {
      symbols.clear();
      load_level(work, lesson, level);
      run_level(work, lesson.shape, lesson.brick.scale, level, lesson.brick.cells_or_null(),
                [&](const Stage& stage, const Split& split) {
                  const auto& samples = lesson.brick.steps[static_cast<std::size_t>(level)]
                                                          [static_cast<std::size_t>(split.axis)];
                  stage_functions().encode16(p, stage, work, {samples.data(), split.fine_size},
                                             symbols);
                });
      for (const Symbol& s : symbols) {
        const auto token = token_of(static_cast<std::uint32_t>(s.value >> plain_bits(s.context)));
        ++by_lesson[i][static_cast<std::size_t>(table_set(level))][s.context]
                   [static_cast<std::size_t>(token)];
      }
    }
  });
  Counts counts{};
  for (const Counts& one : by_lesson) {
    for (std::size_t set = 0; set < kTableSets; ++set) {
      for (std::size_t context = 0; context < kContexts; ++context) {
        for (std::size_t token = 0; token < kTokens; ++token) {
          counts[set][context][token] += one[set][context][token];
        }
      }
    }
  }
  return counts;
}

/// Frequencies in proportion to counts: at least 1 for the escape token, for every token seen and
/// for the tokens next to one seen; the sum is 2048.
std::array<std::uint16_t, kTokens> frequencies_of(const std::array<std::int64_t, kTokens>& counts) {
  std::int64_t total = 0;
  for (const std::int64_t count : counts) total += count;
  std::array<std::uint16_t, kTokens> frequencies{};
  std::int32_t sum = 0;
  std::size_t most = 0;
  for (std::size_t token = 0; token < kTokens; ++token) {
    const bool is_near = counts[token] > 0 || (token > 0 && counts[token - 1] > 0) ||
                         (token + 1 < kEscapeToken && counts[token + 1] > 0);
    if (!is_near && token != kEscapeToken) continue;
    const auto share = (counts[token] * kTableSize + total / 2) / total;
    frequencies[token] =
        static_cast<std::uint16_t>(std::clamp<std::int64_t>(share, 1, kTableSize - 1));
    sum += frequencies[token];
    if (frequencies[token] > frequencies[most]) most = token;
  }
  // Rounding is settled with the most frequent tokens, a little from each.
  while (sum > kTableSize) {
    const auto largest = std::max_element(frequencies.begin(), frequencies.end());
    const int take = std::min(sum - kTableSize, std::max(1, *largest / 8));
    *largest = static_cast<std::uint16_t>(*largest - take);
    sum -= take;
  }
  frequencies[most] = static_cast<std::uint16_t>(frequencies[most] + kTableSize - sum);
  return frequencies;
}

/// A context never met repeats the one below it; below the first met one, the default.
void learn_frequencies(Parameters& p, const Counts& counts) {
  for (std::size_t set = 0; set < kTableSets; ++set) {
    for (std::size_t context = 0; context < kContexts; ++context) {
      std::int64_t total = 0;
      for (const std::int64_t count : counts[set][context]) total += count;
      if (total > 0) p.frequencies[set][context] = frequencies_of(counts[set][context]);
      else if (context > 0) p.frequencies[set][context] = p.frequencies[set][context - 1];
    }
  }
}

}  // namespace

}  // namespace octavo::grey

namespace octavo {

std::unique_ptr<BrickCodec> train_grey_model(VoxelType type, std::span<const TrainingBrick> bricks,
                                             const CodecSettings&) {
  using namespace grey;
  if (!is_integer(type)) {
    throw Error(ErrorKind::invalid_argument,
                "float voxels cannot be coded losslessly as grey values");
  }
  Parameters p = default_parameters();
  p.weight_step = kWeightStep;
  const std::vector<Lesson> lessons = make_lessons(bricks);
  if (!lessons.empty()) {
    p.activity_threshold = learn_threshold(lessons);
    const std::vector<const Lesson*> few = spread(lessons, kTapBricks);
    for (int group = 0; group < kGroups; ++group) learn_weights(p, few, group);
    learn_contexts(p, few);
    learn_frequencies(p, count_tokens(p, lessons));
  }
  return std::make_unique<GreyCodec>(p);
}

}  // namespace octavo
