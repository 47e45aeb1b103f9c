#include "octavo/tasks/parts/part_numbers.h"

#include <gtest/gtest.h>

#include <map>

#include "octavo/core/error.h"

namespace octavo {
namespace {

using Numbers = std::vector<std::int64_t>;

TEST(PartNumbers, AListReadBackHasTheSameParts) {
  for (unsigned mask = 0; mask < 1024; ++mask) {
    Numbers parts;
    for (int part = 0; part < 10; ++part) {
      if ((mask >> part & 1) != 0) parts.push_back(part);
    }
    if (parts.empty()) continue;
    ASSERT_EQ(parse_part_list(part_list_text(parts), 10), parts) << mask;
  }
  EXPECT_EQ(part_list_text({3, 17, 18, 19}), "3,17-19");
  EXPECT_EQ(parse_part_list("4-6,2,5", 7), (Numbers{2, 4, 5, 6}));
}

TEST(PartNumbers, AnythingElseIsRejected) {
  for (const char* const text :
       {"", ",", "3,", ",3", "3-", "-3", "5-3", "x", "3 4", "1-2-3", "+1", "7",
        "99999999999999999999"}) {
    EXPECT_THROW(parse_part_list(text, 7), Error) << text;
  }
}

std::optional<ScheduledParts> scheduled(const std::map<std::string, std::string>& variables,
                                        std::int64_t count) {
  return scheduled_parts(
      [&](const char* name) -> const char* {
        const auto found = variables.find(name);
        return found == variables.end() ? nullptr : found->second.c_str();
      },
      count);
}

TEST(PartNumbers, RanksMakeEachPartOnce) {
  for (const std::int64_t count : {1, 5, 16, 17}) {
    for (const int ranks : {1, 2, 3, 16, 40}) {
      Numbers made(static_cast<std::size_t>(count));
      for (int rank = 0; rank < ranks; ++rank) {
        const auto own = scheduled({{"OMPI_COMM_WORLD_RANK", std::to_string(rank)},
                                    {"OMPI_COMM_WORLD_SIZE", std::to_string(ranks)}},
                                   count);
        ASSERT_TRUE(own);
        for (const std::int64_t part : own->parts) ++made[static_cast<std::size_t>(part)];
      }
      EXPECT_EQ(made, Numbers(static_cast<std::size_t>(count), 1)) << ranks;
    }
  }
}

// Arrays of all parts may begin anywhere; those of some parts name them.
TEST(PartNumbers, ArraysOfSlurmAreTakenAsTheyAreMeant) {
  const auto part = [](int task, int first, int last) {
    return scheduled({{"SLURM_ARRAY_TASK_ID", std::to_string(task)},
                      {"SLURM_ARRAY_TASK_MIN", std::to_string(first)},
                      {"SLURM_ARRAY_TASK_MAX", std::to_string(last)}},
                     10)
        ->parts;
  };
  EXPECT_EQ(part(0, 0, 9), Numbers{0});
  EXPECT_EQ(part(1, 1, 10), Numbers{0});
  EXPECT_EQ(part(10, 1, 10), Numbers{9});
  EXPECT_EQ(part(107, 100, 109), Numbers{7});
  EXPECT_EQ(part(1, 1, 9), Numbers{1});
  EXPECT_EQ(part(7, 7, 7), Numbers{7});
  EXPECT_EQ(part(12, 0, 15), Numbers{});
  EXPECT_THROW(part(12, 12, 13), Error);
}

TEST(PartNumbers, TextsNameTheValueOfTheVariableBesideThePart) {
  const auto task = scheduled({{"SGE_TASK_ID", "4"}}, 8);
  EXPECT_EQ(scheduled_text(*task, 8), "SGE_TASK_ID is 4: part 3 of 8");
  const auto rank =
      scheduled({{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "4"}}, 8);
  EXPECT_EQ(scheduled_text(*rank, 8), "OMPI_COMM_WORLD_RANK is 2 of 4 ranks: parts 2,6 of 8");
}

TEST(PartNumbers, TasksBehindTheLastPartHaveNone) {
  for (const char* const name :
       {"PBS_ARRAY_INDEX", "PBS_ARRAYID", "AWS_BATCH_JOB_ARRAY_INDEX", "JOB_COMPLETION_INDEX"}) {
    EXPECT_EQ(scheduled({{name, "2"}}, 3)->parts, Numbers{2}) << name;
    EXPECT_EQ(scheduled({{name, "3"}}, 3)->parts, Numbers{}) << name;
    EXPECT_THROW(scheduled({{name, "3x"}}, 3), Error) << name;
  }
  EXPECT_EQ(scheduled({{"LSB_JOBINDEX", "3"}}, 3)->parts, Numbers{2});
  EXPECT_EQ(scheduled({{"LSB_JOBINDEX", "4"}}, 3)->parts, Numbers{});
  EXPECT_THROW(scheduled({{"SLURM_ARRAY_TASK_ID", "3"}}, 3), Error);
}

TEST(PartNumbers, RanksOfSlurmAreThoseOfSteps) {
  EXPECT_FALSE(scheduled({{"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "3"}}, 3));
  EXPECT_EQ(scheduled({{"SLURM_PROCID", "1"}, {"SLURM_STEP_NUM_TASKS", "2"}}, 4)->parts,
            (Numbers{1, 3}));
}

TEST(PartNumbers, NoVariableIsNothing) {
  EXPECT_FALSE(scheduled({}, 3));
  EXPECT_FALSE(scheduled({{"LSB_JOBINDEX", "0"}, {"SGE_TASK_ID", "undefined"}}, 3));
}

}  // namespace
}  // namespace octavo
