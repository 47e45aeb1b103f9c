#include "octavo/codec/exact/absent_samples.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/core/error.h"

namespace octavo::exact {

namespace {

constexpr std::uint32_t kExponentMask = 0x7f800000;

/// By which power of two an axis is divided.
int shift_of(HalvingMask halving, int axis) { return halving >> axis & 1; }

/// Calls f(place, place of the coarser sample) for the samples of a level in the order z, y, x.
template <class F>
void for_each_parent(const Size3& size, HalvingMask halving, F&& f) {
  const Size3 coarse = halved(size, halving);
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      const std::int64_t row = ((z >> shift_of(halving, 2)) * coarse.y +
                                (y >> shift_of(halving, 1))) * coarse.x;
      for (std::int64_t x = 0; x < size.x; ++x, ++at) {
        f(at, static_cast<std::size_t>(row + (x >> shift_of(halving, 0))));
      }
    }
  }
}

/// What is learned on the way through a level.
struct AbsentModels {
  std::array<AdaptiveBit, 8> is_absent;  ///< by the flags to the left, above and behind
  AdaptiveBit is_other;                  ///< than the absent voxel before
  std::uint32_t last_bits = kUsualNan;
};

/// One traversal serves both directions: `code(model, bit)` puts or gets a decision, `code_bits`
/// 32 of them.
template <class Code, class CodeBits>
void walk_absent(AbsentFlags& flags, const Size3& size, const AbsentFlags& coarse,
                 HalvingMask halving, std::span<std::uint32_t> bits, Code&& code,
                 CodeBits&& code_bits) {
  AbsentModels models;
  const auto row = static_cast<std::size_t>(size.x);
  const auto plane = static_cast<std::size_t>(size.x * size.y);
  for_each_parent(size, halving, [&](std::size_t at, std::size_t parent) {
    if (!coarse.empty() && coarse[parent] != 0) {
      flags[at] = 1;
    } else {
      const std::size_t in_plane = at % plane;
      const unsigned left = in_plane % row > 0 ? flags[at - 1] : 0u;
      const unsigned above = in_plane >= row ? flags[at - row] : 0u;
      const unsigned behind = at >= plane ? flags[at - plane] : 0u;
      flags[at] = code(models.is_absent[left | above << 1 | behind << 2], flags[at] != 0);
    }
    if (flags[at] == 0 || bits.empty()) return;
    if (code(models.is_other, bits[at] != models.last_bits)) {
      models.last_bits = code_bits(bits[at]);
    }
    bits[at] = models.last_bits;
  });
}

}  // namespace

AbsentFlags coarser_flags(const AbsentFlags& fine, const Size3& size, HalvingMask halving) {
  AbsentFlags coarse(static_cast<std::size_t>(halved(size, halving).voxel_count()), 1);
  for_each_parent(size, halving, [&](std::size_t at, std::size_t parent) {
    coarse[parent] = coarse[parent] & fine[at];
  });
  return coarse;
}

Bytes encode_absent(const AbsentFlags& flags, const Size3& size, const AbsentFlags& coarse,
                    HalvingMask halving, std::span<const std::uint32_t> bits) {
  Bytes out;
  BinaryEncoder coder(out);
  AbsentFlags copy = flags;
  std::vector<std::uint32_t> copied_bits(bits.begin(), bits.end());
  walk_absent(
      copy, size, coarse, halving, copied_bits,
      [&](AdaptiveBit& model, bool bit) {
        put_adaptive(coder, model, bit);
        return bit;
      },
      [&](std::uint32_t value) {
        coder.put_bits(value, 32);
        return value;
      });
  coder.finish();
  return out;
}

AbsentFlags decode_absent(ByteSpan bytes, const Size3& size, const AbsentFlags& coarse,
                          HalvingMask halving, std::span<std::uint32_t> bits) {
  AbsentFlags flags(static_cast<std::size_t>(size.voxel_count()));
  BinaryDecoder coder(bytes);
  walk_absent(
      flags, size, coarse, halving, bits,
      [&](AdaptiveBit& model, bool) { return get_adaptive(coder, model); },
      [&](std::uint32_t) {
        const std::uint32_t value = coder.get_bits(32);
        if ((value & kExponentMask) != kExponentMask) {
          throw Error(ErrorKind::corrupt, "an absent voxel is a finite number");
        }
        return value;
      });
  if (!coder.is_consumed()) throw Error(ErrorKind::corrupt, "absent samples of a wrong length");
  return flags;
}

namespace {

/// The samples of a level of a brick as sums over those below them that are present, and how many
/// voxels these stand for; a sample of level 0 is its own sum.
struct PresentLevel {
  std::vector<double> sums;
  std::vector<double> weights;

  bool is_absent(std::size_t at) const { return weights[at] == 0; }
  double mean(std::size_t at) const { return std::nearbyint(sums[at] / weights[at]); }
};

/// Visits the samples of a level with their weights. Calls f(place, place above, weight).
template <class F>
void for_each_weighed(const BrickShape& shape, std::size_t level, F&& f) {
  const SampleWeights weights = weights_of(shape, static_cast<int>(level));
  const Size3& size = shape.size[level];
  Index3 at{0, 0, 0};
  for_each_parent(size, shape.halving[level], [&](std::size_t place, std::size_t parent) {
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const bool is_last = at[axis] + 1 == size[axis];
      weight *= static_cast<double>(is_last ? weights.last[axis] : weights.each[axis]);
    }
    f(place, parent, weight);
    if (++at.x == size.x) at = {0, at.y + 1, at.z};
    if (at.y == size.y) at = {0, 0, at.z + 1};
  });
}

}  // namespace

void fill_absent(const BrickShape& shape, const AbsentFlags& flags,
                 std::vector<std::int32_t>& codes) {
  // Upwards: the rounded means of what is present, level by level to the sample of the next tier
  std::vector<PresentLevel> levels(static_cast<std::size_t>(shape.level_count) + 1);
  levels[0].sums.assign(codes.begin(), codes.end());
  for (const std::uint8_t flag : flags) levels[0].weights.push_back(flag == 0 ? 1 : 0);
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    const PresentLevel& fine = levels[i];
    PresentLevel& coarse = levels[i + 1];
    const auto count =
        static_cast<std::size_t>(halved(shape.size[i], shape.halving[i]).voxel_count());
    coarse.sums.assign(count, 0);
    coarse.weights.assign(count, 0);
    for_each_weighed(shape, i, [&](std::size_t at, std::size_t parent, double weight) {
      if (fine.is_absent(at)) return;
      coarse.sums[parent] += weight * fine.mean(at);
      coarse.weights[parent] += weight;
    });
  }
  // Downwards: what is absent becomes the sample above
  for (std::size_t i = levels.size() - 1; i-- > 0;) {
    PresentLevel& fine = levels[i];
    const PresentLevel& coarse = levels[i + 1];
    for_each_parent(shape.size[i], shape.halving[i], [&](std::size_t at, std::size_t parent) {
      if (!fine.is_absent(at)) return;
      fine.sums[at] = coarse.is_absent(parent) ? 0 : coarse.mean(parent);
      fine.weights[at] = 1;
    });
  }
  for (std::size_t at = 0; at < codes.size(); ++at) {
    codes[at] = static_cast<std::int32_t>(levels[0].sums[at]);
  }
}

}  // namespace octavo::exact
