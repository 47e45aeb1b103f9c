#include "octavo/render/animated_webp.h"

#include <webp/encode.h>
#include <webp/mux.h>

#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr float kWebpQuality = 90;  // of 100
constexpr int kWebpEffort = 4;      // of 6

[[noreturn]] void fail_webp(const char* what) {
  throw Error(ErrorKind::out_of_memory, std::string("no WebP file: ") + what);
}

}  // namespace

struct AnimatedWebp::Encoder {
  std::int64_t width = 0;
  std::int64_t height = 0;
  WebPAnimEncoder* encoder = nullptr;
  WebPConfig config;

  explicit Encoder(const Picture& first) : width(first.width), height(first.height) {
    WebPAnimEncoderOptions options;
    if (WebPAnimEncoderOptionsInit(&options) == 0 ||
        WebPConfigPreset(&config, WEBP_PRESET_DEFAULT, kWebpQuality) == 0) {
      fail_webp("its library is of another version");
    }
    config.method = kWebpEffort;
    encoder = WebPAnimEncoderNew(static_cast<int>(width), static_cast<int>(height), &options);
    if (encoder == nullptr) fail_webp("its encoder does not start");
  }
  ~Encoder() { WebPAnimEncoderDelete(encoder); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
};

AnimatedWebp::AnimatedWebp(int fps) : fps_(fps) {}
AnimatedWebp::~AnimatedWebp() = default;

int AnimatedWebp::frame_ms_at(std::int64_t picture) const {
  return static_cast<int>((1000 * picture + fps_ / 2) / fps_);
}

void AnimatedWebp::add(const Picture& picture) {
  if (picture.width > kLongestSide || picture.height > kLongestSide) {
    throw Error(ErrorKind::limit_exceeded, "a WebP picture has sides of up to 16383 pixels");
  }
  if (!encoder_) encoder_ = std::make_unique<Encoder>(picture);
  if (picture.width != encoder_->width || picture.height != encoder_->height) {
    throw Error(ErrorKind::invalid_argument, "the pictures of an animation have one size");
  }
  const Picture colors = in_colors(picture);
  WebPPicture frame;
  if (WebPPictureInit(&frame) == 0) fail_webp("its library is of another version");
  frame.width = static_cast<int>(colors.width);
  frame.height = static_cast<int>(colors.height);
  frame.use_argb = 1;
  const bool is_added =
      WebPPictureImportRGB(&frame, colors.pixels.data(), static_cast<int>(3 * colors.width)) != 0 &&
      WebPAnimEncoderAdd(encoder_->encoder, &frame, frame_ms_at(added_), &encoder_->config) != 0;
  WebPPictureFree(&frame);
  if (!is_added) fail_webp(WebPAnimEncoderGetError(encoder_->encoder));
  ++added_;
}

Bytes AnimatedWebp::finish() {
  WebPData data;
  WebPDataInit(&data);
  const bool is_whole =
      WebPAnimEncoderAdd(encoder_->encoder, nullptr, frame_ms_at(added_), nullptr) != 0 &&
      WebPAnimEncoderAssemble(encoder_->encoder, &data) != 0;
  Bytes bytes;
  if (is_whole) bytes.assign(data.bytes, data.bytes + data.size);
  WebPDataClear(&data);
  if (!is_whole) fail_webp(WebPAnimEncoderGetError(encoder_->encoder));
  return bytes;
}

}  // namespace octavo
