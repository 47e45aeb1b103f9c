#include "octavo/io/dicom/run_length_frame.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace octavo::testing {
namespace {

using namespace std::string_literals;

constexpr std::size_t kFramePixels = 8;
/// Eight bytes each: a run and two bytes; two runs.
const std::string kFirst = "\xfb\x07\x01\x01\x02"s;
const std::string kSecond = "\xfd\x09\xfd\x0a"s;

/// A frame whose header names the segments where they stand.
std::string frame_of(const std::vector<std::string>& segments) {
  std::vector<std::uint32_t> header(16, 0);
  header[0] = static_cast<std::uint32_t>(segments.size());
  std::string all;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    header[1 + i] = static_cast<std::uint32_t>(64 + all.size());
    all += segments[i];
  }
  std::string bytes(64, '\0');
  for (std::size_t i = 0; i < 64; ++i) bytes[i] = static_cast<char>(header[i / 4] >> 8 * (i % 4));
  return bytes + all;
}

std::string damage_of(const std::string& frame, std::size_t segments = 2) {
  return run_length_damage(std::as_bytes(std::span(frame)), segments, kFramePixels);
}

void expect_damage(const std::string& frame, const char* words) {
  EXPECT_NE(damage_of(frame).find(words), std::string::npos) << damage_of(frame);
}

TEST(RunLengthFrame, WholeSegmentsMayBeFilledUp) {
  EXPECT_EQ(damage_of(frame_of({kFirst, kSecond})), "");
  EXPECT_EQ(damage_of(frame_of({kSecond}), 1), "");
  EXPECT_EQ(damage_of(frame_of({"\x80"s + kFirst, kSecond})), "");  // a code of no byte
  for (const std::string& filling : {"\0"s, "\x05"s, "\0\0\0"s, "\x80\0"s}) {
    EXPECT_EQ(damage_of(frame_of({kFirst + filling, kSecond + filling})), "");
  }
}

TEST(RunLengthFrame, EveryCutIsFound) {
  const std::string whole = frame_of({kFirst, kSecond});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(damage_of(whole.substr(0, size)), "") << size;
  }
}

TEST(RunLengthFrame, SegmentsOfTooFewOrTooManyBytesAreNamed) {
  expect_damage(frame_of({"\xfb\x07"s, kSecond}), "segment 1 of 2 makes 6 of 8 bytes");
  expect_damage(frame_of({kFirst, "\xfd\x09\xfe\x0a"s}), "segment 2 of 2 makes 7 of 8 bytes");
  expect_damage(frame_of({kFirst, "\xfd\x09\xfc\x0a"s}), "segment 2 of 2 makes more than 8 bytes");
  expect_damage(frame_of({kFirst + "\xfd\x09"s, kSecond}), "segment 1 of 2 makes more than 8");
  expect_damage(frame_of({kFirst, "\xfd\x09\x03\x0a"s}), "makes 4 of 8 bytes before its last run");
  expect_damage(frame_of({kFirst, ""}), "segment 2 of 2 makes 0 of 8 bytes");
}

TEST(RunLengthFrame, HeadersThatDoNotFitAreNamed) {
  expect_damage("abc", "it has 3 bytes, and its header alone 64");
  expect_damage(frame_of({kFirst}), "it has 1 segments, and the bytes of its values are 2");
  expect_damage("\x10"s + std::string(63, '\0'), "it names 16 segments, and 15 is the most");
  const std::string whole = frame_of({kFirst, kSecond});
  for (const std::size_t at : {4U, 8U}) {
    for (const char start : {'\0', '\x3f', '\x7f'}) {
      std::string moved = whole;
      moved[at] = start;
      EXPECT_NE(damage_of(moved), "") << at << " " << int{start};
    }
  }
  std::string backwards = whole;
  std::swap(backwards[4], backwards[8]);
  expect_damage(backwards, "segment 1 of 2 starts at byte 69 of 73, out of its place");
}

}  // namespace
}  // namespace octavo::testing
