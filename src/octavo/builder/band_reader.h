// A group of planes that is larger than memory, read some bricks at a time.
//
// The planes are read several times: once to learn what depends on all of them (checksum, digests,
// which bricks are uniform), once for the bricks that a model is trained on, once for each band: a
// run of bricks in file order. Uniform bricks take no room in a band. The bricks are those that a
// block of all planes has, so that the file is the same, whatever bands hold.
//
// Who encodes a share of the bricks alone reads less often: where the share fits into one band, it
// is picked up as the planes are read first. So are the bricks that a model is trained on, by a
// guess that the bricks which are uniform in the first plane are so in all; where others are
// needed, planes are read once more for them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/builder/float_planes.h"
#include "octavo/builder/voxel_block.h"
#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/core/progress.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// What of a group its reader gives, where others give the rest.
struct BrickShare {
  std::size_t first = 0;  ///< the first brick, in file order
  std::size_t end = 0;    ///< behind the last
  std::int64_t first_plane = 0;  ///< the first plane of the group that is hashed
  std::int64_t end_plane = 0;
  bool is_trained_on = true;     ///< whether training_bricks will be asked for
};

/// What a band is.
struct BandCut {
  std::uint64_t bytes = 1;  ///< of voxels that it may hold; one brick or row of them anyhow
  /// Whether it holds rows of bricks of a layer, since encoding changes voxels; otherwise a run of
  /// bricks in file order.
  bool is_rows = false;
  /// The source where bricks hold its floats beside their codes; then it holds rows.
  const FloatPlanes* floats = nullptr;
  /// All bricks, where it is not there; otherwise bands hold runs of bricks.
  std::optional<BrickShare> share = {};
};

class BandReader {
 public:
  /// Reads planes first .. end, a group, and learns of them what `group` says. `source`,
  /// which is sought here and whose planes bricks hold as they are, `levels` and `progress` must
  /// outlive it.
  /// Throws what the source throws; Error{cancelled}
  /// Memory  a plane, two bands (floats beside codes count), and 192 bytes per brick; of a share
  ///         that fits into one band this and the training bricks
  BandReader(PlaneSource& source, const Levels& levels, std::int64_t first, std::int64_t end,
             const BandCut& cut, Progress& progress);

  /// Time the source took.
  double read_seconds() const { return read_seconds_; }

  /// The group without its voxels.
  const VoxelBlock& group() const { return group_; }

  /// Those that a model of the group is trained on. They last until the first band is read, of a
  /// share until the second.
  std::vector<TrainingBrick> training_bricks();

  /// The digests of the planes that a share has hashed.
  const std::vector<Sha256Digest>& share_digests() const { return digests_; }

  /// True when all bands were given.
  bool is_done() const { return next_ == end_; }

  /// The next band. It lasts until the one behind the next is read. Throws as the constructor.
  BrickBand& next();

 private:
  void hash_plane(Hasher& hasher, std::int64_t z, ByteSpan bytes);
  void make_room_ahead();
  void guess_training_bricks();
  void keep_ahead(std::int64_t z);
  void end_ahead();
  std::vector<std::size_t> training_numbers() const;
  bool take_training_ahead();
  std::uint64_t whole_bytes_of(std::size_t brick) const;
  BrickBand& training_band() { return bands_[cut_.share ? 1 : 0]; }
  void look_at(std::int64_t z);
  void read_plane();
  bool is_a_row(std::size_t brick) const;
  std::vector<std::byte> room_for(std::size_t brick) const;
  std::size_t end_of_step(std::size_t first) const;
  std::uint64_t bytes_of(std::size_t brick) const;
  void read_planes_of(BrickBand& band);
  void copy_plane(std::int64_t z, BrickBand& band);
  void read_bricks(BrickBand& band);
  BrickView view_of_brick(std::size_t brick, const std::vector<std::byte>& voxels) const;
  const std::byte* row_at(const Index3& at) const;

  PlaneSource& source_;
  const Levels& levels_;
  Progress& progress_;
  BandCut cut_;
  std::int64_t width_;  // bytes of a voxel
  VoxelBlock group_;
  UnsetBytes plane_;
  std::vector<Sha256Digest> digests_;
  std::vector<Index3> bricks_;            // in file order
  std::vector<std::size_t> order_;        // in which bands hold them
  std::vector<std::uint8_t> is_uniform_;  // by brick
  std::vector<std::byte> values_;         // the first voxel of each brick
  std::array<BrickBand, 2> bands_;
  std::size_t turn_ = 0;
  double read_seconds_ = 0;
  std::size_t next_ = 0;  // the first brick of the next band, in their order
  std::size_t end_ = 0;   // behind the last of all bands
  bool has_band_ahead_ = false;      // the first band holds the share already
  bool has_training_ahead_ = false;  // the other one what a model is trained on
};

}  // namespace octavo
