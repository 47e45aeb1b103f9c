// zfp over the whole volume: reversible on integers, or fixed accuracy on floats.

#include <zfp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "bench/peers/peer.h"
#include "bench/peers/voxel_errors.h"

namespace octavo::bench {
namespace {

using StreamPtr = std::unique_ptr<zfp_stream, decltype(&zfp_stream_close)>;
using FieldPtr = std::unique_ptr<zfp_field, decltype(&zfp_field_free)>;
using BitsPtr = std::unique_ptr<bitstream, decltype(&stream_close)>;

/// Calls visit(voxel index, value of the voxel), x fastest.
template <class Visit>
void for_each_voxel(const RawVolume& volume, Visit visit) {
  with_voxel_type(volume.type, [&]<class T>(std::type_identity<T>) {
    const std::size_t count = volume.voxels.size() / sizeof(T);
    for (std::size_t i = 0; i < count; ++i) {
      T value;
      std::memcpy(&value, volume.voxels.data() + i * sizeof(T), sizeof(T));
      visit(i, value);
    }
  });
}

/// Fills the voxels of `volume` with value_of(voxel index), which fits their type.
template <class Value>
void fill_voxels(RawVolume& volume, Value value_of) {
  with_voxel_type(volume.type, [&]<class T>(std::type_identity<T>) {
    const std::size_t count = volume.voxels.size() / sizeof(T);
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = static_cast<T>(value_of(i));
      std::memcpy(volume.voxels.data() + i * sizeof(T), &value, sizeof(T));
    }
  });
}

std::size_t voxel_count(const RawVolume& volume) {
  return static_cast<std::size_t>(volume.size.voxel_count());
}

FieldPtr field_of(const RawVolume& volume, void* values, zfp_type type) {
  return {zfp_field_3d(values, type, static_cast<std::size_t>(volume.size.x),
                       static_cast<std::size_t>(volume.size.y),
                       static_cast<std::size_t>(volume.size.z)),
          zfp_field_free};
}

/// One stream for the volume; `set_mode` chooses the mode of a zfp_stream.
template <class SetMode>
Bytes compressed(const RawVolume& volume, void* values, zfp_type type, SetMode set_mode) {
  const StreamPtr zfp(zfp_stream_open(nullptr), zfp_stream_close);
  set_mode(zfp.get());
  const FieldPtr field = field_of(volume, values, type);
  Bytes out(zfp_stream_maximum_size(zfp.get(), field.get()));
  const BitsPtr bits(stream_open(out.data(), out.size()), stream_close);
  zfp_stream_set_bit_stream(zfp.get(), bits.get());
  const std::size_t written = zfp_compress(zfp.get(), field.get());
  require(written > 0, "zfp_compress");
  out.resize(written);
  return out;
}

template <class SetMode>
void decompress(const Bytes& bytes, const RawVolume& volume, void* values, zfp_type type,
                SetMode set_mode) {
  const StreamPtr zfp(zfp_stream_open(nullptr), zfp_stream_close);
  set_mode(zfp.get());
  const FieldPtr field = field_of(volume, values, type);
  // zfp only reads here; its stream type is the one for writing.
  const BitsPtr bits(stream_open(const_cast<std::uint8_t*>(bytes.data()), bytes.size()),
                     stream_close);
  zfp_stream_set_bit_stream(zfp.get(), bits.get());
  require(zfp_decompress(zfp.get(), field.get()) > 0, "zfp_decompress");
}

/// The reversible mode on 32-bit integers. Voxels are centered on their range and scaled to fill 31
/// bits, as zfp's own promotions of 8- and 16-bit integers do: zfp drops low zero bits for nothing.
class Reversible final : public Peer {
 public:
  std::string name() const override { return "zfp-reversible"; }
  bool supports(const RawVolume& volume) const override {
    return is_integer(volume.type) && sample_bits(volume) <= kBits;
  }

  Encoded encode(const RawVolume& volume) override {
    const std::int64_t center = center_of(volume), scale = scale_of(volume);
    std::vector<std::int32_t> values(voxel_count(volume));
    for_each_voxel(volume, [&](std::size_t i, auto voxel) {
      values[i] = static_cast<std::int32_t>((static_cast<std::int64_t>(voxel) - center) * scale);
    });
    return {{compressed(volume, values.data(), zfp_type_int32, zfp_stream_set_reversible)}};
  }

  void decode(const Encoded& encoded, RawVolume& volume) override {
    const std::int64_t center = center_of(volume), scale = scale_of(volume);
    std::vector<std::int32_t> values(voxel_count(volume));
    decompress(encoded.pieces[0], volume, values.data(), zfp_type_int32,
               zfp_stream_set_reversible);
    fill_voxels(volume, [&](std::size_t i) { return values[i] / scale + center; });
  }

 private:
  static constexpr int kBits = 30;

  static std::int64_t center_of(const RawVolume& volume) {
    return volume.range.min + (std::int64_t{1} << (sample_bits(volume) - 1));
  }
  static std::int64_t scale_of(const RawVolume& volume) {
    return std::int64_t{1} << (kBits + 1 - sample_bits(volume));
  }
};

/// The fixed accuracy mode on float32, decoded values rounded to integers. zfp keeps well within
/// its tolerance, so the largest power of two that keeps the bound on this volume is taken: the
/// cheapest, since zfp rounds tolerances down to powers of two.
class Accuracy final : public Peer {
 public:
  explicit Accuracy(std::int64_t max_error) : max_error_(max_error) {}
  std::string name() const override { return "zfp-accuracy"; }
  bool supports(const RawVolume& volume) const override {
    return is_integer(volume.type) && sample_bits(volume) <= kFloatBits;
  }

  void prepare(const RawVolume& volume) override {
    RawVolume decoded = volume;
    tolerance_ = std::exp2(std::floor(std::log2(static_cast<double>(max_error_))) + kFirstGuess);
    for (;; tolerance_ /= 2) {
      decode(encode(volume), decoded);
      if (errors_of(volume, decoded).max_error <= max_error_) return;
      require(tolerance_ > kSmallest, "zfp keeps no bound");
    }
  }

  Encoded encode(const RawVolume& volume) override {
    std::vector<float> values(voxel_count(volume));
    for_each_voxel(volume,
                   [&](std::size_t i, auto voxel) { values[i] = static_cast<float>(voxel); });
    return {{compressed(volume, values.data(), zfp_type_float, mode())}};
  }

  void decode(const Encoded& encoded, RawVolume& volume) override {
    std::vector<float> values(voxel_count(volume));
    decompress(encoded.pieces[0], volume, values.data(), zfp_type_float, mode());
    const auto low = static_cast<float>(volume.range.min);
    const auto high = static_cast<float>(volume.range.max);
    fill_voxels(volume, [&](std::size_t i) {
      return std::llrint(std::clamp(values[i], low, high));
    });
  }

 private:
  static constexpr int kFloatBits = 24;
  static constexpr double kFirstGuess = 5;   // log2 of the first tolerance over the bound
  static constexpr double kSmallest = 1e-3;

  std::function<void(zfp_stream*)> mode() const {
    return [tolerance = tolerance_](zfp_stream* zfp) { zfp_stream_set_accuracy(zfp, tolerance); };
  }

  std::int64_t max_error_;
  double tolerance_ = 0;
};

}  // namespace

void add_zfp_peer(Peers& peers, std::int64_t max_error) {
  if (max_error == 0) peers.push_back(std::make_unique<Reversible>());
  else peers.push_back(std::make_unique<Accuracy>(max_error));
}

}  // namespace octavo::bench
