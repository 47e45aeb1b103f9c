#include "octavo/file/write/interrupted.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

FileHeader header() {
  FileHeader made;
  made.description.type = VoxelType::int16;
  made.description.size = {100, 50, 3};
  made.description.geometry.spacing_mm = {0.1, 0.1, 2.5};
  made.halvings = choose_halvings(made.description.size, {1, 1, 1});
  return made;
}

JournalHead head_of(const FileHeader& made) {
  return {settings_of(made), encode_header(made), made.description.metadata.text()};
}

/// What is said of a build that differs, or "alike".
std::string told(const JournalHead& stored, const JournalHead& now) {
  const auto difference = difference_of(stored, now);
  return difference ? difference->what() : "alike";
}

TEST(DifferenceOf, NamesTheSettingAndBothValues) {
  const struct {
    void (*change)(FileHeader&);
    const char* words;
  } cases[] = {
      {[](FileHeader& h) { h.description.kind = VolumeKind::labels; },
       "another kind: grey there, labels now"},
      {[](FileHeader& h) { h.description.type = VoxelType::uint16; },
       "another voxel type: int16 there, uint16 now"},
      {[](FileHeader& h) { h.description.size.y = 51; },
       "another size: 100 x 50 x 3 there, 100 x 51 x 3 now"},
      {[](FileHeader& h) { h.description.geometry.spacing_mm[0] = 1.0 / 3; },
       "another spacing: 0.1 0.1 2.5 there, 0.3333333333333333 0.1 2.5 now"},
      {[](FileHeader& h) { h.description.geometry.origin_mm[2] = -7; },
       "another origin: 0 0 0 there, 0 0 -7 now"},
      {[](FileHeader& h) { h.description.geometry.direction[0] = -1; },
       "another direction: 1 0 0 0 1 0 0 0 1 there, -1 0 0 0 1 0 0 0 1 now"},
      {[](FileHeader& h) { h.description.rescale.slope = 2; }, "another slope: 1 there, 2 now"},
      {[](FileHeader& h) { h.description.rescale.intercept = -1024; },
       "another intercept: 0 there, -1024 now"},
      {[](FileHeader& h) { h.max_error = 4; }, "another max error: 0 there, 4 now"},
      {[](FileHeader& h) { h.description.coding = SampleCoding{VoxelType::int32, 0.5, -1}; },
       "another list of settings"},
  };
  const FileHeader before = header();
  EXPECT_EQ(told(head_of(before), head_of(before)), "alike");
  for (const auto& c : cases) {
    FileHeader changed = before;
    c.change(changed);
    const auto difference = difference_of(head_of(before), head_of(changed));
    ASSERT_TRUE(difference) << c.words;
    EXPECT_EQ(difference->kind(), ErrorKind::invalid_argument);
    EXPECT_NE(difference->detail().find(c.words), std::string::npos) << difference->detail();
    EXPECT_NE(told(head_of(changed), head_of(before)), "alike");
  }
  FileHeader floats = before;
  floats.description.coding = SampleCoding{VoxelType::int16, 0.5, -1};
  FileHeader finer = floats;
  finer.description.coding->scale = 0.25;
  EXPECT_NE(told(head_of(floats), head_of(finer))
                .find("another float coding: int16 * 0.5 + -1 there, int16 * 0.25 + -1 now"),
            std::string::npos);
}

TEST(DifferenceOf, OfLongDescriptionsShowsWhereTheyPart) {
  JournalHead stored = head_of(header());
  stored.metadata = std::string(500, 'a') + "X" + std::string(500, 'b');
  JournalHead now = stored;
  now.metadata[500] = 'Y';
  const std::string text = told(stored, now);
  EXPECT_NE(text.find(std::string(24, 'a') + "X" + std::string(39, 'b') + "' there"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("aYb"), std::string::npos) << text;
  // One that ends where the other goes on.
  now.metadata = stored.metadata.substr(0, 10);
  EXPECT_NE(told(stored, now).find("'aaaaaaaaaa' now"), std::string::npos);
  now.metadata.clear();
  EXPECT_NE(told(stored, now).find("'' now"), std::string::npos);
}

TEST(DifferenceOf, AHeaderThatAloneDiffersMeansOtherVoxels) {
  const JournalHead stored = head_of(header());
  FileHeader other = header();
  other.build_id = 1;
  const auto difference = difference_of(stored, head_of(other));
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->kind(), ErrorKind::source_rejected);
}

TEST(DifferenceOf, LinesThatAreNoneAreShownAsTheyAre) {
  JournalHead stored = head_of(header());
  JournalHead now = stored;
  stored.settings = "no colon\nkind: grey\n";
  now.settings = "kind: grey\n";
  EXPECT_NE(told(stored, now).find("list of settings: no colon there, kind now"),
            std::string::npos);
  stored.settings = "";
  EXPECT_NE(told(stored, now).find("list of settings:  there, kind now"), std::string::npos);
}

TEST(Planes, AreNeverMoreThanThereAre) {
  const Levels levels({10, 10, 130}, choose_halvings({10, 10, 130}, {1, 1, 1}));
  EXPECT_EQ(planes_in(levels, 1), 64);
  EXPECT_EQ(planes_in(levels, 3), 130);
  EXPECT_EQ(planes_text(0, 64, 130), "planes 0 to 63 of 130");
}

}  // namespace
}  // namespace octavo
