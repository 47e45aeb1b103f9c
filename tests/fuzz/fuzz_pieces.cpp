// The pieces of a brick of arbitrary bytes: the segments that they are divided into make the same
// pieces again.
//
//     u8 levels | for each piece but the last its u16 length | the pieces

#include "fuzz/fuzz_target.h"
#include "octavo/file/pieces.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace octavo;
  fuzz::Input input(data, size);
  const int level_count = 1 + input.take<std::uint8_t>() % kTierLevels;
  const auto count = static_cast<std::size_t>(piece_count(level_count));
  std::vector<std::uint16_t> lengths(count);
  for (std::size_t i = 0; i + 1 < count; ++i) lengths[i] = input.take<std::uint16_t>();
  std::vector<Bytes> pieces;
  for (std::size_t i = 0; i < count; ++i) {
    pieces.push_back(input.take_bytes(i + 1 < count ? lengths[i] : input.left()));
  }
  fuzz::expect_error_or_success([&] {
    const auto spans = segments_of(pieces, level_count);
    std::vector<Bytes> segments;
    for (int i = 0; i < level_count; ++i) {
      const ByteSpan span = spans[static_cast<std::size_t>(i)];
      segments.emplace_back(span.begin(), span.end());
    }
    const auto again = encode_pieces(segments);
    fuzz::require(std::equal(pieces.begin(), pieces.end(), again.begin()), "other pieces");
  });
  return 0;
}
