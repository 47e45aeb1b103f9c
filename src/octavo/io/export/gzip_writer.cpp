#include "octavo/io/export/gzip_writer.h"

#include <zlib.h>

#include <algorithm>
#include <array>

#include "octavo/core/error.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::size_t kDeflatedBytes = std::size_t{1} << 20;
constexpr int kDeflateLevel = 6;

struct DeflatedChunk {
  std::vector<std::uint8_t> bytes;
  std::uint32_t crc = 0;
  std::size_t length = 0;
};

/// Deflates one chunk up to a byte boundary, so that chunks can follow each other in one stream.
DeflatedChunk deflate_chunk(std::span<const std::uint8_t> bytes, int flush) {
  z_stream stream{};
  if (deflateInit2(&stream, kDeflateLevel, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw Error(ErrorKind::out_of_memory, "no memory to compress");
  }
  DeflatedChunk chunk;
  chunk.bytes.resize(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 16);
  chunk.length = bytes.size();
  // zlib takes its input through a pointer that is not const but never writes through it.
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = chunk.bytes.data();
  stream.avail_out = static_cast<uInt>(chunk.bytes.size());
  const int result = deflate(&stream, flush);
  const bool is_complete = stream.avail_in == 0 && stream.avail_out > 0 &&
                           result == (flush == Z_FINISH ? Z_STREAM_END : Z_OK);
  chunk.bytes.resize(stream.total_out);
  deflateEnd(&stream);
  if (!is_complete) throw Error(ErrorKind::internal, "a chunk did not compress in one go");
  chunk.crc = static_cast<std::uint32_t>(crc32(0, bytes.data(), static_cast<uInt>(bytes.size())));
  return chunk;
}

void put_u32(std::uint8_t* out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

}  // namespace

GzipWriter::GzipWriter(PendingFile& file) : file_(file) {
  // RFC 1952: magic, deflate, no flags, no time, default effort, unknown system.
  constexpr std::array<std::uint8_t, 10> kGzipHeader = {0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255};
  file_.append(kGzipHeader);
}

void GzipWriter::append(std::span<const std::uint8_t> bytes) {
  pending_.insert(pending_.end(), bytes.begin(), bytes.end());
  deflate_pending(pending_.size() / kDeflatedBytes * kDeflatedBytes);
}

void GzipWriter::deflate_pending(std::size_t byte_count) {
  const std::span<const std::uint8_t> bytes(pending_.data(), byte_count);
  std::vector<DeflatedChunk> chunks(byte_count / kDeflatedBytes);
  parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
    chunks[i] = deflate_chunk(bytes.subspan(i * kDeflatedBytes, kDeflatedBytes), Z_SYNC_FLUSH);
  });
  for (const DeflatedChunk& chunk : chunks) {
    file_.append(chunk.bytes);
    crc_ = static_cast<std::uint32_t>(
        crc32_combine(crc_, chunk.crc, static_cast<z_off_t>(chunk.length)));
    length_ += static_cast<std::uint32_t>(chunk.length);
  }
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(byte_count));
}

void GzipWriter::finish() {
  const DeflatedChunk last = deflate_chunk(pending_, Z_FINISH);
  file_.append(last.bytes);
  crc_ =
      static_cast<std::uint32_t>(crc32_combine(crc_, last.crc, static_cast<z_off_t>(last.length)));
  length_ += static_cast<std::uint32_t>(last.length);
  std::array<std::uint8_t, 8> trailer{};
  put_u32(trailer.data(), crc_);
  put_u32(trailer.data() + 4, length_);
  file_.append(trailer);
}

}  // namespace octavo
