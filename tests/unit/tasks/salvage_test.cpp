#include "octavo/tasks/salvage.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class Salvage : public testing::ScanFiles {
 protected:
  void SetUp() override {
    path_ = write_grey("scan.8vo");
    damage(path_, brick_offset(path_), 0x55);
    reader_ = testing::open_file(path_);
  }

  std::vector<std::int16_t> filled(const SalvageFilling& filling) {
    const auto salvage = salvaging(reader_, filling, context_);
    std::vector<std::int16_t> out(voxels_.size());
    read_salvaging(filling, context_,
                   [&] { salvage->read(box_of(kScanSize), 0, out.data()); });
    warn_of_salvaged(*salvage, context_);
    EXPECT_EQ(salvage_report(*salvage)->brick_count, 1);
    return out;
  }

  std::string path_;
  std::shared_ptr<const FileReader> reader_;
};

TEST_F(Salvage, FillsWithTheValueThatIsAskedFor) {
  const std::vector<std::int16_t> out = filled({.real_value = 11.0});
  EXPECT_EQ(std::count(out.begin(), out.end(), 11), static_cast<std::ptrdiff_t>(out.size()));
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("with 11 HU"), std::string::npos) << warnings_[0];
}

TEST_F(Salvage, FillsWithTheLowestValueUnlessAsked) {
  const std::vector<std::int16_t> out = filled({});
  const std::int16_t lowest = *std::min_element(voxels_.begin(), voxels_.end());
  EXPECT_EQ(std::count(out.begin(), out.end(), lowest), static_cast<std::ptrdiff_t>(out.size()));
}

TEST_F(Salvage, DamageNamesTheOptionThatHelps) {
  std::vector<std::int16_t> out(voxels_.size());
  const auto read = [&] { reader_->read(box_of(kScanSize), 0, out.data()); };
  const auto field_of = [&](const std::optional<SalvageFilling>& filling) {
    return failure_of([&] { read_salvaging(filling, context_, read); }).field;
  };
  EXPECT_EQ(field_of(std::nullopt), "salvage");
  context_.is_strict = true;
  EXPECT_EQ(field_of(SalvageFilling{}), "is_strict");
  EXPECT_EQ(salvaging(reader_, SalvageFilling{}, context_), reader_);
}

TEST_F(Salvage, AValueThatNoVoxelHoldsIsRejected) {
  const SalvageFilling filling{.real_value = 1e6};
  EXPECT_EQ(failure_of([&] { salvaging(reader_, filling, context_); }).kind,
            ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo
