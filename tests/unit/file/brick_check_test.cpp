// Bricks of every codec against the tier above them, and the lists of their parts.
#include "octavo/file/brick_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "octavo/builder/builder.h"
#include "octavo/core/error.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/verify.h"
#include "octavo/file/write/writer.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using FileContent = std::vector<std::uint8_t>;

/// What the voxels of a file are.
enum class Voxels { waves, noise, gaps_of_nan, few };

double voxel_at(Voxels voxels, const Index3& p, std::mt19937& random) {
  const double wave = std::sin(0.1 * static_cast<double>(p.x + p.y)) +
                      std::cos(0.07 * static_cast<double>(p.z));
  const auto grain = static_cast<double>(random() % 8);
  switch (voxels) {
    case Voxels::waves: return 400 + 100 * wave + grain;
    case Voxels::noise: return static_cast<double>(random() % 65536);
    case Voxels::gaps_of_nan:
      return p.x < 70 || random() % 5 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                           : wave + 0.01 * grain;
    case Voxels::few: return std::floor(3 + 2 * wave);
  }
  return 0;
}

struct Case {
  const char* name;
  VoxelType type;
  Voxels voxels;
  BuildOptions options = {};
};

const Case kCases[] = {
    {"small", VoxelType::int16, Voxels::waves},
    {"fast with parts", VoxelType::int16, Voxels::waves,
     {.preset = Preset::fast, .access = Access::boxes}},
    {"wide", VoxelType::uint32, Voxels::noise},
    {"stored", VoxelType::uint16, Voxels::noise},
    {"rounded", VoxelType::int16, Voxels::waves, {.access = {}, .max_error = 3}},
    {"corrected", VoxelType::int16, Voxels::waves, {.access = Access::slices, .max_error = 40}},
    {"exact floats", VoxelType::float32, Voxels::waves},
    {"floats with NaN", VoxelType::float32, Voxels::gaps_of_nan},
    {"floats with an error", VoxelType::float32, Voxels::waves, {.access = {}, .max_error = 0.5}},
    {"labels", VoxelType::int16, Voxels::few, {.kind = VolumeKind::labels, .access = {}}},
    {"stored labels", VoxelType::uint16, Voxels::noise,
     {.kind = VolumeKind::labels, .access = {}}},
};

FileContent built(const Case& c) {
  VolumeDescription description;
  description.kind = c.options.kind;
  description.type = c.type;
  description.size = {130, 70, 66};
  std::mt19937 random(4);
  std::vector<std::byte> bytes;
  with_voxel_type(c.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const Size3& size = description.size;
    for (Index3 p; p.z < size.z; ++p.z) {
      for (p.y = 0; p.y < size.y; ++p.y) {
        for (p.x = 0; p.x < size.x; ++p.x) {
          const auto voxel = static_cast<T>(voxel_at(c.voxels, p, random));
          const auto* const first = reinterpret_cast<const std::byte*>(&voxel);
          bytes.insert(bytes.end(), first, first + sizeof voxel);
        }
      }
    }
  });
  const auto source = make_memory_source(description, bytes);
  MemoryStorage storage;
  NoProgress progress;
  build_file(*source, storage, "built.8vo", c.options, progress);
  return *storage.files.at("built.8vo");
}

/// The brick of an entry as an encoder gave it, but for its parent.
EncodedBrick encoded_brick(const OpenFile& file, const BrickEntry& entry) {
  EncodedBrick brick;
  brick.range = entry.range;
  const int level_count = file.levels().tier_level_count(entry.tier);
  brick.segments.resize(static_cast<std::size_t>(level_count));
  if (entry.is_uniform()) return brick;
  const BrickBytes bytes = file.read_segments(entry, 0);
  for (std::size_t i = 0; i < brick.segments.size(); ++i) {
    brick.segments[i].assign(bytes.segments[i].begin(), bytes.segments[i].end());
  }
  return brick;
}

/// A lossless file written anew, its bricks changed on the way.
FileContent rewritten(const FileContent& bytes,
                      const std::function<void(const BrickEntry&, EncodedBrick&)>& change) {
  const OpenFile file(byte_source_of(bytes, "good"), {});
  MemoryStorage storage;
  const auto writer =
      FileWriter::create(storage, "changed.8vo", file.description(), file.levels(), 1, {});
  for (int tier = 0; tier < file.levels().tier_count(); ++tier) {
    const Size3 grid = file.levels().brick_grid(tier);
    for (std::int64_t layer = 0; layer < grid.z; ++layer) {
      if (tier == 0) {
        const std::uint32_t model = file.root().model_of_slab(layer);
        if (file.root().models[model].first_slab == static_cast<std::uint32_t>(layer)) {
          writer->add_model(file.read_piece(file.model_piece(model)));
        }
        writer->add_plane_digests(file.slab_trailer(layer).plane_digests);
      }
      for (Index3 at : layer_order(grid)) {
        at.z = layer;
        const BrickEntry entry = file.entry_at(tier, at);
        EncodedBrick brick = encoded_brick(file, entry);
        change(entry, brick);
        writer->add_brick(tier, brick);
      }
    }
  }
  writer->finish();
  return *storage.files.at("changed.8vo");
}

VerifyReport verified(const FileContent& bytes) {
  NoProgress progress;
  return verify_file(byte_source_of(bytes, "file"), {}, progress);
}

TEST(BrickCheck, EveryCodecsBricksDetermineTheSamplesOfTheNextTier) {
  for (const Case& c : kCases) {
    SCOPED_TRACE(c.name);
    const FileContent bytes = built(c);
    const VerifyReport report = verified(bytes);
    EXPECT_TRUE(report.is_sound()) << report.damages.front().detail;
    const OpenFile file(byte_source_of(bytes, "built"), {});
    const Size3 grid = file.levels().brick_grid(0);
    const std::vector<std::int64_t> above = parents_in(file, file.entry_at(1, {0, 0, 0}));
    ASSERT_EQ(above.size(), static_cast<std::size_t>(grid.voxel_count()));
    std::size_t next = 0;
    for (Index3 at; at.z < grid.z; ++at.z) {
      for (at.y = 0; at.y < grid.y; ++at.y) {
        for (at.x = 0; at.x < grid.x; ++at.x, ++next) {
          const CheckedBrick checked = check_brick(file, file.entry_at(0, at), {});
          ASSERT_TRUE(checked.parent.has_value());
          EXPECT_TRUE(are_read_alike(file.description(), *checked.parent, above[next]));
        }
      }
    }
    EXPECT_FALSE(check_brick(file, file.entry_at(1, {0, 0, 0}), {}).parent.has_value());
  }
}

TEST(BrickCheck, ANextTierOfOtherSamplesIsFoundForEveryCodec) {
  for (const Case& c : kCases) {
    if (c.options.max_error > 0) continue;
    SCOPED_TRACE(c.name);
    // All samples above become that of the code 12345, which no brick determines.
    const FileContent bytes = rewritten(built(c), [](const BrickEntry& entry, EncodedBrick& brick) {
      if (entry.tier == 0) return;
      brick.range = {12345, 12345};
      for (Bytes& segment : brick.segments) segment.clear();
    });
    const VerifyReport report = verified(bytes);
    const OpenFile file(byte_source_of(bytes, "changed"), {});
    const std::int64_t bricks = file.levels().brick_count(0);
    EXPECT_EQ(report.damage_count, bricks);
    EXPECT_EQ(report.damaged_brick_count, bricks);
    for (const Damage& damage : report.damages) {
      EXPECT_NE(damage.detail.find(" of level 6 is "), std::string::npos) << damage.detail;
      EXPECT_NE(damage.detail.find(", but the brick below makes it "), std::string::npos)
          << damage.detail;
    }
  }
}

TEST(BrickCheck, AWrongChecksumInTheListOfPartsIsFoundThoughNothingElseIs) {
  const Case boxes{"boxes", VoxelType::int16, Voxels::waves,
                   {.preset = Preset::fast, .access = Access::boxes}};
  const FileContent good = built(boxes);
  const FileContent bytes = rewritten(good, [](const BrickEntry& entry, EncodedBrick& brick) {
    if (entry.tier > 0 || entry.code != 0) return;
    Bytes& list = brick.segments[1];
    std::size_t at = 0;
    while (list[at] >= 128) ++at;  // the length of the first part
    list[at + 1] ^= 1;
  });
  const VerifyReport report = verified(bytes);
  ASSERT_EQ(report.damage_count, 1);
  const Damage& damage = report.damages.front();
  EXPECT_NE(damage.detail.find("a part of a brick has another checksum"), std::string::npos)
      << damage.detail;
  EXPECT_EQ(damage.code, 0u);
  const auto read = [](const FileContent& file, const Box& box) {
    const auto reader = FileReader::open(byte_source_of(file, "file"));
    Bytes voxels(static_cast<std::size_t>(box.size().voxel_count()) * sizeof(std::int16_t));
    reader->read(box, 0, voxels.data());
    return voxels;
  };
  const Box all{{0, 0, 0}, {130, 70, 66}};
  EXPECT_NO_THROW(read(good, all));
  EXPECT_THROW(read(bytes, all), Error);
  EXPECT_THROW(read(bytes, {{0, 0, 0}, {1, 1, 1}}), Error);
  EXPECT_NO_THROW(read(bytes, {{64, 0, 0}, {130, 70, 66}}));
}

TEST(BrickCheck, SamplesAreSaidAsTheyAreRead) {
  VolumeDescription volume;
  EXPECT_EQ(sample_text(volume, -7), "-7");
  volume.type = VoxelType::float32;
  volume.coding = SampleCoding{VoxelType::int16, 0.5, 1, false};
  EXPECT_EQ(sample_text(volume, -7), "-2.5");
  EXPECT_FALSE(are_read_alike(volume, -7, -6));
  volume.coding->scale = 1e-60;
  EXPECT_TRUE(are_read_alike(volume, -7, -6));
  volume.coding = SampleCoding{VoxelType::int32, 0.5, 1, true};
  EXPECT_EQ(sample_text(volume, uniform_parent(volume, -7)), "-2.5");
  EXPECT_EQ(sample_text(volume, 0x7fc00000), "nan");
}

}  // namespace
}  // namespace octavo
