// Every instruction set answers as the portable traversal does.
#include "octavo/codec/label/label_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "octavo/codec/label/label_octant.h"
#include "octavo/codec/label/label_start_weights.h"
#include "support/label_brick.h"

namespace octavo {
namespace {

using testing::LabelBrick;

/// Everything a traversal says.
struct Recorded {
  std::vector<Bytes> segments;
  std::vector<std::vector<std::uint8_t>> questions;
  bool operator==(const Recorded&) const = default;
};

class Recorder final : public LabelObserver {
 public:
  explicit Recorder(Recorded& recorded) : recorded_(recorded) {}
  bool wants_next(LabelAsk) override { return true; }
  void observe(LabelAsk kind, const LabelQuestion& question, bool answer) override {
    std::vector<std::uint8_t> line(question.neighbor.begin(), question.neighbor.end());
    // Whether an absent neighbor is equal means nothing.
    for (std::uint8_t& code : line) code = code < 2 ? 0 : code;
    line.insert(line.end(), {question.first, question.second, static_cast<std::uint8_t>(kind),
                             static_cast<std::uint8_t>(answer)});
    recorded_.questions.push_back(std::move(line));
  }

 private:
  Recorded& recorded_;
};

template <class T>
LabelPyramid pyramid_of(const LabelBrick<T>& sample) {
  return build_label_pyramid(sample.shape, sample.view());
}

template <class T>
Recorded recorded_by(const LabelWalkFunctions& walk, const LabelModel& model,
             const LabelBrick<T>& sample) {
  const LabelPyramid pyramid = pyramid_of(sample);
  Recorded recorded;
  recorded.segments.resize(static_cast<std::size_t>(sample.shape.level_count));
  walk.encode(model, sample.shape, pyramid, recorded.segments, thread_label_work());
  Recorder recorder(recorded);
  walk.observe(model, sample.shape, pyramid, recorder, thread_label_work());
  return recorded;
}

template <class T>
void expect_decodes(const LabelWalkFunctions& walk, const LabelModel& model,
                    const LabelBrick<T>& sample, const std::vector<Bytes>& segments) {
  const LabelPyramid pyramid = pyramid_of(sample);
  const std::vector<ByteSpan> spans(segments.begin(), segments.end());
  for (int level = 0; level < sample.shape.level_count; ++level) {
    LabelWork& work = thread_label_work();
    walk.decode(model, sample.shape, {pyramid.labels.front(), pyramid.labels.back()}, spans, level,
                work);
    const LabelPyramid::Level& expected = pyramid.levels[static_cast<std::size_t>(level)];
    ASSERT_EQ(work.grid.size(), expected.size);
    std::size_t at = 0;
    for (std::int64_t z = 0; z < expected.size.z; ++z) {
      for (std::int64_t y = 0; y < expected.size.y; ++y) {
        for (std::int64_t x = 0; x < expected.size.x; ++x, ++at) {
          const LabelCell cell = work.cell({x, y, z});
          ASSERT_EQ(work.labels[slot_of(cell)], pyramid.labels[expected.rank[at]]);
        }
      }
    }
  }
}

/// Those of every instruction set that this machine has.
std::vector<LabelWalkFunctions> all_walks() {
  std::vector<LabelWalkFunctions> all;
  for (const char* const level : {"scalar", "sse4", "avx2", "avx512", "neon", "wasm"}) {
    if (const auto walk = label_walk_functions_of(level)) all.push_back(*walk);
  }
  return all;
}

template <class T>
void expect_all_alike(const LabelBrick<T>& sample) {
  const LabelModel model({}, label_start_weights());
  const std::vector<LabelWalkFunctions> all = all_walks();
  const Recorded expected = recorded_by(all[0], model, sample);
  for (const LabelWalkFunctions& walk : all) {
    EXPECT_EQ(recorded_by(walk, model, sample), expected);
    expect_decodes(walk, model, sample, expected.segments);
  }
}

constexpr Size3 kWalkSizes[] = {{64, 64, 64}, {1, 1, 2}, {1, 3, 1}, {64, 1, 1}, {2, 2, 64},
                            {5, 7, 11},   {63, 1, 33}, {13, 29, 31}, {3, 3, 3}};

TEST(LabelWalk, EveryInstructionSetWritesAndReadsTheSameBytes) {
  for (const Size3& size : kWalkSizes) {
    SCOPED_TRACE(::testing::Message() << size.x << ' ' << size.y << ' ' << size.z);
    expect_all_alike(testing::balls<std::int16_t>(size, {9, -3, 100, 4, 2000, 0}));
    expect_all_alike(testing::balls<std::uint8_t>(size, {1, 0}));
    // Noise asks many more questions than regions do.
    const Size3 less = {std::min<std::int64_t>(size.x, 20), std::min<std::int64_t>(size.y, 20),
                        std::min<std::int64_t>(size.z, 20)};
    expect_all_alike(testing::noise<std::uint8_t>(less, 1, 2));
    expect_all_alike(testing::noise<std::uint32_t>(less, 2, 40));
  }
}

/// Cubes of two labels, from single voxels to whole octants of levels far above.
LabelBrick<std::uint8_t> cubes_of_two(const Size3& size, unsigned seed) {
  LabelBrick<std::uint8_t> sample(size);
  std::mt19937 random(seed);
  constexpr std::int64_t kSide = 16;
  for (std::int64_t z = 0; z < size.z; z += kSide) {
    for (std::int64_t y = 0; y < size.y; y += kSide) {
      for (std::int64_t x = 0; x < size.x; x += kSide) {
        const auto shift = static_cast<unsigned>(random() % 5);
        const auto share = static_cast<unsigned>(random() % 9);
        const std::uint64_t salt = random();
        const Box cube{{x, y, z}, {x + kSide, y + kSide, z + kSide}};
        const Box inside = intersection(cube, box_of(size));
        for (std::int64_t k = inside.lo.z; k < inside.hi.z; ++k) {
          for (std::int64_t j = inside.lo.y; j < inside.hi.y; ++j) {
            for (std::int64_t i = inside.lo.x; i < inside.hi.x; ++i) {
              const std::uint64_t place = interleave({i >> shift, j >> shift, k >> shift});
              const std::uint64_t drawn = (place + salt) * 0x9e3779b97f4a7c15u >> 60;
              sample.voxels[dense_offset(size, {i, j, k})] = drawn % 8 < share ? 9 : 4;
            }
          }
        }
      }
    }
  }
  return sample;
}

TEST(LabelWalk, OctantsOfTwoLabelsGiveTheSameBytesHoweverTheyAreDivided) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const std::int64_t odd = seed % 3;
    expect_all_alike(cubes_of_two({32 + odd, 32, 32 - odd}, seed));
  }
  expect_all_alike(cubes_of_two({64, 64, 64}, 12));
}

TEST(LabelWalk, ThickSlicesGiveTheSameBytesToo) {
  for (const Point3& spacing : {Point3{1, 1, 4}, Point3{4, 1, 1}, Point3{1, 4, 4}}) {
    const Size3 size = {spacing[0] > 1 ? 16 : 40, spacing[1] > 1 ? 13 : 48,
                        spacing[2] > 1 ? 16 : 37};
    expect_all_alike(testing::balls<std::uint8_t>(size, {1, 2, 3, 4}, spacing));
  }
}


TEST(LabelNet, PairsOfRowsAddUpToTheRowsOfTheFormat) {
  std::mt19937 random(3);
  LabelWeights weights{};
  for (std::int8_t& weight : weights) weight = static_cast<std::int8_t>(random() % 255 - 127);
  const LabelNet net(weights);
  const auto row = [&](std::size_t i) { return weights.data() + kLabelHidden * i; };
  for (int round = 0; round < 200; ++round) {
    LabelQuestion question{};
    for (std::uint8_t& code : question.neighbor) code = static_cast<std::uint8_t>(random() % 8);
    question.first = static_cast<std::uint8_t>(random() % kLabelFirstCategories);
    question.second = static_cast<std::uint8_t>(random() % kLabelSecondCategories);
    int logit = 0;
    for (std::size_t j = 0; j < kLabelHidden; ++j) {
      const std::size_t categories = kLabelNeighbors * kLabelStates;
      int sum = row(categories + question.first)[j] +
                row(categories + kLabelFirstCategories + question.second)[j];
      for (std::size_t i = 0; i < kLabelNeighbors; ++i) {
        const std::size_t code = question.neighbor[i];
        if (code >= 2) sum += row(kLabelStates * i + code - 2)[j];
      }
      logit += std::max(sum, 0) * row(kLabelRows)[j];
    }
    EXPECT_EQ(label_logit(net, question), logit);
  }
}

}  // namespace
}  // namespace octavo
