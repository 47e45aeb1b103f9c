#include "octavo/render/animated_png.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "support/read_png.h"

namespace octavo {
namespace {

struct PngChunk {
  std::string name;
  Bytes content;
};

std::uint32_t number_in(const Bytes& bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
         std::uint32_t{bytes[at + 2]} << 8 | bytes[at + 3];
}

/// Chunks of a file, their checksums proven.
std::vector<PngChunk> chunks_of(const Bytes& file) {
  std::vector<PngChunk> chunks;
  for (std::size_t at = 8; at < file.size();) {
    const std::size_t length = number_in(file, at);
    const auto name = file.begin() + static_cast<std::ptrdiff_t>(at + 4);
    chunks.push_back({std::string(name, name + 4),
                      Bytes(name + 4, name + 4 + static_cast<std::ptrdiff_t>(length))});
    EXPECT_EQ(number_in(file, at + 8 + length),
              crc32(0, file.data() + at + 4, static_cast<uInt>(length + 4)));
    at += 12 + length;
  }
  return chunks;
}

void append_png_chunk(Bytes& file, const std::string& name, const Bytes& content) {
  const auto append = [&](std::size_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
      file.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  };
  append(content.size());
  const std::size_t begin = file.size();
  for (const char letter : name) file.push_back(static_cast<std::uint8_t>(letter));
  for (const std::uint8_t byte : content) file.push_back(byte);
  append(crc32(0, file.data() + begin, static_cast<uInt>(file.size() - begin)));
}

/// The pictures of an animation, each as the still picture that its data are.
std::vector<Picture> pictures_of(const Bytes& file) {
  const std::vector<PngChunk> chunks = chunks_of(file);
  std::vector<Bytes> stills;
  std::uint32_t sequence = 0;
  for (const PngChunk& chunk : chunks) {
    if (chunk.name == "fcTL") {
      EXPECT_EQ(number_in(chunk.content, 0), sequence++);
      Bytes& still = stills.emplace_back(file.begin(), file.begin() + 8);
      append_png_chunk(still, "IHDR", chunks.front().content);
    } else if (chunk.name == "IDAT") {
      append_png_chunk(stills.back(), "IDAT", chunk.content);
    } else if (chunk.name == "fdAT") {
      EXPECT_EQ(number_in(chunk.content, 0), sequence++);
      append_png_chunk(stills.back(), "IDAT",
                       Bytes(chunk.content.begin() + 4, chunk.content.end()));
    }
  }
  std::vector<Picture> pictures;
  for (Bytes& still : stills) {
    append_png_chunk(still, "IEND", {});
    pictures.push_back(testing::read_png(still));
  }
  return pictures;
}

std::vector<Picture> some_pictures(int count) {
  std::vector<Picture> pictures;
  for (int i = 0; i < count; ++i) {
    Picture& picture = pictures.emplace_back(make_picture(301, 200, 3));
    // As noise many chunks of data.
    std::uint32_t noise = static_cast<std::uint32_t>(i) + 1;
    for (std::uint8_t& value : picture.pixels) {
      noise = noise * 1664525 + 1013904223;
      value = static_cast<std::uint8_t>(noise >> 24);
    }
  }
  return pictures;
}

Bytes animation_of(const std::vector<Picture>& pictures, int fps) {
  AnimatedPng animation(static_cast<std::uint32_t>(pictures.size()), fps);
  Bytes file;
  for (const Picture& picture : pictures) {
    const Bytes part = animation.add(picture);
    file.insert(file.end(), part.begin(), part.end());
  }
  return file;
}

TEST(AnimatedPngs, HoldAllPicturesInOrder) {
  for (const int count : {1, 2, 5}) {
    const std::vector<Picture> pictures = some_pictures(count);
    const Bytes file = animation_of(pictures, 24);
    const std::vector<Picture> read = pictures_of(file);
    ASSERT_EQ(read.size(), pictures.size());
    for (std::size_t i = 0; i < read.size(); ++i) EXPECT_EQ(read[i].pixels, pictures[i].pixels);
    // Who knows no animations sees the first.
    EXPECT_EQ(testing::read_png(file).pixels, pictures.front().pixels);
    const std::vector<PngChunk> chunks = chunks_of(file);
    EXPECT_EQ(chunks[1].name, "acTL");
    EXPECT_EQ(number_in(chunks[1].content, 0), static_cast<std::uint32_t>(count));
    EXPECT_EQ(chunks[2].name, "fcTL");
    EXPECT_EQ(number_in(chunks[2].content, 20), 1u << 16 | 24);
    EXPECT_EQ(chunks.back().name, "IEND");
  }
}

TEST(AnimatedPngs, RejectAPictureOfAnotherSize) {
  AnimatedPng animation(2, 10);
  animation.add(make_picture(8, 8, 3));
  EXPECT_THROW(animation.add(make_picture(8, 9, 3)), Error);
}

}  // namespace
}  // namespace octavo
