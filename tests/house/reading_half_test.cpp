// Linked with octavo::read alone: that this program builds is half of the test.
#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo {
namespace {

TEST(ReadingHalf, RejectsWhatIsNoOctavoFile) {
  const std::vector<std::uint8_t> zeros(4096, 0);
  try {
    FileReader::open(byte_source_of(zeros, "zeros"));
    FAIL() << "a file of zeros was opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::not_octavo) << error.what();
  }
}

}  // namespace
}  // namespace octavo
