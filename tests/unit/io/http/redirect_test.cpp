#include "octavo/io/http/redirect.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

TEST(Redirect, UserAndPasswordStayWithTheirServer) {
  const char* const table[][3] = {
      {"http://u:p@a/x/y.8vo?q=1", "z.8vo", "http://u:p@a/x/z.8vo"},
      {"http://u:p@a/x/y.8vo", "/z.8vo?q=2", "http://u:p@a/z.8vo?q=2"},
      {"http://u:p@a/y.8vo", "http://a:80/z.8vo", "http://u:p@a:80/z.8vo"},
      {"http://u:p@a/y.8vo", "http://a:81/z.8vo", "http://a:81/z.8vo"},
      {"http://u:p@a/y.8vo", "https://a/z.8vo", "https://a/z.8vo"},
      {"http://u:p@a/y.8vo", "http://b/z.8vo", "http://b/z.8vo"},
      {"http://u:p@a/y.8vo", "//b/z.8vo", "http://b/z.8vo"},
      {"http://u:p@a/y.8vo", "http://v:w@a/z.8vo", "http://v:w@a/z.8vo"},
      {"https://a/y.8vo", "https://b/z.8vo", "https://b/z.8vo"},
  };
  for (const auto& [from, location, expected] : table) {
    EXPECT_EQ(redirect_target(from, location), expected) << from << " to " << location;
  }
}

TEST(Redirect, SomeAreNotFollowed) {
  const char* const table[][3] = {
      {"https://a/y", "http://a/y", "from https to http"},
      {"https://a/y", "HTTP://a/y", "from https to http"},
      {"http://a/y", "file:///etc/passwd", "'file'"},
      {"http://a/y", "gopher://a/y", "'gopher'"},
      {"http://a/y", "ftp://a/y", "'ftp'"},
      {"http://a/y", "http://", "what is no URL"},
      {"http://a/y", "http://a b/", "what is no URL"},
  };
  for (const auto& [from, location, words] : table) {
    try {
      ADD_FAILURE() << from << " to " << redirect_target(from, location);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io);
      EXPECT_NE(error.detail().find(words), std::string::npos) << error.detail();
    }
  }
}

}  // namespace
}  // namespace octavo
