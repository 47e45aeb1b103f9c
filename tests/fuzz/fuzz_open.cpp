// Header, index root, index pages and trailer of arbitrary bytes.

#include "fuzz/fuzz_target.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace octavo;
  fuzz::expect_error_or_success([&] {
    const auto reader = FileReader::open(byte_source_of({data, data + size}, "input"));
    for (int level = 0; level < reader->levels().count(); ++level) reader->level_summary(level);
    for (int tier = 0; tier < reader->levels().tier_count(); ++tier) {
      const Size3 grid = reader->levels().brick_grid(tier);
      for (std::int64_t i = 0; i < std::min<std::int64_t>(grid.voxel_count(), 64); ++i) {
        fuzz::expect_error_or_success(
            [&] { reader->brick(tier, {i % grid.x, i / grid.x % grid.y, i / grid.x / grid.y}); });
      }
    }
  });
  return 0;
}
