#include "octavo/io/images/tiff_deflate.h"

#include <tiffio.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/header_bytes.h"

namespace octavo {

namespace {

constexpr std::size_t kMostRoom = 1U << 30;  // zlib counts in 32 bits
constexpr std::size_t kAdlerBytes = 4;

/// A stream of zlib that is being inflated.
class OpenDeflate {
 public:
  OpenDeflate() {
    if (inflateInit(&stream) != Z_OK) {
      throw Error(ErrorKind::out_of_memory, "no memory for decompression");
    }
  }
  ~OpenDeflate() { inflateEnd(&stream); }
  OpenDeflate(const OpenDeflate&) = delete;
  OpenDeflate& operator=(const OpenDeflate&) = delete;

  z_stream stream{};
};

/// What is wrong with a stream by the last answer of zlib.
std::string deflate_damage(const z_stream& stream, int state) {
  switch (state) {
    case Z_OK:
    case Z_STREAM_END: return {};
    case Z_BUF_ERROR: return "its stream ends early";
    case Z_NEED_DICT: return "its stream asks for a dictionary";
    case Z_MEM_ERROR: throw Error(ErrorKind::out_of_memory, "no memory for decompression");
    default: return stream.msg != nullptr ? stream.msg : "it holds no stream of Deflate";
  }
}

/// The step from each number to that of the pixel before it, as predictors store them.
template <class T>
void take_steps(std::span<const std::byte> row, std::size_t step, std::span<std::byte> steps) {
  const std::size_t count = row.size() / sizeof(T);
  std::memcpy(steps.data(), row.data(), std::min(step * sizeof(T), row.size()));
  for (std::size_t i = step; i < count; ++i) {
    T before{};
    T value{};
    std::memcpy(&before, row.data() + (i - step) * sizeof(T), sizeof(T));
    std::memcpy(&value, row.data() + i * sizeof(T), sizeof(T));
    value = static_cast<T>(value - before);
    std::memcpy(steps.data() + i * sizeof(T), &value, sizeof(T));
  }
}

void take_row_steps(const PredictedRows& layout, std::span<const std::byte> row,
                    std::span<std::byte> steps) {
  switch (layout.value_bytes) {
    case 1: return take_steps<std::uint8_t>(row, layout.step, steps);
    case 2: return take_steps<std::uint16_t>(row, layout.step, steps);
    case 4: return take_steps<std::uint32_t>(row, layout.step, steps);
    default: return take_steps<std::uint64_t>(row, layout.step, steps);
  }
}

std::uint32_t added_to_adler(std::uint32_t sum, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      adler32_z(sum, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// The checksum of rows as they stood in the file before they were deflated.
std::uint32_t adler_of(TiffPrediction prediction, const PredictedRows& layout,
                       std::span<const std::byte> rows) {
  constexpr std::uint32_t kAdlerOfNothing = 1;
  const bool are_as_stored = prediction == TiffPrediction::none &&
                             (!layout.are_swapped || layout.value_bytes == 1);
  if (are_as_stored) return added_to_adler(kAdlerOfNothing, rows);
  const std::size_t row_bytes = layout.row_values * layout.value_bytes;
  std::vector<std::byte> stored(row_bytes);
  std::uint32_t sum = kAdlerOfNothing;
  for (std::size_t at = 0; at + row_bytes <= rows.size(); at += row_bytes) {
    const std::span<const std::byte> row = rows.subspan(at, row_bytes);
    if (prediction == TiffPrediction::differences) {
      take_row_steps(layout, row, stored);
    } else {
      std::memcpy(stored.data(), row.data(), row_bytes);
    }
    if (layout.are_swapped) swap_values(stored, layout.value_bytes);
    sum = added_to_adler(sum, stored);
  }
  return sum;
}

}  // namespace

bool is_deflate(std::uint16_t compression) {
  return compression == COMPRESSION_DEFLATE || compression == COMPRESSION_ADOBE_DEFLATE;
}

MadeBytes inflate_rows(const SourceFile& file, const CodedBlock& block, std::span<std::byte> rows,
                       std::uint64_t most) {
  OpenDeflate open;
  z_stream& stream = open.stream;
  BlockPieces pieces(file, block);
  RowSink sink(rows);
  int state = Z_OK;
  // Without input left, zlib still gives what it holds back, and then says that it lacks some.
  while (state == Z_OK && sink.taken() <= most) {
    if (stream.avail_in == 0) {
      const std::span<std::byte> piece = pieces.next();
      stream.next_in = reinterpret_cast<Bytef*>(piece.data());
      stream.avail_in = static_cast<uInt>(piece.size());
    }
    const std::span<std::byte> room = sink.room();
    const std::size_t most_room = std::min(room.size(), kMostRoom);
    stream.next_out = reinterpret_cast<Bytef*>(room.data());
    stream.avail_out = static_cast<uInt>(most_room);
    state = inflate(&stream, Z_NO_FLUSH);
    sink.take(most_room - stream.avail_out);
  }
  return {sink.taken(), deflate_damage(stream, state)};
}

bool may_end_with_checksum(const CodedBlock& block, TiffPrediction prediction) {
  return prediction != TiffPrediction::float_bytes && !block.is_mirrored &&
         block.length > kAdlerBytes;
}

bool ends_with_checksum_of(const SourceFile& file, const CodedBlock& block,
                           TiffPrediction prediction, const PredictedRows& layout,
                           std::span<const std::byte> rows) {
  std::array<std::byte, kAdlerBytes> end{};
  if (!may_end_with_checksum(block, prediction) ||
      file.read_some(block.offset + block.length - end.size(), end) != end.size()) {
    return false;
  }
  const auto stored = HeaderBytes(end, true).at<std::uint32_t>(0);
  return stored == adler_of(prediction, layout, rows);
}

}  // namespace octavo
