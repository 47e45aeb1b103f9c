// A file that grows at its end, behind a header that is written in one piece.
#pragma once

#include <memory>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/file/layout.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// Collects what is appended into large writes and keeps the CRC-32C of all of it.
/// Memory  1 MiB
class AppendFile {
 public:
  /// A file in memory: what is appended waits for take().
  AppendFile() = default;

  explicit AppendFile(std::unique_ptr<StorageFile> file) : file_(std::move(file)) {}

  /// Continues a file of `size` bytes whose CRC behind the header is `digest`.
  AppendFile(std::unique_ptr<StorageFile> file, std::uint64_t size, std::uint32_t digest)
      : file_(std::move(file)), written_(size), digest_(digest) {}

  /// Bytes of the file once everything appended is written, the header's room included.
  std::uint64_t size() const { return written_ + buffer_.size(); }

  /// CRC-32C of everything appended so far, the header excluded.
  std::uint32_t digest() const { return digest_; }

  void append(ByteSpan bytes);

  /// Appends and describes what was appended.
  Section append_section(ByteSpan bytes);

  /// Goes on behind so many bytes of this CRC that others have put there.
  void pass_over(std::uint64_t length, std::uint32_t crc);

  /// What was appended to a file in memory, block by block.
  std::vector<Bytes> take();

  void write_header(const HeaderBlock& block) { file_->write(0, block); }

  /// Writes what is still held back.
  void flush();

  StorageFile& file() { return *file_; }

 private:
  void write(ByteSpan bytes);

  std::unique_ptr<StorageFile> file_;  ///< null in memory
  std::vector<Bytes> kept_;
  std::uint64_t written_ = kHeaderBytes;
  std::uint32_t digest_ = 0;
  Bytes buffer_;
};

}  // namespace octavo
