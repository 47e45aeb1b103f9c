// Voxels written as decimal numbers, parted by blanks and line ends, read from front to back.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/io/source/source_file.h"
#include "octavo/io/source/stored_type.h"

namespace octavo {

/// The numbers of a file from some byte on. One thread at a time.
/// Memory  64 KiB, whatever the length
class TextVoxels {
 public:
  /// Throws Error{io}.
  TextVoxels(const std::string& path, std::uint64_t offset);

  /// Fills `values` with the next numbers, of `type` in native byte order.
  /// Throws Error{source_rejected} with the byte where there stands what is no number, one that the
  ///        type cannot hold, or one without a blank behind it: the file may be cut within it;
  ///        Error{io}
  void read(StoredType type, std::span<std::byte> values);

  /// Of the byte behind the last number.
  std::uint64_t offset() const { return buffer_offset_ + at_; }
  const std::string& path() const { return file_.path(); }

 private:
  /// The next word; valid until the next call.
  std::string_view next_word();
  /// Keeps the bytes from at_ on and reads more behind them; false at the end of the file.
  bool refill();
  template <class T>
  void read_values(std::span<std::byte> values);
  [[noreturn]] void reject(const std::string& why) const;

  SourceFile file_;
  std::vector<char> buffer_;
  std::uint64_t buffer_offset_;  ///< of the first byte of the buffer in the file
  std::size_t at_ = 0;           ///< of the next byte in the buffer
};

}  // namespace octavo
