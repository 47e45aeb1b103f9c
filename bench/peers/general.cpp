// Codecs of plain bytes: zlib as .nii.gz uses it, Zstandard, and blosc chunks as Zarr uses them.

#include <blosc.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>

#include "bench/peers/peer.h"

namespace octavo::bench {
namespace {

class Gzip final : public Peer {
 public:
  std::string name() const override { return "gzip-6"; }

  Encoded encode(const RawVolume& volume) override {
    const auto length = static_cast<uLong>(volume.voxels.size());
    Bytes out(compressBound(length));
    auto written = static_cast<uLongf>(out.size());
    require(compress2(out.data(), &written, volume.voxels.data(), length, 6) == Z_OK, "compress2");
    out.resize(written);
    return {{std::move(out)}, 12};  // a gzip member has 12 bytes more than a zlib stream
  }

  void decode(const Encoded& encoded, RawVolume& volume) override {
    const Bytes& in = encoded.pieces[0];
    auto written = static_cast<uLongf>(volume.voxels.size());
    require(uncompress(volume.voxels.data(), &written, in.data(), static_cast<uLong>(in.size())) ==
                Z_OK, "uncompress");
  }
};

class Zstandard final : public Peer {
 public:
  explicit Zstandard(int level) : level_(level) {}
  std::string name() const override { return "zstd-" + std::to_string(level_); }

  Encoded encode(const RawVolume& volume) override {
    Bytes out(ZSTD_compressBound(volume.voxels.size()));
    const std::size_t written = ZSTD_compress(out.data(), out.size(), volume.voxels.data(),
                                              volume.voxels.size(), level_);
    require(!ZSTD_isError(written), "ZSTD_compress");
    out.resize(written);
    return {{std::move(out)}};
  }

  void decode(const Encoded& encoded, RawVolume& volume) override {
    const Bytes& in = encoded.pieces[0];
    const std::size_t written =
        ZSTD_decompress(volume.voxels.data(), volume.voxels.size(), in.data(), in.size());
    require(written == volume.voxels.size(), "ZSTD_decompress");
  }

 private:
  int level_;
};

/// blosc over chunks of 64^3 voxels, clipped at the border.
class BloscChunks final : public Peer {
 public:
  /// coder    "zstd" or "lz4"
  /// shuffle  BLOSC_SHUFFLE (bytes) or BLOSC_BITSHUFFLE
  BloscChunks(const char* coder, int shuffle, int level)
      : coder_(coder), shuffle_(shuffle), level_(level) {}
  std::string name() const override {
    const char* order = shuffle_ == BLOSC_SHUFFLE ? "shuffle" : "bitshuffle";
    return std::string("blosc-") + coder_ + "-" + order + "-" + std::to_string(level_);
  }

  Encoded encode(const RawVolume& volume) override {
    Encoded encoded;
    Bytes chunk, out;
    for_each_chunk(volume.size, [&](const Box& box) {
      chunk.resize(chunk_bytes(volume, box));
      copy_rows(volume, box, [&](std::size_t voxel, std::size_t in_chunk, std::size_t length) {
        std::memcpy(chunk.data() + in_chunk, volume.voxels.data() + voxel, length);
      });
      out.resize(chunk.size() + BLOSC_MAX_OVERHEAD);
      const int written = blosc_compress_ctx(
          level_, shuffle_, static_cast<std::size_t>(volume.voxel_bytes()), chunk.size(),
          chunk.data(), out.data(), out.size(), coder_, 0, 1);
      require(written > 0, "blosc_compress_ctx");
      encoded.pieces.emplace_back(out.begin(), out.begin() + written);
    });
    return encoded;
  }

  void decode(const Encoded& encoded, RawVolume& volume) override {
    std::size_t index = 0;
    Bytes chunk;
    for_each_chunk(volume.size, [&](const Box& box) {
      chunk.resize(chunk_bytes(volume, box));
      const int written = blosc_decompress_ctx(encoded.pieces[index++].data(), chunk.data(),
                                               chunk.size(), 1);
      require(written == static_cast<int>(chunk.size()), "blosc_decompress_ctx");
      copy_rows(volume, box, [&](std::size_t voxel, std::size_t in_chunk, std::size_t length) {
        std::memcpy(volume.voxels.data() + voxel, chunk.data() + in_chunk, length);
      });
    });
  }

 private:
  static constexpr std::int64_t kSide = 64;

  template <class Visit>
  static void for_each_chunk(const Size3& size, Visit visit) {
    for (std::int64_t z = 0; z < size.z; z += kSide) {
      for (std::int64_t y = 0; y < size.y; y += kSide) {
        for (std::int64_t x = 0; x < size.x; x += kSide) {
          visit(intersection({{x, y, z}, {x + kSide, y + kSide, z + kSide}}, box_of(size)));
        }
      }
    }
  }

  static std::size_t chunk_bytes(const RawVolume& volume, const Box& box) {
    return static_cast<std::size_t>(box.size().voxel_count() * volume.voxel_bytes());
  }

  /// Calls copy(offset in the volume, offset in the chunk, bytes) for every row of `box`.
  template <class Copy>
  static void copy_rows(const RawVolume& volume, const Box& box, Copy copy) {
    const auto row = static_cast<std::size_t>(box.size().x * volume.voxel_bytes());
    std::size_t in_chunk = 0;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, in_chunk += row) {
        const std::int64_t voxel = (z * volume.size.y + y) * volume.size.x + box.lo.x;
        copy(static_cast<std::size_t>(voxel * volume.voxel_bytes()), in_chunk, row);
      }
    }
  }

  const char* coder_;
  int shuffle_;
  int level_;
};

}  // namespace

void add_general_peers(Peers& peers) {
  peers.push_back(std::make_unique<Gzip>());
  peers.push_back(std::make_unique<Zstandard>(3));
  peers.push_back(std::make_unique<Zstandard>(19));
  peers.push_back(std::make_unique<BloscChunks>("lz4", BLOSC_SHUFFLE, 5));
  peers.push_back(std::make_unique<BloscChunks>("zstd", BLOSC_SHUFFLE, 5));
  peers.push_back(std::make_unique<BloscChunks>("zstd", BLOSC_BITSHUFFLE, 5));
  peers.push_back(std::make_unique<BloscChunks>("zstd", BLOSC_SHUFFLE, 9));
}

}  // namespace octavo::bench
