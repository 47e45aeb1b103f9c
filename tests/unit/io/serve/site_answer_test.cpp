#include "octavo/io/serve/site_answer.h"

#include <gtest/gtest.h>

#include <string>

namespace octavo {
namespace {

constexpr std::uint64_t kSize = 1000;

SiteTable site() {
  SiteTable table;
  std::vector<std::uint8_t> bytes(kSize);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
  table["/a.8vo"] = memory_content(bytes, media_type_of("a.8vo"));
  table["/index.html"] = memory_content({'<', 'p', '>'}, media_type_of("index.html"));
  return table;
}

SiteRules local_rules() {
  SiteRules rules;
  rules.hosts = {"127.0.0.1:8080", "localhost:8080", "[::1]:8080"};
  return rules;
}

RequestHead asking(const std::string& path) {
  RequestHead head;
  head.method = "GET";
  head.path = path;
  head.host = "localhost:8080";
  return head;
}

bool has(const SiteAnswer& answer, const std::string& text) {
  return answer.head.find(text) != std::string::npos;
}

std::string tag_of_file() { return site()["/a.8vo"]->now()->entity_tag(); }

SiteAnswer answer_to(const RequestHead& head, const SiteRules& rules = local_rules()) {
  SiteTable table = site();
  return site_answer(head, rules, table);
}

TEST(ServedRange, IsOneRunOfBytesThatAreThere) {
  const struct {
    const char* field;
    RangeState state;
    ServedRange range;
  } rows[] = {
      {"bytes=0-0", RangeState::some, {0, 1}},
      {"bytes=10-19", RangeState::some, {10, 10}},
      {"bytes=990-", RangeState::some, {990, 10}},
      {"bytes=990-5000", RangeState::some, {990, 10}},
      {"bytes=990-99999999999999999999999999", RangeState::some, {990, 10}},
      {"bytes=-10", RangeState::some, {990, 10}},
      {"bytes=-5000", RangeState::some, {0, 1000}},
      {"bytes=1000-", RangeState::wrong, {}},
      {"bytes=99999999999999999999999999-", RangeState::wrong, {}},
      {"bytes=20-10", RangeState::none, {}},
      {"bytes=-0", RangeState::wrong, {}},
      {"bytes=-", RangeState::none, {}},
      {"bytes=", RangeState::none, {}},
      {"bytes=0-1,5-6", RangeState::none, {}},
      {"bytes=0x1-2", RangeState::none, {}},
      {"bytes=+1-2", RangeState::none, {}},
      {"bytes=1 - 2", RangeState::none, {}},
      {"bytes 1-2", RangeState::none, {}},
      {"Bytes=10-19", RangeState::some, {10, 10}},
      {"BYTES=-10", RangeState::some, {990, 10}},
      {"BYTES 1-2", RangeState::none, {}},
      {"byte", RangeState::none, {}},
      {"lines=1-2", RangeState::none, {}},
      {"bytes=5000-6000,0-9", RangeState::none, {}},
      {"bytes=1-2-3", RangeState::none, {}},
      {"bytes=5000-4000", RangeState::none, {}},
      {"bytes=1000-1000", RangeState::wrong, {}},
  };
  for (const auto& row : rows) {
    ServedRange range;
    EXPECT_EQ(parse_asked_range(row.field, kSize, range), row.state) << row.field;
    EXPECT_EQ(range, row.range) << row.field;
  }
  ServedRange range;
  EXPECT_EQ(parse_asked_range("bytes=0-", 0, range), RangeState::wrong);
}

TEST(SiteAnswer, GivesAllOfAFileOrARange) {
  RequestHead head = asking("/a.8vo");
  SiteAnswer whole = answer_to(head);
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.length, kSize);
  EXPECT_TRUE(has(whole, "Content-Length: 1000\r\n"));
  EXPECT_TRUE(has(whole, "Accept-Ranges: bytes\r\n"));
  EXPECT_TRUE(has(whole, "ETag: " + tag_of_file()));
  head.range = "bytes=100-199";
  SiteAnswer part = answer_to(head);
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.first, 100u);
  EXPECT_EQ(part.length, 100u);
  EXPECT_TRUE(has(part, "Content-Range: bytes 100-199/1000\r\n"));
  head.method = "HEAD";
  SiteAnswer none = answer_to(head);
  EXPECT_EQ(none.status, 206);
  EXPECT_EQ(none.length, 0u);
  EXPECT_EQ(none.bytes, nullptr);
  EXPECT_TRUE(has(none, "Content-Length: 100\r\n"));
  head.range = "bytes=1000-";
  EXPECT_EQ(answer_to(head).status, 416);
  EXPECT_TRUE(has(answer_to(head), "Content-Range: bytes */1000\r\n"));
  for (const char* ignored : {"bytes=0-9,20-29", "bytes=5-2"}) {
    head.range = ignored;
    EXPECT_EQ(answer_to(head).status, 200) << ignored;
    EXPECT_TRUE(has(answer_to(head), "Content-Length: 1000\r\n")) << ignored;
    EXPECT_FALSE(has(answer_to(head), "Content-Range")) << ignored;
  }
}

TEST(SiteAnswer, SaysOnceHowLongAnAnswerMayBeKept) {
  const auto count_of = [](const SiteAnswer& answer) {
    std::size_t count = 0;
    const std::string field = "Cache-Control:";
    for (std::size_t at = 0; (at = answer.head.find(field, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  RequestHead head = asking("/a.8vo");
  EXPECT_EQ(count_of(answer_to(head)), 1u);
  head.range = "bytes=1000-";
  EXPECT_EQ(count_of(answer_to(head)), 1u);
  EXPECT_TRUE(has(answer_to(head), "Cache-Control: no-store\r\n"));
  head.if_match = "\"x\"";
  EXPECT_EQ(answer_to(head).status, 412);
  EXPECT_EQ(count_of(answer_to(head)), 1u);
  head.if_match.reset();
  head.if_none_match = tag_of_file();
  EXPECT_EQ(answer_to(head).status, 304);
  EXPECT_EQ(count_of(answer_to(head)), 1u);
}

TEST(SiteAnswer, KnowsWhichBytesAClientHas) {
  RequestHead head = asking("/a.8vo");
  head.if_none_match = "\"x\", W/" + tag_of_file();
  EXPECT_EQ(answer_to(head).status, 304);
  head.if_none_match = "\"x\"";
  EXPECT_EQ(answer_to(head).status, 200);
  head.if_none_match.reset();
  head.if_match = "\"x\"";
  EXPECT_EQ(answer_to(head).status, 412);
  head.if_match = tag_of_file();
  EXPECT_EQ(answer_to(head).status, 200);
  head.if_match.reset();
  head.range = "bytes=0-9";
  head.if_range = tag_of_file();
  EXPECT_EQ(answer_to(head).status, 206);
  head.if_range = "\"x\"";
  EXPECT_EQ(answer_to(head).status, 200);
  EXPECT_EQ(answer_to(head).length, kSize);
}

TEST(SiteAnswer, NeverMakesAPathOfAnAddress) {
  for (const char* path : {"/", "/index.html"}) EXPECT_EQ(answer_to(asking(path)).status, 200);
  for (const char* path : {"/../a.8vo", "/./a.8vo", "//a.8vo", "/a.8vo/", "/A.8vo", "/etc/passwd",
                           "/..\\a.8vo", "/a.8vo\n", "/\xc0\xae\xc0\xae/a.8vo", ""}) {
    EXPECT_EQ(answer_to(asking(path)).status, 404) << path;
  }
}

TEST(SiteAnswer, ListensToItsOwnNamesAlone) {
  for (const char* host : {"127.0.0.1:8080", "localhost:8080", "[::1]:8080"}) {
    RequestHead head = asking("/a.8vo");
    head.host = host;
    EXPECT_EQ(answer_to(head).status, 200) << host;
  }
  for (const char* host : {"", "evil.example", "localhost", "localhost:80", "localhost.:8080",
                           "127.0.0.1:8080.evil.example", "LOCALHOST:8080@x", "[::1]"}) {
    RequestHead head = asking("/a.8vo");
    head.host = host;
    EXPECT_EQ(answer_to(head).status, 403) << host;
  }
}

TEST(SiteAnswer, LetsPagesOfOtherSitesReadWhereThatIsAllowed) {
  RequestHead head = asking("/a.8vo");
  head.origin = "http://localhost:8080";
  EXPECT_EQ(answer_to(head).status, 200);
  head.origin = "https://viewer.example";
  EXPECT_EQ(answer_to(head).status, 403);
  EXPECT_FALSE(has(answer_to(head), "Access-Control"));
  EXPECT_TRUE(has(answer_to(asking("/a.8vo")), "Cross-Origin-Resource-Policy: same-origin"));
  SiteRules rules = local_rules();
  rules.allowed_origins = {"https://viewer.example"};
  EXPECT_EQ(answer_to(head, rules).status, 200);
  EXPECT_TRUE(
      has(answer_to(head, rules), "Access-Control-Allow-Origin: https://viewer.example\r\n"));
  EXPECT_TRUE(has(answer_to(head, rules), "Vary: Origin\r\n"));
  head.origin = "https://other.example";
  EXPECT_EQ(answer_to(head, rules).status, 403);
  rules.allowed_origins = {"*"};
  EXPECT_EQ(answer_to(head, rules).status, 200);
  head.method = "OPTIONS";
  EXPECT_EQ(answer_to(head, rules).status, 204);
  EXPECT_TRUE(has(answer_to(head, rules), "Access-Control-Allow-Headers: Range"));
  EXPECT_EQ(answer_to(head).status, 403);
}

TEST(SiteAnswer, OnlyGivesOut) {
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get"}) {
    RequestHead head = asking("/a.8vo");
    head.method = method;
    EXPECT_EQ(answer_to(head).status, 405) << method;
    EXPECT_TRUE(has(answer_to(head), "Allow: GET, HEAD\r\n")) << method;
  }
}

TEST(SiteAnswer, TellsBrowsersToBeStrict) {
  const SiteAnswer page = answer_to(asking("/index.html"));
  EXPECT_TRUE(has(page, "Content-Security-Policy: default-src 'none'"));
  EXPECT_TRUE(has(page, "frame-ancestors 'none'"));
  for (const char* path : {"/index.html", "/a.8vo", "/none"}) {
    EXPECT_TRUE(has(answer_to(asking(path)), "X-Content-Type-Options: nosniff\r\n")) << path;
  }
  EXPECT_TRUE(has(answer_to(asking("/a.8vo")), "Content-Type: application/vnd.octavo\r\n"));
}

}  // namespace
}  // namespace octavo
