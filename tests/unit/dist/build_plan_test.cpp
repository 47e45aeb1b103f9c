// A part opens the slices of its planes, and looks at no other file.
#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>

#include "octavo/builder/build_memory.h"
#include "octavo/builder/builder.h"
#include "octavo/builder/group_reader.h"
#include "octavo/dist/parts.h"
#include "octavo/dist/plan_text.h"
#include "octavo/io/open_source.h"
#include "octavo/io/source/slice_source.h"
#include "octavo/planes/between/isotropic_source.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSide = 8;

/// A stack of raw planes, and how it becomes a volume.
class RawStack {
 public:
  RawStack(std::int64_t count, bool is_isotropic = false) : is_isotropic_(is_isotropic) {
    options_.raw = parse_raw_layout("8,8," + std::to_string(count) + ",uint8");
    options_.spacing_mm = Point3{1, 1, is_isotropic ? 2.5 : 1};
    fs::create_directory(folder_.path() + "/slices");
    for (std::int64_t z = 0; z < count; ++z) write(z, static_cast<int>(z));
    build_.preset = Preset::fast;
    build_.threads = 1;
  }

  std::string slice(std::int64_t z) const {
    return folder_.path() + "/slices/s" + std::to_string(1000000 + z);
  }

  void write(std::int64_t z, int start) const {
    std::string bytes;
    for (int i = 0; i < kSide * kSide; ++i) bytes += static_cast<char>(start / 7 + i * i / 9);
    std::ofstream(slice(z), std::ios::binary) << bytes;
  }

  std::unique_ptr<PlaneSource> open_all() const {
    return volume_of(open_source({folder_.path() + "/slices"}, options_));
  }

  BuildPlan plan(FileCheck check = FileCheck::times) const {
    const auto slices = open_source({folder_.path() + "/slices"}, options_);
    NoProgress progress;
    return plan_build(*open_all(), build_, progress, slices->files().paths,
                      slice_stack_of(*slices), check);
  }

  /// Makes a part by its plan; `opened` gets the paths.
  void make_part(const BuildPlan& plan, std::int64_t first, std::int64_t end,
                 MemoryStorage& storage, const std::string& name,
                 std::set<std::string>* opened = nullptr) const {
    const auto open = [&](const std::vector<std::string>& paths, const SourceOptions& options) {
      if (opened != nullptr) opened->insert(paths.begin(), paths.end());
      return open_source(paths, options);
    };
    const auto source = volume_of(make_slice_source(plan.stack.value(), options_, open));
    NoProgress progress;
    build_part(plan, *source, first, end, storage, name, {.threads = 1}, progress);
  }

  std::vector<std::uint8_t> built() const {
    MemoryStorage storage;
    NoProgress progress;
    build_file(*open_all(), storage, "a.8vo", build_, progress);
    return *storage.files.at("a.8vo");
  }

  const std::string& folder() const { return folder_.path(); }

 private:
  std::unique_ptr<PlaneSource> volume_of(std::unique_ptr<PlaneSource> slices) const {
    if (!is_isotropic_) return slices;
    const IsotropicPlan plan = plan_isotropic(slices->description(), PlaneInterpolation::cubic);
    return make_isotropic_source(std::move(slices), plan);
  }

  TempFolder folder_;
  bool is_isotropic_;
  SourceOptions options_;
  BuildOptions build_;
};

std::vector<std::uint8_t> joined(const BuildPlan& plan, MemoryStorage& storage,
                                 const std::vector<std::string>& names) {
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const std::string& name : names) parts.push_back(PartFile::open(storage, name));
  NoProgress progress;
  join_parts(plan, parts, storage, "a.8vo", false, {.threads = 1}, progress);
  return *storage.files.at("a.8vo");
}

TEST(OwnSlices, PartsOfAStackMakeItsFileAndOpenNothingElse) {
  const SmallGroups groups(4096);
  for (const bool is_isotropic : {false, true}) {
    const RawStack stack(200, is_isotropic);
    const BuildPlan plan = parse_plan(plan_text(stack.plan()));
    ASSERT_TRUE(plan.stack);
    ASSERT_GE(plan.group_count, 4);
    MemoryStorage storage;
    std::vector<std::string> names;
    std::size_t opened_in_all = 0;
    for (std::int64_t group = plan.group_count - 1; group >= 0; --group) {
      names.push_back("part-" + std::to_string(group));
      std::set<std::string> opened;
      stack.make_part(plan, group, group + 1, storage, names.back(), &opened);
      opened_in_all += opened.size();
    }
    EXPECT_LE(opened_in_all, 200 + 4 * names.size());
    EXPECT_TRUE(joined(plan, storage, names) == stack.built());
  }
}

TEST(OwnSlices, APartNeedsNoOtherSlice) {
  const SmallGroups groups(4096);
  const RawStack stack(200);
  const BuildPlan plan = stack.plan();
  MemoryStorage storage;
  stack.make_part(plan, 1, 2, storage, "with all");
  for (std::int64_t z = 0; z < 200; ++z) {
    if (z / 64 != 1) fs::remove(stack.slice(z));
  }
  stack.make_part(plan, 1, 2, storage, "alone");
  EXPECT_TRUE(*storage.files.at("with all") == *storage.files.at("alone"));
  EXPECT_THROW(stack.make_part(plan, 2, 3, storage, "other"), Error);
}

// The change that no voxel of the plan tells of.
TEST(OwnSlices, AChangedSliceIsRejectedByThePartThatReadsIt) {
  const SmallGroups groups(4096);
  const RawStack stack(200);
  const BuildPlan plan = stack.plan();
  stack.write(150, 99);
  fs::last_write_time(stack.slice(150), fs::file_time_type::clock::now() + std::chrono::hours(1));
  MemoryStorage storage;
  stack.make_part(plan, 1, 2, storage, "other");
  const Error error = error_of([&] { stack.make_part(plan, 2, 3, storage, "changed"); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  EXPECT_EQ(error.path(), stack.slice(150));
  EXPECT_EQ(storage.files.size(), 1U);
}

TEST(OwnSlices, CopiesThatLostTheirTimesAreTakenWhereTheirContentIsThePlanned) {
  const SmallGroups groups(4096);
  for (const bool is_isotropic : {false, true}) {
    const RawStack stack(200, is_isotropic);
    const BuildPlan plan = parse_plan(plan_text(stack.plan(FileCheck::content)));
    EXPECT_EQ(plan_text(stack.plan(FileCheck::content)), plan_text(plan));
    EXPECT_NE(plan.id, stack.plan().id);
    const auto now = fs::file_time_type::clock::now();
    for (std::int64_t z = 0; z < 200; ++z) {
      stack.write(z, static_cast<int>(z));
      fs::last_write_time(stack.slice(z), now + std::chrono::hours(z));
    }
    EXPECT_EQ(plan_text(stack.plan(FileCheck::content)), plan_text(plan)) << "times stay out";
    MemoryStorage storage;
    std::vector<std::string> names;
    for (std::int64_t group = 0; group < plan.group_count; ++group) {
      names.push_back("part-" + std::to_string(group));
      stack.make_part(plan, group, group + 1, storage, names.back());
    }
    EXPECT_TRUE(joined(plan, storage, names) == stack.built());
    stack.write(150, 99);
    const Error error = error_of([&] {
      stack.make_part(plan, 0, plan.group_count, storage, "changed");
    });
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_EQ(error.path(), stack.slice(150));
  }
}

TEST(OwnSlices, SlicesThatStandElsewhereMakeTheSameParts) {
  const SmallGroups groups(4096);
  const RawStack stack(130);
  BuildPlan plan = stack.plan();
  plan.inputs = {stack.folder() + "/slices"};
  MemoryStorage storage;
  stack.make_part(plan, 1, 2, storage, "there");
  fs::rename(stack.folder() + "/slices", stack.folder() + "/moved");
  move_files(plan, stack.folder() + "/moved");
  EXPECT_EQ(plan.inputs, std::vector<std::string>{stack.folder() + "/moved"});
  stack.make_part(plan, 1, 2, storage, "here");
  EXPECT_TRUE(*storage.files.at("there") == *storage.files.at("here"));
}

/// Floats of a file that somebody writes to as soon as its first plane is read.
class WrittenWhileRead final : public PlaneSource {
 public:
  explicit WrittenWhileRead(std::string path) : path_(std::move(path)) {
    VolumeDescription volume;
    volume.type = VoxelType::float32;
    volume.size = {8, 8, 8};
    planes_ = make_memory_source(volume, zeros_);
    std::ofstream(path_) << "before";
  }
  const VolumeDescription& description() const override { return planes_->description(); }
  const std::vector<Warning>& warnings() const override { return planes_->warnings(); }
  void seek(std::int64_t first, std::int64_t end) override { planes_->seek(first, end); }
  void read_plane(std::span<std::byte> plane) override {
    std::ofstream(path_) << "and afterwards";
    planes_->read_plane(plane);
  }

 private:
  std::string path_;
  std::vector<std::byte> zeros_ = std::vector<std::byte>(8 * 8 * 8 * 4);
  std::unique_ptr<PlaneSource> planes_;
};

TEST(Planned, EveryPartIsFoundByItsPlaceAndNoOtherPlaceIs) {
  BuildPlan plan;
  for (plan.group_count = 1; plan.group_count < 40; ++plan.group_count) {
    for (plan.part_count = 1; plan.part_count <= plan.group_count; ++plan.part_count) {
      for (std::int64_t part = 0; part < plan.part_count; ++part) {
        PartPlace place = place_of(plan, part);
        ASSERT_EQ(part_at(plan, place), part);
        ++place.end_group;
        ASSERT_EQ(part_at(plan, place), std::nullopt);
      }
    }
  }
}

TEST(Planned, TheBandsOfAGroupTileItsBricks) {
  BuildPlan plan;
  plan.group_count = 3;
  plan.source.size = {64 * 5, 64 * 7, 192};
  for (plan.bands = 2; plan.bands <= 35; ++plan.bands) {
    plan.part_count = plan.group_count * plan.bands;
    BrickAt at = {0, 0};
    for (std::int64_t part = 0; part < plan.part_count; ++part) {
      PartPlace place = place_of(plan, part);
      ASSERT_EQ(begin_of(place), at) << part;
      at = end_of(place, 35);
      ASSERT_GT(at, begin_of(place));
      ASSERT_EQ(part_at(plan, place), part);
      ++place.end_brick;
      ASSERT_EQ(part_at(plan, place), std::nullopt);
    }
    ASSERT_EQ(at, (BrickAt{3, 0}));
  }
}

TEST(Planned, AFileThatChangesWhileItIsReadIsRejected) {
  const TempFolder folder;
  const std::string path = folder.file("floats");
  WrittenWhileRead source(path);
  NoProgress progress;
  const Error error = error_of([&] { plan_build(source, {}, progress, {path}); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
  EXPECT_EQ(error.path(), path);
}

TEST(Planned, NoMoreMemoryIsTakenThanIsAllowed) {
  const RawStack stack(70);
  const auto source = stack.open_all();
  BuildOptions options;
  options.threads = 1;
  options.max_memory_bytes =
      build_memory_bytes(source->description(), 1, 0) + source->resident_bytes();
  NoProgress progress;
  plan_build(*source, options, progress);
  --options.max_memory_bytes;
  const Error error = error_of([&] { plan_build(*source, options, progress); });
  EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded) << error.what();
}

// Where a plan is read, a part opened and its first plane read, the rest of a large stack costs
// next to nothing.
TEST(OwnSlices, OpeningAPartOfALargeStackTakesLessThanASecond) {
  constexpr std::int64_t kSlices = 100'000;
  const SmallGroups groups(1 << 16);
  const RawStack stack(kSlices);
  const std::string text = plan_text(stack.plan());
  const BuildPlan known = parse_plan(text);
  const std::int64_t group = known.group_count / 2;
  const std::int64_t first = first_plane_of(known, group);
  std::set<std::string> opened;
  const auto open = [&](const std::vector<std::string>& paths, const SourceOptions& options) {
    opened.insert(paths.begin(), paths.end());
    return open_source(paths, options);
  };
  const std::clock_t start = std::clock();
  const BuildPlan plan = parse_plan(text);
  SourceOptions options;
  options.raw = parse_raw_layout("8,8," + std::to_string(kSlices) + ",uint8");
  const auto source = make_slice_source(plan.stack.value(), options, open);
  const std::int64_t end = first_plane_of(plan, group + 1);
  NoProgress progress;
  UnchangedFiles(files_of(plan, *source, first, end), progress).require_still();
  source->seek(first, end);
  std::vector<std::byte> plane(kSide * kSide);
  source->read_plane(plane);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("a part of %lld of %lld slices: open after %.2f s of processor time\n",
              static_cast<long long>(end - first), static_cast<long long>(kSlices), seconds);
  EXPECT_EQ(opened.size(), static_cast<std::size_t>(end - first));
  EXPECT_EQ(*opened.begin(), stack.slice(first));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LE(seconds, 1.0);
#endif
}

}  // namespace
}  // namespace octavo::testing
