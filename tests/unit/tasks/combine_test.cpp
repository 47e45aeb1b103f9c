#include "octavo/tasks/combine.h"

#include <random>

#include "support/stopping_progress.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseMask;

constexpr Size3 kCombineSize = {70, 33, 41};

class Combine : public testing::TaskFiles {
 protected:
  void SetUp() override {
    std::mt19937 random(3);
    for (const char* name : {"a.8vo", "b.8vo", "c.8vo"}) {
      masks_.push_back(testing::random_mask(kCombineSize, random));
      options_.inputs.push_back(write(name, masks_.back()));
    }
    options_.output.path = folder_.file("out.8vo");
  }

  std::vector<DenseMask> masks_;
  CombineOptions options_;
};

TEST_F(Combine, MasksAreTakenFromLeftToRight) {
  using Operation = bool (*)(bool, bool);
  const std::pair<Combination, Operation> operations[] = {
      {Combination::unite, [](bool a, bool b) { return a || b; }},
      {Combination::intersect, [](bool a, bool b) { return a && b; }},
      {Combination::subtract, [](bool a, bool b) { return a && !b; }},
      {Combination::exclusive_or, [](bool a, bool b) { return a != b; }}};
  options_.output.overwrite = true;
  for (const auto& [combination, operation] : operations) {
    options_.combination = combination;
    const CombineResult result = combine(options_, context_);
    const auto expected = computed(kCombineSize, [&](const Index3& p) {
      return operation(operation(masks_[0].at(p), masks_[1].at(p)), masks_[2].at(p));
    });
    EXPECT_EQ(read(options_.output.path), expected) << word_of(combination);
    EXPECT_EQ(result.voxels, static_cast<std::uint64_t>(std::count(
                                 expected.voxels.begin(), expected.voxels.end(), 1)));
  }
}

TEST_F(Combine, TheComplementIsThatOfOneMask) {
  options_.combination = Combination::complement;
  EXPECT_EQ(failure_of([&] { combine(options_, context_); }).kind, ErrorKind::invalid_argument);
  options_.inputs.resize(1);
  combine(options_, context_);
  EXPECT_EQ(read(options_.output.path),
            computed(kCombineSize, [&](const Index3& p) { return !masks_[0].at(p); }));
}

TEST_F(Combine, OneMaskIsNotCombined) {
  options_.inputs.resize(1);
  EXPECT_EQ(failure_of([&] { combine(options_, context_); }).kind, ErrorKind::invalid_argument);
}

TEST_F(Combine, AnotherGridIsRejectedUnlessItIsResampled) {
  geometry_.origin_mm[0] += 3 * geometry_.spacing_mm[0];
  options_.inputs = {options_.inputs[0], write("moved.8vo", masks_[1])};
  options_.combination = Combination::intersect;
  const Failure failure = failure_of([&] { combine(options_, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_EQ(failure.field, "is_resampling");

  options_.is_resampling = true;
  const CombineResult result = combine(options_, context_);
  EXPECT_EQ(result.resampled, std::vector<std::string>{options_.inputs[1]});
  EXPECT_EQ(read(options_.output.path), computed(kCombineSize, [&](const Index3& p) {
              return p.x >= 3 && masks_[0].at(p) && masks_[1].at({p.x - 3, p.y, p.z});
            }));
}

TEST_F(Combine, AStopThatIsAskedForLeavesNoFile) {
  testing::StoppingProgress stopped;
  context_.progress = &stopped;
  EXPECT_EQ(failure_of([&] { combine(options_, context_); }).kind, ErrorKind::cancelled);
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
}

}  // namespace
}  // namespace octavo
