// Power cuts, by a model of what a disk may keep: behind every change that a build makes, the name
// holds the old file or the new one, whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "octavo/builder/builder.h"
#include "octavo/file/verify.h"
#include "octavo/planes/memory_source.h"
#include "support/goal_cases.h"
#include "support/recording_storage.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using Content = std::vector<std::uint8_t>;

constexpr Outlasting kWays[] = {Outlasting::everything,        Outlasting::nothing,
                                Outlasting::names_before_data, Outlasting::data_before_names,
                                Outlasting::some_pages,        Outlasting::some_of_all};
constexpr std::size_t kFixedWays = 4;

// The changes of a build of a noisy volume over an old file, or none, and what they lead to.
struct Recorded {
  std::vector<Change> changes;
  std::optional<Content> old_bytes;
  Content new_bytes;
};

Recorded record_build(bool has_old_file) {
  VolumeDescription description;
  description.size = {110, 90, 70};
  std::vector<std::byte> voxels(110 * 90 * 70);
  std::mt19937_64 random(41);
  for (std::byte& voxel : voxels) voxel = static_cast<std::byte>(random() % 200);

  RecordingStorage storage;
  Recorded result;
  if (has_old_file) {
    result.old_bytes = Content{'o', 'l', 'd'};
    storage.add_file("a.8vo", *result.old_bytes);
  }
  BuildOptions options;
  options.overwrite = has_old_file;
  options.threads = 2;
  NoProgress progress;
  build_file(*make_memory_source(description, voxels), storage, "a.8vo", options, progress);
  result.changes = storage.changes;
  result.new_bytes = storage.content(storage.names().at("a.8vo"));
  return result;
}

const Content* old_of(const Recorded& recorded) {
  return recorded.old_bytes ? &*recorded.old_bytes : nullptr;
}

// Whether what stands under the name may stand there; `is_over`: the build has ended.
bool is_allowed(const Recorded& recorded, const Content* found, bool is_over) {
  if (found != nullptr && *found == recorded.new_bytes) return true;
  if (is_over) return false;
  if (found == nullptr) return !recorded.old_bytes;
  return recorded.old_bytes && *found == *recorded.old_bytes;
}

// Cuts behind every change, in every way; the number of states that may not be.
std::uint64_t count_violations(const Recorded& recorded, GoalCases& cases, std::uint64_t rounds) {
  std::mt19937_64 random(42);
  std::uint64_t violations = 0;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    for (std::size_t count = 0; count <= recorded.changes.size(); ++count) {
      for (const Outlasting way : std::span(kWays).subspan(round == 0 ? 0 : kFixedWays)) {
        if (!cases.next()) return violations;
        const auto found = after_power_cut(recorded.changes, count, "a.8vo", old_of(recorded), way,
                                           random);
        const bool is_over = count == recorded.changes.size();
        if (!is_allowed(recorded, found.get(), is_over)) ++violations;
      }
    }
  }
  return violations;
}

std::uint64_t states_of(const Recorded& recorded, std::uint64_t rounds) {
  return (recorded.changes.size() + 1) * (std::size(kWays) + (rounds - 1) * 2);
}

TEST(PowerCut, TheNameHoldsTheOldFileOrTheNewOne) {
  for (const bool has_old_file : {true, false}) {
    const Recorded recorded = record_build(has_old_file);
    NoProgress progress;
    ASSERT_TRUE(verify_file(byte_source_of(recorded.new_bytes, "a.8vo"), {}, progress).is_sound());
    const std::uint64_t rounds = case_count(16, 2000);
    GoalCases cases("D2", "states after a power cut", states_of(recorded, rounds));
    EXPECT_EQ(count_violations(recorded, cases, rounds), 0u);
    cases.tell(std::to_string(recorded.changes.size()) + " changes a build");
    EXPECT_GE(cases.done(), 1000u);
  }
}

// Without one of its syncs a build is not safe, and the model knows it.
TEST(PowerCut, EverySyncIsNeeded) {
  const Recorded recorded = record_build(true);
  const auto is_sync = [](const Change& change) {
    return change.what == Change::What::sync || change.what == Change::What::sync_folder;
  };
  std::vector<std::size_t> syncs;
  for (std::size_t i = 0; i < recorded.changes.size(); ++i) {
    if (is_sync(recorded.changes[i])) syncs.push_back(i);
  }
  ASSERT_GE(syncs.size(), 2u);
  // The last two make the sealed file and its name durable; an earlier one orders data and seal.
  for (const std::size_t at : {syncs[syncs.size() - 2], syncs.back()}) {
    Recorded careless = recorded;
    careless.changes.erase(careless.changes.begin() + static_cast<std::ptrdiff_t>(at));
    GoalCases cases("D2", "states of builds without a sync", states_of(careless, 4));
    EXPECT_GT(count_violations(careless, cases, 4), 0u) << "change " << at;
  }
}

}  // namespace
}  // namespace octavo
