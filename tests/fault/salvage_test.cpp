// What a damaged file still gives: every voxel outside the damaged bricks, and the fill inside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fault/reseal.h"
#include "octavo/file/index.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/repair/salvage.h"
#include "support/memory_reader.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

std::size_t voxel_width(const FileReader& reader) {
  return static_cast<std::size_t>(bytes_per_voxel(reader.description().type));
}

bool is_readable(const FileReader& reader, const Box& box, int level) {
  try {
    read_samples(reader, box, level);
    return true;
  } catch (const Error&) {
    return false;
  }
}

// The fill a brick must get, [z][y][x] of its box.
Bytes expected_fill(const FileReader& damaged, const SampleVolume& volume,
                    const SalvageOptions& options, int level, const Index3& brick) {
  const Box box = brick_box_at(damaged.levels(), level, brick);
  const std::size_t width = voxel_width(damaged);
  Bytes fill;
  if (options.from_coarser) {
    for (int coarse = level + 1; coarse < volume.levels.count(); ++coarse) {
      const auto shift = [&](int axis) {
        return volume.levels.halving_count(coarse, axis) - volume.levels.halving_count(level, axis);
      };
      Box above;
      for (int axis = 0; axis < 3; ++axis) {
        above.lo[axis] = box.lo[axis] >> shift(axis);
        above.hi[axis] = ((box.hi[axis] - 1) >> shift(axis)) + 1;
      }
      if (!is_readable(damaged, above, coarse)) continue;
      for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
        for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
          for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
            const Index3 at{x >> shift(0), y >> shift(1), z >> shift(2)};
            const Bytes one =
                expected_samples(volume, {at, {at.x + 1, at.y + 1, at.z + 1}}, coarse);
            fill.insert(fill.end(), one.begin(), one.end());
          }
        }
      }
      return fill;
    }
  }
  double value = damaged.description().voxel_of(damaged.range().min);
  try {
    value = damaged.description().voxel_of(
        damaged.brick(Levels::tier_of(level), brick).range.min);
  } catch (const Error&) {
    // The lowest value of the volume it is.
  }
  if (options.value) value = *options.value;
  fill.resize(static_cast<std::size_t>(box.size().voxel_count()) * width);
  with_voxel_type(damaged.description().type, [&](auto tag) {
    const auto voxel = static_cast<typename decltype(tag)::type>(value);
    for (std::size_t at = 0; at < fill.size(); at += width) {
      std::memcpy(fill.data() + at, &voxel, width);
    }
  });
  return fill;
}

// Reads every level through a SalvageReader; returns how many bricks were damaged, levels counted
// apart.
std::int64_t check_salvage(const std::vector<std::uint8_t>& bytes, const SampleVolume& volume,
                           const SalvageOptions& options) {
  const auto plain = open_bytes(bytes);
  const SalvageReader salvage(plain, options);
  std::int64_t damaged = 0;
  for (int level = 0; level < volume.levels.count(); ++level) {
    const Box all = box_of(volume.levels.size(level));
    Bytes found(static_cast<std::size_t>(all.size().voxel_count()) * voxel_width(*plain));
    read_parallel(salvage, all, level, found.data(), 3);
    Bytes one_by_one(found.size());
    const Size3 grid = volume.levels.brick_grid(Levels::tier_of(level));
    const auto row_bytes = static_cast<std::size_t>(all.size().x) * voxel_width(*plain);
    for (Index3 brick; brick.z < grid.z; ++brick.z) {
      for (brick.y = 0; brick.y < grid.y; ++brick.y) {
        for (brick.x = 0; brick.x < grid.x; ++brick.x) {
          const Box box = brick_box_at(plain->levels(), level, brick);
          const bool is_whole = is_readable(*plain, box, level);
          damaged += is_whole ? 0 : 1;
          const Bytes part = is_whole ? expected_samples(volume, box, level)
                                      : expected_fill(*plain, volume, options, level, brick);
          const std::size_t width = voxel_width(*plain);
          const auto run = static_cast<std::size_t>(box.size().x) * width;
          auto from = part.begin();
          for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
            for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
              const auto row = static_cast<std::size_t>(z * all.size().y + y);
              const std::size_t at = row * row_bytes + static_cast<std::size_t>(box.lo.x) * width;
              std::copy_n(from, run, one_by_one.begin() + static_cast<std::ptrdiff_t>(at));
              from += static_cast<std::ptrdiff_t>(run);
            }
          }
        }
      }
    }
    EXPECT_EQ(found, one_by_one) << "level " << level;
  }
  EXPECT_EQ(salvage.report().brick_count, damaged);
  return damaged;
}

void check_every_fill(const std::vector<std::uint8_t>& bytes, const SampleVolume& volume,
                      std::int64_t min_damaged) {
  for (const bool from_coarser : {false, true}) {
    for (const std::optional<double> value : {std::optional<double>(), std::optional<double>(9)}) {
      SCOPED_TRACE(std::string(from_coarser ? "coarse " : "") + (value ? "value" : "lowest"));
      EXPECT_GE(check_salvage(bytes, volume, {from_coarser, value}), min_damaged);
    }
  }
}

IndexRoot root_of(const std::vector<std::uint8_t>& bytes, const SampleVolume& volume) {
  const FileHeader header = header_of(bytes);
  return parse_root(ByteSpan(bytes).subspan(header.root.offset, header.root.length),
                    volume.levels, header);
}

SampleVolume sample() {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  volume.model_layers = 2;
  return volume;
}

TEST(Salvage, ASoundFileIsReadAsItIs) {
  SampleVolume volume = sample();
  EXPECT_EQ(check_salvage(sample_file_bytes(volume), volume, {}), 0);
}

TEST(Salvage, OneDamagedSegmentIsFilledAtItsLevelAndBelow) {
  SampleVolume volume = sample();
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const BrickEntry entry = open_bytes(good)->brick(0, {1, 0, 1});
  // A piece and the levels that are lost with it: its own and all finer ones.
  const std::pair<std::size_t, std::int64_t> losses[] = {{0, 1}, {2, 3}, {3, 6}};
  for (const auto& [piece, levels] : losses) {
    std::vector<std::uint8_t> bytes = good;
    bytes[entry.pieces[piece].offset] ^= 1;
    check_every_fill(bytes, volume, levels);
  }
}

TEST(Salvage, ADamagedPageLosesItsBricksOnly) {
  SampleVolume volume = sample();
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  bytes[root_of(bytes, volume).tiers[0].pages[1].offset + 2] ^= 1;
  check_every_fill(bytes, volume, 6 * 6);
  const SalvageReader reader(open_bytes(bytes), {});
  read_samples(reader, box_of(volume.levels.size(0)), 0);
  const SalvageReport report = reader.report();
  ASSERT_EQ(report.damages.size(), 1u);
  EXPECT_EQ(report.damages[0].brick_count, 6);
  EXPECT_EQ(report.damages[0].fill, SalvageFill::volume_lowest);
  EXPECT_NE(report.damages[0].detail.find("index page"), std::string::npos);
}

TEST(Salvage, ADamagedModelLosesTheBricksCodedWithIt) {
  SampleVolume volume = sample();
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const IndexRoot root = root_of(bytes, volume);
  ASSERT_EQ(root.models.size(), 2u);
  ASSERT_GT(root.models[1].length, 0u);
  bytes[root.models[1].offset] ^= 1;
  check_every_fill(bytes, volume, 1);
}

TEST(Salvage, SeveralTiersFloatsAndLabelsAreFilledAlike) {
  SampleVolume floats = make_lossy_float_sample();
  SampleVolume labels =
      make_sample({70, 70, 20}, VoxelType::uint16, Pattern::noisy_half, VolumeKind::labels);
  for (SampleVolume* volume : {&floats, &labels}) {
    std::vector<std::uint8_t> bytes = sample_file_bytes(*volume);
    const auto reader = open_bytes(bytes);
    if (volume == &floats) {
      // The samples of the support are codes; what a reader gives is made of them.
      volume->samples.clear();
      for (int level = 0; level < volume->levels.count(); ++level) {
        volume->samples.push_back(
            read_samples(*reader, box_of(volume->levels.size(level)), level));
      }
    }
    const Size3 grid = volume->levels.brick_grid(0);
    for (Index3 at; at.z < grid.z; ++at.z) {
      const BrickEntry entry = reader->brick(0, at);
      if (!entry.is_uniform()) bytes[entry.pieces[0].offset + 1] ^= 0x10;
    }
    const BrickEntry top = reader->brick(1, {0, 0, 0});
    if (!top.is_uniform()) bytes[top.pieces[0].offset] ^= 4;
    check_every_fill(bytes, *volume, 1);
  }
}

TEST(Salvage, TheReportNamesEveryPlaceOnceInTheOrderOfTheFile) {
  SampleVolume volume = sample();
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto reader = open_bytes(bytes);
  std::vector<std::uint64_t> offsets;
  for (std::int64_t x = 0; x < 3; ++x) {
    const BrickEntry entry = reader->brick(0, {x, 1, 2});
    offsets.push_back(entry.pieces[0].offset);
    bytes[offsets.back()] ^= 0x80;
  }
  const SalvageReader salvage(open_bytes(bytes), {});
  const Box all = box_of(volume.levels.size(0));
  read_samples(salvage, all, 0);
  read_samples(salvage, all, 0);
  const SalvageReport report = salvage.report();
  EXPECT_EQ(report.brick_count, 3);
  EXPECT_EQ(report.damage_count, 3);
  ASSERT_EQ(report.damages.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const SalvagedDamage& damage = report.damages[i];
    EXPECT_EQ(damage.offset, offsets[i]);
    EXPECT_EQ(damage.brick_count, 1);
    EXPECT_EQ(damage.fill, SalvageFill::brick_lowest);
    const std::string byte = "one flipped bit, byte " + std::to_string(offsets[i]);
    EXPECT_NE(damage.detail.find(byte), std::string::npos) << damage.detail;
    EXPECT_EQ(damage.detail.rfind("brick o-code 0x", 0), 0u) << damage.detail;
  }
}

TEST(Salvage, OfBricksBehindOneDamageTheFirstIsToldWhicheverWasReadFirst) {
  SampleVolume volume = sample();
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  bytes[header_of(bytes).pages.offset + 3] ^= 4;
  const auto told_after = [&](const std::vector<Index3>& bricks) {
    const SalvageReader salvage(open_bytes(bytes), {});
    for (const Index3& brick : bricks) {
      const Index3 at{brick.x * 64, brick.y * 64, 0};
      read_samples(salvage, {at, {at.x + 1, at.y + 1, 1}}, 0);
    }
    const SalvageReport report = salvage.report();
    EXPECT_EQ(report.damage_count, 1);
    EXPECT_EQ(report.brick_count, 3);
    return report.damages.front();
  };
  const SalvagedDamage forward = told_after({{0, 0, 0}, {1, 0, 0}, {2, 1, 0}});
  const SalvagedDamage backward = told_after({{2, 1, 0}, {1, 0, 0}, {0, 0, 0}});
  for (const SalvagedDamage& damage : {forward, backward}) {
    EXPECT_EQ(damage.brick, (Index3{0, 0, 0}));
    EXPECT_EQ(damage.brick_count, 3);
    EXPECT_EQ(damage.fill, SalvageFill::volume_lowest);
  }
  EXPECT_EQ(forward.detail, backward.detail);
}

TEST(Salvage, TellsOfTheFileWhatItsReaderDoes) {
  SampleVolume volume = make_lossy_float_sample();
  const auto plain = open_bytes(sample_file_bytes(volume));
  const SalvageReader salvage(plain, {});
  EXPECT_EQ(&salvage.description(), &plain->description());
  EXPECT_EQ(&salvage.levels(), &plain->levels());
  EXPECT_EQ(&salvage.source(), &plain->source());
  EXPECT_EQ(salvage.file_bytes(), plain->file_bytes());
  EXPECT_EQ(salvage.build_id(), plain->build_id());
  EXPECT_EQ(salvage.format_version(), plain->format_version());
  EXPECT_EQ(salvage.max_error(), 1.5);
  EXPECT_EQ(salvage.achieved_error(), 0.75);
  EXPECT_EQ(salvage.axis_order(), plain->axis_order());
  EXPECT_EQ(salvage.thumbnail(), plain->thumbnail());
  EXPECT_EQ(salvage.level_summary(0).bytes, plain->level_summary(0).bytes);
  const BrickEntry entry = salvage.brick(0, {1, 0, 1});
  EXPECT_EQ(entry.code, plain->brick(0, {1, 0, 1}).code);
  EXPECT_EQ(salvage.read_piece(entry, 0), plain->read_piece(entry, 0));
}

TEST(Salvage, ASingleBrickIsFilledToo) {
  SampleVolume volume = sample();
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const BrickEntry entry = open_bytes(bytes)->brick(0, {2, 1, 2});
  bytes[entry.pieces[1].offset] ^= 1;
  const SalvageReader salvage(open_bytes(bytes), {false, 77.0});
  std::vector<std::int16_t> voxels(64 * 64 * 64, 1);
  salvage.read_brick(entry, 0, voxels.data());
  // 130 x 70 x 129 leaves 2 x 6 x 1 voxels of the last brick.
  EXPECT_EQ(std::count(voxels.begin(), voxels.end(), 77), 2 * 6 * 1);
}

TEST(Salvage, TheFillMustBeAVoxelAndWidensTheRange) {
  SampleVolume volume = sample();
  const auto reader = open_bytes(sample_file_bytes(volume));
  for (const double wrong : {0.5, 32768.0, -1e9, std::nan("")}) {
    EXPECT_THROW(SalvageReader(reader, {false, wrong}), Error) << wrong;
  }
  EXPECT_EQ(SalvageReader(reader, {}).range(), reader->range());
  EXPECT_EQ(SalvageReader(reader, {false, -5.0}).range(), (ValueRange{-5, reader->range().max}));
  EXPECT_EQ(SalvageReader(reader, {false, 9000.0}).range(),
            (ValueRange{reader->range().min, 9000}));
}

/// Exact floats whose one brick is damaged; the index knows no end of its range but the largest.
class LostFloats final : public MemoryReader {
 public:
  LostFloats() : MemoryReader(description_of_floats(), {}, {-SampleCoding::kUnbounded, 9}) {}
  BrickEntry brick(int, const Index3&) const override {
    BrickEntry entry;
    entry.range = range();
    return entry;
  }
  void read_strided(const Box&, int, void*, std::int64_t, std::int64_t) const override {
    throw Error(ErrorKind::corrupt, "damaged", "lost.8vo", 512);
  }

 private:
  static VolumeDescription description_of_floats() {
    VolumeDescription description;
    description.size = {3, 3, 3};
    description.type = VoxelType::float32;
    description.coding = SampleCoding{VoxelType::int32, 0.25, 0, true};
    return description;
  }
};

TEST(Salvage, WhereNobodyKnowsTheLowestFloatTheFillIsWhatCoarseLevelsShow) {
  const SalvageReader salvage(std::make_shared<LostFloats>(), {});
  std::vector<float> voxels(27);
  salvage.read(box_of({3, 3, 3}), 0, voxels.data());
  EXPECT_EQ(voxels, std::vector<float>(27, static_cast<float>(0.25 * (2 - 0x1p31))));
}

TEST(Salvage, WhatIsNoDamageIsThrown) {
  SampleVolume volume = sample();
  const SalvageReader salvage(open_bytes(sample_file_bytes(volume)), {});
  EXPECT_THROW(read_samples(salvage, {{0, 0, 0}, {131, 1, 1}}, 0), Error);
  EXPECT_THROW(read_samples(salvage, {{0, 0, 0}, {1, 1, 1}}, 99), Error);
  EXPECT_THROW(salvage.brick(0, {9, 9, 9}), Error);
}

/// Bytes whose reads fail from the moment the switch is thrown.
class SwitchedSource final : public ByteSource {
 public:
  explicit SwitchedSource(std::vector<std::uint8_t> bytes)
      : bytes_(byte_source_of(std::move(bytes), "sample.8vo")) {}
  std::uint64_t size() const override { return bytes_->size(); }
  const std::string& name() const override { return bytes_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (is_failing) throw Error(ErrorKind::io, "the disk fails", name());
    bytes_->read(offset, out);
  }
  bool is_failing = false;

 private:
  std::shared_ptr<ByteSource> bytes_;
};

TEST(Salvage, AFailingDiskIsNeverFilledOver) {
  SampleVolume volume = sample();
  const auto source = std::make_shared<SwitchedSource>(sample_file_bytes(volume));
  const SalvageReader salvage(FileReader::open(source), {true, {}});
  source->is_failing = true;
  try {
    read_samples(salvage, box_of(volume.levels.size(0)), 0);
    FAIL() << "filled";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
  }
  EXPECT_EQ(salvage.report().brick_count, 0);
}

}  // namespace
}  // namespace octavo
