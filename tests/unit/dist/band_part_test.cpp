// Parts that share a group: what they say when they do not fit, and joins of them.
#include "octavo/dist/band_part.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/dist/join_steps.h"
#include "octavo/dist/plan_text.h"
#include "support/failure_text.h"
#include "support/laid_out_file.h"
#include "support/placed_parts.h"

namespace octavo::testing {
namespace {

using Files = std::map<std::string, FileBytes>;

constexpr std::int64_t kBricks = 16;  // of a layer

/// Counts the planes that are read.
class CountedPlanes final : public PlaneSource {
 public:
  explicit CountedPlanes(std::unique_ptr<PlaneSource> source) : source_(std::move(source)) {}
  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  void read_plane(std::span<std::byte> plane) override {
    ++count;
    source_->read_plane(plane);
  }
  void seek(std::int64_t first, std::int64_t end) override { source_->seek(first, end); }
  bool can_seek() const override { return is_sought; }

  std::int64_t count = 0;
  bool is_sought = true;

 private:
  std::unique_ptr<PlaneSource> source_;
};

/// Two groups of 4 planes, each shared by three parts. Of thick slices, so that bricks are small.
class BandParts : public ::testing::Test {
 protected:
  BandParts() {
    volume_ = small_volume("bands", VoxelType::int16, {200, 200, 8});
    volume_.description.geometry.spacing_mm = {1, 1, 16};
    volume_.options.has_thumbnail = true;
    plan_ = shared(volume_, 3);
    for (std::int64_t part = 0; part < plan_.part_count; ++part) {
      places_.push_back(place_of(plan_, part));
    }
    whole_ = built(volume_);
  }

  static BuildPlan shared(const SmallVolume& volume, std::int64_t bands) {
    BuildPlan plan = planned(volume);
    plan.bands = bands;
    plan.part_count = plan.group_count * bands;
    plan.id = id_of(plan);
    return plan;
  }

  void make_all() {
    for (const PartPlace& place : places_) make_placed(volume_, plan_, place, storage_);
  }

  std::string join_failure(const Places& places, ErrorKind kind) {
    return failure_of([&] { joined_places(plan_, storage_, places); }, kind);
  }

  std::vector<std::shared_ptr<PartFile>> opened() {
    std::vector<std::shared_ptr<PartFile>> parts;
    for (const PartPlace& place : places_) {
      parts.push_back(PartFile::open(storage_, name_of(place)));
    }
    return parts;
  }

  void join_in_steps() {
    NoProgress progress;
    const auto parts = opened();
    lay_out_join(plan_, parts, storage_, "a.8vo", false, {.threads = 1}, progress);
    for (const auto& part : parts) copy_part(plan_, part, storage_, "a.8vo", false, progress);
    seal_join(plan_, storage_, "a.8vo", false, {.threads = 1}, progress);
  }

  SmallGroups groups_{1};
  SmallVolume volume_;
  BuildPlan plan_;
  Places places_;
  std::vector<std::uint8_t> whole_;
  MemoryStorage storage_;
};

TEST_F(BandParts, APlanWithBandsHasOneTextAndPlansWithoutKeepTheirs) {
  ASSERT_EQ(layer_bricks_of(plan_), kBricks);
  const std::string text = plan_text(plan_);
  const BuildPlan read = parse_plan(text);
  EXPECT_EQ(read.bands, 3);
  EXPECT_EQ(read.id, plan_.id);
  EXPECT_EQ(plan_text(planned(volume_)).find("bands"), std::string::npos);
  EXPECT_NE(shared(volume_, 2).id, plan_.id);
  for (std::size_t at = 0; at < text.size(); at += 7) {
    std::string changed = text;
    changed[at] = changed[at] == '7' ? '8' : '7';
    EXPECT_THROW(parse_plan(changed), Error) << at;
  }
}

TEST_F(BandParts, JoinsInOneInStepsAndOfConsumedPartsMakeTheFile) {
  make_all();
  const Files parts = copied(storage_.files);
  std::ranges::reverse(places_);
  joined_places(plan_, storage_, places_);
  EXPECT_TRUE(*storage_.files.at("a.8vo") == whole_);
  storage_.files = copied(parts);
  join_in_steps();
  EXPECT_TRUE(*storage_.files.at("a.8vo") == whole_);
  storage_.files = copied(parts);
  NoProgress progress;
  std::vector<std::string> names;
  for (const PartPlace& place : places_) names.push_back(name_of(place));
  consume_parts(plan_, names, storage_, "a.8vo", false, {.threads = 1}, progress);
  EXPECT_TRUE(*storage_.files.at("a.8vo") == whole_);
  EXPECT_EQ(storage_.files.size(), 2u) << "the file, and the mark that says of what plan it is";
}

TEST_F(BandParts, ALayoutTellsWhereBytesOfBandsBelongAndHoldsTheRest) {
  make_all();
  NoProgress progress;
  const JoinLayout layout =
      lay_out_join(plan_, opened(), storage_, "a.8vo", false, {.threads = 1}, progress);
  EXPECT_EQ(layout_text(parse_layout(layout_text(layout))), layout_text(layout));
  EXPECT_EQ(parts_of(layout).size(), places_.size());
  const LaidOutFile made = laid_out_file(layout, storage_, "a.8vo", name_of);
  EXPECT_EQ(made.bytes, layout.file_bytes);
  EXPECT_TRUE(made.file == whole_);
}

TEST_F(BandParts, WhateverCallFailsAJoinedFileIsWholeOrNotThere) {
  make_all();
  const Files parts = copied(storage_.files);
  const std::vector<std::function<void()>> joins = {
      [&] { joined_places(plan_, storage_, places_); }, [&] { join_in_steps(); }};
  for (const std::function<void()>& join : joins) {
    storage_.files = copied(parts);
    storage_.calls.clear();
    join();
    const std::size_t calls = storage_.calls.size();
    for (std::size_t call = 1; call <= calls; call += 1 + calls / 80) {
      storage_.files = copied(parts);
      storage_.calls.clear();
      storage_.fail_at = call;
      storage_.has_failed = false;
      EXPECT_THROW(join(), Error) << call;
      storage_.fail_at = 0;
      const auto found = storage_.files.find("a.8vo");
      if (found != storage_.files.end()) {
        ASSERT_TRUE(*found->second == whole_) << call;
        storage_.remove("a.8vo");
      }
      join();
      ASSERT_TRUE(*storage_.files.at("a.8vo") == whole_) << call;
    }
  }
}

TEST_F(BandParts, MissingBandsAreNamedAndNoOthers) {
  make_all();
  const auto gaps = [&](const Places& places) {
    std::vector<std::shared_ptr<PartFile>> parts;
    for (const PartPlace& place : places) {
      parts.push_back(PartFile::open(storage_, name_of(place)));
    }
    std::string text;
    for (const PartPlace& gap : missing_groups(plan_, parts)) text += place_text(gap) + "; ";
    return text;
  };
  const auto& p = places_;
  EXPECT_EQ(gaps(p), "");
  EXPECT_EQ(gaps({p[0], p[2], p[3], p[4], p[5]}), "bricks 5 to 9 of group 0; ");
  EXPECT_EQ(gaps({p[0], p[1], p[4], p[5]}),
            "bricks 10 to 15 of group 0; bricks 0 to 4 of group 1; ");
  EXPECT_EQ(gaps({p[0]}), "bricks 5 to 15 of group 0; group 1; ");
  EXPECT_EQ(gaps({p[5]}), "group 0; bricks 0 to 9 of group 1; ");
  EXPECT_EQ(gaps({}), "groups 0 to 1; ");
  expect_words(join_failure({p[0], p[2], p[3], p[4], p[5]}, ErrorKind::io),
               {"a.8vo", "no part holds bricks 5 to 9 of group 0"});
}

TEST_F(BandParts, BandsThatOverlapOrAreOfAnotherPlanAreRejectedByName) {
  make_all();
  Places places = places_;
  const PartPlace wider = {plan_.id, 0, 1, 4, 12};
  make_placed(volume_, plan_, wider, storage_);
  places[1] = wider;
  expect_words(join_failure(places, ErrorKind::invalid_argument),
               {"brick 4 of group 0", "another part holds as well"});
  places = places_;
  const PartPlace whole = {plan_.id, 0, 1};
  make_placed(volume_, plan_, whole, storage_);
  places.push_back(whole);
  EXPECT_NE(join_failure(places, ErrorKind::invalid_argument).find("as well"), std::string::npos);
  const BuildPlan other = shared(volume_, 4);
  EXPECT_NE(failure_of([&] { joined_places(other, storage_, places_); },
                       ErrorKind::invalid_argument)
                .find("another plan"),
            std::string::npos);
  EXPECT_EQ(storage_.files.count("a.8vo"), 0u);
}

// No file tells here that the source is another one.
TEST_F(BandParts, BandsOfOtherVoxelsOfTheirGroupAreRejectedByName) {
  make_all();
  SmallVolume changed = volume_;
  changed.voxels.back() ^= std::byte{1};
  make_placed(changed, plan_, places_[4], storage_);
  expect_words(join_failure(places_, ErrorKind::source_rejected),
               {name_of(places_[4]), "other voxels of group 1"});
  make_placed(changed, plan_, places_[3], storage_);
  make_placed(changed, plan_, places_[5], storage_);
  joined_places(plan_, storage_, places_);
  changed.voxels.front() ^= std::byte{1};
  EXPECT_NE(failure_of([&] { make_placed(changed, plan_, places_[2], storage_); },
                       ErrorKind::source_rejected)
                .find("plan again"),
            std::string::npos);
}

TEST_F(BandParts, EveryFlippedBitAndEveryCutIsRejected) {
  make_all();
  const std::string name = name_of(places_[4]);
  auto& bytes = *storage_.files.at(name);
  const std::vector<std::uint8_t> good = bytes;
  const auto expect_rejected = [&](std::size_t at) {
    try {
      joined_places(plan_, storage_, places_);
      ADD_FAILURE() << "byte " << at;
      storage_.remove("a.8vo");
    } catch (const Error& error) {
      EXPECT_EQ(error.path(), name) << error.what() << ", byte " << at;
    }
    EXPECT_EQ(storage_.files.count("a.8vo"), 0u);
    bytes = good;
  };
  for (std::size_t at = 0; at < good.size(); at += at < 80 ? 1 : 1 + good.size() / 80) {
    bytes[at] ^= 0x10;
    expect_rejected(at);
  }
  for (std::size_t length = 0; length < good.size(); length += 1 + good.size() / 30) {
    bytes.resize(length);
    expect_rejected(length);
  }
}

TEST_F(BandParts, WhatHasNoBandsIsRejected) {
  SmallVolume lossy = volume_;
  lossy.options.max_error = 2;
  const PartPlace band = {0, 1, 2, 3, 9};
  const auto failure = [&](const SmallVolume& volume) {
    return failure_of([&] { make_placed(volume, planned(volume), band, storage_); },
                      ErrorKind::invalid_argument);
  };
  expect_words(failure(lossy), {"whose voxels change", "plan parts of whole groups"});
  lossy.options.max_error = 0;
  lossy.options.keep_details = 1;
  expect_words(failure(lossy), {"whose voxels change"});
  for (const PartPlace& place : Places{{0, 2, 3, 0, 4}, {0, 0, 2, 0, 4}, {0, 0, 1, 0, kBricks + 1},
                                       {0, 0, 1, 4, 4}, {0, -1, 0, 0, 4}, {0, 0, 1, -1, 4}}) {
    NoProgress progress;
    EXPECT_THROW(build_band(plan_, *volume_.open(), place, storage_, "band", {}, progress), Error);
  }
  EXPECT_TRUE(storage_.files.empty());
  CountedPlanes sound(volume_.open());
  EXPECT_NO_THROW(require_bands(plan_, sound));
  sound.is_sought = false;
  expect_words(failure_of([&] { require_bands(plan_, sound); }, ErrorKind::invalid_argument),
               {"from its start on"});
  const SmallGroups large(std::uint64_t{1} << 20);
  expect_words(failure_of([&] { require_bands(CountedPlanes(volume_.open()), volume_.options); },
                          ErrorKind::invalid_argument),
               {"8 planes, several layers of bricks"});
}

std::int64_t planes_read(const SmallVolume& volume, const BuildPlan& plan, const PartPlace& place,
                         std::uint64_t band_bytes = 0) {
  CountedPlanes planes(volume.open());
  MemoryStorage storage;
  NoProgress progress;
  build_band(plan, planes, place, storage, "band", {.threads = 1, .band_bytes = band_bytes},
             progress);
  return planes.count;
}

TEST_F(BandParts, PlanesAreReadOnceWhereMemoryHoldsTheBand) {
  EXPECT_EQ(planes_read(volume_, plan_, places_[1]), 4);
  EXPECT_EQ(planes_read(volume_, plan_, places_[4]), 4) << "trained on what was picked up";
  constexpr std::uint64_t kBrickBytes = 64 * 64 * 4 * 2;
  const PartPlace four_bricks = {plan_.id, 0, 1, 0, 4};
  EXPECT_EQ(planes_read(volume_, plan_, four_bricks, 4 * kBrickBytes), 4);
  EXPECT_EQ(planes_read(volume_, plan_, four_bricks, 2 * kBrickBytes), 4 + 2 * 4);
}

TEST_F(BandParts, PlanesAreReadOnceMoreForTrainingWhereTheFirstPlaneTellsOtherBricks) {
  SmallVolume masked = volume_;
  masked.description.size = {512, 512, 8};
  masked.voxels = small_volume("masked", VoxelType::int16, masked.description.size).voxels;
  const auto plane = static_cast<std::ptrdiff_t>(plane_bytes(masked.description));
  const auto clear = [&](std::ptrdiff_t z) {
    std::fill_n(masked.voxels.begin() + z * plane, plane / 4, std::byte{0});
  };
  for (std::ptrdiff_t z = 0; z < 8; ++z) clear(z);
  BuildPlan plan = shared(masked, 2);
  EXPECT_EQ(planes_read(masked, plan, place_of(plan, 1)), 4) << "the plan has the model";
  EXPECT_EQ(planes_read(masked, plan, place_of(plan, 2)), 4) << "bricks of zeros are not chosen";
  masked.voxels = small_volume("masked", VoxelType::int16, masked.description.size).voxels;
  clear(4);
  plan = shared(masked, 2);
  EXPECT_EQ(planes_read(masked, plan, place_of(plan, 2)), 4 + 4);
}

TEST_F(BandParts, APlanReadsThePlanesOfItsGroupOnce) {
  CountedPlanes planes(volume_.open());
  NoProgress progress;
  const BuildPlan plan = plan_build(planes, volume_.options, progress);
  EXPECT_EQ(planes.count, 4);
  EXPECT_EQ(plan.first_model, plan_.first_model);
  EXPECT_EQ(plan.content_hash, plan_.content_hash);
  CountedPlanes from_start(volume_.open());
  from_start.is_sought = false;
  EXPECT_EQ(plan_build(from_start, volume_.options, progress).first_model, plan_.first_model);
  SmallVolume limited = volume_;
  limited.options.band_bytes = 1;
  CountedPlanes bands(limited.open());
  EXPECT_EQ(plan_build(bands, limited.options, progress).first_model, plan_.first_model);
  EXPECT_EQ(bands.count, 4);
}

}  // namespace
}  // namespace octavo::testing
