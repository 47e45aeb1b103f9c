#include "golden/listing.h"

#include <cstdio>

#include "octavo/file/index.h"
#include "octavo/file/slab_trailer.h"

namespace octavo::testing {

namespace {

class Listing {
 public:
  explicit Listing(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}

  /// The next `count` bytes; the first line says what they are.
  void field(std::size_t count, const std::string& what) {
    for (std::size_t done = 0; done < count; done += 16) {
      char head[16];
      std::snprintf(head, sizeof head, "%04zx  ", at_ + done);
      std::string line = head;
      for (std::size_t i = done; i < done + 16; ++i) {
        char pair[8] = "   ";
        if (i < count) std::snprintf(pair, sizeof pair, "%02x ", bytes_[at_ + i]);
        line += pair;
      }
      if (done == 0) line += " " + what;
      line.erase(line.find_last_not_of(' ') + 1);
      text_ += line + "\n";
    }
    at_ += count;
  }

  void varint(const std::string& what) {
    std::size_t count = 1;
    while (bytes_[at_ + count - 1] >= 0x80) ++count;
    field(count, what);
  }

  void heading(const std::string& what) { text_ += (text_.empty() ? "" : "\n") + what + "\n"; }

  const std::string& text() const { return text_; }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::size_t at_ = 0;
  std::string text_;
};

void list_header(Listing& out) {
  out.heading("header");
  out.field(8, "magic");
  out.field(2, "major version");
  out.field(2, "minor version");
  out.field(1, "kind: 1 grey");
  out.field(1, "voxel type: 2 uint8");
  out.field(1, "halvings");
  out.field(1, "sealed");
  out.field(32, "axes halved from level k to k+1: x 1, y 2, z 4");
  out.field(24, "size x, y, z");
  out.field(24, "origin");
  out.field(24, "spacing");
  out.field(72, "direction, row-major");
  out.field(8, "slope");
  out.field(8, "intercept");
  out.field(8, "max error");
  out.field(8, "build id: content hash, then CRC of the description");
  out.field(8, "length of the file");
  for (const char* name : {"metadata", "index pages", "index root", "directory"}) {
    out.field(8, std::string(name) + ": offset");
    out.field(8, "length");
    out.field(4, "CRC");
    out.field(4, "zero");
  }
  out.field(1, "channels");
  out.field(1, "times");
  out.field(2, "extension count");
  out.field(176, "no extensions");
  out.field(4, "CRC of the header so far");
}

void list_slab(Listing& out, const IndexRoot& root, const IndexPage& page, std::int64_t planes) {
  out.heading("slab 0");
  out.field(root.models[0].length, "model 0");
  const PieceRef& piece = page.pieces.front();
  out.field(piece.length, "brick 0, piece 0: level 0");
  out.field(4, "slab trailer");
  out.field(8, "build id");
  out.varint("slab 0");
  out.varint("model 0");
  for (std::size_t i = 0; i < page.ranges.size(); ++i) out.varint("length of a piece");
  for (std::int64_t z = 0; z < planes; ++z) {
    out.field(32, "SHA-256 of plane " + std::to_string(z));
  }
  out.field(4, "CRC of model and pieces");
  out.field(4, "length of the slab trailer");
  out.field(4, "CRC of the slab trailer so far");
}

void list_page(Listing& out, const IndexPage& page) {
  out.heading("index page 0");
  out.field(1, "flags");
  for (std::size_t i = 0; i < page.ranges.size(); ++i) {
    out.varint("smallest voxel, less that of the brick before; zigzag");
    out.varint("largest voxel less the smallest");
  }
  const auto count = static_cast<std::size_t>(page.piece_count);
  for (std::size_t piece = 0; piece < count; ++piece) {
    out.varint("length of piece " + std::to_string(piece));
    if (page.pieces[piece].length > 0) out.field(4, "its CRC");
  }
}

void list_root(Listing& out, const IndexPage& page) {
  out.heading("index root");
  out.varint("models");
  out.varint("model 0: slabs since the one before");
  out.varint("length");
  out.field(4, "CRC");
  out.varint("slab 0: length of its trailer");
  out.varint("page 0: length");
  out.field(4, "CRC");
  out.varint("smallest voxel, zigzag");
  out.varint("largest less the smallest");
  out.varint("uniform bricks");
  for (int piece = 0; piece < page.piece_count; ++piece) {
    out.varint("bytes of pieces " + std::to_string(piece));
  }
}

void list_trailer(Listing& out) {
  out.heading("trailer");
  out.field(8, "magic");
  out.field(8, "build id");
  out.field(8, "length of the file");
  out.field(4, "CRC at the end of the header");
  out.field(4, "CRC of all bytes between header and trailer");
  out.field(8, "offset of the previous trailer");
  out.field(32, "voxel digest");
  out.field(20, "zero");
  out.field(4, "CRC of the trailer so far");
}

}  // namespace

std::string annotated_listing(const std::vector<std::uint8_t>& bytes) {
  const ByteSpan all(bytes);
  const FileHeader header = parse_header(all.first(kHeaderBytes), bytes.size());
  const Levels levels(header.description.size, header.halvings);
  const IndexRoot root =
      parse_root(all.subspan(header.root.offset, header.root.length), levels, header);
  const IndexPage page = parse_page(all.subspan(header.pages.offset, header.pages.length), root,
                                    levels, 0, 0, header);
  Listing out(bytes);
  list_header(out);
  list_slab(out, root, page, header.description.size.z);
  for (int level = 1; level < levels.count(); ++level) {
    const std::uint64_t length = root.tiers[0].piece_bytes[static_cast<std::size_t>(level)];
    if (length == 0) continue;
    out.heading("level " + std::to_string(level));
    out.field(length, "pieces");
  }
  list_page(out, page);
  out.heading("metadata");
  out.field(header.metadata.length, "UTF-8 JSON");
  list_root(out, page);
  list_trailer(out);
  return out.text();
}

}  // namespace octavo::testing
