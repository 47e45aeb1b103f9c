// Rows of a picture whose pixels are taken once: the first face that meets a pixel has it.
//
// Drawn from the nearest cube to the farthest, a picture is the one that painting over from the
// farthest gives, and what is hidden is known before it is drawn: one bit per pixel says whether it
// is taken.
//
//     row y   words of 64 columns   1111 1111 0001 1110 ...   1: taken
//
// Spines of thin cubes have rows of their own, in front of the faces that are drawn later.
//
// Source  hierarchical visibility: Greene, Hierarchical polygon tiling with coverage masks, 1996
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/render/cubes/face_raster.h"

namespace octavo {

class NearestRows {
 public:
  /// Draws into `rows`, and spines into `spines`, where 0 is no pixel of one. They must outlive
  /// this.
  explicit NearestRows(PixelRows& rows, PixelRows* spines = nullptr)
      : rows_(rows),
        spines_(spines),
        words_((rows.width() + 63) / 64),
        taken_(static_cast<std::size_t>(words_ * (rows.end() - rows.begin()))) {}

  /// Whether no pixel of the box around a cube's outline is in the picture and free.
  bool misses(const CubeShape& shape, const Place& corner) const {
    const PixelBox box = rows_.pixels_of(shape, corner);
    if (box.is_empty()) return true;
    for (std::int64_t y = box.top; y < box.bottom; ++y) {
      const std::uint64_t* const taken = row(y);
      for (std::int64_t word = box.left / 64; word * 64 < box.right; ++word) {
        if ((columns(word, box.left, box.right) & ~taken[word]) != 0) return false;
      }
    }
    return true;
  }

  /// Gives the pixels of a face of the cube at `corner` that none has taken a color; false where
  /// all are taken.
  bool fill(const Face& face, const Place& corner, std::uint32_t pixel) {
    bool is_seen = false;
    rows_.for_each_run(face, corner, [&](std::int64_t y, std::int64_t left, std::int64_t right) {
      std::uint64_t* const taken = row(y);
      std::uint32_t* const to = rows_.row(y);
      for (std::int64_t word = left / 64; word * 64 < right; ++word) {
        std::uint64_t free = columns(word, left, right) & ~taken[word];
        taken[word] |= free;
        is_seen |= free != 0;
        for (; free != 0; free &= free - 1) to[64 * word + std::countr_zero(free)] = pixel;
      }
    });
    return is_seen;
  }

  /// The same for the pixels of its spine in the rows of spines.
  bool fill_spine(const CubeShape& shape, const Place& corner, std::uint32_t pixel) {
    bool is_seen = false;
    rows_.for_each_spine_pixel(shape, corner, [&](std::int64_t y, std::int64_t x) {
      std::uint32_t& to = spines_->row(y)[x];
      if ((row(y)[x / 64] >> (x % 64) & 1) != 0 || to != 0) return;
      to = pixel;
      is_seen = true;
    });
    return is_seen;
  }

 private:
  /// The bits of columns left .. right - 1 in a word that has some of them.
  static std::uint64_t columns(std::int64_t word, std::int64_t left, std::int64_t right) {
    std::uint64_t bits = ~std::uint64_t{0};
    if (left > 64 * word) bits <<= left - 64 * word;
    if (right < 64 * word + 64) bits &= ~std::uint64_t{0} >> (64 * word + 64 - right);
    return bits;
  }

  const std::uint64_t* row(std::int64_t y) const {
    return taken_.data() + (y - rows_.begin()) * words_;
  }
  std::uint64_t* row(std::int64_t y) { return taken_.data() + (y - rows_.begin()) * words_; }

  PixelRows& rows_;
  PixelRows* spines_;
  std::int64_t words_;  ///< per row
  std::vector<std::uint64_t> taken_;
};

/// What a pixel shows, of the numbers of a face and a spine, from 1: a spine is seen in front of
/// other masks and of nothing. Of its own mask the outline is what faces make it.
template <class MaskOf>
std::uint32_t seen_number(std::uint32_t face, std::uint32_t spine, const MaskOf& mask_of) {
  const bool is_spine = spine != 0 && (face == 0 || mask_of(face) != mask_of(spine));
  return is_spine ? spine : face;
}

}  // namespace octavo
