// JPEG 2000 lossless (5/3 wavelet), one slice at a time, by OpenJPEG.

#include <openjpeg.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "bench/peers/peer.h"

namespace octavo::bench {
namespace {

/// A growing byte string that OpenJPEG writes to or reads from.
struct Memory {
  Bytes bytes;
  std::size_t position = 0;
};

OPJ_SIZE_T write_memory(void* data, OPJ_SIZE_T length, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  memory.bytes.resize(std::max(memory.bytes.size(), memory.position + length));
  std::memcpy(memory.bytes.data() + memory.position, data, length);
  memory.position += length;
  return length;
}

OPJ_SIZE_T read_memory(void* data, OPJ_SIZE_T length, void* user) {
  auto& memory = *static_cast<Memory*>(user);
  const std::size_t count = std::min(length, memory.bytes.size() - memory.position);
  if (count == 0) return static_cast<OPJ_SIZE_T>(-1);
  std::memcpy(data, memory.bytes.data() + memory.position, count);
  memory.position += count;
  return count;
}

OPJ_OFF_T skip_memory(OPJ_OFF_T length, void* user) {
  static_cast<Memory*>(user)->position += static_cast<std::size_t>(length);
  return length;
}

OPJ_BOOL seek_memory(OPJ_OFF_T position, void* user) {
  static_cast<Memory*>(user)->position = static_cast<std::size_t>(position);
  return OPJ_TRUE;
}

// Stream and codec are both `void` to the compiler, so each has its own way to end.
struct DestroyStream {
  void operator()(opj_stream_t* stream) const { opj_stream_destroy(stream); }
};
struct DestroyCodec {
  void operator()(opj_codec_t* codec) const { opj_destroy_codec(codec); }
};
struct DestroyImage {
  void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};
using Stream = std::unique_ptr<opj_stream_t, DestroyStream>;
using Codec = std::unique_ptr<opj_codec_t, DestroyCodec>;
using Image = std::unique_ptr<opj_image_t, DestroyImage>;

Stream stream_over(Memory& memory, bool reading) {
  Stream stream(opj_stream_default_create(reading ? OPJ_TRUE : OPJ_FALSE));
  opj_stream_set_user_data(stream.get(), &memory, nullptr);
  opj_stream_set_user_data_length(stream.get(), memory.bytes.size());
  opj_stream_set_write_function(stream.get(), write_memory);
  opj_stream_set_read_function(stream.get(), read_memory);
  opj_stream_set_skip_function(stream.get(), skip_memory);
  opj_stream_set_seek_function(stream.get(), seek_memory);
  return stream;
}

/// Levels of the wavelet: 5, fewer where the slice is smaller than 64.
int resolution_count(std::uint32_t width, std::uint32_t height) {
  return std::clamp(static_cast<int>(std::bit_width(std::min(width, height))), 1, 6);
}

class Jpeg2000 final : public SlicePeer {
 public:
  std::string name() const override { return "jpeg2000-openjpeg"; }

 private:
  Bytes encode_slice(const Slice& slice) override {
    opj_cparameters_t parameters;
    opj_set_default_encoder_parameters(&parameters);
    parameters.tcp_numlayers = 1;
    parameters.tcp_rates[0] = 0;
    parameters.cp_disto_alloc = 1;
    parameters.numresolution = resolution_count(slice.width, slice.height);

    opj_image_cmptparm_t component{};
    component.dx = component.dy = 1;
    component.w = slice.width;
    component.h = slice.height;
    component.prec = static_cast<OPJ_UINT32>(slice.bits);
    Image image(opj_image_create(1, &component, OPJ_CLRSPC_GRAY));
    require(image != nullptr, "opj_image_create");
    image->x1 = slice.width;
    image->y1 = slice.height;
    std::copy(slice.samples.begin(), slice.samples.end(), image->comps[0].data);

    Memory memory;
    Codec codec(opj_create_compress(OPJ_CODEC_J2K));
    require(opj_setup_encoder(codec.get(), &parameters, image.get()), "opj_setup_encoder");
    const Stream stream = stream_over(memory, false);
    require(opj_start_compress(codec.get(), image.get(), stream.get()), "opj_start_compress");
    require(opj_encode(codec.get(), stream.get()), "opj_encode");
    require(opj_end_compress(codec.get(), stream.get()), "opj_end_compress");
    return memory.bytes;
  }

  void decode_slice(const Bytes& bytes, Slice& slice) override {
    Memory memory{bytes, 0};
    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    Codec codec(opj_create_decompress(OPJ_CODEC_J2K));
    require(opj_setup_decoder(codec.get(), &parameters), "opj_setup_decoder");
    const Stream stream = stream_over(memory, true);
    opj_image_t* header = nullptr;
    require(opj_read_header(stream.get(), codec.get(), &header), "opj_read_header");
    const Image image(header);
    require(opj_decode(codec.get(), stream.get(), image.get()), "opj_decode");
    const OPJ_INT32* data = image->comps[0].data;
    std::transform(data, data + slice.samples.size(), slice.samples.begin(),
                   [](OPJ_INT32 value) { return static_cast<std::uint16_t>(value); });
  }
};

}  // namespace

void add_jpeg2000_peer(Peers& peers) { peers.push_back(std::make_unique<Jpeg2000>()); }

}  // namespace octavo::bench
