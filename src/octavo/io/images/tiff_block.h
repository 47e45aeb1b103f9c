// Strips and tiles of a TIFF page: decoded, and proven as far as their compression tells damage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/io/images/tiff_predictor.h"
#include "octavo/io/images/tiff_stream.h"

struct tiff;

namespace octavo {

/// Strips or tiles of this many bytes are decoded; those that hold one sample alone may be larger.
inline constexpr std::uint64_t kMaxBlockBytes = std::uint64_t{1} << 30;

/// What libtiff tells of an open file: hooks write into it.
struct TiffMessages {
  std::string error;     ///< the first one
  std::string warnings;  ///< the first ones, a line each
};

/// The first of libtiff's warnings that tells of lost values of a JPEG picture; empty where none
/// does. Others tell of bytes that nothing needs, and of a missing mark behind a whole picture.
std::string told_damage(std::string_view warnings);

/// Decodes blocks of the page that a file stands at. libtiff fills up or passes over what lacks in
/// them, with a warning or without a word.
class TiffBlockDecoder {
 public:
  /// layout      how values stand in the rows of each block
  /// prediction  as prediction_left says
  /// page        its number, for messages
  TiffBlockDecoder(tiff* handle, const SourceFile& file, TiffMessages& messages,
                   const PredictedRows& layout, TiffPrediction prediction, std::int64_t page);

  /// Decodes a strip or tile into its rows, values in native order.
  /// most    bytes that it may make, at least those of its rows; what is behind these is left out
  /// Throws  Error{source_rejected} where it is cut or damaged: where libtiff says so, where the
  ///         stream of Deflate is not proven by its checksum, where that of ZSTD or the codes of
  ///         LZW or PackBits do not make whole rows, or too many, and where a JPEG picture lacks
  ///         values; Error{io}, Error{out_of_memory}
  void decode(std::uint32_t number, std::span<std::byte> rows, std::uint64_t most);

 private:
  /// Throws Error{source_rejected} that names the block and what is wrong with it.
  [[noreturn]] void reject_block(std::uint32_t number, const std::string& damage) const;
  /// Where it stands, as far as the file has its bytes and a block can need them.
  CodedBlock coded_block(std::uint32_t number, std::uint64_t most) const;
  /// Lets libtiff decode. Returns how many bytes it made.
  std::size_t decode_by_libtiff(std::uint32_t number, std::span<std::byte> rows) const;
  void decode_deflated(std::uint32_t number, std::span<std::byte> rows, std::uint64_t most);
  void decode_zstd(std::uint32_t number, std::span<std::byte> rows, std::uint64_t most);
  /// Takes rows as they stood in a stream, or rejects what it made.
  void take_stored(std::uint32_t number, const MadeBytes& made, std::span<std::byte> rows,
                   std::uint64_t most);
  /// What shows that decoded rows are not those that were coded; empty where nothing does.
  std::string damage_behind(std::uint32_t number, std::size_t wanted, std::uint64_t most);
  std::size_t row_bytes() const { return layout_.row_values * layout_.value_bytes; }
  std::span<std::byte> read_coded(const CodedBlock& block);
  bool is_whole_picture(std::span<const std::byte> picture) const;

  tiff* handle_;
  const SourceFile& file_;
  TiffMessages& messages_;
  PredictedRows layout_;
  TiffPrediction prediction_;
  std::int64_t page_;
  std::uint16_t compression_;
  std::vector<std::byte> coded_;  // of the last read_coded
};

}  // namespace octavo
