// What all fuzz targets share. A target takes any bytes; only octavo::Error may leave the code
// under test.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "octavo/core/error.h"

namespace octavo::fuzz {

/// Takes numbers off the front of the input; zeros once it is used up.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  template <class Int>
  Int take() {
    Int value{};
    const std::size_t count = std::min(sizeof value, rest_.size());
    std::memcpy(&value, rest_.data(), count);
    rest_ = rest_.subspan(count);
    return value;
  }

  /// A copy of the next bytes in a block of exactly their size, so that a sanitizer sees every
  /// overrun.
  std::vector<std::uint8_t> take_bytes(std::size_t count) {
    count = std::min(count, rest_.size());
    std::vector<std::uint8_t> bytes(rest_.begin(),
                                    rest_.begin() + static_cast<std::ptrdiff_t>(count));
    rest_ = rest_.subspan(count);
    return bytes;
  }

  std::size_t left() const { return rest_.size(); }

 private:
  std::span<const std::uint8_t> rest_;
};

/// Ends the program: a law that every target states does not hold.
[[noreturn]] inline void fail(const char* what) {
  std::fprintf(stderr, "fuzz: %s\n", what);
  std::abort();
}

inline void require(bool is_true, const char* what) {
  if (!is_true) fail(what);
}

/// Runs `f`; an octavo::Error is an answer like any other.
template <class F>
void expect_error_or_success(F&& f) {
  try {
    f();
  } catch (const Error&) {
  }
}

}  // namespace octavo::fuzz
