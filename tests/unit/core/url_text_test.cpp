#include "octavo/core/url_text.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

TEST(UrlText, OnlyHttpIsAUrl) {
  EXPECT_TRUE(is_url("http://x/y"));
  EXPECT_TRUE(is_url("HTTPS://x/y"));
  EXPECT_FALSE(is_url("file:///x"));
  EXPECT_FALSE(is_url("http:/x"));
  EXPECT_FALSE(is_url("scan.8vo"));
}

TEST(UrlText, APublicNameHasNoUserPasswordQueryOrFragment) {
  const char* const table[][2] = {
      {"https://host/x.8vo", "https://host/x.8vo"},
      {"https://user:secret@host/x.8vo?sig=secret#secret", "https://host/x.8vo"},
      {"HTTP://user@host:8000/a/b.8vo", "HTTP://host:8000/a/b.8vo"},
      {"https://user:se@cret@host/x.8vo", "https://host/x.8vo"},
      {"http://[::1]:80/x.8vo?secret", "http://[::1]:80/x.8vo"},
      {"http://u:secret@[::1]/x@1.8vo", "http://[::1]/x@1.8vo"},
      {"https://host?secret", "https://host"},
      {"https://host/a@b.8vo", "https://host/a@b.8vo"},
      {"https://host/x.8vo?mail=a@b:secret", "https://host/x.8vo"},
      {"scan?1.8vo", "scan?1.8vo"},
  };
  for (const auto& [name, expected] : table) EXPECT_EQ(public_name(name), expected);
}

TEST(UrlText, WhatMayBePartOfAPasswordIsHidden) {
  for (const char* name :
       {"https://user:se/cret@host/x.8vo", "https://user:se?cret@host/x.8vo",
        "https://user:se#cret@host/x.8vo", "https://user:1/secret@host/x.8vo",
        "https://us/er:secret@host/x.8vo", "https://user:secret", "https://[secret", "https://",
        "https://:secret@/x"}) {
    EXPECT_EQ(public_name(name), "https://...") << name;
  }
}

TEST(UrlText, TextKeepsAllButTheSecretsOfItsUrls) {
  EXPECT_EQ(without_secrets("https://u:p@host/x.8vo?sig=1: its spacing is not known; see http://b"),
            "https://host/x.8vo: its spacing is not known; see http://b");
  EXPECT_EQ(without_secrets("a@b?c \"http://u:p@h/x?q\"HTTP://u@h/y#f, http"),
            "a@b?c \"http://h/x\"HTTP://h/y, http");
}

TEST(UrlText, BlanksAndQuotesInANameHideNothingLess) {
  const char* const table[][2] = {
      {"no verb 'http://u:se cret@h/x'; see 'info'", "no verb 'http://h/x'; see 'info'"},
      {"'http://h/x?a= secret' is no place", "'http://h/x' is no place"},
      {"'http://u:it's \"secret\" <1>@h/x?'s': late", "'http://h/x': late"},
      {"('--at=1 http://u:se cret@h/x y') its 'z'", "('--at=1 http://h/x y') its 'z'"},
      {"the files' http://u:p@h/x?q 'z'", "the files' http://h/x 'z'"},
      {"'a' http://h/x?q is 'b c'", "'a' http://h/x is 'b c'"},
      {"'http://u:secret and so on", "'http://..."},
  };
  for (const auto& [text, expected] : table) EXPECT_EQ(without_secrets(text), expected);
}

TEST(UrlText, NoErrorHoldsASecret) {
  const Error error(ErrorKind::io, "differs from http://u:secret@b/y?secret", "http://a/x?secret");
  EXPECT_STREQ(error.what(), "http://a/x: differs from http://b/y");
  EXPECT_EQ(error.detail(), "differs from http://b/y");
  EXPECT_EQ(error.path(), "http://a/x");
  EXPECT_EQ(error.with_detail("is http://c?secret").path(), "http://a/x");
}

}  // namespace
}  // namespace octavo
