// Encodes the bricks of blocks with all workers and hands them to the writer in file order.
//
// Bricks of the next block follow those of the last without a pause: no worker waits for another.
// Each brick is work of its own, so that training for the next block finds threads in between.
// Every brick is decoded again, with a codec parsed from the model's bytes, and compared before it
// is kept: it must be the same, or within the bound with its largest difference measured. At most
// four bricks per thread are held encoded; the writer is called by one thread at a time.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/builder/voxel_block.h"
#include "octavo/builder/workers.h"
#include "octavo/core/progress.h"
#include "octavo/file/write/brick_sink.h"

namespace octavo {

/// A trained codec and the one that a reader of its bytes will have.
struct Model {
  std::shared_ptr<const BrickCodec> encoder;
  std::shared_ptr<const BrickCodec> decoder;
  Bytes serialized;
};

/// type          of the numbers in bricks
/// coding        of float32 voxels
/// detail_level  as CodecSettings::detail_level
/// Throws        Error{internal} when the bytes of the model do not parse.
Model make_model(std::unique_ptr<BrickCodec> codec, VoxelType type,
                 const std::optional<SampleCoding>& coding = std::nullopt, int detail_level = 0);

/// How far the voxels of a tier may end up from those that came in.
struct ErrorBound {
  std::int64_t codes = 0;              ///< of the integers that bricks hold; 0: none may differ
  double voxels = 0;                   ///< of float voxels, where the block has them
  std::optional<SampleCoding> coding;  ///< that turns integers into those float voxels
  double proposal = 0;                 ///< real units, for when float32 cannot keep the bound
  /// Where details are left out any voxel may differ, but none of a level from this one on; the
  /// squares of the differences are summed up.
  int detail_level = 0;

  bool is_lossless() const { return codes == 0 && detail_level == 0; }
};

/// Throws Error{internal} that names a brick which does not decode to its voxels.
/// why  the end of the fact: " (a segment is too short)", or nothing
[[noreturn]] void fail_brick(int tier, const Index3& brick, const std::string& why);

class TierEncoder {
 public:
  /// All but `tier`, `type` and `bound` must outlive the encoder.
  TierEncoder(const Levels& levels, int tier, VoxelType type, Workers& workers, BrickSink& sink,
              Progress& progress, const ErrorBound& bound = {});

  /// Waits for the bricks that are being encoded and drops the rest.
  ~TierEncoder();

  TierEncoder(const TierEncoder&) = delete;
  TierEncoder& operator=(const TierEncoder&) = delete;

  /// Takes the samples of bricks that need no encoding, the first ones of the tier in file order.
  void restore_parents(std::span<const std::int64_t> parents);

  /// Starts to encode the next block of the tier, or of a band its bricks, behind those started
  /// before. Bands are of tier 0; their bricks hold then what they became.
  /// brings_model  gives the model to the writer before the block's first brick, and ends a group
  ///               behind its last
  /// when_done     called once, from any thread, when the block is not looked at any more
  void start(const Model& model, const VoxelBlock& block, bool brings_model,
             std::function<void()> when_done);

  /// Throws as finish() what has gone wrong so far.
  void check();

  /// Waits until the writer has the bricks of all blocks. Throws Error{internal} naming the first
  /// brick that does not decode to its voxels, within the bound; Error{source_rejected} when the
  /// float voxels of a brick are too large for the bound; Error{cancelled}; what the writer throws.
  void finish();

  /// Encodes the next block with a model that the writer has, and waits for it.
  void encode(const Model& model, const VoxelBlock& block);

  /// The samples of the next tier, [z][y][x] of the volume's type, once all blocks are encoded.
  std::vector<std::byte> take_parents() { return std::move(parents_); }

 private:
  struct Work {
    Model model;
    VoxelBlock block;
    bool brings_model;
    std::function<void()> when_done;
    std::vector<Index3> bricks;
    std::size_t first = 0;  ///< the first of them among those of the block
    std::size_t all = 0;    ///< bricks of the block
    std::size_t taken = 0;
    std::size_t kept = 0;

    /// Of the brick that is kept next.
    std::size_t number() const { return first + kept; }
  };

  /// A brick between its worker and the writer.
  struct Slot {
    bool is_ready = false;
    EncodedBrick encoded;
    std::exception_ptr failure;
  };

  // These run under the lock; the last one leaves it while it is with the writer.
  void take_bricks();
  void release_if_failed();
  void keep_ready(std::unique_lock<std::mutex>& lock);

  void work_on(const Work& work, std::size_t place, std::size_t number);
  EncodedBrick encode_checked(const Work& work, std::size_t place) const;
  void measure_errors(EncodedBrick& encoded, const BrickView& view,
                      const std::vector<std::byte>& dense, const Index3& brick) const;
  void keep(Work& work, Slot slot);
  void add_plane_digests(const Work& work);
  void store_parent(const Index3& brick, std::int64_t parent);
  void count_progress(const Work& work);

  const Levels& levels_;
  int tier_;
  VoxelType type_;
  Workers& workers_;
  BrickSink& sink_;
  Progress& progress_;
  ErrorBound bound_;
  std::vector<std::byte> parents_;
  std::size_t restored_ = 0;  // bricks that need no encoding
  std::vector<Index3> layer_;  // the order of bricks in a layer, once one was restored

  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<Work> works_;   // blocks with bricks that are not kept, in order
  std::vector<Slot> slots_;  // by number modulo their count: at most as many are under way
  std::size_t taken_ = 0;    // bricks given to workers
  std::size_t kept_ = 0;     // bricks the writer has
  int running_ = 0;          // bricks with a worker
  bool is_keeping_ = false;  // a worker is with the writer
  std::exception_ptr failure_;
};

}  // namespace octavo
