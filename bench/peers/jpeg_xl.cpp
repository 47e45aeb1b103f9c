// JPEG XL lossless (modular), one slice at a time, by libjxl.

#include <jxl/decode.h>
#include <jxl/decode_cxx.h>
#include <jxl/encode.h>
#include <jxl/encode_cxx.h>

#include "bench/peers/peer.h"

namespace octavo::bench {
namespace {

constexpr JxlPixelFormat kFormat = {1, JXL_TYPE_UINT16, JXL_NATIVE_ENDIAN, 0};

/// libjxl 0.7 takes 16-bit samples as fractions of 65535; these keep every `bits`-bit value exact.
std::uint16_t widened(std::uint16_t value, int bits) {
  const std::uint32_t top = (1u << bits) - 1;
  return static_cast<std::uint16_t>((value * std::uint64_t{65535} + top / 2) / top);
}
std::uint16_t narrowed(std::uint16_t value, int bits) {
  const std::uint32_t top = (1u << bits) - 1;
  return static_cast<std::uint16_t>((value * std::uint64_t{top} + 32767) / 65535);
}

class JpegXl final : public SlicePeer {
 public:
  explicit JpegXl(int effort) : effort_(effort) {}
  std::string name() const override { return "jpeg-xl-e" + std::to_string(effort_); }

 private:
  static void set_up(JxlEncoder* encoder, const Slice& slice, int effort) {
    JxlBasicInfo info;
    JxlEncoderInitBasicInfo(&info);
    info.xsize = slice.width;
    info.ysize = slice.height;
    info.bits_per_sample = static_cast<std::uint32_t>(slice.bits);
    info.num_color_channels = 1;
    info.uses_original_profile = JXL_TRUE;
    require(JxlEncoderSetBasicInfo(encoder, &info) == JXL_ENC_SUCCESS, "JxlEncoderSetBasicInfo");
    JxlColorEncoding color;
    JxlColorEncodingSetToSRGB(&color, JXL_TRUE);
    require(JxlEncoderSetColorEncoding(encoder, &color) == JXL_ENC_SUCCESS,
            "JxlEncoderSetColorEncoding");
    JxlEncoderFrameSettings* frame = JxlEncoderFrameSettingsCreate(encoder, nullptr);
    JxlEncoderSetFrameLossless(frame, JXL_TRUE);
    JxlEncoderFrameSettingsSetOption(frame, JXL_ENC_FRAME_SETTING_EFFORT, effort);
    std::vector<std::uint16_t> wide(slice.samples.size());
    for (std::size_t i = 0; i < wide.size(); ++i) wide[i] = widened(slice.samples[i], slice.bits);
    require(JxlEncoderAddImageFrame(frame, &kFormat, wide.data(), wide.size() * 2) ==
                JXL_ENC_SUCCESS, "JxlEncoderAddImageFrame");
    JxlEncoderCloseInput(encoder);
  }

  Bytes encode_slice(const Slice& slice) override {
    const JxlEncoderPtr encoder = JxlEncoderMake(nullptr);
    set_up(encoder.get(), slice, effort_);
    Bytes out(slice.samples.size() * 2 + 4096);
    std::uint8_t* next = out.data();
    std::size_t left = out.size();
    while (JxlEncoderProcessOutput(encoder.get(), &next, &left) == JXL_ENC_NEED_MORE_OUTPUT) {
      const std::size_t used = out.size() - left;
      out.resize(out.size() * 2);
      next = out.data() + used;
      left = out.size() - used;
    }
    out.resize(out.size() - left);
    return out;
  }

  void decode_slice(const Bytes& bytes, Slice& slice) override {
    const JxlDecoderPtr decoder = JxlDecoderMake(nullptr);
    JxlDecoderSubscribeEvents(decoder.get(), JXL_DEC_FULL_IMAGE);
    JxlDecoderSetInput(decoder.get(), bytes.data(), bytes.size());
    JxlDecoderCloseInput(decoder.get());
    JxlDecoderStatus status = JxlDecoderProcessInput(decoder.get());
    require(status == JXL_DEC_NEED_IMAGE_OUT_BUFFER, "JxlDecoderProcessInput");
    require(JxlDecoderSetImageOutBuffer(decoder.get(), &kFormat, slice.samples.data(),
                                        slice.samples.size() * 2) == JXL_DEC_SUCCESS,
            "JxlDecoderSetImageOutBuffer");
    status = JxlDecoderProcessInput(decoder.get());
    require(status == JXL_DEC_FULL_IMAGE, "JxlDecoderProcessInput");
    for (std::uint16_t& value : slice.samples) value = narrowed(value, slice.bits);
  }

  int effort_;
};

}  // namespace

void add_jpeg_xl_peers(Peers& peers) {
  peers.push_back(std::make_unique<JpegXl>(3));
  peers.push_back(std::make_unique<JpegXl>(7));
}

}  // namespace octavo::bench
