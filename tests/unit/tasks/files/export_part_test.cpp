#include "octavo/tasks/files/export_part.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class ExportPart : public testing::ScanFiles {
 protected:
  void SetUp() override {
    options_.input = write_grey("scan.8vo");
    options_.output.path = folder_.file("part.raw");
  }

  std::vector<std::int16_t> exported() const {
    const std::string bytes = testing::bytes_of_file(options_.output.path);
    std::vector<std::int16_t> voxels(bytes.size() / 2);
    std::memcpy(voxels.data(), bytes.data(), voxels.size() * 2);
    return voxels;
  }

  ExportPartOptions options_;
};

TEST_F(ExportPart, TheWholeVolume) {
  const ExportPartResult result = export_part(options_, context_);
  EXPECT_EQ(result.written.files, std::vector{options_.output.path});
  EXPECT_EQ(result.box, box_of(kScanSize));
  EXPECT_EQ(exported(), voxels_);
  EXPECT_FALSE(result.salvaged);
}

TEST_F(ExportPart, ABoxInVoxelsOrInMm) {
  options_.box = AskedBox{{3, 2, 1}, {5, 3, 2}};
  EXPECT_EQ(export_part(options_, context_).box, (Box{{3, 2, 1}, {5, 3, 2}}));
  const auto at = static_cast<std::size_t>((33 + 2) * 40 + 3);
  EXPECT_EQ(exported(), (std::vector{voxels_[at], voxels_[at + 1]}));
  options_.box.reset();
  options_.box_mm = BoxMm{{-8.5, 21, 7}, {-8, 21, 7}};
  options_.output.overwrite = true;
  EXPECT_EQ(export_part(options_, context_).box, (Box{{3, 2, 1}, {5, 3, 2}}));
}

TEST_F(ExportPart, DamageIsFilledOnlyWhenAsked) {
  damage(options_.input, brick_offset(options_.input), 0x55);
  EXPECT_EQ(failure_of([&] { export_part(options_, context_); }).field, "salvage");
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
  options_.salvage = SalvageFilling{.real_value = 4.0};
  const ExportPartResult result = export_part(options_, context_);
  ASSERT_TRUE(result.salvaged);
  EXPECT_EQ(result.salvaged->damage_count, 1);
  EXPECT_EQ(exported(), std::vector<std::int16_t>(voxels_.size(), 4));
  EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(ExportPart, WhatNobodyKnowsIsWarnedOfAndNotWrittenWhereStrict) {
  options_.input = write("labels.8vo", testing::DenseLabels({8, 8, 8}, 1), false);
  options_.output.path = folder_.file("part.mha");
  context_.is_strict = true;
  EXPECT_EQ(failure_of([&] { export_part(options_, context_); }).field, "is_strict");
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
  context_.is_strict = false;
  export_part(options_, context_);
  EXPECT_FALSE(warnings_.empty());
}

TEST_F(ExportPart, ARescaleThatMostProgramsLoseIsWarnedOf) {
  options_.input = write_grey("slope.8vo", {2.2, 0});
  for (const char* const name : {"part.nrrd", "part.mha", "part.mhd", "part.tif"}) {
    options_.output.path = folder_.file(name);
    warnings_.clear();
    export_part(options_, context_);
    ASSERT_EQ(warnings_.size(), 1u) << name;
    EXPECT_NE(warnings_[0].find("2.2 x stored"), std::string::npos) << warnings_[0];
  }
  warnings_.clear();
  options_.output.path = folder_.file("part.nii");
  export_part(options_, context_);
  options_.values = ExportValues::real;
  options_.output.path = folder_.file("real.nrrd");
  export_part(options_, context_);
  options_.values = ExportValues::stored;
  options_.output.path = folder_.file("stored.nrrd");
  export_part(options_, context_);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(ExportPart, LevelsThatAreNotThereAreRejected) {
  options_.level = 99;
  EXPECT_EQ(failure_of([&] { export_part(options_, context_); }).kind,
            ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo
