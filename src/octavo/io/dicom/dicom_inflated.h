// A DICOM file whose data set is deflated, read as if it were not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/source/voxel_stream.h"

namespace octavo {

/// The bytes of a file from `start` on, inflated; places count as if the file held them so.
/// Reads from front to back inflate each byte once, also when several threads take turns: a few
/// streams stay open where they ended. Thread-safe.
/// Memory  110 KiB for each thread that reads
/// Source  DICOM PS3.5, A.5 (the syntax), RFC 1951 (deflate, here without a zlib header)
class InflatedFile {
 public:
  /// Inflates the file once to learn its length. Throws Error{source_rejected} where it is cut or
  /// damaged, Error{io}.
  InflatedFile(const std::string& path, std::uint64_t start);

  std::uint64_t size() const { return size_; }

  /// Fills `bytes`. Requires start <= offset and offset + bytes.size() <= size().
  /// Throws as the constructor does.
  void read_exactly(std::uint64_t offset, std::span<std::byte> bytes);

  /// Closes the streams that stay open. From now on none stays open at `end` or behind it, where
  /// no more is read: of a series of many files only those that are being read hold a descriptor.
  void close_behind(std::uint64_t end);

 private:
  struct Cursor {
    std::uint64_t at;
    VoxelStream stream;
  };
  /// The open stream that stands nearest before `offset`, else a new one.
  Cursor take_cursor(std::uint64_t offset);

  std::string path_;
  std::uint64_t start_;
  std::uint64_t size_;
  std::uint64_t end_;  ///< of what is read; guarded, as `cursors_` is
  std::mutex mutex_;
  std::vector<Cursor> cursors_;
};

}  // namespace octavo
