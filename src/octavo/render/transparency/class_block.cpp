#include "octavo/render/transparency/class_block.h"

#include <algorithm>
#include <cstring>

namespace octavo {

ClassBlock::ClassBlock() : classes_(std::size_t{1} << 3 * kLevel) {
  for (int level = 1; level <= kLevel; ++level) {
    flags_[static_cast<std::size_t>(level)].resize(std::size_t{1} << 3 * (kLevel - level));
  }
}

void ClassBlock::reset(const Size3& size) { size_ = size; }

void ClassBlock::condense() {
  flag_pairs();
  for (int level = 2; level <= kLevel; ++level) flag_level(level);
}

// Octants of voxels: four rows of pairs, each pair one number of 32 bits.
void ClassBlock::flag_pairs() {
  constexpr std::int64_t kPairs = kSide / 2;
  std::vector<std::uint8_t>& flags = flags_[1];
  std::fill(flags.begin(), flags.end(), std::uint8_t{0});
  for (std::int64_t z = 0; z + 1 < size_.z; z += 2) {
    for (std::int64_t y = 0; y + 1 < size_.y; y += 2) {
      std::uint32_t rows[4][kPairs];
      for (std::int64_t i = 0; i < 4; ++i) {
        const std::int64_t row = (z + i / 2) * kSide + y + i % 2;
        std::memcpy(rows[i], classes_.data() + row * kSide, sizeof rows[i]);
      }
      std::uint8_t* const out = flags.data() + (z / 2 * kPairs + y / 2) * kPairs;
      for (std::int64_t x = 0; x < size_.x / 2; ++x) {
        const std::uint32_t first = rows[0][x];
        const std::uint32_t turned = first << 16 | first >> 16;
        const std::uint32_t differs =
            (first ^ turned) | (first ^ rows[1][x]) | (first ^ rows[2][x]) | (first ^ rows[3][x]);
        out[x] = differs == 0 ? 1 : 0;
      }
    }
  }
}

// A cube is of one class when its octants are, and agree. An octant outside the box has no flag.
void ClassBlock::flag_level(int level) {
  const std::vector<std::uint8_t>& below = flags_[static_cast<std::size_t>(level - 1)];
  std::vector<std::uint8_t>& flags = flags_[static_cast<std::size_t>(level)];
  const std::int64_t cells = kSide >> level;
  const std::int64_t half = std::int64_t{1} << (level - 1);
  for (std::int64_t z = 0; z < cells; ++z) {
    for (std::int64_t y = 0; y < cells; ++y) {
      for (std::int64_t x = 0; x < cells; ++x) {
        bool is_one = true;
        std::uint16_t first = 0;
        for (std::int64_t i = 0; i < 8 && is_one; ++i) {
          const Index3 c{2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2)};
          const std::uint16_t class_id = at(c.x * half, c.y * half, c.z * half);
          if (i == 0) first = class_id;
          const auto cell = static_cast<std::size_t>((c.z * 2 * cells + c.y) * 2 * cells + c.x);
          is_one = below[cell] != 0 && class_id == first;
        }
        flags[static_cast<std::size_t>((z * cells + y) * cells + x)] = is_one ? 1 : 0;
      }
    }
  }
}

}  // namespace octavo
