#include "octavo/io/images/tiff_block.h"

#include <tiffio.h>

#include <algorithm>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/io/images/tiff_code_lengths.h"
#include "octavo/io/images/tiff_deflate.h"
#include "octavo/io/images/tiff_zstd.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/jpeg_completeness.h"

namespace octavo {

namespace {

std::uint16_t tag_of(TIFF* handle, std::uint32_t tag, std::uint16_t absent) {
  std::uint16_t value = 0;
  return TIFFGetFieldDefaulted(handle, tag, &value) == 1 ? value : absent;
}

/// Whether libtiff tells of JPEG that is sound and of a kind that libjpeg has no decoder for.
bool is_unknown_process(std::string_view told) {
  return told.find("Unsupported JPEG process") != std::string_view::npos ||
         told.find("arithmetic coding") != std::string_view::npos;
}

/// What is wrong with what codes make; empty where these are whole rows.
std::string damage_of(const MadeBytes& made, const WantedRows& wanted) {
  if (made.count > wanted.most) {
    return "its codes make more than its " + std::to_string(wanted.most) + " bytes";
  }
  if (!made.damage.empty()) return made.damage;
  const std::string found = "its codes make " + std::to_string(made.count);
  if (made.count < wanted.bytes) {
    return found + " of " + std::to_string(wanted.bytes) + " bytes";
  }
  if (wanted.may_end(made.count)) return {};
  return found + " bytes, and each row has " + std::to_string(wanted.row_bytes);
}

}  // namespace

std::string told_damage(std::string_view warnings) {
  for (; !warnings.empty(); warnings.remove_prefix(warnings.find('\n') + 1)) {
    const std::string_view line = warnings.substr(0, warnings.find('\n'));
    if (line.find("Corrupt JPEG data") != std::string_view::npos &&
        line.find("extraneous bytes") == std::string_view::npos) {
      return std::string(line);
    }
  }
  return {};
}

TiffBlockDecoder::TiffBlockDecoder(tiff* handle, const SourceFile& file, TiffMessages& messages,
                                   const PredictedRows& layout, TiffPrediction prediction,
                                   std::int64_t page)
    : handle_(handle),
      file_(file),
      messages_(messages),
      layout_(layout),
      prediction_(prediction),
      page_(page),
      compression_(tag_of(handle, TIFFTAG_COMPRESSION, COMPRESSION_NONE)) {}

void TiffBlockDecoder::decode(std::uint32_t number, std::span<std::byte> rows,
                              std::uint64_t most) {
  messages_ = {};
  if (is_deflate(compression_)) return decode_deflated(number, rows, most);
  if (compression_ == COMPRESSION_ZSTD) return decode_zstd(number, rows, most);
  const std::size_t found = decode_by_libtiff(number, rows);
  if (is_unknown_process(messages_.error)) {
    reject(file_.path(), "page " + std::to_string(page_) +
                             " is compressed by a process of JPEG that is not read (lossless ones "
                             "and those of arithmetic codes are not); save it with Deflate or LZW, "
                             "or uncompressed");
  }
  if (!messages_.error.empty()) reject_block(number, escaped(messages_.error));
  if (found != rows.size()) {
    reject_block(number, std::to_string(rows.size()) + " bytes expected, " +
                             std::to_string(found) + " found");
  }
  const std::string damage = damage_behind(number, rows.size(), most);
  if (!damage.empty()) reject_block(number, damage);
  undo_prediction(prediction_, layout_, rows);
}

std::string TiffBlockDecoder::damage_behind(std::uint32_t number, std::size_t wanted,
                                            std::uint64_t most) {
  const WantedRows rows = {wanted, most, row_bytes()};
  switch (compression_) {
    case COMPRESSION_LZW: {
      const auto made = lzw_bytes(read_coded(coded_block(number, most)), rows);
      return made ? damage_of(*made, rows) : "";
    }
    case COMPRESSION_PACKBITS:
      return damage_of(packbits_bytes(read_coded(coded_block(number, most)), rows), rows);
    case COMPRESSION_JPEG: {
      const std::string told = told_damage(messages_.warnings);
      if (!told.empty()) return escaped(told);
      const bool is_whole = is_whole_picture(read_coded(coded_block(number, most)));
      return is_whole ? "" : "its picture ends before its last value";
    }
    default: return {};
  }
}

void TiffBlockDecoder::reject_block(std::uint32_t number, const std::string& damage) const {
  const char* block = TIFFIsTiled(handle_) != 0 ? "tile " : "strip ";
  reject(file_.path(), block + std::to_string(number) + " of page " + std::to_string(page_) +
                           " is damaged (" + damage + "); copy the file again from its origin");
}

CodedBlock TiffBlockDecoder::coded_block(std::uint32_t number, std::uint64_t most) const {
  // No compression makes values ten times as long; beside them stand heads and tables.
  constexpr std::uint64_t kMostGrowth = 10;
  constexpr std::uint64_t kMostBeside = std::uint64_t{1} << 16;
  CodedBlock block;
  block.offset = std::min<std::uint64_t>(TIFFGetStrileOffset(handle_, number), file_.size());
  block.length = std::min<std::uint64_t>({TIFFGetStrileByteCount(handle_, number),
                                          file_.size() - block.offset,
                                          kMostGrowth * most + kMostBeside});
  block.is_mirrored =
      tag_of(handle_, TIFFTAG_FILLORDER, FILLORDER_MSB2LSB) == FILLORDER_LSB2MSB;
  return block;
}

std::size_t TiffBlockDecoder::decode_by_libtiff(std::uint32_t number,
                                                std::span<std::byte> rows) const {
  const auto wanted = static_cast<tmsize_t>(rows.size());
  const tmsize_t found = TIFFIsTiled(handle_) != 0
                             ? TIFFReadEncodedTile(handle_, number, rows.data(), wanted)
                             : TIFFReadEncodedStrip(handle_, number, rows.data(), wanted);
  return static_cast<std::size_t>(std::max<tmsize_t>(found, 0));
}

void TiffBlockDecoder::decode_deflated(std::uint32_t number, std::span<std::byte> rows,
                                       std::uint64_t most) {
  const CodedBlock block = coded_block(number, most);
  // libtiff may be faster, and does not say whether a stream is whole.
  if (may_end_with_checksum(block, prediction_) &&
      decode_by_libtiff(number, rows) == rows.size() &&
      ends_with_checksum_of(file_, block, prediction_, layout_, rows)) {
    return;
  }
  take_stored(number, inflate_rows(file_, block, rows, most), rows, most);
}

void TiffBlockDecoder::decode_zstd(std::uint32_t number, std::span<std::byte> rows,
                                   std::uint64_t most) {
  take_stored(number, unpack_zstd_rows(file_, coded_block(number, most), rows, most), rows, most);
}

void TiffBlockDecoder::take_stored(std::uint32_t number, const MadeBytes& made,
                                   std::span<std::byte> rows, std::uint64_t most) {
  const std::string damage = damage_of(made, {rows.size(), most, row_bytes()});
  if (!damage.empty()) reject_block(number, damage);
  if (layout_.are_swapped) swap_values(rows, layout_.value_bytes);
  undo_prediction(prediction_, layout_, rows);
}

std::span<std::byte> TiffBlockDecoder::read_coded(const CodedBlock& block) {
  coded_.resize(static_cast<std::size_t>(block.length));
  file_.read_exactly(block.offset, coded_);
  if (block.is_mirrored && compression_ != COMPRESSION_JPEG) {
    TIFFReverseBits(reinterpret_cast<std::uint8_t*>(coded_.data()),
                    static_cast<tmsize_t>(coded_.size()));
  }
  return coded_;
}

bool TiffBlockDecoder::is_whole_picture(std::span<const std::byte> picture) const {
  std::uint32_t table_bytes = 0;
  const std::byte* tables = nullptr;
  const bool has_tables =
      TIFFGetField(handle_, TIFFTAG_JPEGTABLES, &table_bytes, &tables) == 1 && tables != nullptr;
  return is_whole_jpeg({tables, has_tables ? table_bytes : 0}, picture);
}

}  // namespace octavo
