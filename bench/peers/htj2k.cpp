// High-throughput JPEG 2000 lossless (5/3 wavelet), one slice at a time, by OpenJPH.

#include <openjph/ojph_arg.h>
#include <openjph/ojph_mem.h>
#include <openjph/ojph_file.h>
#include <openjph/ojph_codestream.h>
#include <openjph/ojph_params.h>

#include "bench/peers/peer.h"

namespace octavo::bench {
namespace {

class HighThroughput final : public SlicePeer {
 public:
  std::string name() const override { return "htj2k-openjph"; }

 private:
  Bytes encode_slice(const Slice& slice) override {
    ojph::codestream stream;
    ojph::param_siz siz = stream.access_siz();
    siz.set_image_extent(ojph::point(slice.width, slice.height));
    siz.set_num_components(1);
    siz.set_component(0, ojph::point(1, 1), static_cast<ojph::ui32>(slice.bits), false);
    ojph::param_cod cod = stream.access_cod();
    cod.set_num_decomposition(5);
    cod.set_block_dims(64, 64);
    cod.set_reversible(true);
    cod.set_color_transform(false);
    stream.set_planar(true);

    ojph::mem_outfile out;
    out.open();
    stream.write_headers(&out);
    ojph::ui32 component = 0;
    ojph::line_buf* line = stream.exchange(nullptr, component);
    for (std::uint32_t y = 0; y < slice.height; ++y) {
      const std::uint16_t* row = slice.samples.data() + std::size_t{y} * slice.width;
      std::copy(row, row + slice.width, line->i32);
      line = stream.exchange(line, component);
    }
    stream.flush();
    const auto length = static_cast<std::size_t>(out.tell());
    Bytes bytes(out.get_data(), out.get_data() + length);
    stream.close();
    return bytes;
  }

  void decode_slice(const Bytes& bytes, Slice& slice) override {
    ojph::mem_infile in;
    in.open(bytes.data(), bytes.size());
    ojph::codestream stream;
    stream.read_headers(&in);
    stream.set_planar(true);
    stream.create();
    ojph::ui32 component = 0;
    for (std::uint32_t y = 0; y < slice.height; ++y) {
      const ojph::line_buf* line = stream.pull(component);
      std::uint16_t* row = slice.samples.data() + std::size_t{y} * slice.width;
      for (std::uint32_t x = 0; x < slice.width; ++x) {
        row[x] = static_cast<std::uint16_t>(line->i32[x]);
      }
    }
    stream.close();
  }
};

}  // namespace

void add_htj2k_peer(Peers& peers) { peers.push_back(std::make_unique<HighThroughput>()); }

}  // namespace octavo::bench
