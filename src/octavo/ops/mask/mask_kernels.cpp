#include "octavo/ops/mask/mask_kernels.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "octavo/codec/simd_targets.h"
#include "octavo/core/voxel_type.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/octree/word_steps.h"
#include "octavo/ops/measure/moment_sums.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/ops/mask/mask_kernels.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Bit i of the word at `to` says whether lowest <= row[i] <= highest. The next word may be written
// as well.
#if HWY_TARGET == HWY_SCALAR

template <class T>
HWY_INLINE void store_bits(const T* row, T lowest, T highest, std::uint64_t* to) {
  *to = 0;
  for (std::int64_t i = 0; i < kMaskRun; ++i) {
    const bool is_inside = lowest <= row[i] && row[i] <= highest;
    *to |= std::uint64_t{is_inside} << i;
  }
}

#else

constexpr hn::CappedTag<std::uint8_t, 64> kBytes{};
constexpr std::size_t kByteLanes = MaxLanes(kBytes);

// As many bytes as a vector has: 255 where lowest <= row[i] <= highest, else 0.
template <class T>
HWY_INLINE hn::VFromD<decltype(kBytes)> bytes_in_window(const T* row, T lowest, T highest) {
  const hn::Repartition<T, decltype(kBytes)> d;
  const auto low = hn::Set(d, lowest);
  const auto high = hn::Set(d, highest);
  const auto part = [&](std::size_t i) HWY_ATTR {
    const auto voxels = hn::LoadU(d, row + i * MaxLanes(d));
    // Also for NaN, which equals nothing.
    const auto inside = hn::Eq(hn::Min(hn::Max(voxels, low), high), voxels);
    return hn::BitCast(kBytes, hn::VecFromMask(d, inside));
  };
  static_assert(sizeof(T) <= 4);
  if constexpr (sizeof(T) == 1) {
    return part(0);
  } else if constexpr (sizeof(T) == 2) {
    return hn::ConcatEven(kBytes, part(1), part(0));
  } else {
    const hn::Repartition<std::uint16_t, decltype(kBytes)> pairs;
    const auto joined = [&](std::size_t i) HWY_ATTR {
      return hn::BitCast(kBytes, hn::ConcatEven(pairs, hn::BitCast(pairs, part(i + 1)),
                                                hn::BitCast(pairs, part(i))));
    };
    return hn::ConcatEven(kBytes, joined(2), joined(0));
  }
}

template <class T>
HWY_INLINE void store_bits(const T* row, T lowest, T highest, std::uint64_t* to) {
  auto* const bytes = reinterpret_cast<std::uint8_t*>(to);
  for (std::size_t i = 0; i < static_cast<std::size_t>(kMaskRun); i += kByteLanes) {
    const auto inside = hn::MaskFromVec(bytes_in_window(row + i, lowest, highest));
    hn::StoreMaskBits(kBytes, inside, bytes + i / 8);
  }
}

#endif  // HWY_TARGET == HWY_SCALAR

template <class T>
HWY_INLINE void rows_of(const BrickView& block, T lowest, T highest, std::uint64_t* rows,
                        std::size_t stride) {
  const std::int64_t whole = block.size.x / kMaskRun;
  const auto rest = static_cast<std::size_t>(block.size.x % kMaskRun);
  for (std::int64_t z = 0; z < block.size.z; ++z) {
    for (std::int64_t y = 0; y < block.size.y; ++y) {
      const T* row =
          static_cast<const T*>(block.voxels) + z * block.plane_stride + y * block.row_stride;
      std::uint64_t* to = rows + static_cast<std::size_t>(4 * z + y) * stride;
      for (std::int64_t run = 0; run < whole; ++run, row += kMaskRun) {
        // The rows of the next block: prefetchers of the processor stop at the end of a page.
        const auto* const ahead = reinterpret_cast<const char*>(row + 4 * block.row_stride);
        for (std::size_t i = 0; i < kMaskRun * sizeof(T); i += 64) hwy::Prefetch(ahead + i);
        store_bits(row, lowest, highest, to++);
      }
      if (rest == 0) continue;
      T padded[kMaskRun];
      std::fill(std::copy_n(row, rest, padded), padded + kMaskRun, T{0});
      store_bits(padded, lowest, highest, to);
      *to &= (std::uint64_t{1} << rest) - 1;
    }
  }
}

void find_rows(const BrickView& block, const void* lowest, const void* highest, std::uint64_t* rows,
               std::size_t stride) {
  with_voxel_type(block.type, [&](auto id) HWY_ATTR {
    using T = typename decltype(id)::type;
    rows_of(block, *static_cast<const T*>(lowest), *static_cast<const T*>(highest), rows, stride);
  });
}

constexpr hn::CappedTag<std::uint64_t, kMaskRunsAtOnce> kRuns{};
using Runs = hn::VFromD<decltype(kRuns)>;

// Exchanges those bits of b that `mask` has with those of a that are `shift` places further up.
HWY_INLINE void exchange(Runs& a, Runs& b, int shift, std::uint64_t mask) {
  const Runs other = hn::And(hn::Xor(hn::ShiftRightSame(a, shift), b), hn::Set(kRuns, mask));
  b = hn::Xor(b, other);
  a = hn::Xor(a, hn::ShiftLeftSame(other, shift));
}

// The same within a word.
HWY_INLINE Runs exchanged(Runs word, int shift, std::uint64_t mask) {
  const Runs other = hn::And(hn::Xor(hn::ShiftRightSame(word, shift), word), hn::Set(kRuns, mask));
  return hn::Xor(word, hn::Xor(other, hn::ShiftLeftSame(other, shift)));
}

// Sixteen rows of sixteen times four voxels, as words of the voxels of four in all rows.
HWY_INLINE void transpose(Runs (&rows)[16]) {
  constexpr std::uint64_t kLowHalves[4] = {0x0f0f0f0f0f0f0f0fu, 0x00ff00ff00ff00ffu,
                                           0x0000ffff0000ffffu, 0x00000000ffffffffu};
  for (std::size_t stage = 0; stage < 4; ++stage) {
    const std::size_t step = std::size_t{1} << stage;
    for (std::size_t row = 0; row < 16; ++row) {
      if ((row & step) != 0) continue;
      exchange(rows[row], rows[row + step], static_cast<int>(4 * step), kLowHalves[stage]);
    }
  }
}

void find_words(const std::uint64_t* rows, std::size_t stride, std::size_t count,
                std::uint64_t* words) {
  for (std::size_t run = 0; run < count; run += MaxLanes(kRuns)) {
    Runs all[16];
    Runs any = hn::Zero(kRuns);
    Runs each = hn::Set(kRuns, kFullWord);
    for (std::size_t row = 0; row < 16; ++row) {
      // In the order z1 y0 y1 z0 of the bits of the coordinates: two exchanges then give o-codes.
      const std::size_t place = (row & 8) | (row << 2 & 4) | (row & 2) | (row >> 2 & 1);
      const Runs bits = hn::LoadU(kRuns, rows + row * stride + run);
      all[place] = bits;
      any = hn::Or(any, bits);
      each = hn::And(each, bits);
    }
    // Most runs lie wholly in or out of the mask: all their rows are as their words will be.
    const auto is_out = hn::Eq(any, hn::Zero(kRuns));
    const auto is_in = hn::Eq(each, hn::Set(kRuns, kFullWord));
    if (!hn::AllTrue(kRuns, hn::Or(is_out, is_in))) {
      transpose(all);
      for (Runs& word : all) {
        word = exchanged(word, 14, 0x0000cccc0000ccccu);
        word = exchanged(word, 1, 0x2222222222222222u);
      }
    }
    for (std::size_t i = 0; i < 16; ++i) hn::StoreU(all[i], kRuns, words + i * stride + run);
  }
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
HWY_EXPORT(find_words);
HWY_EXPORT(add_words);

void words_of_rows(const std::uint64_t* rows, std::size_t stride, std::size_t count,
                   std::uint64_t* words) {
  HWY_DYNAMIC_DISPATCH(find_words)(rows, stride, count, words);
}

RunRows::RunRows(std::int64_t width)
    : runs_(static_cast<std::size_t>((width + kMaskRun - 1) / kMaskRun)),
      // What is loaded and stored at once may reach behind the last run.
      stride_(runs_ + kMaskRunsAtOnce),
      rows_(16 * stride_),
      words_(16 * stride_) {}

void RunRows::take(const BrickView& block, const void* lowest, const void* highest) {
  if (block.size.y < 4 || block.size.z < 4) std::fill(rows_.begin(), rows_.end(), 0);
  HWY_DYNAMIC_DISPATCH(find_rows)(block, lowest, highest, rows_.data(), stride_);
  words_of_rows(rows_.data(), stride_, runs_, words_.data());
}

SmallSums sums_of_words(std::uint64_t mixed, const std::uint64_t* words) {
  SmallSums all;
  HWY_DYNAMIC_DISPATCH(add_words)(mixed, words, all);
  return all;
}

SmallSums sums_of_bits(std::uint64_t word) { return sums_of_words(1, &word); }

}  // namespace octavo
#endif  // HWY_ONCE
