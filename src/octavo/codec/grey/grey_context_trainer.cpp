// Learns how large residuals will be (context weights by non-negative least squares) and how
// probable they are then (token frequencies by counting).

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>

#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/grey_training.h"
#include "octavo/codec/grey/least_squares.h"
#include "octavo/threads/parallel_for.h"

namespace octavo::grey {

namespace {

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

/// Per split axis, by level group.
constexpr std::int64_t kContextSamples[kGroups] = {20000, 10000, 6000};
constexpr double kContextRidge = 1e-4;

/// Features and residual magnitudes that contexts are learned from.
struct ContextSamples {
  std::vector<std::array<std::int16_t, kFeatures>> features;
  std::vector<std::int32_t> magnitudes;
};

/// Takes about `wanted` samples from a split whose residuals and magnitudes are known.
void take_samples(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                  Thinning thinning, ContextSamples& samples) {
  const RowBuffers& r = work.row;
  const auto f = [](std::int32_t v) { return static_cast<std::int16_t>(v); };
  std::vector<int> chosen;
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      const int coded = list_coded(stage, work, y, z);
      chosen.clear();
      for (int i = 0; i < coded; ++i) {
        if (thinning.keeps_next()) chosen.push_back(coded == stage.pairs.x ? i : r.order[i]);
      }
      if (chosen.empty()) continue;
      for (const int x : chosen) {
        PortableKernel<std::int16_t>::some_features(p, stage, work,
                                                    {{x, y, z}, {x + 1, y + 1, z + 1}});
      }
      const MagnitudeRows near =
          magnitude_rows(work.magnitudes, p.predictor, stage.axis, y, z, r.zeros + 8);
      const std::int32_t* const residuals = work.residuals.row(y, z);
      for (const int x : chosen) {
        samples.features.push_back(
            {f(r.gradient_along[x]), f(r.curvature_along[x]), f(r.gradient_across[x]),
             f(near.sibling[0][x]), f(near.sibling[1][x]), 1, f(near.up[x + 2]),
             f(near.up[x - 2]), f(near.up[x]), f(near.up[x - 1]), f(near.up[x + 1]),
             f(near.back[x]), f(near.back[x - 1]), f(near.back[x + 1]), f(near.back_up[x]),
             f(near.back_down[x])});
        samples.magnitudes.push_back(std::min(std::abs(residuals[x]), kMaxMagnitude));
      }
    }
  }
}

/// Sums of samples. A sample weighs 1 / (what these weights, Q8, predict)^2: relative errors count.
/// Without weights samples weigh alike.
void add_samples(const ContextSamples& samples, std::span<const std::int16_t> weights,
                 NormalEquations& equations) {
  for (std::size_t i = 0; i < samples.magnitudes.size(); ++i) {
    const SampleMeasures measured = measure(samples.features[i], weights);
    const float predicted = static_cast<float>(measured.predicted) / 256;
    const float root = weights.empty() ? 1 : 1 / std::sqrt(predicted * predicted + 0.05f);
    equations.add(samples.features[i], samples.magnitudes[i], measured, root);
  }
}

/// The solution with the inactive features held at zero.
std::vector<double> solve_active(const NormalEquations& equations,
                                 const std::array<bool, kFeatures>& is_active) {
  std::vector<double> matrix = equations.matrix();
  std::vector<double> right = equations.right();
  for (std::size_t k = 0; k < kFeatures; ++k) {
    if (!is_active[k]) right[k] = 0;
    for (std::size_t j = k; j < kFeatures; ++j) {
      if (is_active[k] && is_active[j]) continue;
      matrix[k * kFeatures + j] = k == j ? 1 : 0;
    }
  }
  return solve(std::move(matrix), std::move(right), kContextRidge);
}

/// Non-negative weights, Q8, that predict the magnitude: features whose weight turns negative drop
/// out.
std::vector<std::int16_t> fit_contexts(const ContextSamples& samples) {
  std::vector<std::int16_t> weights;
  for (int round = 0; round < 3; ++round) {
    NormalEquations equations(kFeatures);
    add_samples(samples, weights, equations);
    weights.assign(kFeatures, 0);
    equations.finish();
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
      for (std::size_t k = 0; k < kFeatures; ++k) {
        if (!is_active[k]) continue;
        weights[k] = static_cast<std::int16_t>(
            std::lround(std::clamp<double>(fitted[k] * 256, 0, 8191)));
      }
      break;
    }
  }
  return weights;
}

template <std::size_t kCount>
using SymbolCounts = std::array<std::int64_t, kCount>;
using TokenCounts = SymbolCounts<kTokens>;
using EdgeCounts = SymbolCounts<kEdgeKinds>;

/// How often each token and each kind of edge is met, by context.
struct Counts {
  std::array<std::array<TokenCounts, kContexts>, kTableSets> tokens{};
  std::array<EdgeCounts, kEdgeContexts> edges{};

  void add(const Symbol& symbol, int set) {
    const std::uint64_t value = symbol.value() >> symbol.low_bits();
    if (symbol.context() >= kContexts) {
      ++edges[symbol.context() - kContexts][value];
      return;
    }
    const auto token = static_cast<std::size_t>(token_of(static_cast<std::uint32_t>(value)));
    ++tokens[static_cast<std::size_t>(set)][symbol.context()][token];
  }
};

template <class Tables>
void add_counts(Tables& sums, const Tables& more) {
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if constexpr (std::is_integral_v<typename Tables::value_type>) sums[i] += more[i];
    else add_counts(sums[i], more[i]);
  }
}

Counts sum_of(const std::vector<Counts>& by_sample) {
  Counts counts;
  for (const Counts& one : by_sample) {
    add_counts(counts.tokens, one.tokens);
    add_counts(counts.edges, one.edges);
  }
  return counts;
}

/// Runs a training sample through its splits and counts its symbols. Calls
/// `learn(stage, work, part)` after each split, when work.residuals holds the residuals and the
/// magnitudes are those of the split.
template <class Learn>
void list_sample(const Parameters& p, const TrainingSample& sample, Counts& counts,
                 Learn&& learn) {
  std::vector<Symbol> symbols;
  for (int level = 0; level + 1 < sample.shape.level_count; ++level) {
    walk_level(p, sample, level,
               [&](const Stage& stage, Workspace<std::int16_t>& work,
                   const Target<std::int16_t>& target, const PartNumber& part) {
                 symbols.clear();
                 list_split(p, stage, work, target, symbols);
                 for (const Symbol& s : symbols) counts.add(s, stage.set);
                 if (stage.has_edges) {
                   for (const Symbol& s : work.edge_symbols) counts.add(s, stage.set);
                 }
                 learn(stage, work, part);
               });
  }
}

/// Of the samples whose number leaves `rest` when divided by `share`.
Counts count_symbols(const Parameters& p, const std::vector<TrainingSample>& training,
                     std::size_t share, std::size_t rest) {
  std::vector<Counts> by_sample(training.size());
  parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    if (i % share != rest) return;
    list_sample(p, training[i], by_sample[i], [](const auto&...) {});
  });
  return sum_of(by_sample);
}

template <std::size_t kCount>
std::int64_t total_of(const SymbolCounts<kCount>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

/// Frequencies in proportion to counts: at least 1 for the escape token, for every token seen and
/// for the tokens next to one seen; the sum is 2048.
std::array<std::uint16_t, kTokens> frequencies_of(const TokenCounts& counts) {
  const std::int64_t total = total_of(counts);
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

/// Logarithms to base 2 of 1 .. 2048 in units of 1/65536, by integer arithmetic alone.
const std::array<std::int64_t, kTableSize + 1>& logarithms() {
  static const auto table = [] {
    std::array<std::int64_t, kTableSize + 1> made{};
    for (std::uint64_t n = 1; n <= kTableSize; ++n) {
      const int whole = bit_length(n) - 1;
      std::uint64_t mantissa = n << (31 - whole);  // 1 .. 2 in Q31
      std::int64_t fraction = 0;
      for (int bit = 15; bit >= 0; --bit) {
        mantissa = mantissa * mantissa >> 31;
        if (mantissa >> 32 == 0) continue;
        mantissa >>= 1;
        fraction |= std::int64_t{1} << bit;
      }
      made[n] = (std::int64_t{whole} << 16) + fraction;
    }
    return made;
  }();
  return table;
}

/// Those of edges: at least 1 for every kind.
std::array<std::uint16_t, kEdgeKinds> frequencies_of(const EdgeCounts& counts) {
  const std::int64_t total = total_of(counts) + kEdgeKinds;
  const auto share = [&](std::size_t kind) {
    const std::int64_t in_proportion = (counts[kind] + 1) * kTableSize / total;
    return std::clamp<std::int64_t>(in_proportion, 1, kTableSize / 2 - 1);
  };
  const std::int64_t first = share(1);
  const std::int64_t second = share(2);
  return {static_cast<std::uint16_t>(kTableSize - first - second),
          static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(second)};
}

/// Bits of a table in a model.
std::int64_t table_bits(const TokenCounts& counts) {
  constexpr std::int64_t kBitsPerFrequency = 6;
  std::int64_t last = 0;
  for (std::size_t token = 0; token < kEscapeToken; ++token) {
    if (counts[token] > 0) last = static_cast<std::int64_t>(token) + 1;
  }
  return (last + 1) * kBitsPerFrequency;
}
std::int64_t table_bits(const EdgeCounts&) { return 18; }

/// Bits, in units of 1/65536, of counted symbols under their own table and of the table.
template <std::size_t kCount>
std::int64_t cost_of(const SymbolCounts<kCount>& counts) {
  const auto frequencies = frequencies_of(counts);
  std::int64_t bits = table_bits(counts) << 16;
  for (std::size_t symbol = 0; symbol < kCount; ++symbol) {
    if (counts[symbol] == 0) continue;
    bits +=
        counts[symbol] * ((std::int64_t{kTableBits} << 16) - logarithms()[frequencies[symbol]]);
  }
  return bits;
}

/// Tables for a run of contexts: neighbors share one while a second costs more than it saves. A
/// context never met repeats the one below it; below the first met one, the table stays.
template <class ContextCounts, class ContextTables>
void share_tables(const ContextCounts& counts, ContextTables& tables) {
  std::size_t first = 0;  // of the contexts that share the table being made
  typename ContextCounts::value_type shared{};
  for (std::size_t context = 0; context < counts.size(); ++context) {
    const auto& own = counts[context];
    auto joined = shared;
    add_counts(joined, own);
    if (total_of(own) == 0 || total_of(shared) == 0 ||
        cost_of(joined) <= cost_of(shared) + cost_of(own)) {
      if (total_of(shared) == 0 && total_of(own) > 0) first = context;
      shared = joined;
    } else {
      first = context;
      shared = own;
    }
    if (total_of(shared) == 0) continue;
    const auto frequencies = frequencies_of(shared);
    for (std::size_t of = first; of <= context; ++of) tables[of] = frequencies;
  }
}

/// What the counted residuals of level 0 cost under p's tables and under their own.
TableCost cost_under(const Parameters& p, const Counts& counts) {
  const auto bits_of = [](std::uint16_t slots) {
    return (std::int64_t{kTableBits} << 16) - logarithms()[slots];
  };
  TableCost cost;
  for (std::size_t context = 0; context < kContexts; ++context) {
    const TokenCounts& seen = counts.tokens[0][context];
    if (total_of(seen) == 0) continue;
    const auto own = frequencies_of(seen);
    const auto& given = p.frequencies[0][context];
    for (std::size_t token = 0; token < kTokens; ++token) {
      if (seen[token] == 0) continue;
      cost.own_bits += seen[token] * bits_of(own[token]);
      const bool escapes = given[token] == 0;
      cost.given_bits += seen[token] * (escapes ? bits_of(given[kEscapeToken]) +
                                                      (std::int64_t{kEscapeBits} << 16)
                                                : bits_of(given[token]));
    }
  }
  return cost;
}

}  // namespace

TableCost learn_contexts(Parameters& p, const std::vector<TrainingSample>& training,
                         std::size_t share) {
  std::vector<Counts> counts(training.size());
  std::vector<std::array<std::array<ContextSamples, 3>, kGroups>> by_sample(training.size());
  parallel_for(std::size_t{0}, training.size(), [&](std::size_t i) {
    if (i % share != share - 1) return;
    list_sample(p, training[i], counts[i],
                [&](const Stage& stage, Workspace<std::int16_t>& work, const PartNumber& part) {
                  const auto group = static_cast<std::size_t>(stage.group);
                  const std::int64_t wanted =
                      kContextSamples[group] /
                      static_cast<std::int64_t>(training.size() / share) / part.count;
                  const auto seed = static_cast<std::uint32_t>(
                      static_cast<std::int64_t>(i) * part.count + part.number + 77);
                  take_samples(p, stage, work,
                               Thinning(wanted, stage.pairs.voxel_count(), seed),
                               by_sample[i][group][static_cast<std::size_t>(stage.axis)]);
                });
  });
  const TableCost cost = cost_under(p, sum_of(counts));
  parallel_for(0, kGroups * 3, [&](int task) {
    ContextSamples all;
    for (auto& sample : by_sample) {
      auto& s = sample[static_cast<std::size_t>(task / 3)][static_cast<std::size_t>(task % 3)];
      all.features.insert(all.features.end(), s.features.begin(), s.features.end());
      all.magnitudes.insert(all.magnitudes.end(), s.magnitudes.begin(), s.magnitudes.end());
    }
    if (all.magnitudes.size() < kFewSamples) return;
    const std::vector<std::int16_t> weights = fit_contexts(all);
    std::copy(weights.begin(), weights.end(), p.context_weights[task / 3][task % 3]);
  });
  return cost;
}

TableCost table_cost(const Parameters& p, const std::vector<TrainingSample>& training,
                     std::size_t share) {
  return cost_under(p, count_symbols(p, training, share, share - 1));
}

void learn_frequencies(Parameters& p, const std::vector<TrainingSample>& training,
                       std::size_t share) {
  const Counts counts = count_symbols(p, training, share, 0);
  for (std::size_t set = 0; set < kTableSets; ++set) {
    share_tables(counts.tokens[set], p.frequencies[set]);
  }
  if (p.has_edges) share_tables(counts.edges, p.edge_frequencies);
}

}  // namespace octavo::grey
