// Bytes that came a long way, on which some of them may have changed.
#pragma once

#include <span>

#include "octavo/core/error.h"
#include "octavo/file/storage/byte_source.h"

namespace octavo {

/// A source that asks somebody for its bytes and keeps what came.
class FetchedSource : public ByteSource {
 public:
  /// Keeps nothing of these ranges: they are asked for anew when they are read again. Held bytes go
  /// as well. Thread-safe.
  virtual void forget(std::span<const ByteRange> ranges) const = 0;
};

/// Calls forget() of a source that has one; false of others, whose bytes stay what they are.
inline bool forget_fetched(const ByteSource& source, std::span<const ByteRange> ranges) {
  const auto* fetched = dynamic_cast<const FetchedSource*>(&source);
  if (fetched == nullptr) return false;
  fetched->forget(ranges);
  return true;
}

/// What `read` returns. Where it finds damage in bytes that came a long way, `ranges` of them are
/// asked for once more, and it is called again: what it throws then counts.
template <class Read>
auto read_twice(const ByteSource& source, std::span<const ByteRange> ranges, Read read) {
  try {
    return read();
  } catch (const Error& error) {
    const bool is_damage = error.kind() == ErrorKind::corrupt ||
                           error.kind() == ErrorKind::truncated ||
                           error.kind() == ErrorKind::not_octavo ||
                           error.kind() == ErrorKind::unsupported_version;
    if (!is_damage || !forget_fetched(source, ranges)) throw;
  }
  return read();
}

/// What `find` returns. Where is_good(found) is false of bytes that came a long way, they all are
/// asked for once more: what is found then counts.
template <class Find, class IsGood>
auto found_twice(const ByteSource& source, Find find, IsGood is_good) {
  auto found = find();
  const ByteRange all{0, source.size()};
  if (!is_good(found) && forget_fetched(source, {&all, 1})) found = find();
  return found;
}

}  // namespace octavo
