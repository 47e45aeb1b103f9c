// Bytes that came a long way, on which some of them may have changed.
#pragma once

#include <span>

#include "octavo/core/error.h"
#include "octavo/file/storage/byte_source.h"

namespace octavo {

/// Whether an error can come of bytes that were changed.
inline bool may_be_damage(const Error& error) {
  return error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::truncated ||
         error.kind() == ErrorKind::not_octavo || error.kind() == ErrorKind::unsupported_version;
}

/// What `read` returns. Where that is not is_good(found), or an error that damage can be, and
/// `ranges` of the source can be forgotten, it is called once more: what comes of that counts. Not
/// to be called within itself, as every such call would double the one around it.
template <class Read, class IsGood>
auto read_twice(const ByteSource& source, std::span<const ByteRange> ranges, Read read,
                IsGood is_good) {
  try {
    auto found = read();
    if (is_good(found) || !source.forget(ranges)) return found;
  } catch (const Error& error) {
    if (!may_be_damage(error) || !source.forget(ranges)) throw;
  }
  return read();
}

template <class Read>
auto read_twice(const ByteSource& source, std::span<const ByteRange> ranges, Read read) {
  try {
    return read();
  } catch (const Error& error) {
    if (!may_be_damage(error) || !source.forget(ranges)) throw;
  }
  return read();
}

}  // namespace octavo
