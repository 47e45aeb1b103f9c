// Index roots and pages of arbitrary bytes: every piece that a page names lies in the data of the
// file.
//
//     512 bytes of header | index root | index pages, one after the other

#include <algorithm>

#include "fuzz/fuzz_target.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/index.h"

namespace {

using namespace octavo;

constexpr std::size_t kMostPages = 64;
constexpr std::size_t kHeaderCrcAt = kHeaderBytes - 4;

FileHeader take_header(fuzz::Input& input) {
  Bytes bytes = input.take_bytes(kHeaderBytes);
  bytes.resize(kHeaderBytes);
  store_little_endian(crc32c(ByteSpan(bytes).first(kHeaderCrcAt)), bytes.data() + kHeaderCrcAt);
  HeaderBlock block{};
  std::ranges::copy(bytes, block.begin());
  return parse_header(bytes, load_file_bytes(block));
}

void check_page(const IndexPage& page, const FileHeader& header) {
  for (const ValueRange& range : page.ranges) {
    fuzz::require(range.min <= range.max, "a range that ends before it begins");
  }
  for (const PieceRef& piece : page.pieces) {
    fuzz::require(piece.offset >= kHeaderBytes && piece.offset <= header.pages.offset &&
                      piece.length <= header.pages.offset - piece.offset,
                  "a piece outside the data");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  fuzz::expect_error_or_success([&] {
    const FileHeader header = take_header(input);
    const Levels levels(header.description.size, header.halvings);
    const Bytes root_bytes =
        input.take_bytes(std::min<std::uint64_t>(header.root.length, input.left()));
    const IndexRoot root = parse_root(root_bytes, levels, header);
    root.range();
    root.error_steps();
    for (std::int64_t slab = 0; slab < std::min<std::int64_t>(levels.brick_grid(0).z, 64); ++slab) {
      fuzz::require(root.slab_trailer_offset(slab) <= header.pages.offset, "a trailer outside");
      fuzz::require(root.model_of_slab(slab) < root.models.size(), "a slab without a model");
    }
    for (int tier = 0; tier < levels.tier_count(); ++tier) {
      const std::vector<PageRef>& pages = root.tiers[static_cast<std::size_t>(tier)].pages;
      for (std::size_t i = 0; i < std::min(pages.size(), kMostPages); ++i) {
        const Bytes bytes =
            input.take_bytes(std::min<std::size_t>(pages[i].length, input.left()));
        fuzz::expect_error_or_success(
            [&] { check_page(parse_page(bytes, root, levels, tier, i, header), header); });
      }
    }
  });
  return 0;
}
