// Bytes that stand in several files one after the other, as one stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/source/voxel_stream.h"

namespace octavo {

struct PieceStart {
  std::uint64_t offset = 0;      ///< in the file; where the deflated stream starts, or the bytes
  std::uint64_t skip_bytes = 0;  ///< before the bytes, counted behind decompression
};

struct StreamPiece {
  std::string path;
  PieceStart start;
};

/// Bytes that stand behind what was asked for.
struct BytesBehind {
  std::uint64_t count = 0;
  std::size_t files = 0;  ///< that have some
  std::string path;       ///< the first of them

  void add(const std::string& of, std::uint64_t bytes);
};

/// As VoxelStream, over pieces of equal length, which start alike where they lie in one deflated
/// file. One file is open at a time, from the first on.
class PiecedStream {
 public:
  /// piece_bytes   of each piece, behind decompression; of a single one nobody needs to know them
  /// is_cancelled  as that of VoxelStream
  /// Requires a piece
  PiecedStream(std::vector<StreamPiece> pieces, std::uint64_t piece_bytes, StreamCoding coding,
               std::function<bool()> is_cancelled = {});

  /// The file that is read.
  const std::string& path() const { return pieces_[number_].path; }

  /// How many bytes stand in one file from the next one on.
  std::uint64_t bytes_in_file() const {
    return left() == 0 && has_next() ? piece_bytes_ : left();
  }

  /// As VoxelStream::read
  void read(std::span<std::byte> bytes);

  /// As VoxelStream::skip; plain pieces that are passed are not read.
  void skip(std::uint64_t count);

  /// As VoxelStream::finish, with what was left of earlier pieces.
  BytesBehind finish();

 private:
  VoxelStream& stream();
  std::uint64_t left() const { return piece_bytes_ - at_; }
  bool has_next() const { return number_ + 1 < pieces_.size(); }
  std::uint64_t rest();
  void next();

  std::vector<StreamPiece> pieces_;
  std::uint64_t piece_bytes_;
  StreamCoding coding_;
  std::function<bool()> is_cancelled_;
  std::size_t number_ = 0;             ///< of the piece that is read
  std::uint64_t at_ = 0;               ///< in it
  std::optional<VoxelStream> stream_;  ///< of it, once it is opened
  BytesBehind behind_;                 ///< of earlier pieces
  std::map<std::string, std::uint64_t> rest_of_;  ///< by the path of a file
};

}  // namespace octavo
