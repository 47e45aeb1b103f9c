// Byte streams that wait, side by side, until their turn in the file comes.
//
// All streams share one scratch file: each fills a block in memory, and full blocks go to the
// scratch file in the order in which they fill. Streams that never fill a block need no scratch
// file at all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/file/storage.h"

namespace octavo {

/// Memory  256 KiB per stream in use and 8 bytes per 256 KiB spooled
class Spool {
 public:
  Spool(Storage& storage, std::string folder, std::size_t stream_count);

  void append(std::size_t stream, ByteSpan bytes);

  std::uint64_t size(std::size_t stream) const;

  /// Hands the bytes of a stream to `sink` in order, a block at a time.
  void copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const;

 private:
  struct Stream {
    std::vector<std::uint64_t> blocks;  ///< offsets in the scratch file
    Bytes tail;
  };

  Storage& storage_;
  std::string folder_;
  std::unique_ptr<StorageFile> scratch_;
  std::uint64_t scratch_bytes_ = 0;
  std::vector<Stream> streams_;
};

}  // namespace octavo
