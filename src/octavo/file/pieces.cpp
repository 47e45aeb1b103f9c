#include "octavo/file/pieces.h"

#include <algorithm>

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

}  // namespace

Bytes join_segments(std::span<const Bytes> segments) {
  Bytes piece;
  if (segments.back().empty()) return piece;
  ByteWriter out(piece);
  for (const Bytes& segment : segments.first(segments.size() - 1)) out.put_varint(segment.size());
  for (const Bytes& segment : segments) piece.insert(piece.end(), segment.begin(), segment.end());
  return piece;
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
