// Byte streams that wait, side by side, until their turn in the file comes.
//
// All streams share one scratch file: each fills a block in memory, and full blocks go to the
// scratch file in the order in which they fill. Streams that never fill a block need no scratch
// file at all. Where a build keeps a journal, that takes the place of the scratch file.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/journal.h"

namespace octavo {

/// Memory  256 KiB per stream in use and 16 bytes per 256 KiB spooled
class Spool {
 public:
  Spool(Storage& storage, std::string folder, std::size_t stream_count);

  /// One that keeps all in memory.
  explicit Spool(std::size_t stream_count) : streams_(stream_count) {}

  /// Blocks go to `journal`, which must outlive their use, from now on. Before the first append.
  void keep_in(Journal& journal) { journal_ = &journal; }

  /// Takes over a block that stands in the journal.
  void restore(const JournalBlock& block);

  void append(std::size_t stream, ByteSpan bytes);

  /// Sends what waits in memory to the journal.
  void flush();

  std::uint64_t size(std::size_t stream) const;

  /// Hands the bytes of a stream to `sink` in order, a block at a time.
  void copy(std::size_t stream, const std::function<void(ByteSpan)>& sink) const;

 private:
  struct Block {
    std::uint64_t offset;
    std::uint64_t length;
  };
  struct Stream {
    std::vector<Block> blocks;  ///< in the scratch file or the journal
    std::uint64_t block_bytes = 0;
    Bytes tail;
  };

  void send_tail(std::size_t stream);

  Storage* storage_ = nullptr;  ///< null: all in memory
  std::string folder_;
  Journal* journal_ = nullptr;
  std::unique_ptr<StorageFile> scratch_;
  std::uint64_t scratch_bytes_ = 0;
  std::vector<Stream> streams_;
};

}  // namespace octavo
