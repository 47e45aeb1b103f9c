#include "octavo/render/animated_png.h"

#include <zlib.h>

#include <algorithm>
#include <string_view>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::size_t kSignatureBytes = 8;
constexpr std::size_t kLengthBytes = 4;
constexpr std::size_t kNameBytes = 4;
constexpr std::size_t kChunkFrame = 12;  // length, name and checksum

void append_number(Bytes& out, std::uint32_t value, int bytes) {
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
    out.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

std::uint32_t number_at(ByteSpan bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | bytes[3];
}

void append_chunk(Bytes& out, std::string_view name, ByteSpan content) {
  append_number(out, static_cast<std::uint32_t>(content.size()), 4);
  const std::size_t checked = out.size();
  out.insert(out.end(), name.begin(), name.end());
  out.insert(out.end(), content.begin(), content.end());
  const auto count = static_cast<uInt>(out.size() - checked);
  append_number(out, static_cast<std::uint32_t>(crc32(0, out.data() + checked, count)), 4);
}

/// Calls visit(name, content) for the chunks of a file of encode_png.
template <class Visit>
void visit_chunks(ByteSpan file, Visit&& visit) {
  for (std::size_t at = kSignatureBytes; at + kChunkFrame <= file.size();) {
    const std::size_t length = number_at(file.subspan(at));
    const auto* const name = reinterpret_cast<const char*>(file.data() + at + kLengthBytes);
    visit(std::string_view(name, kNameBytes),
          file.subspan(at + kLengthBytes + kNameBytes, length));
    at += kChunkFrame + length;
  }
}

}  // namespace

AnimatedPng::AnimatedPng(std::uint32_t pictures, int fps)
    : pictures_(pictures), fps_(std::clamp(fps, 1, 100)) {}

Bytes AnimatedPng::add(const Picture& picture) {
  const Bytes file = encode_png(picture);
  Bytes out;
  const bool is_first = added_ == 0;
  if (is_first) out = Bytes(file.begin(), file.begin() + kSignatureBytes);

  // How the picture takes its turn.
  Bytes control;
  append_number(control, sequence_, 4);
  append_number(control, static_cast<std::uint32_t>(picture.width), 4);
  append_number(control, static_cast<std::uint32_t>(picture.height), 4);
  append_number(control, 0, 4);
  append_number(control, 0, 4);
  append_number(control, 1, 2);
  append_number(control, static_cast<std::uint32_t>(fps_), 2);
  append_number(control, 0, 2);

  visit_chunks(file, [&](std::string_view name, ByteSpan content) {
    if (name == "IHDR") {
      if (is_first) {
        header_ = Bytes(content.begin(), content.end());
        append_chunk(out, name, content);
        Bytes animation;
        append_number(animation, pictures_, 4);
        append_number(animation, 0, 4);
        append_chunk(out, "acTL", animation);
      } else if (!std::equal(content.begin(), content.end(), header_.begin(), header_.end())) {
        throw Error(ErrorKind::invalid_argument, "the pictures of an animation differ in size");
      }
      append_chunk(out, "fcTL", control);
      ++sequence_;
    } else if (name == "IDAT" && is_first) {
      append_chunk(out, name, content);
    } else if (name == "IDAT") {
      Bytes numbered;
      numbered.reserve(4 + content.size());
      append_number(numbered, sequence_++, 4);
      numbered.insert(numbered.end(), content.begin(), content.end());
      append_chunk(out, "fdAT", numbered);
    }
  });
  if (++added_ == pictures_) append_chunk(out, "IEND", {});
  return out;
}

}  // namespace octavo
