// JPEG-LS, lossless or near-lossless, one slice at a time, by CharLS.

#include <charls/charls.h>

#include <algorithm>

#include "bench/peers/peer.h"

namespace octavo::bench {
namespace {

class JpegLs final : public SlicePeer {
 public:
  /// max_error  JPEG-LS's NEAR; the standard allows 255 and half of the largest sample
  explicit JpegLs(std::int64_t max_error) : max_error_(max_error) {}
  std::string name() const override { return "jpeg-ls-charls"; }
  bool supports(const RawVolume& volume) const override {
    const std::int64_t top = (std::int64_t{1} << std::max(sample_bits(volume), kMinBits)) - 1;
    return SlicePeer::supports(volume) && max_error_ <= std::min<std::int64_t>(255, top / 2);
  }

 private:
  // Samples of at most 8 bits travel as bytes.
  static constexpr int kMinBits = 2;

  Bytes encode_slice(const Slice& slice) override {
    charls::jpegls_encoder encoder;
    const int bits = std::max(slice.bits, kMinBits);
    encoder.frame_info({slice.width, slice.height, bits, 1});
    encoder.near_lossless(static_cast<std::int32_t>(max_error_));
    Bytes out(encoder.estimated_destination_size());
    encoder.destination(out);
    std::size_t written = 0;
    if (bits <= 8) {
      written = encoder.encode(Bytes(slice.samples.begin(), slice.samples.end()));
    } else {
      written = encoder.encode(slice.samples);
    }
    out.resize(written);
    return out;
  }

  void decode_slice(const Bytes& bytes, Slice& slice) override {
    charls::jpegls_decoder decoder(bytes, true);
    if (std::max(slice.bits, kMinBits) <= 8) {
      Bytes narrow(slice.samples.size());
      decoder.decode(narrow);
      slice.samples.assign(narrow.begin(), narrow.end());
    } else {
      decoder.decode(slice.samples);
    }
  }

  std::int64_t max_error_;
};

}  // namespace

void add_jpeg_ls_peer(Peers& peers, std::int64_t max_error) {
  peers.push_back(std::make_unique<JpegLs>(max_error));
}

}  // namespace octavo::bench
