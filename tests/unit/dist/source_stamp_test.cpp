#include "octavo/dist/source_stamp.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using testing::ScratchFolder;

void write(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string failure_of(const std::vector<SourceStamp>& stamps, ErrorKind kind) {
  try {
    NoProgress progress;
    UnchangedFiles(stamps, progress).require_still();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  return "";
}

TEST(SourceStamp, AChangeIsSeenByItsLengthAndByItsTime) {
  const ScratchFolder folder;
  const std::string a = folder.file("a");
  const std::string b = folder.file("b");
  write(a, "12345");
  write(b, "678");
  const auto stamps = stamps_of({a, b});
  ASSERT_EQ(stamps.size(), 2u);
  EXPECT_EQ(stamps[0].bytes, 5);
  EXPECT_EQ(failure_of(stamps, ErrorKind::internal), "");
  // Of the same length
  const auto time = std::filesystem::last_write_time(b);
  write(b, "679");
  std::filesystem::last_write_time(b, time + std::chrono::nanoseconds(1));
  const std::string changed = failure_of(stamps, ErrorKind::source_rejected);
  EXPECT_NE(changed.find(b), std::string::npos) << changed;
  EXPECT_NE(changed.find("3 bytes of 2"), std::string::npos) << changed;
  // Of the same time
  write(b, "6789");
  std::filesystem::last_write_time(b, time);
  EXPECT_NE(failure_of(stamps, ErrorKind::source_rejected).find("4 bytes of"), std::string::npos);
  write(b, "678");
  std::filesystem::last_write_time(b, time);
  EXPECT_EQ(failure_of(stamps, ErrorKind::internal), "");
  std::filesystem::remove(a);
  EXPECT_NE(failure_of(stamps, ErrorKind::io).find(a), std::string::npos);
  EXPECT_THROW(stamps_of({a}), Error);
}

TEST(SourceStamp, AChangeOfContentIsSeenWhateverTheTimesAre) {
  const ScratchFolder folder;
  const std::string a = folder.file("a");
  const std::string bytes((std::size_t{1} << 20) + 7, 'a');  // more than is read at once
  write(a, bytes);
  NoProgress progress;
  const auto stamps = stamps_of({a}, FileCheck::content, progress);
  EXPECT_EQ(stamps[0].written_ns, 0);
  const auto time = std::filesystem::last_write_time(a);
  std::filesystem::last_write_time(a, time - std::chrono::hours(5));
  EXPECT_EQ(failure_of(stamps, ErrorKind::internal), "") << "a copy that lost its time";
  for (const std::size_t changed : {std::size_t{0}, bytes.size() - 1}) {
    std::string other = bytes;
    other[changed] = 'b';
    write(a, other);
    std::filesystem::last_write_time(a, time);
    const std::string failure = failure_of(stamps, ErrorKind::source_rejected);
    EXPECT_NE(failure.find("of another checksum"), std::string::npos) << failure;
  }
  write(a, bytes + "b");
  const std::string longer = failure_of(stamps, ErrorKind::source_rejected);
  EXPECT_NE(longer.find("1048584 now"), std::string::npos) << longer;
  // Whoever reads on looks at the times alone.
  write(a, bytes);
  const UnchangedFiles files(stamps, progress);
  files.require_still();
  std::filesystem::last_write_time(a, time + std::chrono::hours(1));
  EXPECT_THROW(files.require_still(), Error);
}

}  // namespace
}  // namespace octavo
