#include "octavo/ops/mask_kernels.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "octavo/codec/simd_targets.h"
#include "octavo/core/voxel_type.h"
#include "octavo/core/word_steps.h"
#include "octavo/ops/moment_sums.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/ops/mask_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Bit i says whether lowest <= row[i] <= highest, for 64 voxels.
template <class T>
HWY_INLINE std::uint64_t bits_of_run(const T* row, T lowest, T highest) {
  const hn::CappedTag<T, 64 / sizeof(T)> d;
  constexpr std::size_t kLanes = MaxLanes(d);
  constexpr std::uint64_t kKept =
      kLanes >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << kLanes % 64) - 1;
  const auto low = hn::Set(d, lowest);
  const auto high = hn::Set(d, highest);
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(kMaskRun); i += kLanes) {
    const auto voxels = hn::LoadU(d, row + i);
    // Also for NaN, which equals nothing.
    const auto inside = hn::Eq(hn::Min(hn::Max(voxels, low), high), voxels);
    std::uint8_t bytes[64] = {};
    hn::StoreMaskBits(d, inside, bytes);
    std::uint64_t some;
    std::memcpy(&some, bytes, sizeof some);
    bits |= (some & kKept) << i;
  }
  return bits;
}

template <class T>
HWY_INLINE void rows_of(const BrickView& block, T lowest, T highest, std::uint64_t* rows) {
  const auto* const voxels = static_cast<const T*>(block.voxels);
  const auto count = static_cast<std::size_t>(block.size.x);
  for (std::int64_t z = 0; z < block.size.z; ++z) {
    for (std::int64_t y = 0; y < block.size.y; ++y) {
      const T* row = voxels + z * block.plane_stride + y * block.row_stride;
      std::uint64_t kept = ~std::uint64_t{0};
      T padded[kMaskRun];
      if (count < static_cast<std::size_t>(kMaskRun)) {
        std::fill(std::copy_n(row, count, padded), padded + kMaskRun, T{0});
        row = padded;
        kept = (std::uint64_t{1} << count) - 1;
      }
      rows[4 * z + y] = bits_of_run(row, lowest, highest) & kept;
    }
  }
}

void find_rows(const BrickView& block, const void* lowest, const void* highest,
               std::uint64_t* rows) {
  with_voxel_type(block.type, [&](auto id) HWY_ATTR {
    using T = typename decltype(id)::type;
    rows_of(block, *static_cast<const T*>(lowest), *static_cast<const T*>(highest), rows);
  });
}

// The bits whose coordinate on an axis is 1 or 3, and those where it is 2 or 3.
constexpr std::uint64_t odd_bits(std::size_t axis) {
  return slab_of(static_cast<int>(axis), 1) | slab_of(static_cast<int>(axis), 3);
}
constexpr std::uint64_t high_bits(std::size_t axis) {
  return slab_of(static_cast<int>(axis), 2) | slab_of(static_cast<int>(axis), 3);
}
constexpr std::uint64_t kOdd[3] = {odd_bits(0), odd_bits(1), odd_bits(2)};
constexpr std::uint64_t kHigh[3] = {high_bits(0), high_bits(1), high_bits(2)};

HWY_INLINE std::int64_t count_of(std::uint64_t word) { return std::popcount(word); }

HWY_INLINE SmallSums sums_of_one(std::uint64_t word) {
  SmallSums sums;
  sums.count = count_of(word);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::uint64_t odd = word & kOdd[a];
    const std::uint64_t high = word & kHigh[a];
    sums.first[a] = count_of(odd) + 2 * count_of(high);
    sums.second[a] = count_of(odd) + 4 * count_of(high) + 4 * count_of(odd & high);
  }
  for (std::size_t i = 3; i < 6; ++i) {
    const std::size_t a = MomentSums::kPairs[i][0];
    const std::size_t b = MomentSums::kPairs[i][1];
    const std::uint64_t odd = word & kOdd[a];
    const std::uint64_t high = word & kHigh[a];
    sums.second[i] = count_of(odd & kOdd[b]) + 2 * count_of(odd & kHigh[b]) +
                     2 * count_of(high & kOdd[b]) + 4 * count_of(high & kHigh[b]);
  }
  return sums;
}

void add_words(std::uint64_t mixed, const std::uint64_t* words, SmallSums& all) {
  for (std::uint64_t left = mixed; left != 0; left &= left - 1) {
    const auto bit = static_cast<std::size_t>(std::countr_zero(left));
    const SmallSums sums = sums_of_one(*words++);
    std::int64_t corner[3];
    for (std::size_t a = 0; a < 3; ++a) {
      corner[a] =
          static_cast<std::int64_t>(4 * (bit >> kLowPlace[a] & 1) + 8 * (bit >> kHighPlace[a] & 1));
      all.first[a] += sums.first[a] + corner[a] * sums.count;
    }
    for (std::size_t i = 0; i < 6; ++i) {
      const std::size_t a = MomentSums::kPairs[i][0];
      const std::size_t b = MomentSums::kPairs[i][1];
      all.second[i] += sums.second[i] + corner[a] * sums.first[b] + corner[b] * sums.first[a] +
                       corner[a] * corner[b] * sums.count;
    }
    all.count += sums.count;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo {

HWY_EXPORT(find_rows);
HWY_EXPORT(add_words);

void rows_in_window(const BrickView& block, const void* lowest, const void* highest,
                    std::array<std::uint64_t, 16>& rows) {
  rows.fill(0);
  HWY_DYNAMIC_DISPATCH(find_rows)(block, lowest, highest, rows.data());
}

SmallSums sums_of_words(std::uint64_t mixed, const std::uint64_t* words) {
  SmallSums all;
  HWY_DYNAMIC_DISPATCH(add_words)(mixed, words, all);
  return all;
}

SmallSums sums_of_bits(std::uint64_t word) { return sums_of_words(1, &word); }

}  // namespace octavo
#endif  // HWY_ONCE
