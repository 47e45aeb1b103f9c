#include "octavo/dist/plan_text.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <set>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/core/utf8.h"
#include "octavo/dist/codec_check.h"
#include "octavo/dist/parts.h"
#include "octavo/planes/memory_source.h"
#include "support/built_file.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using testing::MemoryStorage;
using testing::ScratchFolder;
using testing::Volume;

Volume volume_of(VoxelType type, VolumeKind kind = VolumeKind::grey) {
  Volume volume;
  volume.description.type = type;
  volume.description.kind = kind;
  volume.description.size = {70, 66, 65};
  volume.description.geometry.spacing_mm = {0.1, 1.0 / 3, 0.7};
  volume.description.geometry.origin_mm = {-1e-7, 12345.678, 0};
  volume.description.rescale = {-0.1, 1e-3};
  volume.description.padding = -2000;
  volume.description.metadata = Metadata::read(R"({"a": [1, {"b":"c \"d\" é"}], "z":1e3})");
  const auto count = static_cast<std::size_t>(volume.description.size.voxel_count());
  with_voxel_type(type, [&](auto id) {
    using T = typename decltype(id)::type;
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = static_cast<T>(i * i / 64 % 90);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof value);
    }
  });
  return volume;
}

BuildPlan plan_of(const Volume& volume, const BuildOptions& options,
                  const std::vector<std::string>& files = {}) {
  NoProgress progress;
  const auto source = make_memory_source(volume.description, volume.voxels);
  return plan_build(*source, options, progress, files);
}

void make_part(const Volume& volume, const BuildPlan& plan, MemoryStorage& storage) {
  NoProgress progress;
  const auto source = make_memory_source(volume.description, volume.voxels);
  build_part(plan, *source, 0, plan.group_count, storage, "part", {.threads = 1}, progress);
}

std::vector<std::uint8_t> joined(const Volume& volume, const BuildPlan& plan) {
  NoProgress progress;
  MemoryStorage storage;
  make_part(volume, plan, storage);
  join_parts(plan, {PartFile::open(storage, "part")}, storage, "a.8vo", false, {.threads = 1},
             progress);
  return *storage.files.at("a.8vo");
}

std::vector<std::uint8_t> built(const Volume& volume, const BuildOptions& options) {
  NoProgress progress;
  MemoryStorage storage;
  const auto source = make_memory_source(volume.description, volume.voxels);
  build_file(*source, storage, "a.8vo", options, progress);
  return *storage.files.at("a.8vo");
}

TEST(PlanText, NamesAreBytesOfAnyKind) {
  const std::string names[] = {"plain \u00e9", "Sch\xe4" "del_1.tif", "D\xe9/\xf0\x9f/a",
                               "\xff\xfe" "00", std::string("\0", 1)};
  for (const std::string& name : names) {
    EXPECT_EQ(bytes_of_word(plan_word(name)), name);
    EXPECT_TRUE(is_utf8(plan_word(name)));
  }
  EXPECT_EQ(plan_word(names[0]), names[0]);
  for (const std::string bad : {"x0", "xg0", "x0E", "x"}) {
    EXPECT_THROW(bytes_of_word(std::string(1, '\0') + bad.substr(1)), Error) << bad;
  }
  BuildOptions options;
  options.threads = 1;
  BuildPlan plan = plan_of(volume_of(VoxelType::uint8), options);
  plan.inputs = {names[1]};
  plan.files = {{names[2], 5, 7, {}}};
  plan.id = id_of(plan);
  const BuildPlan again = parse_plan(plan_text(plan));
  EXPECT_EQ(again.inputs, plan.inputs);
  EXPECT_EQ(again.files.front().path, names[2]);
}

TEST(PlanText, APlanReadBackMakesTheSameFile) {
  BuildOptions grey;
  grey.threads = 1;
  grey.access = Access::slices;
  grey.max_error = 0.3;
  BuildOptions labels;
  labels.threads = 1;
  labels.kind = VolumeKind::labels;
  BuildOptions details;
  details.threads = 1;
  details.preset = Preset::fast;
  details.keep_details = 2;
  details.has_thumbnail = true;
  BuildOptions floats;
  floats.threads = 1;
  floats.repair = {1.5f, -2.0f};
  BuildOptions within = floats;
  within.max_error = 0.017;
  const std::vector<std::pair<Volume, BuildOptions>> rows = {
      {volume_of(VoxelType::int16), grey},
      {volume_of(VoxelType::uint16), details},
      {volume_of(VoxelType::uint8, VolumeKind::labels), labels},
      {volume_of(VoxelType::float32), floats},
      {volume_of(VoxelType::float32), within}};
  for (const auto& [volume, options] : rows) {
    const BuildPlan plan = plan_of(volume, options);
    const std::string text = plan_text(plan);
    const BuildPlan again = parse_plan(text);
    EXPECT_EQ(again.id, plan.id);
    EXPECT_EQ(again.floats, plan.floats);
    EXPECT_EQ(again.first_model, plan.first_model);
    EXPECT_EQ(again.source.padding, plan.source.padding);
    EXPECT_EQ(plan_text(again), text);
    EXPECT_TRUE(joined(volume, again) == built(volume, options)) << text;
  }
}

TEST(PlanText, EveryChangeIsRejected) {
  const ScratchFolder folder;
  std::ofstream(folder.file("a.raw")) << "voxels";
  BuildOptions options;
  options.threads = 1;
  BuildPlan plan = plan_of(volume_of(VoxelType::int16), options, {folder.file("a.raw")});
  plan.inputs = {"a.raw", "\"b\""};
  plan.recipe = R"({"kind":"grey"})";
  plan.id = id_of(plan);
  const std::string text = plan_text(plan);
  const BuildPlan again = parse_plan(text);
  ASSERT_EQ(again.files, plan.files);
  ASSERT_EQ(again.inputs, plan.inputs);
  ASSERT_EQ(again.recipe, plan.recipe);
  const auto is_rejected = [](const std::string& changed) {
    try {
      parse_plan(changed);
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  for (std::size_t at = 0; at < text.size(); at += 1 + text.size() / 400) {
    for (const char other : {'0', ' ', '"'}) {
      std::string changed = text;
      if (changed[at] == other) continue;
      changed[at] = other;
      EXPECT_TRUE(is_rejected(changed)) << at << ": " << text.substr(at, 20);
    }
  }
  for (std::size_t length = 0; length < text.size(); length += 1 + text.size() / 100) {
    EXPECT_TRUE(is_rejected(text.substr(0, length))) << length;
  }
  EXPECT_TRUE(is_rejected(text + "\n"));
  EXPECT_TRUE(is_rejected("{\"octavo_plan\":2}\n"));
  EXPECT_TRUE(is_rejected("{\"octavo_plan\":3}\n"));
}

TEST(PlanText, PartsHoldEveryGroupOnceAndDifferByOneAtMost) {
  for (const std::int64_t groups : {1, 2, 7, 117, 466}) {
    for (std::int64_t parts = 1; parts <= groups; ++parts) {
      BuildPlan plan;
      plan.group_count = groups;
      plan.part_count = parts;
      std::int64_t end = 0;
      for (std::int64_t part = 0; part < parts; ++part) {
        const PartPlace place = place_of(plan, part);
        ASSERT_EQ(place.first_group, end);
        end = place.end_group;
        const std::int64_t count = end - place.first_group;
        ASSERT_TRUE(count == groups / parts || count == (groups + parts - 1) / parts);
      }
      ASSERT_EQ(end, groups);
    }
  }
}

TEST(PlanText, EachKindOfBuildIsCheckedByItself) {
  BuildOptions fast;
  fast.preset = Preset::fast;
  BuildOptions small = fast;
  small.preset = Preset::small;
  BuildOptions lossy = fast;
  lossy.max_error = 2;
  BuildOptions labels = fast;
  labels.kind = VolumeKind::labels;
  const std::set<std::uint32_t> checks = {
      codec_check(VoxelType::int16, fast),   codec_check(VoxelType::int16, small),
      codec_check(VoxelType::int16, lossy),  codec_check(VoxelType::uint8, labels),
      codec_check(VoxelType::float32, fast), codec_check(VoxelType::float32, lossy)};
  EXPECT_EQ(checks.size(), 6U);
  EXPECT_EQ(codec_check(VoxelType::int16, fast), codec_check(VoxelType::uint32, fast));
}

TEST(PlanText, AProgramThatMakesOtherBytesIsRejected) {
  BuildOptions options;
  options.threads = 1;
  const Volume volume = volume_of(VoxelType::uint8);
  BuildPlan other = plan_of(volume, options);
  EXPECT_EQ(other.codec_check, codec_check(other.source.type, other.options));
  ++other.codec_check;
  other.id = id_of(other);
  const BuildPlan plan = parse_plan(plan_text(other));
  EXPECT_EQ(plan.codec_check, other.codec_check);
  MemoryStorage storage;
  for (const auto& action : {std::function<void()>([&] { make_part(volume, plan, storage); }),
                             std::function<void()>([&] {
                               NoProgress progress;
                               join_parts(plan, {}, storage, "a.8vo", false, {}, progress);
                             })}) {
    try {
      action();
      FAIL() << "another program was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
      EXPECT_NE(error.detail().find("codec check"), std::string::npos) << error.what();
    }
  }
  EXPECT_TRUE(storage.files.empty());
}

TEST(PlanText, GroupsOfAnotherProgramAreRejected) {
  BuildOptions options;
  options.threads = 1;
  std::string text;
  {
    const SmallGroups groups(1 << 10);
    text = plan_text(plan_of(volume_of(VoxelType::uint8), options));
  }
  try {
    parse_plan(text);
    FAIL() << "groups of another program were taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
    EXPECT_NE(error.detail().find("another version"), std::string::npos) << error.what();
  }
}

/// Whose file is written again while its planes are read.
class RestlessSource final : public PlaneSource {
 public:
  RestlessSource(const Volume& volume, std::string path)
      : source_(make_memory_source(volume.description, volume.voxels)), path_(std::move(path)) {}
  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  void seek(std::int64_t first, std::int64_t end) override { source_->seek(first, end); }
  void read_plane(std::span<std::byte> plane) override {
    source_->read_plane(plane);
    std::ofstream(path_, std::ios::app) << "more";
  }

 private:
  std::unique_ptr<PlaneSource> source_;
  std::string path_;
};

/// A volume, and the file that plans of it name.
struct PlannedFile {
  PlannedFile() {
    std::ofstream(path) << "voxels";
    options.threads = 1;
  }

  ScratchFolder folder;
  std::string path = folder.file("slice");
  BuildOptions options;
  Volume volume = volume_of(VoxelType::uint8);
};

TEST(PlanText, AFileThatChangesWhileItIsReadIsInNoPart) {
  const PlannedFile file;
  const BuildPlan plan = plan_of(file.volume, file.options, {file.path});
  RestlessSource source(file.volume, file.path);
  MemoryStorage storage;
  NoProgress progress;
  try {
    build_part(plan, source, 0, plan.group_count, storage, "part", {.threads = 1}, progress);
    FAIL() << "a source that changed was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_EQ(error.path(), file.path);
  }
  EXPECT_TRUE(storage.files.empty());
}

// A change behind the first group, which no voxel of the plan tells of.
TEST(PlanText, AFileThatWasChangedSinceIsRejectedByName) {
  const PlannedFile file;
  const BuildPlan plan = parse_plan(plan_text(plan_of(file.volume, file.options, {file.path})));
  EXPECT_NE(plan.id, plan_of(file.volume, file.options).id);
  MemoryStorage storage;
  make_part(file.volume, plan, storage);
  std::ofstream(file.path) << "voxel";
  try {
    make_part(file.volume, plan, storage);
    FAIL() << "a changed source was taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_EQ(error.path(), file.path);
  }
}

}  // namespace
}  // namespace octavo
