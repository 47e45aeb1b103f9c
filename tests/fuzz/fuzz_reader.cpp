// The whole reader on arbitrary bytes: verification, every level, boxes, labels as words.

#include "fuzz/fuzz_target.h"
#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/verify.h"

namespace {

constexpr std::int64_t kMostVoxels = std::int64_t{1} << 18;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace octavo;
  const std::vector<std::uint8_t> bytes(data, data + size);
  fuzz::expect_error_or_success([&] {
    const auto reader = FileReader::open(byte_source_of(bytes, "input"));
    for (int level = reader->levels().count() - 1; level >= 0; --level) {
      Box box = box_of(reader->levels().size(level));
      while (box.size().voxel_count() > kMostVoxels) {
        for (int axis = 0; axis < 3; ++axis) box.hi[axis] = (box.hi[axis] + 1) / 2;
      }
      std::vector<std::uint8_t> out(static_cast<std::size_t>(
          box.size().voxel_count() * bytes_per_voxel(reader->description().type)));
      fuzz::expect_error_or_success([&] { reader->read(box, level, out.data()); });
    }
    if (reader->description().kind == VolumeKind::labels) {
      LabelWords words;
      fuzz::expect_error_or_success([&] { reader->read_words(reader->brick(0, {}), words); });
    }
    reader->thumbnail();
  });
  NoProgress progress;
  fuzz::expect_error_or_success([&] { verify_file(byte_source_of(bytes, "input"), {}, progress); });
  return 0;
}
