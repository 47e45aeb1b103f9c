// Headers and trailers of arbitrary bytes: one that is read is written as it was.
//
//     u8 choice | 512 bytes of header | 96 bytes of trailer | u64 length of the source

#include <algorithm>

#include "fuzz/fuzz_target.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/index.h"
#include "octavo/file/layout.h"

namespace {

using namespace octavo;

constexpr std::uint8_t kIsAsLongAsStated = 1;
/// Extensions that a program may skip are not written again.
constexpr std::size_t kExtensionCountAt = 330;
constexpr std::size_t kCrcBytes = 4;

void seal(Bytes& block) {
  if (block.size() < kCrcBytes) return;
  const std::size_t at = block.size() - kCrcBytes;
  store_little_endian(crc32c(ByteSpan(block).first(at)), block.data() + at);
}

void check_trailer(const Bytes& bytes, const FileHeader& header) {
  if (bytes.size() != kTrailerBytes) return;
  const TrailerBlock again = encode_trailer(parse_trailer(bytes, header));
  fuzz::require(std::ranges::equal(again, bytes), "another trailer");
}

void check_header(const Bytes& bytes, const FileHeader& header) {
  const HeaderBlock again = encode_header(header);
  fuzz::require(std::equal(again.begin(), again.begin() + kExtensionCountAt, bytes.begin()),
                "another header");
  const FileHeader reread = parse_header(again, header.file_bytes);
  fuzz::require(encode_header(reread) == again, "a header that changes each time");
  const Levels levels(header.description.size, header.halvings);
  for (int tier = 0; tier < levels.tier_count(); ++tier) make_tier_index(levels, tier);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const auto choice = input.take<std::uint8_t>();
  Bytes block = input.take_bytes(kHeaderBytes);
  Bytes trailer = input.take_bytes(kTrailerBytes);
  auto source_bytes = input.take<std::uint64_t>();
  seal(block);
  if (block.size() == kHeaderBytes) {
    HeaderBlock header{};
    std::ranges::copy(block, header.begin());
    if (choice & kIsAsLongAsStated) source_bytes = load_file_bytes(header);
    fuzz::expect_error_or_success([&] { parse_unsealed_header(header); });
    // A trailer that belongs to the header
    if (trailer.size() == kTrailerBytes && choice & kIsAsLongAsStated) {
      store_little_endian(load_header_crc(header), trailer.data() + 24);
    }
  }
  seal(trailer);
  fuzz::expect_error_or_success([&] {
    const FileHeader header = parse_header(block, source_bytes);
    check_header(block, header);
    check_trailer(trailer, header);
  });
  return 0;
}
