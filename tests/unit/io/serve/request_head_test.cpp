#include "octavo/io/serve/request_head.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace octavo {
namespace {

ParsedHead parsed(const std::string& lines) { return parse_request_head(lines + "\r\n"); }

TEST(RequestHead, HasWhatTheServerAsksFor) {
  const ParsedHead p = parsed(
      "GET /a%20b.8vo?x=1&y HTTP/1.1\r\nhOsT:  127.0.0.1:80 \r\nRange: bytes=0-5\r\n"
      "If-Range: \"a\"\r\nIf-Match: \"b\"\r\nIf-None-Match: \"c\"\r\nOrigin: http://x\r\n"
      "Accept: */*\r\nContent-Length: 0\r\n");
  ASSERT_EQ(p.status, 0);
  EXPECT_EQ(p.head.method, "GET");
  EXPECT_EQ(p.head.path, "/a b.8vo");
  EXPECT_EQ(p.head.query, "x=1&y");
  EXPECT_EQ(p.head.host, "127.0.0.1:80");
  EXPECT_EQ(p.head.range, "bytes=0-5");
  EXPECT_EQ(p.head.if_range, "\"a\"");
  EXPECT_EQ(p.head.if_match, "\"b\"");
  EXPECT_EQ(p.head.if_none_match, "\"c\"");
  EXPECT_EQ(p.head.origin, "http://x");
  EXPECT_TRUE(p.head.keeps_alive);
}

TEST(RequestHead, SaysWhetherTheConnectionStays) {
  EXPECT_FALSE(parsed("GET / HTTP/1.0\r\n").head.keeps_alive);
  EXPECT_FALSE(parsed("GET / HTTP/1.1\r\nConnection: Close\r\n").head.keeps_alive);
}

TEST(RequestHead, TakesTheHostOfAnAbsoluteTarget) {
  const ParsedHead p = parsed("GET HTTP://127.0.0.1:80/a%20b?x HTTP/1.1\r\nHost: other\r\n");
  ASSERT_EQ(p.status, 0);
  EXPECT_EQ(p.head.path, "/a b");
  EXPECT_EQ(p.head.query, "x");
  EXPECT_EQ(p.head.host, "127.0.0.1:80");
  EXPECT_EQ(parsed("GET http://localhost HTTP/1.1\r\n").head.path, "/");
  EXPECT_EQ(parsed("GET http://localhost?x HTTP/1.1\r\n").head.query, "x");
}

TEST(RequestHead, IgnoresAnEmptyLineBefore) {
  const ParsedHead p = parsed("\r\nGET /a HTTP/1.1\r\nHost: b\r\n");
  ASSERT_EQ(p.status, 0);
  EXPECT_EQ(p.head.path, "/a");
  EXPECT_EQ(p.head.host, "b");
}

TEST(RequestHead, RejectsWhatCouldBeReadInTwoWays) {
  const struct {
    int status;
    std::string lines;
  } rows[] = {
      {400, ""},
      {400, "GET\r\n"},
      {400, "GET / HTTP/1.1 x\r\n"},
      {400, "G T / HTTP/1.1\r\n"},
      {400, "GET /\tx HTTX/1.1\r\n"},
      {505, "GET / HTTP/2.0\r\n"},
      {505, "GET / HTTP/1.10\r\n"},
      {400, "\r\n\r\nGET / HTTP/1.1\r\n"},
      {400, "GET http:///a HTTP/1.1\r\n"},
      {400, "GET http://name@127.0.0.1/ HTTP/1.1\r\n"},
      {404, "GET https://127.0.0.1/ HTTP/1.1\r\n"},
      {404, "GET http:/a HTTP/1.1\r\n"},
      {400, "GET http://a/ HTTP/1.1\r\nHost: a\r\nHost: a\r\n"},
      {404, "GET * HTTP/1.1\r\n"},
      {404, "GET /%zz HTTP/1.1\r\n"},
      {404, "GET /%00 HTTP/1.1\r\n"},
      {404, "GET /a%2 HTTP/1.1\r\n"},
      {400, "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n"},
      {400, "GET / HTTP/1.1\r\nRange: bytes=0-1\r\nRange: bytes=0-2\r\n"},
      {400, "GET / HTTP/1.1\r\nno colon\r\n"},
      {400, "GET / HTTP/1.1\r\nName : x\r\n"},
      {400, "GET / HTTP/1.1\r\nA: x\r\n folded\r\n"},
      {400, "GET / HTTP/1.1\r\nA: \x01\r\n"},
      {400, std::string("GET /\0 HTTP/1.1\r\n", 18)},
      {400, "GET / HTTP/1.1\r\nContent-Length: 5\r\n"},
      {400, "GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n"},
  };
  for (const auto& row : rows) EXPECT_EQ(parsed(row.lines).status, row.status) << row.lines;
  EXPECT_EQ(parse_request_head("GET / HTTP/1.1\r\n").status, 400);
  EXPECT_EQ(parse_request_head("GET / HTTP/1.1\r\n\r\nmore").status, 400);
}

TEST(RequestHead, EndsBehindItsEmptyLine) {
  EXPECT_EQ(end_of_head("GET / HTTP/1.1\r\n\r\nGET"), 18u);
  EXPECT_EQ(end_of_head("GET / HTTP/1.1\r\n\r"), std::nullopt);
}

TEST(RequestHead, TakesAnyBytes) {
  // Mutants of a good head: each gets a status or a path that begins with "/".
  const std::string good =
      "GET /a.8vo?q HTTP/1.1\r\nHost: localhost\r\nRange: bytes=1-2\r\nOrigin: x\r\n\r\n";
  std::mt19937 random(7);
  int rejected = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 4; ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0: text[at] = static_cast<char>(random()); break;
        case 1: text.erase(at, 1 + random() % 5); break;
        default: text.insert(at, 1, static_cast<char>(random())); break;
      }
      if (text.empty()) text = "x";
    }
    const ParsedHead p = parse_request_head(text);
    if (p.status == 0) {
      ASSERT_TRUE(p.head.path.starts_with('/')) << text;
    } else {
      ++rejected;
    }
  }
  EXPECT_GT(rejected, 2000);
}

TEST(PercentText, ComesBack) {
  std::string all;
  for (int c = 1; c < 256; ++c) all.push_back(static_cast<char>(c));
  EXPECT_EQ(percent_decoded(percent_encoded(all)), all);
  EXPECT_EQ(percent_encoded("a b/ü"), "a%20b%2F%C3%BC");
  EXPECT_EQ(percent_encoded("head-1_x.8vo~"), "head-1_x.8vo~");
}

}  // namespace
}  // namespace octavo
