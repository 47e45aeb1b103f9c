// Reading around the damage of files of arbitrary bytes: no level fails once the file opens, and
// what was filled is in the report.

#include "fuzz/fuzz_target.h"
#include "octavo/file/repair/salvage.h"
#include "octavo/file/storage/storage.h"

namespace {

constexpr std::int64_t kMostVoxels = std::int64_t{1} << 16;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace octavo;
  if (size == 0) return 0;
  fuzz::Input input(data, size);
  SalvageOptions options;
  options.from_coarser = (input.take<std::uint8_t>() & 1) != 0;
  fuzz::expect_error_or_success([&] {
    const SalvageReader reader(
        FileReader::open(byte_source_of(input.take_bytes(input.left()), "input")), options);
    for (int level = reader.levels().count() - 1; level >= 0; --level) {
      Box box = box_of(reader.levels().size(level));
      while (box.size().voxel_count() > kMostVoxels) {
        for (int axis = 0; axis < 3; ++axis) box.hi[axis] = (box.hi[axis] + 1) / 2;
      }
      Bytes out(static_cast<std::size_t>(box.size().voxel_count() *
                                         bytes_per_voxel(reader.description().type)));
      reader.read(box, level, out.data());
    }
    const SalvageReport report = reader.report();
    fuzz::require((report.brick_count > 0) == (report.damage_count > 0),
                  "bricks filled without damage, or damage without bricks filled");
  });
  return 0;
}
