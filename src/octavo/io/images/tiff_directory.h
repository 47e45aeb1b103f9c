// One directory (IFD) of a TIFF as it stands in the file: libtiff hands out one value of a tag, and
// passes over tags whose values it does not expect.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/source/source_file.h"

namespace octavo {

inline constexpr std::uint16_t kZeissTag = 34412;      // CZ_LSMINFO
inline constexpr std::uint16_t kMetaMorphTag = 33629;  // UIC2, a value of which is a plane

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

  bool has(std::uint16_t tag) const { return entry_of(tag).has_value(); }
  /// The single whole number of a tag, of any type of integers; nothing where it is absent.
  /// Throws Error{source_rejected} where it has several or none, is of another type or below 0, or
  ///        stands in several entries that differ; Error{io}
  std::optional<std::uint64_t> number(std::uint16_t tag) const;
  /// How many values a tag has; nothing where it is absent.
  /// Throws Error{source_rejected} where it stands in several entries that differ
  std::optional<std::uint64_t> value_count(std::uint16_t tag) const;
  /// The first whole numbers of a tag, of any type of integers; none where it is absent.
  /// most   how many are wanted
  /// Throws Error{source_rejected} where these are of another type or below 0, where the file ends
  ///        before all of them, or where the tag stands in several entries that differ; Error{io}
  /// Memory 8 bytes each, up to eight times the bytes of the file
  std::vector<std::uint64_t> numbers(std::uint16_t tag, std::uint64_t most) const;
  const SourceFile& file() const { return file_; }
  /// The bytes of the file that the directory takes up.
  std::uint64_t begin() const { return begin_; }
  std::uint64_t end() const { return end_; }
  /// Where the next directory begins; 0: this is the last one.
  std::uint64_t link() const { return link_; }
  bool is_big_tiff() const { return is_big_tiff_; }
  /// Bytes of the longest text (ASCII) that the file can hold, as its entry says.
  std::uint64_t longest_text() const;

 private:
  std::size_t entry_bytes() const { return is_big_tiff_ ? 20 : 12; }
  std::uint64_t number_at(std::span<const std::byte> bytes) const;
  /// The bytes of the entry of a tag. Throws Error{source_rejected} where there are several that
  /// differ.
  std::optional<std::span<const std::byte>> entry_of(std::uint16_t tag) const;
  [[noreturn]] void reject_tag(std::uint16_t tag, const std::string& why) const;
  /// Of the entry that starts at `at` in entries_; empty where it is none.
  std::string text_at(std::size_t at) const;

  const SourceFile& file_;
  bool is_big_endian_ = false;
  bool is_big_tiff_ = false;
  std::uint64_t begin_ = 0;
  std::uint64_t end_ = 0;
  std::uint64_t link_ = 0;
  std::vector<std::byte> entries_;
};

}  // namespace octavo
