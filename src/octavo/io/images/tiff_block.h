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

/// The first of libtiff's warnings that tells of values that are lost; empty where none does.
std::string told_damage(std::uint16_t compression, std::string_view warnings);

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
  ///         stream of Deflate is not proven by its checksum or makes too much, where PackBits make
  ///         too much, and where a JPEG picture lacks values; Error{io}, Error{out_of_memory}
  void decode(std::uint32_t number, std::span<std::byte> rows, std::uint64_t most);

  /// Throws Error{source_rejected} that names the block and what is wrong with it.
  [[noreturn]] void reject_block(std::uint32_t number, const std::string& damage) const;

 private:
  /// Where it stands, as far as the file has its bytes and a block can need them.
  CodedBlock coded_block(std::uint32_t number, std::uint64_t most) const;
  /// Lets libtiff decode. Returns how many bytes it made.
  std::size_t decode_by_libtiff(std::uint32_t number, std::span<std::byte> rows) const;
  void decode_deflated(std::uint32_t number, std::span<std::byte> rows, std::uint64_t most);
  /// True where a JPEG picture is there to its last value.
  bool is_whole_picture(const CodedBlock& block);

  tiff* handle_;
  const SourceFile& file_;
  TiffMessages& messages_;
  PredictedRows layout_;
  TiffPrediction prediction_;
  std::int64_t page_;
  std::uint16_t compression_;
  std::vector<std::byte> coded_;  // a JPEG picture
};

}  // namespace octavo
