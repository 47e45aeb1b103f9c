// Arithmetic on sizes that come from outside: every product and sum is proven before it is used.
#pragma once

#include <cstdint>

#include "octavo/core/error.h"

namespace octavo {

/// a * b; throws Error{limit_exceeded} naming `what` when it does not fit in 64 bits.
inline std::uint64_t checked_mul(std::uint64_t a, std::uint64_t b, const char* what) {
  std::uint64_t product = 0;
  if (__builtin_mul_overflow(a, b, &product)) {
    throw Error(ErrorKind::limit_exceeded, std::string(what) + " exceeds 64 bits");
  }
  return product;
}

/// a * b of a count; throws Error{limit_exceeded} naming `what` when it does not fit in int64_t.
inline std::int64_t checked_count(std::int64_t a, std::int64_t b, const char* what) {
  std::int64_t product = 0;
  if (__builtin_mul_overflow(a, b, &product)) {
    throw Error(ErrorKind::limit_exceeded, std::string(what) + " exceed 63 bits");
  }
  return product;
}

/// a + b; throws Error{limit_exceeded} naming `what` when it does not fit in 64 bits.
inline std::uint64_t checked_add(std::uint64_t a, std::uint64_t b, const char* what) {
  std::uint64_t sum = 0;
  if (__builtin_add_overflow(a, b, &sum)) {
    throw Error(ErrorKind::limit_exceeded, std::string(what) + " exceeds 64 bits");
  }
  return sum;
}

}  // namespace octavo
