#include "octavo/io/images/tiff_block.h"

#include <tiffio.h>

#include <algorithm>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/io/images/tiff_deflate.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/jpeg_completeness.h"

namespace octavo {

namespace {

std::uint16_t tag_of(TIFF* handle, std::uint32_t tag, std::uint16_t absent) {
  std::uint16_t value = 0;
  return TIFFGetFieldDefaulted(handle, tag, &value) == 1 ? value : absent;
}

/// What is wrong with a stream of Deflate; empty where it makes whole rows, those wanted at least.
std::string damage_of(const MadeBytes& made, std::size_t wanted, std::uint64_t most,
                      std::size_t row_bytes) {
  if (made.count > most) {
    return "its stream makes more than its " + std::to_string(most) + " bytes";
  }
  if (!made.damage.empty()) return made.damage;
  const std::string found = "its stream makes " + std::to_string(made.count);
  if (made.count < wanted) return found + " of " + std::to_string(wanted) + " bytes";
  if ((made.count - wanted) % row_bytes == 0) return {};
  return found + " bytes, and each row has " + std::to_string(row_bytes);
}

}  // namespace

std::string told_damage(std::uint16_t compression, std::string_view warnings) {
  const auto has = [](std::string_view line, const char* words) {
    return line.find(words) != std::string_view::npos;
  };
  for (; !warnings.empty(); warnings.remove_prefix(warnings.find('\n') + 1)) {
    const std::string_view line = warnings.substr(0, warnings.find('\n'));
    // libjpeg also tells of bytes that nothing needs, and of a missing mark behind a whole picture.
    const bool is_of_jpeg = compression == COMPRESSION_JPEG && has(line, "Corrupt JPEG data") &&
                            !has(line, "extraneous bytes");
    const bool is_of_packbits = compression == COMPRESSION_PACKBITS &&
                                (has(line, "Discarding") || has(line, "lack of data"));
    if (is_of_jpeg || is_of_packbits) return std::string(line);
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
  const std::size_t found = decode_by_libtiff(number, rows);
  if (!messages_.error.empty()) reject_block(number, escaped(messages_.error));
  if (found != rows.size()) {
    reject_block(number, std::to_string(rows.size()) + " bytes expected, " +
                             std::to_string(found) + " found");
  }
  // Rows that PackBits make behind the page count for nothing.
  const bool may_go_on = compression_ == COMPRESSION_PACKBITS && most > rows.size();
  const std::string damage = may_go_on ? "" : told_damage(compression_, messages_.warnings);
  if (!damage.empty()) reject_block(number, escaped(damage));
  if (compression_ == COMPRESSION_JPEG && !is_whole_picture(coded_block(number, most))) {
    reject_block(number, "its picture ends before its last value");
  }
  undo_prediction(prediction_, layout_, rows);
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
  const MadeBytes made = inflate_rows(file_, block, rows, most);
  const std::string damage =
      damage_of(made, rows.size(), most, layout_.row_values * layout_.value_bytes);
  if (!damage.empty()) reject_block(number, damage);
  if (layout_.are_swapped) swap_values(rows, layout_.value_bytes);
  undo_prediction(prediction_, layout_, rows);
}

bool TiffBlockDecoder::is_whole_picture(const CodedBlock& block) {
  coded_.resize(static_cast<std::size_t>(block.length));
  file_.read_exactly(block.offset, coded_);
  std::uint32_t table_bytes = 0;
  const std::byte* tables = nullptr;
  const bool has_tables =
      TIFFGetField(handle_, TIFFTAG_JPEGTABLES, &table_bytes, &tables) == 1 && tables != nullptr;
  return is_whole_jpeg({tables, has_tables ? table_bytes : 0}, coded_);
}

}  // namespace octavo
