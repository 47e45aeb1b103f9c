#include "octavo/file/write/copy_described.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fault/reseal.h"
#include "octavo/core/error.h"
#include "octavo/file/open_file.h"
#include "octavo/file/verify.h"
#include "support/built_file.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

template <class T>
testing::Volume noisy(const Size3& size, std::int64_t noisy_width) {
  testing::Volume volume;
  volume.description.size = size;
  volume.description.type = voxel_type_of<T>();
  volume.description.metadata = Metadata::read(R"({"source":{"format":"raw"}})");
  std::mt19937 random(1);
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()), T{4});
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const auto x = static_cast<std::int64_t>(i) % size.x;
    const auto y = static_cast<std::int64_t>(i) / size.x % size.y;
    if (x < noisy_width && y < noisy_width) voxels[i] = static_cast<T>(random() % 100);
  }
  const auto bytes = std::as_bytes(std::span(voxels));
  volume.voxels.assign(bytes.begin(), bytes.end());
  return volume;
}

void build(const testing::Volume& volume, double max_error, const std::string& path,
           bool has_thumbnail = false) {
  NoProgress progress;
  BuildOptions options;
  options.kind = volume.description.kind;
  options.preset = Preset::fast;
  options.max_error = max_error;
  options.has_thumbnail = has_thumbnail;
  build_file(*make_memory_source(volume.description, volume.voxels), local_storage(), path, options,
             progress);
}

std::uint64_t copy(const std::string& from, const VolumeDescription& description,
                   const std::string& to, bool overwrite = false) {
  NoProgress progress;
  return copy_described(open_byte_source(local_storage(), from), description, local_storage(), to,
                        overwrite, progress);
}

// A copy under another description has the bytes of a build under it.
void expect_copied(testing::Volume volume, double max_error, bool has_thumbnail = false) {
  const testing::ScratchFolder folder;
  build(volume, max_error, folder.file("a.8vo"), has_thumbnail);
  volume.description.geometry.origin_mm = {1, -2, 3.5};
  volume.description.geometry.direction = {0, 1, 0, 1, 0, 0, 0, 0, 1};
  volume.description.metadata.set_made_by(MadeBy("transform"));
  build(volume, max_error, folder.file("b.8vo"), has_thumbnail);
  const VolumeDescription wanted = testing::open_file(folder.file("b.8vo"))->description();
  const std::uint64_t bytes = copy(folder.file("a.8vo"), wanted, folder.file("c.8vo"));
  const std::string copied = testing::bytes_of_file(folder.file("c.8vo"));
  EXPECT_EQ(bytes, copied.size());
  EXPECT_TRUE(copied == testing::bytes_of_file(folder.file("b.8vo")));
}

TEST(CopyDescribed, GivesTheBytesOfABuildUnderThatDescription) {
  expect_copied(noisy<std::int16_t>({70, 67, 130}, 70), 0);
  expect_copied(noisy<std::int16_t>({70, 67, 65}, 70), 5);
  expect_copied(noisy<float>({70, 67, 65}, 70), 0.3);
  expect_copied(noisy<float>({70, 67, 65}, 70), 0);
  testing::Volume labels = noisy<std::uint8_t>({140, 67, 65}, 20);
  labels.description.kind = VolumeKind::labels;
  expect_copied(labels, 0);
}

// The axes of the copy run otherwise: its picture is another one.
TEST(CopyDescribed, MakesTheThumbnailAnew) {
  expect_copied(noisy<std::int16_t>({70, 67, 130}, 70), 0, true);
}

// A golden file with parts: two of "Xnot" that stand for themselves, one that follows from the
// voxels, one from something else, one from both.
Bytes file_with_parts() {
  const std::string bytes =
      testing::bytes_of_file(testing::source_folder() + "/tests/golden/v1/parts.8vo");
  return {bytes.begin(), bytes.end()};
}

// A folder with a file, and where a copy of it under another place goes.
class CopiedBytes : public testing::ScratchFolder {
 public:
  explicit CopiedBytes(const Bytes& bytes) {
    std::ofstream out(from, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  }

  OpenFile opened(const std::string& path) const {
    return OpenFile(open_byte_source(local_storage(), path), {});
  }

  void copy_moved() const {
    VolumeDescription moved = testing::open_file(from)->description();
    moved.geometry.origin_mm = {1, 2, 3};
    copy(from, moved, to);
  }

  void copy_with_metadata(const std::string& text) const {
    VolumeDescription other = testing::open_file(from)->description();
    other.metadata = Metadata::read(text);
    copy(from, other, to);
  }

  /// Names and bytes of the parts of a file.
  std::vector<std::pair<std::string, Bytes>> parts_of(const std::string& path) const {
    const OpenFile file = opened(path);
    std::vector<std::pair<std::string, Bytes>> parts;
    for (const PartEntry& part : file.parts()) {
      Bytes all;
      file.copy_part(part, [&](ByteSpan block) {
        all.insert(all.end(), block.begin(), block.end());
      });
      parts.emplace_back(name_of(part.tag), all);
    }
    return parts;
  }

  void expect_kept(const std::vector<std::size_t>& numbers) const {
    const auto all = parts_of(from);
    std::vector<std::pair<std::string, Bytes>> kept;
    for (const std::size_t number : numbers) kept.push_back(all.at(number));
    EXPECT_EQ(parts_of(to), kept);
    NoProgress progress;
    EXPECT_TRUE(verify_file(open_byte_source(local_storage(), to), {}, progress).is_sound());
  }

  const std::string from = file("a.8vo");
  const std::string to = file("b.8vo");
};

// How the copy of damaged bytes fails; nothing is left of it.
Error failure_of(const Bytes& bytes) {
  const CopiedBytes folder(bytes);
  try {
    folder.copy_moved();
  } catch (const Error& error) {
    EXPECT_EQ(error.path(), folder.from) << error.what();
    EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
    std::filesystem::remove(folder.from);
    EXPECT_TRUE(folder.is_empty());
    return error;
  }
  ADD_FAILURE() << "copied";
  return Error(ErrorKind::internal, "");
}

void expect_place(const Error& error, const std::string& what, std::uint64_t offset) {
  const std::string place = what + " at byte " + std::to_string(offset) + ": ";
  EXPECT_TRUE(error.detail().starts_with(place)) << error.detail();
  EXPECT_EQ(error.offset(), offset);
}

TEST(CopyDescribed, NamesTheFileAndThePlaceOfADamagedPart) {
  Bytes bytes = file_with_parts();
  const OpenFile sound(byte_source_of(bytes, "a.8vo"), {});
  const Section part = sound.parts().front().bytes;
  bytes[part.offset] ^= 0xff;
  bytes[part.offset + 2] ^= 0xff;
  expect_place(failure_of(bytes), "part 'Xnot'", part.offset);
}

TEST(CopyDescribed, NamesTheFileAndThePlaceOfADamagedSlabTrailer) {
  Bytes bytes = file_with_parts();
  const OpenFile sound(byte_source_of(bytes, "a.8vo"), {});
  const std::uint64_t trailer = sound.root().slab_trailer_offset(0);
  bytes[trailer + 20] ^= 0xff;
  expect_place(failure_of(bytes), "slab trailer 0", trailer);
}

TEST(CopyDescribed, KeepsUnknownPartsThatStandForThemselves) {
  const CopiedBytes folder(file_with_parts());
  folder.copy_moved();
  EXPECT_EQ(folder.parts_of(folder.from).size(), 5u);
  folder.expect_kept({0, 4});
}

// The voxels are where they were: what follows from them alone still holds.
TEST(CopyDescribed, KeepsPartsThatFollowFromTheVoxelsUnderOtherMetadata) {
  const CopiedBytes folder(file_with_parts());
  folder.copy_with_metadata(R"({"unit":"mm"})");
  folder.expect_kept({0, 1, 4});
}

// Nothing says whether they still hold.
TEST(CopyDescribed, LeavesOutExtensionsAndTheMinorVersionThatTheyCameWith) {
  Bytes bytes = file_with_parts();
  const FileHeader layout = testing::header_of(bytes);
  const Bytes extension = {1, 0, 0x01, 0x7f, 2, 0, 0xaa, 0xbb};  // one, of tag 0x7f01 and 2 bytes
  std::copy(extension.begin(), extension.end(), bytes.begin() + 330);
  bytes[10] = 3;
  testing::reseal(bytes, layout);
  const CopiedBytes folder(bytes);
  EXPECT_EQ(testing::open_file(folder.from)->format_version(), "1.3");
  folder.copy_moved();
  EXPECT_EQ(testing::open_file(folder.to)->format_version(), "1.0");
  const std::string copied = testing::bytes_of_file(folder.to);
  EXPECT_EQ(copied.substr(330, 178), std::string(178, '\0'));
}

TEST(CopyDescribed, CopiesEveryModel) {
  // A group is 32 MiB: two of them, the second with a model of its own.
  expect_copied(noisy<std::uint8_t>({736, 736, 70}, 40), 0);
  // With a maximum error the tiers above the first have one more.
  expect_copied(noisy<std::uint8_t>({736, 736, 70}, 40), 2);
}

TEST(CopyDescribed, RejectsAnotherVolumeAndATakenNameAndLeavesNothing) {
  const testing::Volume volume = noisy<std::int16_t>({20, 20, 20}, 20);
  const testing::ScratchFolder folder;
  build(volume, 0, folder.file("a.8vo"));
  VolumeDescription other = volume.description;
  other.size.z = 21;
  EXPECT_THROW(copy(folder.file("a.8vo"), other, folder.file("b.8vo")), Error);
  other = volume.description;
  other.kind = VolumeKind::labels;
  EXPECT_THROW(copy(folder.file("a.8vo"), other, folder.file("b.8vo")), Error);
  EXPECT_FALSE(std::filesystem::exists(folder.file("b.8vo")));
  EXPECT_THROW(copy(folder.file("a.8vo"), volume.description, folder.file("a.8vo")), Error);
  copy(folder.file("a.8vo"), volume.description, folder.file("b.8vo"));
  copy(folder.file("a.8vo"), volume.description, folder.file("b.8vo"), true);
}

TEST(CopyDescribed, RejectsADamagedBrickAndLeavesNothing) {
  const testing::Volume volume = noisy<std::int16_t>({70, 67, 65}, 70);
  const testing::ScratchFolder folder;
  build(volume, 0, folder.file("a.8vo"));
  const BrickEntry brick = testing::open_file(folder.file("a.8vo"))->brick(0, {0, 0, 0});
  std::fstream file(folder.file("a.8vo"), std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(brick.pieces[0].offset + 5));
  file.put('\x55');
  file.put('\xaa');
  file.close();
  EXPECT_THROW(copy(folder.file("a.8vo"), volume.description, folder.file("b.8vo")), Error);
  EXPECT_FALSE(std::filesystem::exists(folder.file("b.8vo")));
  std::filesystem::remove(folder.file("a.8vo"));
  EXPECT_TRUE(folder.is_empty());
}

}  // namespace
}  // namespace octavo
