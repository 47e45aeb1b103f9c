#include "octavo/codec/exact/float_places.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <vector>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/codec/entropy/byte_io.h"
#include "octavo/core/error.h"

namespace octavo::exact {

namespace {

constexpr int kExponentBits = 8;
constexpr std::size_t kExponentContexts = 10;

/// What is learned of the voxels in the bin around zero.
struct CentralModels {
  std::array<AdaptiveBit, 8> is_zero;      ///< by the zeros to the left, above and behind
  std::array<AdaptiveBit, 2> is_negative;  ///< by whether it is a zero
  /// A tree of decisions, highest bit first, by how far the exponent before lay below the highest.
  std::array<std::array<AdaptiveBit, 1 << kExponentBits>, kExponentContexts> exponent;
};

/// Which voxels of the bin around zero are zeros; those outside the box are none.
class ZeroFlags {
 public:
  explicit ZeroFlags(const Size3& size)
      : row_(size.x + 1),
        plane_(row_ * (size.y + 1)),
        flags_(static_cast<std::size_t>(plane_ * (size.z + 1))) {}
  std::uint8_t* row(std::int64_t y, std::int64_t z) {
    return flags_.data() + (z + 1) * plane_ + (y + 1) * row_ + 1;
  }
  std::size_t context(const std::uint8_t* at) const {
    return static_cast<std::size_t>(at[-1] | at[-row_] << 1 | at[-plane_] << 2);
  }

 private:
  std::int64_t row_;
  std::int64_t plane_;
  std::vector<std::uint8_t> flags_;
};

/// Codes the ranks of the bin around zero. Coder: bit(model, bit) and plain(value, count) put or
/// get.
template <class Coder>
class CentralPlaces {
 public:
  CentralPlaces(Coder& coder, int short_bits)
      : coder_(coder), mantissa_bits_(kMantissaBits - short_bits) {}

  void start_row() { context_ = 0; }

  /// rank  looked at by an encoder alone
  std::int64_t code(const FloatBin& bin, std::size_t zeros, std::int64_t rank) {
    const std::int64_t magnitude = rank < 0 ? ~rank : rank;
    const bool is_zero = coder_.bit(models_.is_zero[zeros], magnitude == 0);
    const bool is_negative = coder_.bit(models_.is_negative[is_zero ? 1 : 0], rank < 0);
    std::int64_t found = 0;
    if (!is_zero) {
      const std::int64_t exponent = code_exponent(magnitude >> mantissa_bits_);
      const std::int64_t highest = std::max(bin.end - 1, ~bin.first) >> mantissa_bits_;
      const auto below = static_cast<std::uint64_t>(std::max<std::int64_t>(0, highest - exponent));
      context_ = 1 + static_cast<std::size_t>(bit_length(below));
      const std::int64_t mask = (std::int64_t{1} << mantissa_bits_) - 1;
      found = exponent << mantissa_bits_ |
              static_cast<std::int64_t>(
                  coder_.plain(static_cast<std::uint64_t>(magnitude & mask), mantissa_bits_));
    }
    return is_negative ? ~found : found;
  }

 private:
  std::int64_t code_exponent(std::int64_t exponent) {
    auto& tree = models_.exponent[context_];
    std::size_t node = 1;
    for (int i = kExponentBits; i-- > 0;) {
      node = node << 1 | static_cast<std::size_t>(coder_.bit(tree[node], exponent >> i & 1));
    }
    return static_cast<std::int64_t>(node - (std::size_t{1} << kExponentBits));
  }

  Coder& coder_;
  int mantissa_bits_;
  CentralModels models_;
  std::size_t context_ = 0;
};

/// The last float of each code, as far as codes do not share a slot.
class LastOfCode {
 public:
  struct Slot {
    std::int32_t code = 0;
    bool is_set = false;
    bool was_repeated = false;
    std::int64_t rank = 0;

    bool is_of(std::int32_t other) const { return is_set && code == other; }
  };
  Slot& slot_of(std::int32_t code) { return slots_[static_cast<std::uint32_t>(code) % kSlots]; }

 private:
  static constexpr std::size_t kSlots = 4096;
  std::vector<Slot> slots_ = std::vector<Slot>(kSlots);
};

/// Says of voxels that they are the last float of the same code.
template <class Coder>
class Repeats {
 public:
  explicit Repeats(Coder& coder) : coder_(coder) {}

  void start_row() { is_repeating_ = false; }

  /// The rank of the voxel, or nothing where it is not the last of its code.
  std::optional<std::int64_t> code(std::int32_t code, std::int64_t rank) {
    LastOfCode::Slot& slot = last_.slot_of(code);
    AdaptiveBit& model = models_[is_repeating_ ? 1 : 0][slot.was_repeated ? 1 : 0];
    is_repeating_ = slot.is_of(code) && coder_.bit(model, rank == slot.rank);
    slot.was_repeated = is_repeating_;
    return is_repeating_ ? std::optional(slot.rank) : std::nullopt;
  }
  void keep(std::int32_t code, std::int64_t rank) {
    LastOfCode::Slot& slot = last_.slot_of(code);
    slot = {code, true, slot.was_repeated, rank};
  }

 private:
  Coder& coder_;
  LastOfCode last_;
  std::array<std::array<AdaptiveBit, 2>, 2> models_;
  bool is_repeating_ = false;
};

/// How a box is coded.
struct PlaceStyle {
  static constexpr int kRepeatsFlag = 32;

  int short_bits = 0;  ///< mantissa bits that are 0 in all voxels that are present
  bool has_repeats = false;
};

/// One traversal serves both directions: `voxel(i)` gives what an encoder looks at,
/// `take(i, float)` gets what a decoder is after.
template <class Coder, class Voxel, class Take>
void walk_places(const FloatBins& bins, const PlaceBox& box, const PlaceStyle& style,
                 Coder& coder, Voxel&& voxel, Take&& take) {
  CentralPlaces<Coder> central(coder, style.short_bits);
  std::optional<Repeats<Coder>> repeats;
  if (style.has_repeats) repeats.emplace(coder);
  ZeroFlags zeros(box.size);
  // The rank in a bin of more than one float
  const auto code_rank = [&](const FloatBin& bin, const std::uint8_t* zero, std::int64_t rank) {
    if (bin.is_central()) return central.code(bin, zeros.context(zero), rank);
    const int width = bit_length(static_cast<std::uint64_t>(bin.end - bin.first - 1));
    return bin.first + static_cast<std::int64_t>(
                           coder.plain(static_cast<std::uint64_t>(rank - bin.first), width));
  };
  std::size_t i = 0;
  for (std::int64_t z = 0; z < box.size.z; ++z) {
    for (std::int64_t y = 0; y < box.size.y; ++y) {
      std::uint8_t* zero = zeros.row(y, z);
      central.start_row();
      if (repeats) repeats->start_row();
      for (std::int64_t x = 0; x < box.size.x; ++x, ++i, ++zero) {
        if (!box.absent.empty() && box.absent[i] != 0) continue;
        const std::int32_t code = box.codes[i];
        const FloatBin bin = bins.bin_of(code, style.short_bits);
        const std::int64_t rank = short_rank(rank_of(voxel(i)), style.short_bits);
        std::int64_t found = bin.first;
        if (bin.end - bin.first > 1) {
          const auto repeated = repeats ? repeats->code(code, rank) : std::nullopt;
          found = repeated ? *repeated : code_rank(bin, zero, rank);
          if (repeats) repeats->keep(code, found);
          *zero = bin.is_central() && (found == 0 || found == -1);
        }
        if (!bin.contains(found)) throw Error(ErrorKind::corrupt, "a voxel outside its bin");
        take(i, float_of(whole_rank(static_cast<std::int32_t>(found), style.short_bits)));
      }
    }
  }
}

struct PlaceEncoder {
  Bytes decisions;
  Bytes plain_bytes;
  BinaryEncoder coder{decisions};
  BitWriter writer{plain_bytes};
  bool has_decisions = false;

  bool bit(AdaptiveBit& model, bool bit) {
    has_decisions = true;
    put_adaptive(coder, model, bit);
    return bit;
  }
  std::uint64_t plain(std::uint64_t value, int count) {
    writer.put(value, count);
    return value;
  }
};

struct PlaceDecoder {
  BinaryDecoder coder;
  BitReader reader;
  bool has_decisions = false;

  bool bit(AdaptiveBit& model, bool) {
    has_decisions = true;
    return get_adaptive(coder, model);
  }
  std::uint64_t plain(std::uint64_t, int count) { return reader.get(count); }
};

bool is_present(const PlaceBox& box, std::size_t i) {
  return box.absent.empty() || box.absent[i] == 0;
}

int short_bits_of(const PlaceBox& box, std::span<const float> voxels) {
  int bits = kMantissaBits;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const std::uint32_t magnitude = bits_of(voxels[i]) & ~kSignBit;
    if (!is_present(box, i) || magnitude == 0) continue;
    bits = std::min(bits, std::countr_zero(magnitude));
  }
  return bits;
}

/// Whether so many voxels are the last float of their code that saying so may pay.
bool may_repeat(const PlaceBox& box, std::span<const float> voxels) {
  constexpr std::size_t kWorthTrying = 64;
  LastOfCode last;
  std::size_t repeated = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (!is_present(box, i)) continue;
    LastOfCode::Slot& slot = last.slot_of(box.codes[i]);
    const std::int64_t rank = rank_of(voxels[i]);
    if (slot.is_of(box.codes[i]) && slot.rank == rank) ++repeated;
    slot = {box.codes[i], true, false, rank};
  }
  return repeated * kWorthTrying > voxels.size();
}

Bytes encode_in_style(const FloatBins& bins, const PlaceBox& box, const PlaceStyle& style,
                      std::span<const float> voxels) {
  PlaceEncoder encoder;
  walk_places(
      bins, box, style, encoder, [&](std::size_t i) { return voxels[i]; },
      [](std::size_t, float) {});
  if (encoder.has_decisions) encoder.coder.finish();
  encoder.writer.finish();
  Bytes out = {static_cast<std::uint8_t>(style.short_bits |
                                         (style.has_repeats ? PlaceStyle::kRepeatsFlag : 0))};
  put_counted(out, encoder.decisions);
  put_counted(out, encoder.plain_bytes);
  return out;
}

PlaceStyle take_style(ByteSpan& segment) {
  const std::uint8_t byte = take_bytes(segment, 1).front();
  if (byte >= 2 * PlaceStyle::kRepeatsFlag) {
    throw Error(ErrorKind::unsupported_version,
                "a float brick whose places are of a later version of the format");
  }
  const PlaceStyle style{byte % PlaceStyle::kRepeatsFlag, byte >= PlaceStyle::kRepeatsFlag};
  if (style.short_bits > kMantissaBits) {
    throw Error(ErrorKind::corrupt, "places leave out more bits than a mantissa has");
  }
  return style;
}

}  // namespace

Bytes encode_places(const FloatBins& bins, const PlaceBox& box, std::span<const float> voxels) {
  PlaceStyle style{short_bits_of(box, voxels), false};
  Bytes best = encode_in_style(bins, box, style, voxels);
  if (!may_repeat(box, voxels)) return best;
  style.has_repeats = true;
  Bytes other = encode_in_style(bins, box, style, voxels);
  return other.size() < best.size() ? other : best;
}

void decode_places(const FloatBins& bins, const PlaceBox& box, ByteSpan& segment,
                   std::span<float> voxels) {
  const PlaceStyle style = take_style(segment);
  const ByteSpan decisions = take_counted(segment);
  const ByteSpan plain = take_counted(segment);
  PlaceDecoder decoder{BinaryDecoder(decisions), BitReader(plain)};
  walk_places(
      bins, box, style, decoder, [](std::size_t) { return 0.0f; },
      [&](std::size_t i, float voxel) { voxels[i] = voxel; });
  const bool is_whole =
      decoder.has_decisions ? decoder.coder.is_consumed() : decisions.empty();
  if (!is_whole || !decoder.reader.is_consumed()) {
    throw Error(ErrorKind::corrupt, "places of a wrong length");
  }
}

void skip_places(ByteSpan& segment) {
  take_style(segment);
  for (int part = 0; part < 2; ++part) take_counted(segment);
}

}  // namespace octavo::exact
