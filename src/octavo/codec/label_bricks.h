// Bricks of labels as words: what a codec of labels takes and gives besides arrays of voxels.
//
// Bytes and words do not depend on the way taken: a brick's words are encoded to the bytes of its
// voxels, and its bytes decoded to the words of its voxels. Cubes of 4^3 voxels of one label cost a
// step on either way, not 64.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "octavo/codec/brick_codec.h"
#include "octavo/octree/label_words.h"

namespace octavo {

class LabelBrickCodec : public BrickCodec {
 public:
  /// Encodes the brick of these words.
  /// Throws  Error{invalid_argument} for a label that the codec's voxel type does not have
  /// Memory  about 3 bytes per voxel of the brick, 5 more where it is stored, kept for the thread's
  ///         next one; thread-safe
  virtual EncodedBrick encode_words(const BrickShape& shape, const LabelWords& words) const = 0;

  /// Decodes level 0 as words.
  /// Throws  as BrickCodec::decode
  virtual void decode_words(const BrickShape& shape, const ValueRange& range,
                            std::span<const ByteSpan> segments, LabelWords& words) const = 0;
};

/// Throws Error{invalid_argument} for a codec of another kind than labels.
const LabelBrickCodec& as_label_codec(const BrickCodec& codec);

/// Gives the words of brick number `brick`.
using TakeWords = std::function<void(std::size_t brick, LabelWords& words)>;

/// The model that train_label_model makes of the voxels of bricks of these shapes, whose words are
/// taken one after the other.
std::unique_ptr<BrickCodec> train_label_words(VoxelType type, std::span<const BrickShape> shapes,
                                              const TakeWords& take);

}  // namespace octavo
