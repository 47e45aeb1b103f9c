#include "octavo/tasks/files/repair.h"

#include "support/scan_files.h"

namespace octavo {
namespace {

class Repair : public testing::ScanFiles {
 protected:
  void SetUp() override {
    options_.input = write_grey("scan.8vo");
    options_.output.path = folder_.file("repaired.8vo");
  }

  Failure failure() {
    return failure_of([&] { repair(options_, context_); });
  }

  RepairOptions options_;
};

TEST_F(Repair, AFlippedBitIsTurnedBack) {
  const std::string sound = testing::bytes_of_file(options_.input);
  damage(options_.input, brick_offset(options_.input), 4);
  const RepairResult result = repair(options_, context_);
  ASSERT_TRUE(std::holds_alternative<BitRepairResult>(result));
  EXPECT_EQ(std::get<BitRepairResult>(result).flips.size(), 1u);
  EXPECT_EQ(testing::bytes_of_file(options_.output.path), sound);
}

TEST_F(Repair, OtherDamageNamesWhatHelps) {
  damage(options_.input, brick_offset(options_.input), 0x55);
  EXPECT_EQ(failure().field, "repair.salvage");
  std::filesystem::resize_file(options_.input, std::filesystem::file_size(options_.input) - 100);
  EXPECT_EQ(failure().field, "repair.input");
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
}

TEST_F(Repair, ASoundFileNeedsNone) {
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument);
}

TEST_F(Repair, NamesThatCannotBeUsedAreRejected) {
  options_.output.path = folder_.file("repaired.nii");
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument);
  options_.output = {options_.input, true};
  EXPECT_EQ(failure().kind, ErrorKind::invalid_argument);
  options_ = {folder_.file("nothing.8vo"), {folder_.file("repaired.8vo")}};
  EXPECT_EQ(failure().kind, ErrorKind::io);
}

}  // namespace
}  // namespace octavo
