// What failures say.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "support/hints.h"

namespace octavo::testing {

/// What an action that fails says, with its hints.
inline std::string failure_of(const std::function<void()>& action, ErrorKind kind) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return with_hints(error);
  }
  ADD_FAILURE() << "nothing failed";
  return {};
}

inline void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
  }
}

}  // namespace octavo::testing
