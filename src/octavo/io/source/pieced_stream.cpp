#include "octavo/io/source/pieced_stream.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace octavo {

void BytesBehind::add(const std::string& of, std::uint64_t bytes) {
  if (bytes == 0) return;
  if (files == 0) path = of;
  ++files;
  count += bytes;
}

PiecedStream::PiecedStream(std::vector<StreamPiece> pieces, std::uint64_t piece_bytes,
                           StreamCoding coding, std::function<bool()> is_cancelled)
    : pieces_(std::move(pieces)),
      piece_bytes_(pieces_.size() == 1 ? std::numeric_limits<std::uint64_t>::max() : piece_bytes),
      coding_(coding),
      is_cancelled_(std::move(is_cancelled)) {
  stream();
}

VoxelStream& PiecedStream::stream() {
  if (!stream_) {
    const StreamPiece& piece = pieces_[number_];
    stream_.emplace(piece.path, piece.start.offset, coding_, is_cancelled_);
    stream_->skip(piece.start.skip_bytes);
    stream_->skip(at_);
  }
  return *stream_;
}

/// How many bytes stand behind a piece that was read, whose checksums are proven by that. A file
/// that many pieces lie in is read to its end for one of them.
std::uint64_t PiecedStream::rest() {
  const auto known = rest_of_.find(path());
  if (known != rest_of_.end()) return known->second;
  return rest_of_[path()] = stream().finish();
}

/// Goes on to the next piece; of a deflated one the checksums are proven before.
void PiecedStream::next() {
  if (coding_ != StreamCoding::plain) behind_.add(path(), rest());
  stream_.reset();
  at_ = 0;
  ++number_;
}

void PiecedStream::read(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    if (left() == 0 && has_next()) next();
    const std::size_t count =
        has_next() ? std::min<std::uint64_t>(bytes.size(), left()) : bytes.size();
    stream().read(bytes.first(count));
    at_ += count;
    bytes = bytes.subspan(count);
  }
}

void PiecedStream::skip(std::uint64_t count) {
  while (has_next() && count >= left()) {
    count -= left();
    if (coding_ != StreamCoding::plain) stream().skip(left());
    next();
  }
  if (count == 0) return;
  if (stream_ || coding_ != StreamCoding::plain || !has_next()) stream().skip(count);
  at_ += count;
}

BytesBehind PiecedStream::finish() {
  BytesBehind all = behind_;
  all.add(path(), rest());
  return all;
}

}  // namespace octavo
