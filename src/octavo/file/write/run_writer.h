// Writes the bricks of consecutive layers: what a file, a build that goes on and a part of a file
// have in common.
//
//   out     level 0 of tier 0 as it comes: model, pieces, slab trailer, pieces, slab trailer, ..
//   spool   a stream for each level above, and behind them one for the index pages
//
// A band is a run of bricks inside one layer, the only one of its group. Its streams have no slab
// trailer, the model only where the band begins the layer, and pages that end where those of the
// layer do or the band does: who has all bands of the layer makes the rest.
//
// Invariants
//   What a run holds depends on its bricks, its first layer and the number of its first model, not
//   on where in a file it stands.
// Consequences
//   Runs that follow each other are put into one file stream by stream, without looking at a brick.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/levels.h"
#include "octavo/core/sha256.h"
#include "octavo/file/write/append_file.h"
#include "octavo/file/write/index_builder.h"
#include "octavo/file/write/journal.h"
#include "octavo/file/write/spool.h"

namespace octavo {

/// Where a run begins: at the start of a group, or inside one.
struct RunStart {
  std::int64_t layer = 0;   ///< of tier 0
  std::uint64_t model = 0;  ///< the number of its first model among those of the file
  std::int64_t place = 0;      ///< of a band: its first brick in the layer
  std::int64_t end_place = 0;  ///< of a band: behind its last; 0: whole layers

  bool is_band() const { return end_place > 0; }
};

/// The streams of a spool that a run needs: one per level of a piece, then that of the pages.
std::size_t run_streams(const Levels& levels);
/// The one of the index pages.
std::size_t page_stream(const Levels& levels);

class RunWriter {
 public:
  /// All but `start` must outlive the writer.
  /// keeps_groups  whether what take_group gives is collected, 8 bytes a brick
  RunWriter(const FileHeader& header, const Levels& levels, AppendFile& out, Spool& spool,
            bool keeps_groups, const RunStart& start = {});

  /// These are BrickSink's.
  void add_model(const Bytes& model);
  void add_brick(int tier, const EncodedBrick& brick);
  void add_plane_digests(std::span<const Sha256Digest> digests);

  /// Ends a group of whole layers of tier 0. Requires keeps_groups.
  /// Returns  what is known of the layers since the group before
  JournalGroup take_group(std::uint32_t voxels_crc);

  /// Ends a band. Requires keeps_groups.
  /// digests  of planes of the layer, which stand in what is returned
  /// Returns  what is known of its bricks: no slab trailer, and of the model where it stands only
  ///          in a band that begins the layer
  JournalGroup take_band(std::uint32_t voxels_crc, std::vector<Sha256Digest> digests);

  /// Goes on behind a group whose bytes stand in `out` and `spool`. Offsets are those in `out`.
  void take_over(const JournalGroup& group);

  const IndexRoot& root() const { return index_.root(); }
  /// Behind the last whole group, of tier 0.
  std::int64_t group_end() const { return group_end_; }
  /// Whether the bricks of all tiers have come.
  bool is_complete() const { return tier_ == levels_.tier_count(); }
  /// The sum of EncodedBrick::squared_error of tier 0, in the order of bricks.
  double squared_error() const { return squared_error_; }
  /// Of the digests of all planes so far, those taken over included.
  Sha256Digest voxel_digest() const;

 private:
  void check_brick(int tier, const EncodedBrick& brick) const;
  std::uint64_t next_code(int tier) const;
  void advance(int tier);
  void append_slab_trailer();
  std::uint64_t model_count() const { return start_.model + index_.root().models.size(); }
  std::int64_t layer_count() const { return levels_.brick_grid(0).z; }

  const FileHeader& header_;
  const Levels& levels_;
  AppendFile& out_;
  Spool& spool_;
  IndexBuilder index_;
  bool keeps_groups_;
  RunStart start_;

  // Where the next brick belongs.
  int tier_ = 0;
  std::int64_t layer_;
  std::int64_t place_;

  double squared_error_ = 0;
  Sha256 planes_hasher_;                    ///< of the digests of all planes before the layer
  std::vector<Sha256Digest> slab_digests_;  ///< of the planes of the layer
  std::vector<std::uint64_t> slab_lengths_;
  std::uint32_t slab_crc_ = 0;

  // Since the last group.
  std::int64_t group_end_;
  std::vector<std::int64_t> group_parents_;
  std::vector<Sha256Digest> group_digests_;
};

}  // namespace octavo
