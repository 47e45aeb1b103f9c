// Pictures one after the other in one PNG file, again and again.
//
//     signature  IHDR  acTL | fcTL IDAT... | fcTL fdAT... | fcTL fdAT... | ...  IEND
//
// Programs that know nothing of animations show the first picture.
//
// Source  Portable Network Graphics Specification, third edition (W3C 2025)
#pragma once

#include <cstdint>

#include "octavo/core/bytes.h"
#include "octavo/render/picture.h"

namespace octavo {

class AnimatedPng {
 public:
  /// pictures  how many there will be, at least 1
  /// fps       1 .. 100
  AnimatedPng(std::uint32_t pictures, int fps);

  /// The bytes of the file from where the last call ended, with one more picture. All have the
  /// size and the channels of the first one.
  /// Throws Error{invalid_argument} for another size, and as encode_png
  Bytes add(const Picture& picture);

 private:
  std::uint32_t pictures_;
  int fps_;
  std::uint32_t added_ = 0;
  std::uint32_t sequence_ = 0;  // of fcTL and fdAT
  Bytes header_;                // the IHDR of all
};

}  // namespace octavo
