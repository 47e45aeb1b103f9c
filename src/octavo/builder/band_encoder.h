// Encodes groups that memory does not hold, band by band.
//
//   lossless     runs of bricks in file order; their planes were hashed when they were read first
//   otherwise    rows of bricks, since planes are hashed as they come out, row by row; a sorter
//                brings the bricks of a layer into file order
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/builder/band_reader.h"
#include "octavo/builder/build_outline.h"
#include "octavo/builder/layer_sorter.h"
#include "octavo/builder/tier_encoder.h"
#include "octavo/builder/workers.h"
#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/brick_sink.h"

namespace octavo {

/// How bands are cut for such a build.
BandCut band_cut(const BuildOutline& outline, std::uint64_t band_bytes);

class BandEncoder {
 public:
  /// All must outlive it.
  /// folder  of scratch files
  BandEncoder(const BuildOutline& outline, Workers& workers, BrickSink& sink, Storage& storage,
              const std::string& folder, Progress& progress);

  /// Encodes the next group, read by nobody yet, and waits for it: while a band is being encoded
  /// the next one is read. Throws as BandReader::next, TierEncoder::finish and the sink
  void encode(std::shared_ptr<BandReader> bands, const Model& model);

  /// As TierEncoder.
  void restore_parents(std::span<const std::int64_t> parents) { encoder_.restore_parents(parents); }
  std::vector<std::byte> take_parents() { return encoder_.take_parents(); }

 private:
  void end_band();

  const BuildOutline& outline_;
  Workers& workers_;
  std::optional<LayerSorter> sorter_;              // where voxels may differ
  std::vector<std::unique_ptr<Hasher>> hashers_;   // of the planes of the layer, then
  const BrickBand* started_ = nullptr;             // the band that is being encoded
  std::shared_ptr<BandReader> bands_;              // longer than who encodes its bricks
  TierEncoder encoder_;
};

}  // namespace octavo
