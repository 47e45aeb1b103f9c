// The passes of a split: every instruction set of this machine against the portable one.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "octavo/codec/grey/edge_pairs.h"
#include "octavo/codec/grey/grey_stage.h"
#include "octavo/codec/grey/octant_transform.h"
#include "support/goal_cases.h"

namespace octavo::grey {
namespace {

/// A split with everything about it drawn at random, also what no trained model would hold.
struct RandomSplit {
  Model model;
  Stage stage;
  UniformCells cells;
  std::shared_ptr<const ValueGaps> gaps;
  Size3 fine;
  std::vector<std::int16_t> means;
  std::vector<std::int32_t> details;
};

/// What the samples of a split are like.
enum class Samples {
  any,
  sparse,  ///< mostly the smallest one: the split has edges
  gapped,  ///< multiples of 3: the split has gaps
  both
};

RandomSplit make_split(std::mt19937& random, const Size3& fine, int axis, Predictor predictor,
                       int bits, bool has_cells, Samples kind = Samples::any) {
  RandomSplit s;
  const auto below = [&](std::uint32_t n) { return static_cast<std::int32_t>(random() % n); };
  Parameters& p = s.model.parameters;
  p = default_parameters();
  p.predictor = predictor;
  p.activity_threshold = 1 + below(1u << bits) % kMaxThreshold;
  for (auto& group : p.weights) {
    for (auto& along : group) {
      for (int cls = 1; cls < kClasses; ++cls) {
        for (auto& w : along[cls])
          w = static_cast<std::int16_t>(below(bits == 16 ? 65536 : 800) - 400);
      }
    }
  }
  for (auto& group : p.mean_weights) {
    for (auto& along : group) {
      // Weights below 1 have passes of their own.
      const std::int32_t most = below(2) == 0 ? kMaxMeanWeight : 4095;
      for (int cls = 1; cls < kClasses; ++cls) {
        along[cls] = below(static_cast<std::uint32_t>(2 * most + 1)) - most;
      }
    }
  }
  for (auto& group : p.far_shares) {
    for (auto& share : group) share = below(2 * kMaxShare + 1) - kMaxShare;
  }
  for (auto& group : p.behind_weights) {
    for (auto& along : group) {
      for (int cls = 1; cls < kClasses; ++cls) along[cls] = below(2 * kMaxShare + 1) - kMaxShare;
    }
  }
  for (auto& group : p.context_weights) {
    for (auto& along : group) {
      for (auto& w : along) w = below(4) == 0 ? below(8192) : below(60);
    }
  }
  const bool is_sparse = kind == Samples::sparse || kind == Samples::both;
  p.has_edges = is_sparse;
  for (auto& context : p.edge_frequencies) {
    context[1] = static_cast<std::uint16_t>(1 + below(1023));
    context[2] = static_cast<std::uint16_t>(1 + below(1023));
    context[0] = static_cast<std::uint16_t>(kTableSize - context[1] - context[2]);
  }
  build_tables(s.model);

  s.fine = fine;
  const std::int32_t range = (1 << bits) - 1;
  const bool has_gaps = kind == Samples::gapped || kind == Samples::both;
  std::vector<std::int16_t> target(static_cast<std::size_t>(fine.voxel_count()));
  for (auto& v : target) {
    std::int32_t above = below(3) == 0 ? below(2) * range : below(1u << bits);
    if (is_sparse && below(4) != 0) above = 0;
    if (has_gaps) above = above / 3 * 3;
    v = static_cast<std::int16_t>(-32768 + above);
  }
  s.stage.axis = axis;
  s.stage.group = below(kGroups);
  s.stage.set = below(kTableSets);
  s.stage.rounding = below(2);
  s.stage.odd_low = 1 - s.stage.rounding;
  s.stage.odd_high = s.stage.rounding;
  s.stage.pairs = fine;
  s.stage.pairs[axis] /= 2;
  s.stage.min = -32768;
  s.stage.max = -32768 + range;
  if (below(2) == 0 && fine[axis] % 2 == 0 && !has_gaps) {
    const std::int64_t each = std::int64_t{1} << below(20);
    s.stage.last_pair = {each, 1 + below(static_cast<std::uint32_t>(each))};
  }
  s.stage.has_edges = is_sparse;
  if (has_gaps) {
    std::vector<std::uint8_t> used(static_cast<std::size_t>(range + 1));
    for (std::size_t i = 0; i < used.size(); i += 3) used[i] = 1;
    s.gaps = std::make_shared<const ValueGaps>(s.stage.min, used, s.stage.rounding);
    s.stage.gaps = s.gaps.get();
  }
  const auto coded = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    if (!has_cells) return true;
    const Size3& n = s.cells.size;
    return s.cells.flags[static_cast<std::size_t>(((z >> 1) * n.y + (y >> 1)) * n.x + (x >> 1))] ==
           0;
  };
  if (has_cells) {
    s.cells.size = {fine.x / 2 + 1, fine.y / 2 + 1, fine.z / 2 + 1};
    s.cells.flags.resize(static_cast<std::size_t>(s.cells.size.voxel_count()));
    for (auto& flag : s.cells.flags) flag = static_cast<std::uint8_t>(below(2));
    // Every second time whole rows and planes are alike.
    const std::int64_t row = s.cells.size.x;
    for (std::size_t i = 0; below(2) == 0 && i < s.cells.flags.size(); ++i) {
      if (static_cast<std::int64_t>(i) % row != 0) s.cells.flags[i] = s.cells.flags[i - 1];
    }
    for (int& shift : s.stage.cell_shift) shift = 1;
  }
  // Both samples of a pair in a uniform cell are alike.
  const std::int64_t steps[3] = {1, fine.x, fine.x * fine.y};
  for (std::int64_t z = 0; z < s.stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < s.stage.pairs.y; ++y) {
      for (std::int64_t x = 0; x < s.stage.pairs.x; ++x) {
        const Index3 at{axis == 0 ? 2 * x : x, axis == 1 ? 2 * y : y, axis == 2 ? 2 * z : z};
        std::int16_t* const a = target.data() + at.z * fine.x * fine.y + at.y * fine.x + at.x;
        if (!coded(x, y, z)) a[steps[axis]] = a[0];
        s.details.push_back(a[0] - a[steps[axis]]);
      }
    }
  }
  s.means = means_along(target, fine, axis, s.stage.rounding, s.stage.last_pair);
  return s;
}

struct Results {
  std::vector<std::int32_t> residuals;
  std::vector<Symbol> symbols;
  std::vector<Symbol> edges;
  std::vector<std::int16_t> samples;

  bool operator==(const Results& other) const {
    return residuals == other.residuals && samples == other.samples && symbols == other.symbols &&
           edges == other.edges;
  }
};

/// What other splits may have left of theirs.
template <class Grid>
void dirty(Grid& grid) {
  auto* const first = grid.row(0, 0);
  using Number = std::remove_cvref_t<decltype(*first)>;
  constexpr std::int64_t kCount = kBrickSide * kBrickSide * kBrickSide / 2;
  std::fill_n(first, kCount, std::numeric_limits<Number>::lowest());
}

void load(Workspace<std::int16_t>& work, const RandomSplit& s) {
  dirty(work.predictions);
  dirty(work.excesses);
  dirty(work.plane_excesses);
  Size3 coarse = s.fine;
  coarse[s.stage.axis] = (coarse[s.stage.axis] + 1) / 2;
  work.means.set_size(coarse);
  const std::int16_t* from = s.means.data();
  for (std::int64_t z = 0; z < coarse.z; ++z) {
    for (std::int64_t y = 0; y < coarse.y; ++y, from += coarse.x) {
      std::copy_n(from, coarse.x, work.means.row(y, z));
    }
  }
  work.means.fill_margins();
  repeat_along(work.means, work.fine, s.stage.axis, s.fine);
  for (auto& grid : work.magnitudes) grid.set_size({0, 0, 0});
  work.residuals.set_size(s.stage.pairs);
}

std::vector<std::int16_t> pairs_of(Workspace<std::int16_t>& work, const RandomSplit& s) {
  std::vector<std::int16_t> samples;
  Size3 size = s.fine;
  size[s.stage.axis] -= size[s.stage.axis] % 2;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      samples.insert(samples.end(), work.fine.row(y, z), work.fine.row(y, z) + size.x);
    }
  }
  return samples;
}

void load_with_details(Workspace<std::int16_t>& work, const RandomSplit& s) {
  load(work, s);
  const Size3& pairs = s.stage.pairs;
  const std::int32_t* from = s.details.data();
  for (std::int64_t z = 0; z < pairs.z; ++z) {
    for (std::int64_t y = 0; y < pairs.y; ++y, from += pairs.x) {
      std::copy_n(from, pairs.x, work.residuals.row(y, z));
    }
  }
}

/// Encodes a split and decodes its segment again.
Results run(const StageFunctions& functions, RandomSplit& s, bool has_cells) {
  Workspace<std::int16_t> work;
  Results results;
  s.stage.cells = has_cells ? &s.cells : nullptr;
  const Size3& pairs = s.stage.pairs;
  load_with_details(work, s);
  std::vector<Symbol> edges;
  if (s.stage.has_edges) {
    functions.narrow.mark_edges(s.stage, work);
    results.edges = edges = work.edge_symbols;
  }
  functions.narrow.predict(s.model.parameters, s.stage, work);
  for (std::int64_t z = 0; z < pairs.z; ++z) {
    for (std::int64_t y = 0; y < pairs.y; ++y) {
      const std::int32_t* const row = work.residuals.row(y, z);
      results.residuals.insert(results.residuals.end(), row, row + pairs.x);
    }
  }
  functions.narrow.list_symbols(s.model.parameters, s.stage, work, results.symbols);
  results.samples = pairs_of(work, s);

  std::vector<Symbol> at_once;
  load_with_details(work, s);
  if (s.stage.has_edges) functions.narrow.mark_edges(s.stage, work);
  functions.narrow.encode(s.model.parameters, s.stage, work, at_once);
  EXPECT_TRUE(at_once == results.symbols);
  EXPECT_EQ(pairs_of(work, s), results.samples);

  const std::int64_t count = s.stage.detail_count();
  const auto is_edge = [](const Symbol& symbol) { return symbol.value() != 0; };
  const auto edge_count = std::count_if(edges.begin(), edges.end(), is_edge);
  EXPECT_EQ(static_cast<std::int64_t>(results.symbols.size()) + edge_count, count);
  edges.insert(edges.end(), results.symbols.begin(), results.symbols.end());
  const Bytes segment = encode_symbols(s.model, s.stage.set, edges, count, 0);
  for (const int most_states : {kMaxStates, 16, 8}) {
    const auto encoded = [&](PushTokens push) {
      return encode_symbols(s.model, s.stage.set, edges, count, 0, most_states, push);
    };
    EXPECT_EQ(encoded(functions.push), encoded(push_tokens)) << most_states << " states";
  }
  load_with_details(work, s);
  SymbolWriter writer(s.model, s.stage.set, 0, functions.push);
  if (s.stage.has_edges) {
    functions.narrow.mark_edges(s.stage, work);
    writer.add(work.edge_symbols);
  }
  functions.narrow.write(s.model.parameters, s.stage, work, writer);
  EXPECT_EQ(writer.finish(count), segment);
  EXPECT_EQ(pairs_of(work, s), results.samples);
  load(work, s);
  SymbolReader symbols(s.model, s.stage.set, segment, count, 0);
  if (s.stage.has_edges) functions.narrow.take_edges(s.stage, work, symbols);
  functions.narrow.decode(s.model.parameters, {s.stage, work, symbols});
  symbols.finish();
  EXPECT_EQ(pairs_of(work, s), results.samples);
  return results;
}

constexpr const char* kInstructionSets[] = {"sse4", "avx2", "avx512", "neon", "wasm"};

/// Every instruction set of this machine gives what the portable functions give.
void expect_as_portable(RandomSplit& split, bool has_cells) {
  const Results expected = run(portable_stage_functions(), split, has_cells);
  for (const char* name : kInstructionSets) {
    if (const auto functions = stage_functions_of(name)) {
      ASSERT_TRUE(run(*functions, split, has_cells) == expected) << name;
    }
  }
}

class StagesOf : public ::testing::TestWithParam<std::string> {};

/// In the everyday run one of five combinations is tried. Five divides no number of choices, so
/// that every choice meets every other one.
bool is_turn_of(int& combination) {
  return octavo::testing::is_full_form() || combination++ % 5 == 0;
}

TEST(StagesOfEverySet, GiveWhatThePortableOnesGive) {
  std::mt19937 random(21);
  const Size3 sizes[] = {{64, 64, 64}, {63, 5, 7},   {2, 2, 2},
                         {33, 64, 9},  {48, 21, 64}, {8, 3, 40}};
  int combination = 0;
  for (const Size3& fine : sizes) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const Predictor predictor : {Predictor::neighbors, Predictor::means}) {
        for (const int bits : {1, 5, 12, 16}) {
          for (const bool has_cells : {false, true}) {
            if (!is_turn_of(combination)) continue;
            SCOPED_TRACE(::testing::Message()
                         << fine.x << "x" << fine.y << "x" << fine.z << " axis " << axis
                         << " predictor " << static_cast<int>(predictor) << " bits " << bits
                         << " cells " << has_cells);
            RandomSplit split = make_split(random, fine, axis, predictor, bits, has_cells);
            ASSERT_NO_FATAL_FAILURE(expect_as_portable(split, has_cells));
          }
        }
      }
    }
  }
}

TEST(StagesOfEverySet, GiveTheSameAroundEdgesAndGaps) {
  std::mt19937 random(22);
  int combination = 0;
  for (const Size3& fine : {Size3{33, 64, 9}, Size3{63, 5, 7}, Size3{2, 2, 2}}) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const Predictor predictor : {Predictor::neighbors, Predictor::means}) {
        for (const Samples kind : {Samples::sparse, Samples::gapped, Samples::both}) {
          for (const bool has_cells : {false, true}) {
            if (!is_turn_of(combination)) continue;
            SCOPED_TRACE(::testing::Message()
                         << fine.x << "x" << fine.y << "x" << fine.z << " axis " << axis
                         << " predictor " << static_cast<int>(predictor) << " samples "
                         << static_cast<int>(kind) << " cells " << has_cells);
            // Only ranges of 8 bits have gaps.
            const int bits = kind == Samples::sparse && axis != 1 ? 16 : 8;
            RandomSplit split = make_split(random, fine, axis, predictor, bits, has_cells, kind);
            ASSERT_NO_FATAL_FAILURE(expect_as_portable(split, has_cells));
          }
        }
      }
    }
  }
}

TEST(StagesOfEverySet, GiveTheSameAroundEdgesAndGapsInRowsOfEveryLength) {
  std::mt19937 random(24);
  int combination = 0;
  for (std::int64_t length = 2; length <= kBrickSide; ++length) {
    for (const Predictor predictor : {Predictor::neighbors, Predictor::means}) {
      for (const Samples kind : {Samples::sparse, Samples::gapped, Samples::both}) {
        if (!is_turn_of(combination)) continue;
        SCOPED_TRACE(::testing::Message() << length << " predictor " << static_cast<int>(predictor)
                                          << " samples " << static_cast<int>(kind));
        const int axis = static_cast<int>(length % 3);
        RandomSplit split =
            make_split(random, {length, 12, 10}, axis, predictor, 7, true, kind);
        ASSERT_NO_FATAL_FAILURE(expect_as_portable(split, true));
      }
    }
  }
}

/// A pair whose other sample is known to be even or odd, by the range or by the gaps, spends no bit
/// on it.
TEST(Edges, SpendNoBitOnWhatCanBeOneNumberAlone) {
  std::mt19937 random(25);
  RandomSplit split =
      make_split(random, {64, 32, 32}, 0, Predictor::neighbors, 8, false, Samples::both);
  Workspace<std::int16_t> work;
  load_with_details(work, split);
  mark_edges(split.stage, work);
  EXPECT_GT(work.edge_symbols.size(), 1000u);
  // Multiples of 3 are never neighbors.
  for (const Symbol& symbol : work.edge_symbols) ASSERT_EQ(symbol.low_bits(), 0);
  split.stage.gaps = nullptr;
  mark_edges(split.stage, work);
  const auto spends = [](const Symbol& symbol) { return symbol.low_bits() == 1; };
  EXPECT_GT(std::count_if(work.edge_symbols.begin(), work.edge_symbols.end(), spends), 1000);
}

/// Decodes a stream that nobody encoded; nothing when it ends too early.
std::optional<std::vector<std::int16_t>> decode_any(const StageFunctions& functions,
                                                    const RandomSplit& s, ByteSpan segment) {
  Workspace<std::int16_t> work;
  load(work, s);
  SymbolReader symbols(s.model, s.stage.set, segment, s.stage.detail_count(), 0);
  try {
    if (s.stage.has_edges) functions.narrow.take_edges(s.stage, work, symbols);
    functions.narrow.decode(s.model.parameters, {s.stage, work, symbols});
  } catch (const Error&) {
    return std::nullopt;
  }
  return pairs_of(work, s);
}

TEST_P(StagesOf, MakeTheSameOfAnyStream) {
  const auto functions = stage_functions_of(GetParam());
  if (!functions) GTEST_SKIP() << "this machine has no " << GetParam();
  std::mt19937 random(23);
  int complete = 0;
  for (int round = 0; round < 60; ++round) {
    const Size3 fine{static_cast<std::int64_t>(2 + random() % 63), 8, 6};
    const auto predictor = round % 2 == 0 ? Predictor::neighbors : Predictor::means;
    // Every second split of each kind has edges, gaps or both.
    const auto kind = static_cast<Samples>(round % 4 < 2 ? 0 : 1 + round / 4 % 3);
    const bool is_any = kind == Samples::any;
    const int bits = is_any ? 1 + static_cast<int>(random() % 16) : 7;
    RandomSplit split = make_split(random, fine, round % 3, predictor, bits, false, kind);
    // Long enough for every symbol, plain bits and words alike.
    Bytes segment(60001);
    for (auto& byte : segment) byte = static_cast<std::uint8_t>(random());
    Bytes length;
    put_varint(length, 20000);
    std::copy(length.begin(), length.end(), segment.begin());
    const auto expected = decode_any(portable_stage_functions(), split, segment);
    ASSERT_EQ(decode_any(*functions, split, segment), expected) << round;
    if (!expected) continue;
    ++complete;
    for (const std::int16_t sample : *expected) {
      ASSERT_GE(sample, split.stage.min);
      ASSERT_LE(sample, split.stage.max);
    }
  }
  EXPECT_GT(complete, 30);
}

/// The segment of a split whose true details are known, with at most so many states.
Bytes segment_of(const RandomSplit& s, int most_states) {
  Workspace<std::int16_t> work;
  load_with_details(work, s);
  std::vector<Symbol> symbols;
  if (s.stage.has_edges) {
    mark_edges(s.stage, work);
    symbols = work.edge_symbols;
  }
  portable_stage_functions().narrow.encode(s.model.parameters, s.stage, work, symbols);
  return encode_symbols(s.model, s.stage.set, symbols, s.stage.detail_count(), 0, most_states);
}

std::vector<std::int16_t> samples_of(const RandomSplit& s) {
  Workspace<std::int16_t> work;
  load_with_details(work, s);
  if (s.stage.has_edges) mark_edges(s.stage, work);
  portable_stage_functions().narrow.predict(s.model.parameters, s.stage, work);
  return pairs_of(work, s);
}

/// Of any sizes, with and without cells, edges and gaps, whatever the number of states.
TEST_P(StagesOf, DecodePartsTogetherToWhatEachHolds) {
  const auto functions = stage_functions_of(GetParam());
  if (!functions) GTEST_SKIP() << "this machine has no " << GetParam();
  std::mt19937 random(27);
  const Size3 sizes[] = {{64, 32, 32}, {64, 32, 7}, {33, 5, 32}, {2, 1, 2}, {16, 40, 9}};
  Workspace<std::int16_t> works[kMostTogether];
  // Seven divides no number of choices either.
  for (int round = 0; round < 60; round += octavo::testing::is_full_form() ? 1 : 7) {
    SCOPED_TRACE(round);
    const int axis = round % 3;
    const auto predictor = round % 4 == 0 ? Predictor::neighbors : Predictor::means;
    const auto kind = static_cast<Samples>(round / 3 % 4);
    const int bits = kind == Samples::any ? 12 : 7;
    const int most_states = 1 << (round % 6);
    const std::size_t count = 1 + random() % kMostTogether;
    std::vector<std::unique_ptr<RandomSplit>> splits;
    std::vector<Bytes> bytes;
    for (std::size_t i = 0; i < count; ++i) {
      Size3 fine = sizes[random() % 5];
      fine[axis] += fine[axis] % 2;
      const bool has_cells = random() % 2 == 0;
      splits.push_back(std::make_unique<RandomSplit>(
          make_split(random, fine, axis, predictor, bits, has_cells, kind)));
      RandomSplit& split = *splits.back();
      split.stage.cells = has_cells ? &split.cells : nullptr;
      // All are of one model.
      split.model.parameters = splits.front()->model.parameters;
      build_tables(split.model);
      split.stage.group = splits.front()->stage.group;
      load(works[i], split);
      bytes.push_back(segment_of(split, most_states));
    }
    std::vector<std::unique_ptr<SymbolReader>> readers;
    std::vector<SplitTask<std::int16_t>> tasks;
    for (std::size_t i = 0; i < count; ++i) {
      const RandomSplit& split = *splits[i];
      readers.push_back(std::make_unique<SymbolReader>(
          split.model, split.stage.set, bytes[i], split.stage.detail_count(), 0, most_states));
      if (split.stage.has_edges) {
        functions->narrow.take_edges(split.stage, works[i], *readers[i]);
      }
      tasks.push_back({split.stage, works[i], *readers[i]});
    }
    functions->narrow.decode_together(splits.front()->model.parameters, tasks);
    for (std::size_t i = 0; i < count; ++i) {
      readers[i]->finish();
      ASSERT_EQ(pairs_of(works[i], *splits[i]), samples_of(*splits[i])) << i << " of " << count;
    }
  }
}

/// Times a step, a damaged residual can become the lowest 32-bit number, which has no opposite: its
/// magnitude must stay one that contexts can be made of.
TEST_P(StagesOf, BoundTheMagnitudeOfTheLowestResidual) {
  const auto functions = stage_functions_of(GetParam());
  if (!functions) GTEST_SKIP() << "this machine has no " << GetParam();
  std::mt19937 random(3);
  for (const Predictor predictor : {Predictor::neighbors, Predictor::means}) {
    RandomSplit split = make_split(random, {64, 2, 2}, 1, predictor, 12, false);
    split.stage.step = 4096;
    split.stage.step_bits = 12;
    split.stage.odd_low = split.stage.odd_high = 0;
    Workspace<std::int16_t> work;
    load(work, split);
    functions->narrow.predict(split.model.parameters, split.stage, work);
    std::vector<Symbol> symbols;
    for (std::int64_t z = 0; z < split.stage.pairs.z; ++z) {
      std::fill_n(work.residuals.row(0, z), split.stage.pairs.x, 0);
    }
    functions->narrow.list_symbols(split.model.parameters, split.stage, work, symbols);
    // Of the first plane, whose contexts depend on means alone.
    for (int i = 0; i < 64; ++i) {
      Symbol& symbol = symbols[static_cast<std::size_t>(i)];
      const auto packed = static_cast<unsigned>(symbol.context()) |
                          static_cast<unsigned>(symbol.low_bits()) << 8;
      symbol = Symbol(zigzag(-(std::int64_t{1} << 19)), packed, i);
    }
    const auto count = static_cast<std::int64_t>(symbols.size());
    const Bytes segment = encode_symbols(split.model, split.stage.set, symbols, count, 0);
    load(work, split);
    SymbolReader reader(split.model, split.stage.set, segment, count, 0);
    try {
      functions->narrow.decode(split.model.parameters, {split.stage, work, reader});
    } catch (const Error& error) {
      // The second plane has other contexts now and may take more than there is.
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
    }
    const std::int16_t* const magnitudes = work.magnitudes[1].row(0, 0);
    for (int x = 0; x < 64; ++x) ASSERT_EQ(magnitudes[x], kMaxMagnitude) << x;
  }
}

INSTANTIATE_TEST_SUITE_P(EveryInstructionSet, StagesOf,
                         ::testing::Values("scalar", "sse4", "avx2", "avx512", "neon",
                                         "wasm"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace octavo::grey
