#include "octavo/io/http/answer_head.h"

#include <gtest/gtest.h>

#include <limits>

namespace octavo {
namespace {

AnswerHead head_of(std::initializer_list<const char*> lines) {
  AnswerHead head;
  for (const char* line : lines) head.take(line);
  return head;
}

TEST(AnswerHead, TheLastHeadCounts) {
  const AnswerHead head = head_of({"HTTP/1.1 100 Continue\r\n", "ETag: \"old\"\r\n", "\r\n",
                                   "HTTP/2 206\r\n", "eTaG:  \"new\"  \r\n", "nonsense\r\n"});
  EXPECT_EQ(head.status, 206);
  EXPECT_EQ(head.validator(), "\"new\"");
}

TEST(AnswerHead, LastModifiedStandsInForAnETag) {
  EXPECT_EQ(head_of({"Last-Modified: today"}).validator(), "today");
  EXPECT_EQ(head_of({"Last-Modified: today", "ETag: x"}).validator(), "x");
  EXPECT_EQ(head_of({"HTTP/1.1 206"}).validator(), "");
}

TEST(AnswerHead, OnlyWhatNamesAnotherPlaceIsARedirect) {
  for (const char* status : {"HTTP/1.1 300 x", "HTTP/1.1 301 x", "HTTP/1.1 302 x",
                             "HTTP/1.1 303 x", "HTTP/1.1 307 x", "HTTP/1.1 308 x"}) {
    EXPECT_TRUE(head_of({status, "Location: /x"}).is_redirect()) << status;
    EXPECT_FALSE(head_of({status}).is_redirect()) << status;
  }
  EXPECT_FALSE(head_of({"HTTP/1.1 304 x", "Location: /x"}).is_redirect());
}

TEST(AnswerHead, PausesAreSecondsOrDates) {
  const auto pause = [](const std::string& value) {
    AnswerHead head;
    head.take("Retry-After: " + value);
    return head.pause_seconds(784'111'777);
  };
  EXPECT_EQ(pause("120"), 120);
  EXPECT_EQ(pause("0"), 0);
  EXPECT_EQ(pause("Sun, 06 Nov 1994 08:49:47 GMT"), 10);
  EXPECT_EQ(pause("Sun, 06 Nov 1994 08:49:07 GMT"), 0);
  EXPECT_EQ(pause("99999999999999999999999"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(pause("soon"), std::nullopt);
  EXPECT_EQ(pause("-5"), std::nullopt);
  EXPECT_EQ(pause(""), std::nullopt);
}

std::string problem(const AnswerHead& head) { return offered_range(head, 100, 50).problem; }

TEST(AnswerHead, ARangeMayBeShorterThanAskedForButBeginsThere) {
  for (const char* range :
       {"Content-Range: bytes 100-149/1000", "Content-Range: bytes 100-100/1000",
        "Content-Range: bytes 100-119/120"}) {
    EXPECT_EQ(problem(head_of({range})), "") << range;
  }
  const RangeOffer offer =
      offered_range(head_of({"Content-Range: bytes 100-119/1000"}), 100, 50);
  EXPECT_EQ(offer.range.length(), 20u);
  EXPECT_EQ(offer.range.total, 1000u);
}

TEST(AnswerHead, WhatDoesNotFitIsNamed) {
  const char* const kRight = "Content-Range: bytes 100-149/1000";
  const std::pair<AnswerHead, const char*> table[] = {
      {head_of({"Content-Range: bytes 99-149/1000"}), "sent bytes 99-149, asked were 100-149"},
      {head_of({"Content-Range: bytes 100-150/1000"}), "sent bytes 100-150"},
      {head_of({"Content-Range: bytes 0-9/10"}), "sent bytes 0-9"},
      {head_of({kRight, kRight}), "Content-Range is 'bytes 100-149/1000, bytes 100-149/1000'"},
      {head_of({"Content-Range: bytes 100-149/*"}), "Content-Range is"},
      {head_of({"Content-Range: bytes 100-149/149"}), "Content-Range is"},
      {head_of({"Content-Range: bytes 149-100/1000"}), "Content-Range is"},
      {head_of({"Content-Range: bytes 100-99999999999999999999/1000"}), "Content-Range is"},
      {head_of({kRight, "Content-Encoding: br"}), "encodes the file as br"},
      {head_of({kRight, "Content-Length: 51"}), "more bytes than were asked for"},
      {head_of({kRight, "Content-Length: 49"}), "has 49 bytes, announced were 50"},
      {head_of({"Content-Type: Multipart/byteranges"}), "multipart"},
  };
  for (const auto& [head, words] : table) {
    EXPECT_NE(problem(head).find(words), std::string::npos) << problem(head) << "\n" << words;
  }
}

}  // namespace
}  // namespace octavo
