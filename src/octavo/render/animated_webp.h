// Pictures one after the other in one WebP file, again and again.
//
// Colors are kept to a few levels of 255; the same pictures give the same bytes with the same
// library.
#pragma once

#include <cstdint>
#include <memory>

#include "octavo/core/bytes.h"
#include "octavo/render/picture.h"

namespace octavo {

class AnimatedWebp {
 public:
  /// No side of a picture may be longer, pixels.
  static constexpr std::int64_t kLongestSide = 16383;

  /// fps  1 .. 100
  explicit AnimatedWebp(int fps);
  ~AnimatedWebp();
  AnimatedWebp(const AnimatedWebp&) = delete;
  AnimatedWebp& operator=(const AnimatedWebp&) = delete;

  /// Adds one more picture. All have the size of the first one.
  /// Throws Error{invalid_argument} for another size, Error{limit_exceeded} for a longer side,
  ///        Error{out_of_memory}
  void add(const Picture& picture);

  /// The file. Requires a picture. Throws as add.
  Bytes finish();

 private:
  struct Encoder;

  int frame_ms_at(std::int64_t picture) const;

  int fps_;
  std::int64_t added_ = 0;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace octavo
