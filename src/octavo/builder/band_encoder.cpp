#include "octavo/builder/band_encoder.h"

#include <algorithm>
#include <utility>

#include "octavo/builder/crypto_hasher.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

bool is_changed(const BuildOutline& outline) {
  return outline.writing.max_error > 0 || outline.bound.detail_level > 0;
}

/// Adds the rows that a band of rows of bricks has of a plane, counted from the layer's first one.
/// coding  makes floats of them, if given
void hash_rows(const Levels& levels, const BrickBand& band, std::int64_t plane,
               const std::optional<SampleCoding>& coding, Hasher& hasher) {
  const auto row_bricks = static_cast<std::size_t>(levels.brick_grid(0).x);
  Bytes row;
  std::vector<float> floats;
  for (std::size_t first = 0; first < band.bricks.size(); first += row_bricks) {
    const std::int64_t height = band.views[first].size.y;
    for (std::int64_t y = 0; y < height; ++y) {
      row.clear();
      for (std::size_t i = first; i < first + row_bricks; ++i) {
        const BrickView& view = band.views[i];
        const std::int64_t width = view.size.x * bytes_per_voxel(view.type);
        const auto* const at =
            static_cast<const std::uint8_t*>(view.voxels) + (plane * height + y) * width;
        row.insert(row.end(), at, at + width);
      }
      if (!coding) {
        hasher.add(row);
        continue;
      }
      floats.resize(row.size() / sizeof(std::int32_t));
      decode_samples(*coding, reinterpret_cast<const std::byte*>(row.data()), floats);
      hasher.add({reinterpret_cast<const std::uint8_t*>(floats.data()),
                  floats.size() * sizeof(float)});
    }
  }
}

}  // namespace

BandCut band_cut(const BuildOutline& outline, std::uint64_t band_bytes) {
  return {band_bytes, is_changed(outline), outline.float_voxels()};
}

BandEncoder::BandEncoder(const BuildOutline& outline, Workers& workers, BrickSink& sink,
                         Storage& storage, const std::string& folder, Progress& progress)
    : outline_(outline),
      workers_(workers),
      sorter_(is_changed(outline)
                  ? std::make_optional<LayerSorter>(outline.levels, sink, storage, folder, progress)
                  : std::nullopt),
      encoder_(outline.levels, 0, outline.description.codec_type(), workers,
               sorter_ ? static_cast<BrickSink&>(*sorter_) : sink, progress, outline.bound) {}

void BandEncoder::encode(std::shared_ptr<BandReader> bands, const Model& model) {
  bands_ = std::move(bands);
  while (!bands_->is_done()) {
    VoxelBlock block = bands_->group();
    block.band = &bands_->next();
    end_band();
    encoder_.start(model, block, true, {});
    started_ = block.band;
  }
  end_band();
}

// Waits for the band that is being encoded and hashes what its voxels have become.
void BandEncoder::end_band() {
  encoder_.finish();
  const BrickBand* const band = std::exchange(started_, nullptr);
  if (!sorter_ || band == nullptr) return;
  const Levels& levels = outline_.levels;
  const std::int64_t planes = band->views.front().size.z;
  while (hashers_.size() < static_cast<std::size_t>(planes)) {
    hashers_.push_back(make_crypto_hasher());
  }
  const std::optional<SampleCoding> coding = outline_.bound.coding;
  workers_.run([&] {
    parallel_for(std::int64_t{0}, planes, [&](std::int64_t plane) {
      hash_rows(levels, *band, plane, coding, *hashers_[static_cast<std::size_t>(plane)]);
    });
  });
  if (band->bricks.back().y + 1 < levels.brick_grid(0).y) return;
  std::vector<Sha256Digest> digests;
  for (const auto& hasher : hashers_) digests.push_back(hasher->digest());
  hashers_.clear();
  sorter_->end_layer(digests);
}

}  // namespace octavo
