// Bricks of tier 0 that come row by row, passed on in file order, layer by layer.
//
//   rows of a layer          scratch file             sink
//   0 1 2 3 | 4 5 6 7 | ..   segments as they come    0 1 4 5 2 3 6 7 ..
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/levels.h"
#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/brick_sink.h"

namespace octavo {

/// Memory  8 MiB and 256 bytes per brick of a layer; on disk the encoded layer
class LayerSorter final : public BrickSink {
 public:
  /// All must outlive it. The scratch file stands in `folder`.
  LayerSorter(const Levels& levels, BrickSink& sink, Storage& storage, std::string folder,
              const Progress& progress)
      : levels_(levels),
        sink_(sink),
        storage_(storage),
        folder_(std::move(folder)),
        progress_(progress) {}

  void add_model(const Bytes& model) override { sink_.add_model(model); }

  /// The next brick of the layer, of tier 0: x fastest, then y. Throws Error{io}
  void add_brick(int tier, const EncodedBrick& brick) override;

  /// Nothing: end_layer gets them.
  void add_plane_digests(std::span<const Sha256Digest>) override {}

  /// Takes note of it until the layer ends.
  void end_group(std::uint32_t voxels_crc) override { group_crc_ = voxels_crc; }

  /// Passes on the bricks of a layer, once all have come, and the end of its group where that came.
  /// digests  of the planes of the layer. Throws what the sink throws; Error{io},
  ///          Error{cancelled}
  void end_layer(std::span<const Sha256Digest> digests);

 private:
  struct Held {
    EncodedBrick brick;                  // without segments
    std::vector<std::size_t> lengths;    // of its segments
    std::uint64_t offset = 0;
  };

  void write_held_back();

  const Levels& levels_;
  BrickSink& sink_;
  Storage& storage_;
  std::string folder_;
  const Progress& progress_;
  std::unique_ptr<StorageFile> scratch_;
  std::uint64_t written_ = 0;  // in the scratch file
  Bytes tail_;                 // behind that
  std::vector<Held> held_;     // by row
  std::optional<std::uint32_t> group_crc_;
};

}  // namespace octavo
