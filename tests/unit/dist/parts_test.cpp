// Whatever parts a build is made in, its file is that of a build in one piece.
#include "octavo/dist/parts.h"

#include <gtest/gtest.h>

#include <functional>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/planes/between/isotropic_source.h"
#include "octavo/planes/memory_source.h"
#include "octavo/planes/phantom.h"
#include "support/failure_text.h"
#include "support/memory_storage.h"
#include "support/texture_source.h"

namespace octavo {
namespace {

using testing::expect_words;
using testing::failure_of;
using testing::MemoryStorage;
using testing::TextureSource;

using Runs = std::vector<std::pair<std::int64_t, std::int64_t>>;  // groups first .. end
using Open = std::function<std::unique_ptr<PlaneSource>()>;

struct Case {
  const char* name;
  Open open;
  BuildOptions options;
  std::vector<Runs> partings;
};

const Runs kEach = {{0, 1}, {1, 2}, {2, 3}};
const Runs kBackwards = {{2, 3}, {0, 2}};
const Runs kOne = {{0, 3}};

constexpr Size3 kOneBrickAGroup = {40, 30, 150};

Open texture(VoxelType type, VolumeKind kind = VolumeKind::grey, bool is_alike = false) {
  return [=] {
    // Alike groups have six bricks each, others one.
    const Size3 size = is_alike ? Size3{136, 72, 150} : kOneBrickAGroup;
    auto source = std::make_unique<TextureSource>(TextureSource::three_groups(type, kind, size));
    source->is_alike = is_alike;
    return source;
  };
}

BuildOptions options_of(Preset preset, double max_error = 0) {
  BuildOptions options;
  options.preset = preset;
  options.max_error = max_error;
  options.threads = 2;
  return options;
}

std::vector<std::uint8_t> built(const Case& row) {
  MemoryStorage storage;
  NoProgress progress;
  build_file(*row.open(), storage, "a.8vo", row.options, progress);
  return *storage.files.at("a.8vo");
}

std::string part_name(std::int64_t first) { return "part-" + std::to_string(first); }

BuildPlan plan_of(const Case& row) {
  NoProgress progress;
  return plan_build(*row.open(), row.options, progress);
}

void make_part(const BuildPlan& plan, const Open& open, std::int64_t first, std::int64_t end,
               MemoryStorage& storage) {
  NoProgress progress;
  build_part(plan, *open(), first, end, storage, part_name(first), {.threads = 2}, progress);
}

std::vector<std::shared_ptr<PartFile>> open_parts(MemoryStorage& storage, const Runs& runs) {
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const auto& run : runs) parts.push_back(PartFile::open(storage, part_name(run.first)));
  return parts;
}

BuildResult join(const BuildPlan& plan, MemoryStorage& storage, const Runs& runs) {
  NoProgress progress;
  return join_parts(plan, open_parts(storage, runs), storage, "a.8vo", false, {.threads = 2},
                    progress);
}

void expect_same_file(const Case& row) {
  SCOPED_TRACE(row.name);
  const std::vector<std::uint8_t> whole = built(row);
  const BuildPlan plan = plan_of(row);
  for (const Runs& runs : row.partings) {
    MemoryStorage storage;
    for (const auto& [first, end] : runs) make_part(plan, row.open, first, end, storage);
    const BuildResult result = join(plan, storage, runs);
    EXPECT_EQ(result.file_bytes, whole.size());
    ASSERT_TRUE(*storage.files.at("a.8vo") == whole) << runs.size() << " parts";
    EXPECT_EQ(storage.files.size(), runs.size() + 1) << "something is left behind";
  }
}

class Parts : public ::testing::Test {
  SmallGroups groups_{1};
};

TEST_F(Parts, GreyVolumesAreTheSameInAnyParts) {
  expect_same_file({"fast", texture(VoxelType::int16), options_of(Preset::fast),
                    {kEach, kBackwards, kOne, {{0, 1}, {1, 3}}}});
  expect_same_file({"small", texture(VoxelType::uint16, VolumeKind::grey, true),
                    options_of(Preset::small), {kEach}});
}

TEST_F(Parts, VolumesWithAMaxErrorAreTheSame) {
  expect_same_file({"max error", texture(VoxelType::int16), options_of(Preset::fast, 4),
                    {kEach, kBackwards}});
}

TEST_F(Parts, VolumesWithoutDetailsAreTheSameUpToTheErrorsInTheirMetadata) {
  BuildOptions options = options_of(Preset::fast);
  options.keep_details = 1;
  expect_same_file({"keep details", texture(VoxelType::int16), options, {kEach, kOne}});
}

TEST_F(Parts, LabelsAreTheSame) {
  BuildOptions options = options_of(Preset::small);
  options.kind = VolumeKind::labels;
  expect_same_file({"labels", texture(VoxelType::uint16, VolumeKind::labels), options,
                    {kEach, kBackwards}});
}

TEST_F(Parts, FloatsAreTheSameBitByBitAndWithinAMaxError) {
  expect_same_file({"exact", texture(VoxelType::float32), options_of(Preset::fast),
                    {{{1, 2}, {0, 1}, {2, 3}}}});
  expect_same_file({"within", texture(VoxelType::float32), options_of(Preset::fast, 0.3),
                    {{{0, 1}, {1, 3}}}});
}

TEST_F(Parts, ThumbnailsAreTheSame) {
  BuildOptions options = options_of(Preset::fast);
  options.has_thumbnail = true;
  expect_same_file({"thumbnail", texture(VoxelType::int16), options, {kBackwards}});
}

TEST_F(Parts, IsotropicVolumesAreTheSame) {
  const Open open = [] {
    PhantomOptions phantom;
    phantom.size = {90, 80, 61};
    phantom.spacing_mm = {1, 1, 2.4};
    phantom.noise_sigma = 4;
    auto source = make_phantom(phantom);
    const IsotropicPlan plan = plan_isotropic(source->description(), PlaneInterpolation::cubic);
    return make_isotropic_source(std::move(source), plan);
  };
  expect_same_file({"isotropic", open, options_of(Preset::fast), {kEach}});
}

TEST_F(Parts, APartMadeTwiceHasTheSameBytes) {
  const Case row{"twice", texture(VoxelType::int16), options_of(Preset::fast), {}};
  const BuildPlan plan = plan_of(row);
  EXPECT_EQ(plan_of(row).id, plan.id);
  MemoryStorage one;
  MemoryStorage other;
  make_part(plan, row.open, 1, 2, one);
  make_part(plan, row.open, 1, 2, other);
  make_part(plan, row.open, 1, 2, other);
  EXPECT_TRUE(*one.files.at("part-1") == *other.files.at("part-1"));
  EXPECT_EQ(other.files.size(), 1u);
}

TEST_F(Parts, WrongPartsAreRejectedByName) {
  const Case row{"wrong", texture(VoxelType::int16), options_of(Preset::fast), {}};
  const BuildPlan plan = plan_of(row);
  MemoryStorage storage;
  for (const auto& [first, end] : kEach) make_part(plan, row.open, first, end, storage);
  expect_words(failure_of([&] { join(plan, storage, {{0, 1}}); }, ErrorKind::io),
               {"a.8vo", "groups 1 to 2 of 3"});
  EXPECT_EQ(missing_groups(plan, open_parts(storage, {{0, 1}, {2, 3}})).front().first_group, 1);
  expect_words(failure_of([&] { join(plan, storage, {{0, 1}, {1, 2}, {1, 2}, {2, 3}}); },
                          ErrorKind::invalid_argument),
               {"part-1", "group 1", "another part"});
  BuildPlan other = plan;
  ++other.id;
  expect_words(failure_of([&] { join(other, storage, kEach); }, ErrorKind::invalid_argument),
               {"part-0", "another plan"});
  EXPECT_EQ(storage.files.count("a.8vo"), 0u);
  EXPECT_EQ(storage.files.size(), 3u);
}

TEST_F(Parts, OtherSourcesThanThePlannedOneAreRejected) {
  const Case row{"other", texture(VoxelType::int16), options_of(Preset::fast), {}};
  const BuildPlan plan = plan_of(row);
  MemoryStorage storage;
  expect_words(failure_of([&] { make_part(plan, texture(VoxelType::uint16), 1, 2, storage); },
                          ErrorKind::source_rejected),
               {"voxel type", "plan again"});
  const Open changed = [] {
    auto source = std::make_unique<TextureSource>(TextureSource::three_groups(
        VoxelType::int16, VolumeKind::grey, kOneBrickAGroup));
    source->changed_plane = 10;
    return source;
  };
  expect_words(failure_of([&] { make_part(plan, changed, 0, 1, storage); },
                          ErrorKind::source_rejected),
               {"first planes", "plan again"});
  EXPECT_TRUE(storage.files.empty());
}

// Every byte is proven by a checksum or, in the head, means nothing.
TEST_F(Parts, DamagedPartsAreRejected) {
  const Case row{"damaged", texture(VoxelType::int16), options_of(Preset::fast), {}};
  const BuildPlan plan = plan_of(row);
  MemoryStorage storage;
  for (const auto& [first, end] : kEach) make_part(plan, row.open, first, end, storage);
  auto& bytes = *storage.files.at("part-1");
  const std::vector<std::uint8_t> whole = bytes;
  const auto rejected = [&] {
    try {
      join(plan, storage, kEach);
    } catch (const Error& error) {
      EXPECT_EQ(error.path(), "part-1") << error.what();
      EXPECT_EQ(storage.files.count("a.8vo"), 0u);
      return true;
    }
    storage.remove("a.8vo");
    return false;
  };
  for (std::size_t at = 0; at < whole.size(); at += 1 + whole.size() / 60) {
    bytes[at] ^= 0x10;
    EXPECT_TRUE(rejected()) << "byte " << at;
    bytes = whole;
  }
  for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 30) {
    bytes.resize(length);
    EXPECT_TRUE(rejected()) << length << " bytes";
    bytes = whole;
  }
  EXPECT_FALSE(rejected());
}

// Whatever call fails, no name holds half a part.
TEST_F(Parts, AFailingDiskLeavesNoPart) {
  const Case row{"disk", texture(VoxelType::int16), options_of(Preset::fast), {}};
  const BuildPlan plan = plan_of(row);
  MemoryStorage sound;
  make_part(plan, row.open, 2, 3, sound);
  const std::size_t calls = sound.calls.size();
  for (std::size_t call = 1; call <= calls; ++call) {
    MemoryStorage storage;
    storage.fail_at = call;
    failure_of([&] { make_part(plan, row.open, 2, 3, storage); }, ErrorKind::io);
    const auto part = storage.files.find("part-2");
    if (part != storage.files.end()) {
      EXPECT_TRUE(*part->second == *sound.files.at("part-2")) << sound.calls[call - 1];
    }
    EXPECT_LE(storage.files.size(), 1u) << sound.calls[call - 1];
  }
}

}  // namespace
}  // namespace octavo
