#include "octavo/io/images/tiff_zstd.h"

#include <zstd.h>
#include <zstd_errors.h>

#include <memory>

#include "octavo/core/error.h"

namespace octavo {

namespace {

struct ContextEnd {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

}  // namespace

MadeBytes unpack_zstd_rows(const SourceFile& file, const CodedBlock& block,
                           std::span<std::byte> rows, std::uint64_t most) {
  const std::unique_ptr<ZSTD_DCtx, ContextEnd> context(ZSTD_createDCtx());
  if (context == nullptr) throw Error(ErrorKind::out_of_memory, "no memory for decompression");
  BlockPieces pieces(file, block);
  RowSink sink(rows);
  ZSTD_inBuffer input{};
  MadeBytes made;
  std::size_t state = 1;  // 0 behind the checksum, where the frame ends
  while (state != 0 && made.damage.empty() && sink.taken() <= most) {
    if (input.pos == input.size) {
      const std::span<const std::byte> piece = pieces.next();
      input = {piece.data(), piece.size(), 0};
    }
    const std::span<std::byte> room = sink.room();
    ZSTD_outBuffer output = {room.data(), room.size(), 0};
    const bool has_input = input.size > 0;
    state = ZSTD_decompressStream(context.get(), &output, &input);
    sink.take(output.pos);
    if (ZSTD_getErrorCode(state) == ZSTD_error_memory_allocation) {
      throw Error(ErrorKind::out_of_memory, "no memory for decompression");
    }
    if (ZSTD_isError(state) != 0) {
      made.damage = ZSTD_getErrorName(state);
    } else if (state != 0 && !has_input && output.pos == 0) {
      made.damage = "its frame ends early";
    }
  }
  made.count = sink.taken();
  return made;
}

}  // namespace octavo
