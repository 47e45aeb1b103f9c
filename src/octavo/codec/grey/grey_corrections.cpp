#include "octavo/codec/grey/grey_corrections.h"

#include <algorithm>
#include <array>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/core/error.h"

namespace octavo::grey {

namespace {

/// Learns slowly: corrections are few and alike throughout a brick.
using SlowBit = AdaptiveBitOf<7>;

/// Whether a voxel is corrected depends on how many of the 18 voxels around it that come before it
/// are (two to the left, five above, eleven behind), and on the one to the left; its sign on the
/// sum of theirs.
struct CorrectionModels {
  std::array<std::array<SlowBit, 2>, 19> is_corrected;
  std::array<SlowBit, 3> is_negative;
  SlowBit is_larger;
};

/// Corrections with margins, so that neighborhoods need no case at the border.
class PaddedCorrections {
 public:
  explicit PaddedCorrections(const Size3& size)
      : row_(size.x + 4),
        plane_(row_ * (size.y + 2)),
        values_(static_cast<std::size_t>(plane_ * (size.z + 1) + 4)) {}
  std::int8_t* at(std::int64_t y, std::int64_t z) {
    return values_.data() + (z + 1) * plane_ + (y + 1) * row_ + 2;
  }
  std::int64_t row() const { return row_; }
  std::int64_t plane() const { return plane_; }

 private:
  std::int64_t row_;
  std::int64_t plane_;
  std::vector<std::int8_t> values_;
};

/// One traversal serves both directions: `code(model, bit)` puts or gets a decision.
template <class Code>
void walk_corrections(Corrections& corrections, const Size3& size, Code&& code) {
  CorrectionModels models;
  PaddedCorrections padded(size);
  const std::int64_t r = padded.row();
  const std::int64_t p = padded.plane();
  // Those of earlier rows; the two to the left come on the way.
  const std::int64_t above[] = {-r - 2, -r - 1,     -r,     -r + 1, -r + 2, -p - r - 1,
                                -p - r, -p - r + 1, -p - 2, -p - 1, -p,     -p + 1,
                                -p + 2, -p + r - 1, -p + r, -p + r + 1};
  std::vector<std::uint8_t> counts(static_cast<std::size_t>(size.x));
  std::int8_t* out = corrections.data();
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y, out += size.x) {
      std::int8_t* const c = padded.at(y, z);
      // Corrected neighbors in earlier rows, a row at a time
      std::fill(counts.begin(), counts.end(), std::uint8_t{0});
      for (const std::int64_t offset : above) {
        const std::int8_t* const from = c + offset;
        for (std::size_t x = 0; x < counts.size(); ++x) {
          counts[x] = static_cast<std::uint8_t>(counts[x] + (from[x] != 0));
        }
      }
      for (std::int64_t x = 0; x < size.x; ++x) {
        // Is it corrected?
        const std::size_t left = c[x - 1] != 0;
        const std::size_t count = counts[static_cast<std::size_t>(x)] + left + (c[x - 2] != 0);
        int value = out[x];
        if (!code(models.is_corrected[count][left], value != 0)) {
          out[x] = 0;
          continue;
        }
        // Which way, and by how much?
        int sum = c[x - 1] + c[x - 2];
        for (const std::int64_t offset : above) sum += c[x + offset];
        const std::size_t sign = sum < 0 ? 0u : sum == 0 ? 1u : 2u;
        const bool is_negative = code(models.is_negative[sign], value < 0);
        int magnitude = 1;
        while (magnitude < kMaxCorrection &&
               code(models.is_larger, (value < 0 ? -value : value) > magnitude)) {
          ++magnitude;
        }
        value = is_negative ? -magnitude : magnitude;
        out[x] = c[x] = static_cast<std::int8_t>(value);
      }
    }
  }
}

}  // namespace

Bytes encode_corrections(const Corrections& corrections, const Size3& size) {
  Bytes out;
  const auto is_zero = [](std::int8_t c) { return c == 0; };
  if (std::all_of(corrections.begin(), corrections.end(), is_zero)) return out;
  BinaryEncoder coder(out);
  Corrections copy = corrections;
  walk_corrections(copy, size, [&](SlowBit& model, bool bit) {
    put_adaptive(coder, model, bit);
    return bit;
  });
  coder.finish();
  return out;
}

Corrections decode_corrections(ByteSpan bytes, const Size3& size) {
  Corrections corrections(static_cast<std::size_t>(size.voxel_count()));
  if (bytes.empty()) return corrections;
  BinaryDecoder coder(bytes);
  walk_corrections(corrections, size,
                   [&](SlowBit& model, bool) { return get_adaptive(coder, model); });
  if (!coder.is_consumed()) throw Error(ErrorKind::corrupt, "corrections of a wrong length");
  return corrections;
}

}  // namespace octavo::grey
