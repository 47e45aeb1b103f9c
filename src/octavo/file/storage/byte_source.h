// Where the bytes of a file come from: a disk, a URL, memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octavo/file/storage/byte_range.h"

namespace octavo {

/// Random access to immutable bytes. Thread-safe.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual std::uint64_t size() const = 0;
  /// What to call it in messages: a path or URL.
  virtual const std::string& name() const = 0;
  /// Fills `out` with the bytes from `offset` on, or throws: Error{truncated} when the source is
  /// shorter, Error{io} when reading fails.
  virtual void read(std::uint64_t offset, std::span<std::uint8_t> out) const = 0;

  /// What of `ranges` is not at hand: reading it waits for somebody, or fails until the bytes were
  /// brought. Rising and apart from one another.
  virtual std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const;

  /// How many bytes fetch() keeps at most; 0 where it does nothing.
  virtual std::uint64_t fetched_bytes_kept() const { return 0; }

  /// Brings ranges that are read soon, several at the same time, and keeps them in memory until
  /// others take their place. Throws as read() does, when all have come or failed.
  virtual void fetch(std::span<const ByteRange> /*ranges*/) const {}

  /// How many bytes fetch() brings in the time of one more round of requests: so many that are not
  /// needed cost less than asking where those are that are. 0 where nobody knows.
  virtual std::uint64_t bytes_per_round() const { return 0; }

  /// Bytes of `ranges`, those at hand and those that fetch() brings, stay until the last copy of
  /// what is returned is gone. Where more are held than fetched_bytes_kept(), nothing else is kept.
  virtual std::shared_ptr<const void> hold(std::span<const ByteRange> /*ranges*/) const {
    return nullptr;
  }

  /// Keeps nothing of these ranges, also where they are held: they are asked for anew when they are
  /// read again. False where nobody is asked: the bytes stay what they are.
  virtual bool forget(std::span<const ByteRange> /*ranges*/) const { return false; }
};

/// The bytes [offset, offset + length) of a source. They are asked for in parts, the first of at
/// most 1 MiB, no other longer than what came before it: memory follows the bytes that arrive,
/// whatever `length` claims. Throws as ByteSource::read
std::vector<std::uint8_t> read_arriving(const ByteSource& source, std::uint64_t offset,
                                        std::uint64_t length);
/// The same into a buffer, which may have memory already.
void read_arriving(const ByteSource& source, std::uint64_t offset, std::uint64_t length,
                   std::vector<std::uint8_t>& bytes);

/// A ByteSource over bytes in memory.
std::shared_ptr<ByteSource> byte_source_of(std::vector<std::uint8_t> bytes, std::string name);

}  // namespace octavo
