// One directory (IFD) of a TIFF as it stands in the file: libtiff hands out one value of a tag.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/source/source_file.h"

namespace octavo {

/// The entries of a directory, of classic TIFF or BigTIFF, in either byte order.
class TiffDirectory {
 public:
  /// offset  of the directory in `file`, which must outlive it
  /// Throws  Error{source_rejected} where the file ends before the link behind the entries;
  ///         Error{io}
  TiffDirectory(const SourceFile& file, std::uint64_t offset, bool is_big_endian);

  /// The texts (ASCII) of a tag in the order of its entries, of which there should be one, up to
  /// eight. Those longer than a mebibyte or cut by the end of the file are left out.
  /// skipped  how many of the first ones are not wanted
  /// Throws   Error{io}
  std::vector<std::string> texts(std::uint16_t tag, std::size_t skipped) const;

  /// The single whole number of a tag; nothing where it has several, is of another type or absent.
  std::optional<std::uint64_t> number(std::uint16_t tag) const;
  /// Bytes of the longest text (ASCII) that the file can hold, as its entry says.
  std::uint64_t longest_text() const;

 private:
  std::size_t entry_bytes() const { return is_big_tiff_ ? 20 : 12; }
  std::uint64_t number_at(std::span<const std::byte> bytes) const;
  /// Of the entry that starts at `at` in entries_; empty where it is none.
  std::string text_at(std::size_t at) const;

  const SourceFile& file_;
  bool is_big_endian_ = false;
  bool is_big_tiff_ = false;
  std::vector<std::byte> entries_;
};

}  // namespace octavo
