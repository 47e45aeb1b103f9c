// The streams of exact floats, each of arbitrary bytes: what is read and written again reads as
// before, and every float lies in the bin of its code.
//
//     u8 stream | 3 u8 size, then:
//     0 absent samples   u8 choice | flags of the next level, a bit each | bytes
//     1 places           u8 coding | u16 length, places | a byte for each voxel: its code

#include <algorithm>

#include "fuzz/brick_input.h"
#include "octavo/codec/exact/absent_samples.h"
#include "octavo/codec/exact/float_places.h"

namespace {

using namespace octavo;
using namespace octavo::exact;
using fuzz::require;

constexpr std::uint8_t kHasCoarse = 8;
constexpr std::uint8_t kHasBits = 16;

Size3 take_size(fuzz::Input& input) {
  Size3 size;
  for (int axis = 0; axis < 3; ++axis) size[axis] = 1 + input.take<std::uint8_t>() % 8;
  return size;
}

void check_absent(fuzz::Input& input, const Size3& size) {
  const auto choice = input.take<std::uint8_t>();
  const auto halving = static_cast<HalvingMask>(choice & kHalveAll);
  AbsentFlags coarse;
  if (choice & kHasCoarse) {
    coarse.resize(static_cast<std::size_t>(halved(size, halving).voxel_count()));
    const Bytes bits = input.take_bytes((coarse.size() + 7) / 8);
    for (std::size_t i = 0; i < coarse.size() && i / 8 < bits.size(); ++i) {
      coarse[i] = bits[i / 8] >> i % 8 & 1;
    }
  }
  const auto count = static_cast<std::size_t>(choice & kHasBits ? size.voxel_count() : 0);
  std::vector<std::uint32_t> bits(count);
  const AbsentFlags flags =
      decode_absent(input.take_bytes(input.left()), size, coarse, halving, bits);
  std::vector<std::uint32_t> bits_again(count);
  const Bytes again = encode_absent(flags, size, coarse, halving, bits);
  require(decode_absent(again, size, coarse, halving, bits_again) == flags, "other flags");
  require(bits_again == bits, "other bits of absent voxels");

  const Levels levels(size, choose_halvings(size, {1, 1, 1}));
  std::vector<std::int32_t> codes(flags.size(), 7);
  fill_absent(brick_shape(levels, 0, {0, 0, 0}), flags, codes);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    require(flags[i] != 0 || codes[i] == 7, "a code of a sample that is present changes");
  }
}

/// Codes near 0, where bins hold most floats, and far out.
std::int32_t code_of(std::uint8_t byte) {
  const auto near = static_cast<std::int32_t>(byte) - 96;
  return byte < 192 ? near : static_cast<std::int32_t>(kLargestBin) - (byte - 192);
}

void check_places(fuzz::Input& input, const Size3& size) {
  const SampleCoding& coding =
      fuzz::kFuzzedCodings[input.take<std::uint8_t>() % fuzz::kFuzzedCodings.size()];
  const Bytes bytes = input.take_bytes(input.take<std::uint16_t>());
  const auto count = static_cast<std::size_t>(size.voxel_count());
  std::vector<std::int32_t> codes(count);
  for (std::int32_t& code : codes) code = code_of(input.take<std::uint8_t>());
  const FloatBins bins(coding);
  const PlaceBox box{size, codes, {}};

  ByteSpan skipped = bytes;
  skip_places(skipped);
  std::vector<float> voxels(count);
  ByteSpan left = bytes;
  decode_places(bins, box, left, voxels);
  require(left.size() == skipped.size(), "places of another length");
  for (std::size_t i = 0; i < count; ++i) {
    require(bins.bin_of(codes[i], 0).contains(rank_of(voxels[i])), "a float outside its bin");
  }
  const Bytes again = encode_places(bins, box, voxels);
  std::vector<float> reread(count);
  ByteSpan rest = again;
  decode_places(bins, box, rest, reread);
  for (std::size_t i = 0; i < count; ++i) {
    require(bits_of(reread[i]) == bits_of(voxels[i]), "another float");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const bool is_absent = input.take<std::uint8_t>() % 2 == 0;
  const Size3 box = take_size(input);
  fuzz::expect_error_or_success([&] {
    if (is_absent) check_absent(input, box);
    else check_places(input, box);
  });
  return 0;
}
