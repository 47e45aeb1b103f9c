// Encodes the bricks of a block with all workers and hands them to the writer in file order.
//
// Every brick is decoded again, with a codec parsed from the model's bytes, and compared before it
// is kept: it must be the same, or within the bound with its largest difference measured. At most
// four bricks per thread are held encoded; the writer is called by one thread at a time.
#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "octavo/build/voxel_block.h"
#include "octavo/build/workers.h"
#include "octavo/core/progress.h"
#include "octavo/file/writer.h"

namespace octavo {

/// A trained codec and the one that a reader of its bytes will have.
struct Model {
  std::shared_ptr<const BrickCodec> encoder;
  std::shared_ptr<const BrickCodec> decoder;
  Bytes serialized;
};

/// Throws Error{internal} when the bytes of the model do not parse.
Model make_model(std::unique_ptr<BrickCodec> codec, VoxelType type);

/// How far the voxels of a tier may end up from those that came in.
struct ErrorBound {
  std::int64_t codes = 0;              ///< of the integers that bricks hold; 0: none may differ
  double voxels = 0;                   ///< of float voxels, where the block has them
  std::optional<SampleCoding> coding;  ///< that turns integers into those float voxels
  double proposal = 0;                 ///< real units, for when float32 cannot keep the bound
};

class TierEncoder {
 public:
  /// All but `tier`, `type` and `bound` must outlive the encoder.
  TierEncoder(const Levels& levels, int tier, VoxelType type, Workers& workers, FileWriter& writer,
              Progress& progress, const ErrorBound& bound = {});

  /// Encodes the next block of the tier. Throws Error{internal} naming the first brick that does
  /// not decode to its voxels, within the bound; Error{source_rejected} when the float voxels of a
  /// brick are too large for the bound; Error{cancelled}; what the writer throws.
  void encode(const Model& model, const VoxelBlock& block);

  /// The samples of the next tier, [z][y][x] of the volume's type, once all blocks are encoded.
  std::vector<std::byte> take_parents() { return std::move(parents_); }

 private:
  EncodedBrick encode_checked(const Model& model, const VoxelBlock& block,
                              const Index3& brick) const;
  void keep(const Index3& brick, const EncodedBrick& encoded);

  const Levels& levels_;
  int tier_;
  VoxelType type_;
  Workers& workers_;
  FileWriter& writer_;
  Progress& progress_;
  ErrorBound bound_;
  std::vector<std::byte> parents_;
};

}  // namespace octavo
