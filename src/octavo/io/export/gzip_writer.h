// One gzip stream, deflated by all threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/file/storage/pending_file.h"

namespace octavo {

/// Cuts what it is given into chunks of 1 MiB, deflates them side by side and writes one gzip
/// member. The bytes depend on nothing but the input: no clock, no name, no thread count.
/// Memory that of the largest `append`, twice
class GzipWriter {
 public:
  explicit GzipWriter(PendingFile& file);

  void append(std::span<const std::uint8_t> bytes);
  /// Ends the stream with its checksum and length. Throws Error{io}.
  void finish();

 private:
  void deflate_pending(std::size_t byte_count);

  PendingFile& file_;
  std::vector<std::uint8_t> pending_;
  std::uint32_t crc_ = 0;
  std::uint32_t length_ = 0;  // modulo 2^32, as the trailer has it
};

}  // namespace octavo
