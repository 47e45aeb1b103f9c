// The whole reader on arbitrary bytes: verification, every level, boxes in parts of bricks and of
// their planes, labels as words.

#include <optional>
#include <random>
#include <thread>

#include "fuzz/fuzz_target.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/verify.h"

namespace {

using namespace octavo;

constexpr std::int64_t kMostVoxels = std::int64_t{1} << 18;
constexpr int kBoxes = 2;

using Voxels = std::vector<std::uint8_t>;

/// Nothing when the file is damaged there.
std::optional<Voxels> voxels_of(const FileReader& reader, const Box& box, int level) {
  Voxels out(static_cast<std::size_t>(box.size().voxel_count() *
                                      bytes_per_voxel(reader.description().type)));
  bool is_read = false;
  fuzz::expect_error_or_success([&] {
    reader.read(box, level, out.data());
    is_read = true;
  });
  return is_read ? std::optional(std::move(out)) : std::nullopt;
}

/// The same by a thread of its own, in whose work space nothing of the file is left.
std::optional<Voxels> voxels_afresh(const FileReader& reader, const Box& box, int level) {
  std::optional<Voxels> found;
  std::thread([&] { found = voxels_of(reader, box, level); }).join();
  return found;
}

/// A box of at most kMostVoxels at the front of a level.
Box front_of(const Size3& size) {
  Box box = box_of(size);
  while (box.size().voxel_count() > kMostVoxels) {
    for (int axis = 0; axis < 3; ++axis) box.hi[axis] = (box.hi[axis] + 1) / 2;
  }
  return box;
}

Box random_box(const Box& inside, std::minstd_rand& random) {
  Box box = inside;
  for (int axis = 0; axis < 3; ++axis) {
    if (random() % 4 == 0) continue;
    box.lo[axis] = static_cast<std::int64_t>(random()) % inside.hi[axis];
    const std::int64_t left = inside.hi[axis] - box.lo[axis];
    box.hi[axis] = box.lo[axis] + 1 + static_cast<std::int64_t>(random()) % left;
  }
  return box;
}

void require_equal(const Voxels& found, const Box& box, const Voxels& all, const Box& inside) {
  const std::size_t voxel_bytes =
      all.size() / static_cast<std::size_t>(inside.size().voxel_count());
  const std::size_t row = static_cast<std::size_t>(box.size().x) * voxel_bytes;
  const std::uint8_t* next = found.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, next += row) {
      const std::int64_t at = (z * inside.hi.y + y) * inside.hi.x + box.lo.x;
      fuzz::require(
          std::memcmp(next, all.data() + static_cast<std::size_t>(at) * voxel_bytes, row) == 0,
          "a box differs from the level it was cut from");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::vector<std::uint8_t> bytes(data, data + size);
  fuzz::expect_error_or_success([&] {
    const auto reader = FileReader::open(byte_source_of(bytes, "input"));
    const auto keeping = FileReader::open(byte_source_of(bytes, "input"));
    const auto passing = FileReader::open(byte_source_of(bytes, "input"), {.cache_bytes = 0});
    std::minstd_rand random(crc32c(bytes));
    for (int level = reader->levels().count() - 1; level >= 0; --level) {
      const Box front = front_of(reader->levels().size(level));
      const auto all = voxels_of(*reader, front, level);
      for (int i = 0; i < kBoxes; ++i) {
        const Box box = random_box(front, random);
        // What is damaged behind a box matters only to those who keep what lies there.
        const auto kept = voxels_afresh(*keeping, box, level);
        const auto found = voxels_afresh(*passing, box, level);
        if (!all) continue;
        fuzz::require(found.has_value(), "a box cannot be read of a level that can");
        require_equal(*found, box, *all, front);
        if (kept) require_equal(*kept, box, *all, front);
      }
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
