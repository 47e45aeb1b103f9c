#include "octavo/file/pieces.h"

#include <algorithm>

#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

void split(ByteSpan piece, std::span<ByteSpan> segments) {
  if (piece.empty()) return;
  ByteReader in(piece, "coarse levels");
  std::array<std::uint64_t, kTierLevels> lengths{};
  for (std::size_t i = 0; i + 1 < segments.size(); ++i) lengths[i] = in.varint();
  for (std::size_t i = 0; i + 1 < segments.size(); ++i) {
    if (lengths[i] > in.left()) in.fail("ends early");
    segments[i] = in.take(static_cast<std::size_t>(lengths[i]));
  }
  if (in.left() == 0) in.fail("no coarsest samples");
  segments.back() = in.take(in.left());
}

Bytes encode_joint(std::span<const Bytes> segments) {
  Bytes piece;
  if (segments.back().empty()) {
    const auto is_empty = [](const Bytes& segment) { return segment.empty(); };
    if (std::all_of(segments.begin(), segments.end(), is_empty)) return piece;
    throw Error(ErrorKind::internal, "pieces: coarse levels without the coarsest one");
  }
  ByteWriter out(piece);
  for (const Bytes& segment : segments.first(segments.size() - 1)) out.put_varint(segment.size());
  for (const Bytes& segment : segments) piece.insert(piece.end(), segment.begin(), segment.end());
  return piece;
}

}  // namespace

std::array<Bytes, kTierPieces> encode_pieces(std::span<const Bytes> segments) {
  std::array<Bytes, kTierPieces> pieces;
  const std::size_t alone = std::min<std::size_t>(segments.size(), kTierPieces) - 1;
  std::copy_n(segments.begin(), alone, pieces.begin());
  pieces[alone] = encode_joint(segments.subspan(alone));
  return pieces;
}

std::array<ByteSpan, kTierLevels> segments_of(std::span<const Bytes> pieces, int level_count) {
  std::array<ByteSpan, kTierLevels> segments;
  std::copy(pieces.begin(), pieces.end(), segments.begin());
  if (level_count > kTierPieces) {
    const auto joint_count = static_cast<std::size_t>(level_count - kTierPieces) + 1;
    split(pieces.back(), std::span(segments).subspan(kTierPieces - 1, joint_count));
  }
  return segments;
}

}  // namespace octavo
