// Builds that keep the details of coarse levels alone: what they keep is exact, what they leave out
// is interpolated and measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "octavo/builder/recover.h"
#include "octavo/core/error.h"
#include "octavo/file/verify.h"
#include "support/built_file.h"
#include "support/hints.h"
#include "support/memory_storage.h"
#include "support/texture_source.h"
#include "support/voxel_numbers.h"

namespace octavo {
namespace {

using namespace octavo::testing;

std::uint32_t grain_at(const Index3& p) {
  auto h = static_cast<std::uint32_t>(p.x * 73856093 ^ p.y * 19349663 ^ p.z * 83492791);
  h ^= h >> 13;
  h *= 0x5bd1e995u;
  return h >> 16;
}

double waves(const Index3& p) {
  const double near = static_cast<double>(p.x) / 5 + static_cast<double>(p.y) / 7;
  return std::floor(700 * std::sin(near) * std::cos(static_cast<double>(p.z) / 6)) +
         (grain_at(p) & 7);
}
double small_waves(const Index3& p) { return waves(p) / 8; }
double in_air(const Index3& p) { return p.x < 9 || p.y > 20 ? -1000 : waves(p); }
double wide_waves(const Index3& p) { return waves(p) * 1e6; }
double multiples(const Index3& p) { return std::floor(waves(p) / 9 + 100) * 16 + 3; }
double few_values(const Index3& p) { return std::floor((waves(p) + 700) / 100) * 17; }
double noise(const Index3& p) { return grain_at(p) & 0xff; }
double streaks(const Index3& p) { return grain_at({p.x, p.y, p.z / 16}) & 0xfff; }
double speckles(const Index3& p) { return grain_at(p) < 1500 ? 20 + (grain_at(p) & 127) : 0; }
double one_value(const Index3&) { return -5; }

struct Case {
  const char* name;
  Size3 size;
  VoxelType type;
  double (*voxel)(const Index3&);
  int most = 5;  ///< levels without details
  Preset preset = Preset::small;
  Point3 spacing = {1, 1, 1};
};

constexpr Case kCases[] = {
    {"waves", {41, 37, 33}, VoxelType::int16, waves},
    {"bytes", {40, 37, 34}, VoxelType::int8, small_waves, 5, Preset::fast},
    {"in_air", {70, 33, 30}, VoxelType::int16, in_air},
    {"fast_wide", {22, 21, 37}, VoxelType::int32, wide_waves, 5, Preset::fast},
    {"wide", {22, 21, 37}, VoxelType::int32, wide_waves},
    {"multiples", {41, 37, 33}, VoxelType::uint16, multiples},
    {"few_values", {41, 37, 33}, VoxelType::uint8, few_values},
    {"noise", {6, 5, 4}, VoxelType::uint8, noise, 3},
    {"streaks", {40, 24, 34}, VoxelType::uint16, streaks},
    {"speckles", {41, 37, 33}, VoxelType::uint8, speckles},
    {"thick", {41, 37, 12}, VoxelType::int16, waves, 5, Preset::small, {1, 1, 4}},
    {"two_tiers", {130, 9, 7}, VoxelType::int16, waves},
    {"row", {70, 1, 1}, VoxelType::int16, waves, 5, Preset::fast},
    {"tiny", {3, 2, 2}, VoxelType::int16, waves, 2},
    {"one_value", {17, 9, 3}, VoxelType::int16, one_value},
};

Volume volume_of(const Case& one) {
  Volume volume;
  volume.description.type = one.type;
  volume.description.size = one.size;
  volume.description.geometry.spacing_mm = one.spacing;
  volume.voxels.resize(
      static_cast<std::size_t>(one.size.voxel_count() * bytes_per_voxel(one.type)));
  with_voxel_type(one.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    std::byte* out = volume.voxels.data();
    for (std::int64_t z = 0; z < one.size.z; ++z) {
      for (std::int64_t y = 0; y < one.size.y; ++y) {
        for (std::int64_t x = 0; x < one.size.x; ++x, out += sizeof(T)) {
          const auto voxel = static_cast<T>(one.voxel({x, y, z}));
          std::memcpy(out, &voxel, sizeof voxel);
        }
      }
    }
  });
  return volume;
}

BuildResult build(const Volume& volume, MemoryStorage& storage, const BuildOptions& options) {
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  return build_file(*source, storage, "a.8vo", options, progress);
}

std::shared_ptr<FileReader> reader_of(MemoryStorage& storage) {
  return FileReader::open(open_byte_source(storage, "a.8vo"));
}

bool is_sound(MemoryStorage& storage) {
  NoProgress progress;
  return verify_file(open_byte_source(storage, "a.8vo"), {}, progress).is_sound();
}

std::vector<std::int64_t> numbers_of(const FileReader& reader, int level) {
  const auto bytes = read_box(reader, box_of(reader.levels().size(level)), level);
  return as_numbers<std::int64_t>(bytes, reader.description().type);
}

/// Whether no brick has bytes of a level below; one that is stored has its samples in front.
bool has_no_details_below(const FileReader& reader, int level) {
  bool has_none = true;
  visit_cells(box_of(reader.levels().brick_grid(0)), {1, 1, 1}, [&](const Index3& place) {
    const BrickEntry brick = reader.brick(0, place);
    const bool is_stored = brick.pieces.back().length == 0;
    const auto last = brick.pieces.size() - 1;  // several levels may share it
    for (std::size_t i = 0; i < std::min(static_cast<std::size_t>(level), last); ++i) {
      has_none = has_none && (brick.pieces[i].length == 0 || (is_stored && i == 0));
    }
    return true;
  });
  return has_none;
}

class KeptDetails : public ::testing::TestWithParam<Case> {};

TEST_P(KeptDetails, LevelsThatHaveThemAreThoseOfALosslessFile) {
  const Volume volume = volume_of(GetParam());
  MemoryStorage whole;
  build(volume, whole, {.preset = GetParam().preset});
  const auto lossless = reader_of(whole);
  for (int kept = 1; kept <= GetParam().most; ++kept) {
    MemoryStorage storage;
    build(volume, storage, {.preset = GetParam().preset, .keep_details = kept});
    const auto reader = reader_of(storage);
    EXPECT_EQ(reader->detail_level(), kept);
    for (int level = 0; level < reader->levels().count(); ++level) {
      const Box all = box_of(reader->levels().size(level));
      if (level < kept) continue;
      EXPECT_TRUE(read_box(*reader, all, level) == read_box(*lossless, all, level))
          << "level " << level << " of those from " << kept << " on";
    }
    EXPECT_TRUE(has_no_details_below(*reader, kept)) << kept;
    // The ranges of bricks bound what was interpolated, and the digest is that of it.
    EXPECT_TRUE(is_sound(storage)) << kept;
  }
}

TEST_P(KeptDetails, ErrorsAreThoseOfAllVoxels) {
  const Volume volume = volume_of(GetParam());
  MemoryStorage whole;
  build(volume, whole, {});
  const std::vector<std::int64_t> meant = numbers_of(*reader_of(whole), 0);
  MemoryStorage storage;
  const BuildResult result = build(volume, storage, {.keep_details = 1});
  const auto reader = reader_of(storage);
  const std::vector<std::int64_t> found = numbers_of(*reader, 0);
  double largest = 0;
  double squared = 0;
  for (std::size_t i = 0; i < meant.size(); ++i) {
    const auto difference = static_cast<double>(meant[i] - found[i]);
    largest = std::max(largest, std::abs(difference));
    squared += difference * difference;
  }
  const double rms = std::sqrt(squared / static_cast<double>(meant.size()));
  const auto [low, high] = std::minmax_element(meant.begin(), meant.end());
  const auto range = static_cast<double>(*high - *low);
  EXPECT_EQ(reader->max_error(), largest);
  EXPECT_EQ(reader->achieved_error(), largest);
  const auto& coding = reader->description().metadata.facts().coding;
  ASSERT_TRUE(coding && coding->detail_errors && result.detail_errors);
  EXPECT_EQ(coding->keep_details, 1);
  EXPECT_EQ(coding->detail_errors->max, largest);
  EXPECT_NEAR(*coding->detail_errors->rms, rms, 1e-9 * rms);
  EXPECT_EQ(coding->detail_errors->rms, result.detail_errors->rms);
  ASSERT_EQ(coding->detail_errors->psnr_db.has_value(), squared > 0);
  if (squared == 0) return;
  EXPECT_NEAR(*coding->detail_errors->psnr_db, 20 * std::log10(range / rms), 0.006);
}

INSTANTIATE_TEST_SUITE_P(EveryCase, KeptDetails, ::testing::ValuesIn(kCases),
                         [](const auto& of) { return std::string(of.param.name); });

// Rises by 200 from voxel to voxel, along an axis that bricks are cut at.
TEST(InterpolatedDetails, ARampComesThroughAndIsFlatterNextToTheFacesOfBricks) {
  constexpr std::int64_t kSlope = 200;
  for (int axis = 0; axis < 3; ++axis) {
    Volume volume;
    volume.description.type = VoxelType::int16;
    volume.description.size = {6, 6, 6};
    volume.description.size[axis] = 140;
    const Size3& size = volume.description.size;
    std::vector<std::int16_t> voxels;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          // Multiples of the slope would come back as such.
          const std::int64_t at = Index3{x, y, z}[axis];
          voxels.push_back(static_cast<std::int16_t>(kSlope * at + at % 2));
        }
      }
    }
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
    MemoryStorage storage;
    build(volume, storage, {.keep_details = 1});
    const auto reader = reader_of(storage);
    const std::vector<std::int64_t> found = numbers_of(*reader, 0);
    std::int64_t largest = 0;
    std::int64_t largest_at_faces = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const std::int64_t at = voxels[i] / kSlope;
      const bool is_inside = at % 64 >= 4 && at % 64 < 60 && at < 136;
      std::int64_t& most = is_inside ? largest : largest_at_faces;
      most = std::max(most, std::abs(found[i] - voxels[i]));
    }
    EXPECT_LE(largest, 2) << "axis " << axis;
    EXPECT_LE(largest_at_faces, kSlope / 3) << "axis " << axis;
  }
}

TEST(KeptDetailsBuild, SaysWhatItCannotLeaveOut) {
  const Volume volume = volume_of(kCases[0]);
  Volume tiny = volume_of({"", {3, 2, 2}, VoxelType::int16, waves});
  Volume voxel = volume_of({"", {1, 1, 1}, VoxelType::int16, waves});
  Volume floats = volume_of({"", {9, 9, 9}, VoxelType::float32, waves});
  const struct {
    const Volume& volume;
    BuildOptions options;
    std::string words;
  } rejected[] = {
      {volume, {.keep_details = 6}, "from level 6 on [keep_details=1 to 5]"},
      {volume, {.keep_details = -1}, "from level -1 on [keep_details=1 to 5]"},
      {tiny, {.keep_details = 3}, "from level 3 on [keep_details=1 to 2]"},
      {voxel, {.keep_details = 1}, "it has no details [keep_details]"},
      {volume, {.max_error = 2, .keep_details = 1}, "no max error is kept"},
      {volume, {.access = Access::boxes, .keep_details = 1}, "no bytes to be cut into parts"},
      {volume, {.kind = VolumeKind::labels, .keep_details = 1}, "label maps are always lossless"},
      {floats, {.keep_details = 1}, "these are float32"},
      {floats, {.max_error = 2, .keep_details = 1}, "these are float32"},
  };
  for (const auto& one : rejected) {
    MemoryStorage storage;
    try {
      build(one.volume, storage, one.options);
      ADD_FAILURE() << one.words;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
      EXPECT_NE(with_hints(error).find(one.words), std::string::npos) << with_hints(error);
    }
    EXPECT_TRUE(storage.files.empty());
  }
}

// Of what an interrupted build left a sound file is made, whose missing planes are whole as well.
TEST(KeptDetailsBuild, WhatAnInterruptedOneLeftCanBeSealed) {
  TextureSource torn(TextureSource::three_groups(), 149);
  MemoryStorage storage;
  NoProgress progress;
  BuildOptions options;
  options.interrupted = Interrupted::resume;
  options.keep_details = 1;
  EXPECT_THROW(build_file(torn, storage, "b.8vo", options, progress), Error);
  const auto sealed = seal_interrupted(storage, "b.8vo", "a.8vo", {}, progress);
  ASSERT_TRUE(sealed);
  EXPECT_EQ(sealed->whole_planes, 64);
  EXPECT_TRUE(is_sound(storage));
  const auto reader = reader_of(storage);
  EXPECT_EQ(reader->detail_level(), 1);
  EXPECT_GT(reader->achieved_error(), 0);

  // The errors are those of the whole planes.
  const auto coding = reader->description().metadata.facts().coding;
  ASSERT_TRUE(coding && coding->detail_errors);
  EXPECT_EQ(coding->detail_errors->max, reader->achieved_error());
  TextureSource source(TextureSource::three_groups());
  const Size3& size = source.description().size;
  std::vector<std::int16_t> plane(static_cast<std::size_t>(size.x * size.y));
  std::vector<std::int16_t> kept(plane.size());
  double squared = 0;
  for (std::int64_t z = 0; z < sealed->whole_planes; ++z) {
    source.read_plane(std::as_writable_bytes(std::span(plane)));
    reader->read({{0, 0, z}, {size.x, size.y, z + 1}}, 0, kept.data());
    for (std::size_t i = 0; i < plane.size(); ++i) {
      squared += std::pow(static_cast<double>(plane[i]) - static_cast<double>(kept[i]), 2);
    }
  }
  const double rms = std::sqrt(squared / static_cast<double>(size.x * size.y * 64));
  EXPECT_NEAR(coding->detail_errors->rms.value(), rms, 1e-9 * rms);
}

}  // namespace
}  // namespace octavo
