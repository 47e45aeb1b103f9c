// Small pictures in one folder, and how it is rejected as a source.
#pragma once

#include <gtest/gtest.h>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {

class ImageFolder : public ::testing::Test {
 protected:
  void add_png(const std::string& name, char value) {
    write_png(folder_.file(name), 2, 2, 8, 0, std::string(4, value));
  }
  void expect_rejected(const std::vector<std::string>& words) {
    const Error error = source_error({folder_.path()}, options_);
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    for (const std::string& word : words) {
      EXPECT_TRUE(contains(error, word)) << error.what();
    }
  }

  TempFolder folder_;
  SourceOptions options_;
};

}  // namespace octavo::testing
