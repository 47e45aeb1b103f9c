#include "octavo/io/source/pieced_stream.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Four files of a counted run of bytes, `piece` of them in each, and others before these.
std::vector<StreamPiece> write_pieces(const TempFolder& folder, std::size_t piece,
                                      StreamCoding coding) {
  const std::string all = counted(4 * piece, 3);
  std::vector<StreamPiece> pieces;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::string front(i, '!');
    const std::string bytes = front + all.substr(i * piece, piece);
    const std::string path = folder.file("p" + std::to_string(i));
    write_file(path, coding == StreamCoding::plain ? bytes : gzip(bytes));
    pieces.push_back({path, {0, i}});
  }
  return pieces;
}

std::string read_text(PiecedStream& stream, std::size_t count) {
  std::string text(count, '\0');
  stream.read(std::as_writable_bytes(std::span(text)));
  return text;
}

TEST(PiecedStream, ReadsAndSkipsAcrossFiles) {
  constexpr std::size_t kPiece = 10;
  const std::string all = counted(4 * kPiece, 3);
  for (const StreamCoding coding : {StreamCoding::plain, StreamCoding::deflated}) {
    const TempFolder folder;
    const std::vector<StreamPiece> pieces = write_pieces(folder, kPiece, coding);
    for (std::size_t skipped = 0; skipped <= all.size(); ++skipped) {
      for (const std::size_t count : {1U, 7U, 10U, 21U}) {
        if (skipped + count + 3 > all.size()) continue;
        PiecedStream stream(pieces, kPiece, coding);
        stream.skip(skipped);
        EXPECT_EQ(read_text(stream, count), all.substr(skipped, count)) << skipped;
        stream.skip(2);
        EXPECT_EQ(read_text(stream, 1), all.substr(skipped + count + 2, 1)) << skipped;
        stream.skip(all.size() - skipped - count - 3);
        EXPECT_EQ(stream.finish().count, 0u);
        EXPECT_EQ(stream.path(), pieces.back().path);
      }
    }
  }
}

TEST(PiecedStream, OfDeflatedFilesProvesEachToItsEnd) {
  const TempFolder folder;
  std::vector<StreamPiece> pieces = write_pieces(folder, 10, StreamCoding::deflated);
  const std::string whole = read_file(pieces[1].path);
  std::string damaged = whole;
  damaged[damaged.size() - 6] ^= 1;  // its checksum
  write_file(pieces[1].path, damaged);
  PiecedStream stream(pieces, 10, StreamCoding::deflated);
  EXPECT_EQ(read_text(stream, 10).size(), 10u);
  const Error error = error_of([&] { read_text(stream, 11); });
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  EXPECT_EQ(error.path(), pieces[1].path);
  // Bytes behind the piece are none of the stream.
  write_file(pieces[1].path, gzip("!" + counted(40, 3).substr(10, 10) + "more"));
  PiecedStream longer(pieces, 10, StreamCoding::deflated);
  EXPECT_EQ(read_text(longer, 40), counted(40, 3));
  const BytesBehind behind = longer.finish();
  EXPECT_EQ(behind.count, 4u);
  EXPECT_EQ(behind.files, 1u);
  EXPECT_EQ(behind.path, pieces[1].path);
}

}  // namespace
}  // namespace octavo::testing
