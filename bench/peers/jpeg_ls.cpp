// JPEG-LS lossless, one slice at a time, by CharLS.

#include <charls/charls.h>

#include "bench/peers/peer.h"

namespace octavo::bench {
namespace {

class JpegLs final : public SlicePeer {
 public:
  std::string name() const override { return "jpeg-ls-charls"; }

 private:
  // Samples of at most 8 bits travel as bytes.
  static constexpr int kMinBits = 2;

  Bytes encode_slice(const Slice& slice) override {
    charls::jpegls_encoder encoder;
    const int bits = std::max(slice.bits, kMinBits);
    encoder.frame_info({slice.width, slice.height, bits, 1});
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
};

}  // namespace

void add_jpeg_ls_peer(Peers& peers) { peers.push_back(std::make_unique<JpegLs>()); }

}  // namespace octavo::bench
