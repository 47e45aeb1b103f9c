// Where encoded bricks go: into a file, or into a part of one.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/hasher.h"

namespace octavo {

class BrickSink {
 public:
  virtual ~BrickSink() = default;

  /// Appends a model; the bricks that follow use it. Called before the first brick of a group; a
  /// model before the first brick of tier 1 is that of all tiers above tier 0, which otherwise use
  /// the first one.
  virtual void add_model(const Bytes& model) = 0;

  /// Appends the next brick of `tier`. Bricks of tier 0 come layer by layer (z), inside a layer in
  /// o-code order (see layer_order); after all of them those of tier 1 in the same order, and so
  /// on.
  /// brick.max_error  in steps of the header (error_step); 0 above tier 0
  virtual void add_brick(int tier, const EncodedBrick& brick) = 0;

  /// The SHA-256 of each plane of the layer of tier 0 that is being added, by z, of voxels as they
  /// will be read. Called before the last brick of the layer.
  virtual void add_plane_digests(std::span<const Sha256Digest> digests) = 0;

  /// Ends a group of whole layers of tier 0.
  /// voxels_crc  CRC-32C of the group's voxels, by which they are known again
  virtual void end_group(std::uint32_t voxels_crc) = 0;
};

}  // namespace octavo
