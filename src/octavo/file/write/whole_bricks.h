// The bricks that an interrupted build finished, one after another, with their bytes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/file/index.h"
#include "octavo/file/write/interrupted.h"

namespace octavo {

/// Gives the bricks of the whole layers of tier 0 in brick order. Every byte is proven before it is
/// given out.
/// Memory  that of a page, and 1 MiB per level
class WholeBricks {
 public:
  /// Throws Error{corrupt} when nothing is whole, Error{io}
  explicit WholeBricks(InterruptedBuild build);

  /// The volume, its metadata and its max error.
  const FileHeader& header() const { return header_; }
  const Levels& levels() const { return levels_; }
  /// As JournalHead::settings.
  const std::string& settings() const { return build_.head.settings; }

  /// Layers of tier 0 that are whole.
  std::int64_t layer_count() const { return layer_count_; }
  /// Smallest and largest value in them.
  ValueRange range() const { return range_; }
  /// The sum of EncodedBrick::squared_error of their bricks.
  double squared_error() const { return squared_error_; }

  /// The digests of the planes of those layers, by z.
  const std::vector<Sha256Digest>& plane_digests() const { return plane_digests_; }

  /// True when a model begins with the next brick, which is the first of its layer.
  bool has_model() const;
  /// That model.
  Bytes model();
  /// The next brick. Requires that one is left. Throws Error{corrupt}, Error{io}
  EncodedBrick next();

 private:
  // A stream of the journal, read from its start.
  struct Stream {
    std::vector<JournalBlock> blocks;
    std::size_t block = 0;
    std::uint64_t at = 0;  ///< in the block
  };

  void place(const std::vector<WholeGroup>& groups);
  void open_page();
  Bytes take(std::size_t stream, std::uint64_t count);
  Bytes proven_piece(Bytes bytes, int level, std::uint32_t crc) const;

  InterruptedBuild build_;
  FileHeader header_;
  Levels levels_;
  std::int64_t layer_count_ = 0;
  ValueRange range_;
  double squared_error_ = 0;
  IndexRoot root_;
  std::vector<Stream> streams_;
  std::vector<std::int64_t> parents_;
  std::vector<Sha256Digest> plane_digests_;
  std::size_t next_model_ = 0;
  std::size_t next_page_ = 0;
  IndexPage page_;
  std::size_t in_page_ = 0;   ///< bricks of the page that were given
  std::size_t given_ = 0;     ///< bricks that were given in all
};

}  // namespace octavo
