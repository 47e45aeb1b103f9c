// A file of which some bytes are at hand: those that somebody fetched and put in.
//
//     file     |################################################|
//     runs       |====|      |==========||==|        |=|             apart or side by side
//     missing  ..      ......                ........   .........
//
// A reader that must not wait asks what is missing (FileReader::ranges_of), has it fetched in any
// way there is, and puts it in.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "octavo/file/storage/byte_source.h"

namespace octavo {

/// Runs of bytes by their offsets; they do not overlap. Not thread-safe.
class SparseBytes {
 public:
  /// Keeps those of the bytes that are not here yet.
  /// Requires offset + bytes.size() <= 2^64 - 1
  void put(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// Copies bytes out; false, with `out` in any state, where some are missing.
  bool read(std::uint64_t offset, std::span<std::uint8_t> out) const;

  /// As ByteSource::missing
  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const;

  std::uint64_t byte_count() const { return byte_count_; }

  /// As ByteSource::hold, for what is put in: a run of which some bytes are held stays whole.
  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges);

  /// Drops the runs that have bytes of `ranges`, held or not.
  void drop(std::span<const ByteRange> ranges);

  /// Drops the runs that were put first until no more than `most_bytes` are left, or those alone
  /// that are held.
  void shrink_to(std::uint64_t most_bytes);

 private:
  using Ranges = std::vector<ByteRange>;

  struct Run {
    std::vector<std::uint8_t> bytes;
    std::uint64_t number = 0;  ///< of those that were put
  };

  using Runs = std::map<std::uint64_t, Run>;

  void insert(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  /// Returns the run behind it.
  Runs::iterator erase(Runs::iterator run);

  Runs runs_;                                         ///< by offset
  std::map<std::uint64_t, std::uint64_t> offsets_;    ///< of runs, by number
  std::vector<std::weak_ptr<const Ranges>> holds_;    ///< rising and apart, each of them
  std::uint64_t next_number_ = 0;
  std::uint64_t byte_count_ = 0;
};

/// Thread-safe: bytes may be put in while others are read.
class SparseSource final : public ByteSource {
 public:
  /// size  of the whole file
  SparseSource(std::uint64_t size, std::string name);

  /// Throws Error{invalid_argument} where the bytes lie beyond the end of the file.
  void put(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// As SparseBytes::shrink_to
  void shrink_to(std::uint64_t most_bytes);

  std::uint64_t byte_count() const;

  std::uint64_t size() const override { return size_; }
  const std::string& name() const override { return name_; }
  /// Throws Error{io} where bytes are missing, Error{truncated} beyond the end.
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override;
  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override;
  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges) const override;

 private:
  std::uint64_t size_;
  std::string name_;
  mutable std::mutex mutex_;
  mutable SparseBytes held_;
};

}  // namespace octavo
