// A codec that is measured: voxels in, pieces of bytes out, and back.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/common/raw_volume.h"

namespace octavo::bench {

/// What one volume became: one piece per stream, slice or chunk.
struct Encoded {
  std::vector<Bytes> pieces;
  std::uint64_t extra_bytes = 0;  ///< side information that stands in no piece
  std::uint64_t byte_count() const;
};

class Peer {
 public:
  virtual ~Peer() = default;
  virtual std::string name() const = 0;
  /// False when the codec cannot hold the volume within its bound.
  virtual bool supports(const RawVolume&) const { return true; }
  /// Chooses what depends on the volume; called once before its first run, never timed.
  virtual void prepare(const RawVolume&) {}
  virtual Encoded encode(const RawVolume& volume) = 0;
  /// Fills the voxels of `volume`; its other members are set and its voxels have their final
  /// length.
  virtual void decode(const Encoded& encoded, RawVolume& volume) = 0;
};

using Peers = std::vector<std::unique_ptr<Peer>>;

/// Stops with Error{internal} naming the peer when `ok` is false.
void require(bool ok, const char* what);

// One function per source file; each appends its codecs. Those with a bound keep every decoded
// voxel within `max_error` of its source, in voxel units; 0 is lossless.
void add_general_peers(Peers& peers);                            // gzip, zstd, blosc
void add_jpeg_ls_peer(Peers& peers, std::int64_t max_error);     // CharLS
void add_jpeg2000_peer(Peers& peers);                            // OpenJPEG 5/3
void add_htj2k_peer(Peers& peers);                               // OpenJPH 5/3
void add_jpeg_xl_peers(Peers& peers);                            // libjxl, efforts 3 and 7
void add_zfp_peer(Peers& peers, std::int64_t max_error);         // zfp over the whole volume
void add_octavo_peers(Peers& peers, std::int64_t max_error);     // bricks in memory, whole files

/// A codec of two-dimensional slices of 8 to 16 bit samples: one piece per slice, counted from the
/// smallest voxel so that signed and unsigned volumes are treated alike.
class SlicePeer : public Peer {
 public:
  bool supports(const RawVolume& volume) const override;
  Encoded encode(const RawVolume& volume) override;
  void decode(const Encoded& encoded, RawVolume& volume) override;

 protected:
  struct Slice {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    int bits = 0;
    std::vector<std::uint16_t> samples;
  };
  virtual Bytes encode_slice(const Slice& slice) = 0;
  /// Fills slice.samples, which has its final length.
  virtual void decode_slice(const Bytes& bytes, Slice& slice) = 0;
};

}  // namespace octavo::bench
