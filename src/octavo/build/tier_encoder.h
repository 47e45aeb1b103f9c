// Encodes the bricks of a block with all workers and hands them to the writer in file order.
//
// Every brick is decoded again, with a codec parsed from the model's bytes, and compared before it
// is kept. At most four bricks per thread are held encoded; the writer is called by one thread at a
// time.
#pragma once

#include <memory>
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

class TierEncoder {
 public:
  /// All but `tier` and `type` must outlive the encoder.
  TierEncoder(const Levels& levels, int tier, VoxelType type, Workers& workers, FileWriter& writer,
              Progress& progress);

  /// Encodes the next block of the tier. Throws Error{internal} naming the first brick that does
  /// not decode to its voxels; Error{cancelled}; what the writer throws.
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
  std::vector<std::byte> parents_;
};

}  // namespace octavo
