// Kept files of every feature of the format: today's reader gives back what they were made of.
//
// tests/golden/v1/levels.txt lists them: file, level, CRC-32C of the level's voxels (little-endian,
// [z][y][x]); a reader in another language checks itself against the same list. Those of
// newer/ are rejected with the kind of error in newer/kinds.txt. Run with
// OCTAVO_WRITE_GOLDEN=1 to make the files that are missing, and to list them; none is replaced.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/file/thumbnail.h"
#include "octavo/file/write/writer.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"
#include "support/sample_file.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

using namespace octavo::testing;

const std::string kFolder = source_folder() + "/tests/golden/v1/";

/// A reproducible number for a place, 0 .. 65535.
std::uint32_t noise_at(const Index3& p) {
  auto h = static_cast<std::uint32_t>(p.x * 73856093 ^ p.y * 19349663 ^ p.z * 83492791);
  h ^= h >> 13;
  h *= 0x5bd1e995u;
  h ^= h >> 15;
  return h & 0xffff;
}

/// Two balls, one inside the other, that rise along x, on a ground of 0; `grain` values of noise.
std::int64_t scan_at(const Index3& p, std::int64_t scale, std::int64_t grain) {
  const auto distance = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y) + (p.z - z) * (p.z - z);
  };
  if (distance(20, 16, 12) > 300) return 0;
  const std::int64_t base = distance(18, 15, 12) < 90 ? 9 * scale : 4 * scale + p.x * scale / 8;
  return base + static_cast<std::int64_t>(noise_at(p)) * grain / 65536;
}

std::int64_t label_at(const Index3& p) {
  return p.x / 9 + p.y / 11 > 4 ? 0 : 3 + (p.x + p.z / 2) / 9 * 4 + p.y / 12;
}

struct Feature {
  std::string name;
  Size3 size;
  VoxelType type;
  double (*voxel)(const Index3&);
  BuildOptions options = {};
  Point3 spacing = {1, 1, 1};
  /// Nothing: the file is built as any other; else it is written brick by brick.
  void (*write)(FileWriter& writer, SampleVolume& volume) = nullptr;
  /// What it is built of, where that is not `voxel`.
  double (*source)(const Index3&) = nullptr;
};

template <std::int64_t kScale, std::int64_t kGrain>
double scan(const Index3& p) {
  return static_cast<double>(scan_at(p, kScale, kGrain));
}
double signed_scan(const Index3& p) { return scan<100, 24>(p) - 1024; }
double wide_scan(const Index3& p) { return scan<90000000, 4000>(p) - 1000000000; }
double multiples(const Index3& p) { return scan<50, 9>(p) * 16 + 3; }
double spread(const Index3& p) {
  return static_cast<double>(scan_at(p, 8, 5) % 100 * 255 / 100);
}
double sparse(const Index3& p) {
  return noise_at(p) < 1500 ? static_cast<double>(20 + (noise_at(p) & 127)) : 0;
}
/// Quiet waves in a box of air: quantized details need few corrections.
double waves(const Index3& p) {
  const bool is_inside = p.x > 8 && p.x < 50 && p.y > 6 && p.y < 40 && p.z > 5 && p.z < 30;
  const double x = static_cast<double>(p.x) / 20;
  const double y = static_cast<double>(p.y) / 17;
  return is_inside ? 2000 + std::floor(600 * std::sin(2 * x + y)) + (noise_at(p) & 7) : 0;
}
/// Waves a few voxels long: what is decoded tells more than the means.
double ripples(const Index3& p) {
  const double near = static_cast<double>(p.x) / 2 + static_cast<double>(p.y) / 3;
  const double far = static_cast<double>(p.z) / 2 - static_cast<double>(p.y) / 4;
  return std::floor(700 * std::sin(near) * std::cos(far)) + (noise_at(p) & 7) - 300;
}
double white_noise(const Index3& p) { return noise_at(p) & 0xff; }
double labels(const Index3& p) { return static_cast<double>(label_at(p)); }
double many_labels(const Index3& p) { return noise_at(p) * 7.0; }
double scaled_scan(const Index3& p) { return 0.25 * scan<100, 24>(p) - 100; }
double smooth_floats(const Index3& p) {
  return static_cast<double>(scan_at(p, 1000, 90)) / 1237.0;
}
/// Noise with zeros of both signs, NaN with payloads in a corner, and infinities.
double exact_floats(const Index3& p) {
  const std::uint32_t some = noise_at(p);
  if (p.x + p.y < 9) return std::bit_cast<float>(0x7fc00000u + (p.z > 4 ? some % 3 : 0));
  if (some < 300) return some % 2 == 0 ? std::numeric_limits<double>::infinity() : -0.0;
  if (p.z > 8) return p.x < 20 ? 0.0 : static_cast<double>(some) * 1e-12;
  return static_cast<double>(scan_at(p, 100, 24)) * 0.37 + static_cast<double>(some) / 70001.0;
}
/// Finite or not, all bits are random: no code says less than the floats do.
double any_floats(const Index3& p) {
  return std::bit_cast<float>(noise_at(p) << 16 | noise_at({p.y + 50, p.z + 60, p.x + 70}));
}
/// Floats of 10 bits: few small ones, many large ones that have their own codes, NaN in every row.
double repeated_floats(const Index3& p) {
  const std::uint32_t some = noise_at(p);
  if (some < 9800) return std::numeric_limits<double>::quiet_NaN();
  const auto other = static_cast<float>(noise_at({p.y + 50, p.z + 60, p.x + 70}));
  const float value =
      some < 22000 ? 1000 + other * 0.045F : std::sqrt(static_cast<float>(some % 40)) - 3;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & ~0x1fffU);
}
/// NaN and infinities in smooth floats, and what takes their place.
double holed_floats(const Index3& p) {
  const std::uint32_t some = noise_at(p);
  if (some < 900) return std::numeric_limits<double>::quiet_NaN();
  if (some > 65000) return (some % 2 == 0 ? 1 : -1) * std::numeric_limits<double>::infinity();
  return smooth_floats(p);
}
constexpr float kForNaN = -1.5F;
constexpr float kForInfinity = 40;
double filled_floats(const Index3& p) {
  const double value = holed_floats(p);
  if (std::isnan(value)) return kForNaN;
  return std::isinf(value) ? std::copysign(kForInfinity, value) : value;
}
/// Steep along x, nearly alike along z: another axis order than the usual one pays.
double streaks(const Index3& p) {
  return static_cast<double>(noise_at({p.x, p.y, p.z / 16}) & 0xfff);
}

/// One voxel in a plane of 33 x 32 bricks.
double one_spot(const Index3& p) { return p.x == 2100 && p.y == 2040 ? 9 : p.x < 2050 ? 1 : 0; }
double ramp(const Index3& p) { return static_cast<double>(p.x % 97 + 3 * p.y + p.z); }

Part part_of(const PartTag& tag, std::uint32_t flags, const std::string& text) {
  return {tag, flags, [text](const auto& sink) {
            sink({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
          }};
}

/// A model for each of two slabs.
void write_two_models(FileWriter& writer, SampleVolume& volume) {
  volume.model_layers = 1;
  encode_sample(writer, volume);
}

/// The axes of a mask cut in level 0: all that a model can say, of which builds choose three.
template <std::uint8_t kCutAxes>
void write_cut(FileWriter& writer, SampleVolume& volume) {
  volume.changed_codec = [&](const BrickCodec& codec) {
    Bytes model = codec.serialized();
    model[1] = kCutAxes;
    return parse_model(codec.kind(), volume.description.type, model);
  };
  encode_sample(writer, volume);
}

/// A private part: what it holds stands behind the name of whose it is.
Part private_part(const PartTag& tag, std::uint32_t flags, const std::string& text) {
  const std::string owner = "octavo.example";
  return part_of(tag, flags, static_cast<char>(owner.size()) + owner + text);
}

/// Parts that no program knows, none of which is required.
void write_parts(FileWriter& writer, SampleVolume& volume) {
  encode_sample(writer, volume);
  writer.add_part(private_part({'X', 'n', 'o', 't'}, 0, "stands for itself"));
  writer.add_part(private_part({'X', 'v', 'o', 'x'}, kVoxelPart, std::string(3000, 'd')));
  writer.add_part(private_part({'X', 'm', 'e', 't'}, kRestPart, "5000 letters"));
  writer.add_part(private_part({'X', 'a', 'l', 'l'}, kVoxelPart | kRestPart, ""));
  writer.add_part(private_part({'X', 'n', 'o', 't'}, 0, ""));
}

std::vector<Feature> features() {
  const auto with = [](Preset preset, double max_error) {
    BuildOptions options;
    options.preset = preset;
    options.max_error = max_error;
    return options;
  };
  const auto in_parts = [&](Preset preset, Access access, double max_error = 0) {
    BuildOptions options = with(preset, max_error);
    options.access = access;
    return options;
  };
  const auto details = [&](int level, Preset preset) {
    BuildOptions options = with(preset, 0);
    options.keep_details = level;
    return options;
  };
  BuildOptions as_labels;
  as_labels.kind = VolumeKind::labels;
  BuildOptions filled = with(Preset::small, 0.05);
  filled.repair = {kForNaN, kForInfinity};
  const auto shown = [](BuildOptions options) {
    options.has_thumbnail = true;
    return options;
  };
  const Size3 size{41, 33, 26};
  const Size3 cut_size{35, 34, 36};
  return {
      {"small-int16", {44, 36, 30}, VoxelType::int16, ripples},
      {"small-uint8-thick", {41, 33, 12}, VoxelType::uint8, scan<20, 5>, {}, {1, 1, 4}},
      {"small-int32-wide", {20, 18, 17}, VoxelType::int32, wide_scan},
      {"small-axis-order", {40, 24, 32}, VoxelType::uint16, streaks},
      {"small-two-tiers", {70, 40, 9}, VoxelType::int8, scan<9, 3>},
      {"small-lattice", size, VoxelType::uint16, multiples},
      {"small-edges", size, VoxelType::uint8, sparse},
      {"small-gaps", size, VoxelType::uint8, spread},
      {"stored-uint8", {20, 18, 17}, VoxelType::uint8, white_noise},
      {"fast-int16", size, VoxelType::int16, signed_scan, with(Preset::fast, 0)},
      {"fast-int32-wide", {20, 18, 17}, VoxelType::int32, wide_scan, with(Preset::fast, 0)},
      {"max-error-rounded", size, VoxelType::int16, signed_scan, with(Preset::small, 2)},
      {"max-error-quantised", {60, 48, 36}, VoxelType::uint16, waves, with(Preset::small, 12)},
      {"max-error-fast", size, VoxelType::uint16, scan<1000, 90>, with(Preset::fast, 60)},
      {"float32-scaled", size, VoxelType::float32, scaled_scan},
      {"float32-exact", {66, 18, 12}, VoxelType::float32, exact_floats},
      {"float32-exact-fast", {30, 17, 11}, VoxelType::float32, exact_floats, with(Preset::fast, 0)},
      {"float32-plain", {19, 18, 13}, VoxelType::float32, any_floats},
      {"float32-repeats", {40, 21, 11}, VoxelType::float32, repeated_floats},
      {"float32-max-error", size, VoxelType::float32, smooth_floats, with(Preset::small, 0.05)},
      {"float32-filled", {24, 20, 17}, VoxelType::float32, filled_floats, filled, {1, 1, 1},
       nullptr, holed_floats},
      {"slices-small", {20, 36, 34}, VoxelType::int16, ripples,
       in_parts(Preset::small, Access::slices)},
      {"slices-fast", {36, 34, 33}, VoxelType::int16, signed_scan,
       in_parts(Preset::fast, Access::slices)},
      {"slices-flat", {34, 36, 12}, VoxelType::uint8, scan<20, 5>,
       in_parts(Preset::fast, Access::slices), {1, 1, 4}},
      {"boxes-axis-order", {40, 24, 34}, VoxelType::uint16, streaks,
       in_parts(Preset::small, Access::boxes)},
      {"boxes-gaps", {34, 34, 20}, VoxelType::uint8, spread,
       in_parts(Preset::small, Access::boxes)},
      {"boxes-edges", {34, 20, 34}, VoxelType::uint8, sparse,
       in_parts(Preset::fast, Access::boxes)},
      {"boxes-max-error", {44, 40, 36}, VoxelType::uint16, waves,
       in_parts(Preset::fast, Access::boxes, 12)},
      {"boxes-float32", {34, 36, 20}, VoxelType::float32, smooth_floats,
       in_parts(Preset::fast, Access::boxes, 0.05)},
      {"cut-x", cut_size, VoxelType::uint8, scan<20, 5>, {}, {1, 1, 1}, write_cut<1>},
      {"cut-y", cut_size, VoxelType::uint8, scan<20, 5>, {}, {1, 1, 1}, write_cut<2>},
      {"cut-xy", cut_size, VoxelType::uint8, scan<20, 5>, {}, {1, 1, 1}, write_cut<3>},
      {"cut-z", cut_size, VoxelType::uint8, scan<20, 5>, {}, {1, 1, 1}, write_cut<4>},
      {"cut-xz", cut_size, VoxelType::uint8, scan<20, 5>, {}, {1, 1, 1}, write_cut<5>},
      {"details-int16", {70, 35, 31}, VoxelType::int16, ripples, details(1, Preset::small)},
      {"details-uint8-thick", {41, 33, 13}, VoxelType::uint8, scan<20, 5>,
       details(2, Preset::fast), {1, 1, 4}},
      {"details-last", {12, 10, 9}, VoxelType::int16, ripples, details(4, Preset::small)},
      {"details-stored", {6, 5, 4}, VoxelType::uint8, white_noise, details(1, Preset::small)},
      {"two-pages", {2112, 2048, 1}, VoxelType::uint8, one_spot},
      {"three-tiers", {4097, 3, 2}, VoxelType::int16, ramp},
      {"two-models", {20, 18, 70}, VoxelType::int16, signed_scan, {}, {1, 1, 1}, write_two_models},
      {"parts", {20, 18, 17}, VoxelType::int16, signed_scan, {}, {1, 1, 1}, write_parts},
      {"thumbnail", {300, 7, 40}, VoxelType::int16, signed_scan, shown({}), {1, 1, 2.5}},
      {"thumbnail-labels", size, VoxelType::uint8, labels, shown(as_labels)},
      {"labels-uint8", size, VoxelType::uint8, labels, as_labels},
      {"labels-stored-uint32", {20, 18, 17}, VoxelType::uint32, many_labels, as_labels},
  };
}

std::vector<std::byte> voxels_of(const Feature& feature, double (*voxel_at)(const Index3&)) {
  std::vector<std::byte> voxels(static_cast<std::size_t>(feature.size.voxel_count() *
                                                         bytes_per_voxel(feature.type)));
  with_voxel_type(feature.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    std::byte* out = voxels.data();
    for (std::int64_t z = 0; z < feature.size.z; ++z) {
      for (std::int64_t y = 0; y < feature.size.y; ++y) {
        for (std::int64_t x = 0; x < feature.size.x; ++x, out += sizeof(T)) {
          const auto voxel = static_cast<T>(voxel_at({x, y, z}));
          std::memcpy(out, &voxel, sizeof voxel);
        }
      }
    }
  });
  return voxels;
}

std::vector<std::byte> voxels_of(const Feature& feature) {
  return voxels_of(feature, feature.voxel);
}

/// The file of voxels that are given to the writer brick by brick.
std::vector<std::uint8_t> write(const Feature& feature) {
  SampleVolume volume = make_sample(feature.size, feature.type, Pattern::constant);
  const std::vector<std::byte> voxels = voxels_of(feature);
  std::memcpy(volume.samples[0].data(), voxels.data(), voxels.size());
  volume.description.metadata = Metadata::read(R"({"made_for":")" + std::string(5000, 'm') + "\"}");
  MemoryStorage storage;
  const auto writer = FileWriter::create(storage, "golden.8vo", volume.description, volume.levels,
                                         crc32c(volume.samples[0]), {});
  feature.write(*writer, volume);
  writer->finish();
  return *storage.files.at("golden.8vo");
}

std::vector<std::uint8_t> build(const Feature& feature) {
  if (feature.write != nullptr) return write(feature);
  VolumeDescription description;
  description.size = feature.size;
  description.type = feature.type;
  description.kind = feature.options.kind;
  description.geometry.spacing_mm = feature.spacing;
  const auto voxels =
      voxels_of(feature, feature.source == nullptr ? feature.voxel : feature.source);
  const auto source = make_memory_source(description, voxels);
  MemoryStorage storage;
  NoProgress progress;
  build_file(*source, storage, "golden.8vo", feature.options, progress);
  return *storage.files.at("golden.8vo");
}

std::vector<std::uint8_t> kept(const std::string& name) {
  std::ifstream in(kFolder + name + ".8vo", std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::uint8_t> level_of(const FileReader& reader, int level) {
  const Size3 size = reader.levels().size(level);
  std::vector<std::uint8_t> voxels(static_cast<std::size_t>(
      size.voxel_count() * bytes_per_voxel(reader.description().type)));
  reader.read(box_of(size), level, voxels.data());
  return voxels;
}

std::string crc_text(const std::vector<std::uint8_t>& bytes) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", crc32c(bytes));
  return text;
}

/// The lines of levels.txt for one file.
std::string lines_for(const Feature& feature, const FileReader& reader) {
  std::string lines;
  for (int level = 0; level < reader.levels().count(); ++level) {
    lines += feature.name + ".8vo " + std::to_string(level) + " " +
             crc_text(level_of(reader, level)) + "\n";
  }
  return lines;
}

/// A sound file but for a part that no program knows and that is required.
std::vector<std::uint8_t> file_with_required_part() {
  const Feature feature{"required-part", {20, 18, 17}, VoxelType::int16, signed_scan, {}, {1, 1, 1},
                        [](FileWriter& writer, SampleVolume& volume) {
                          encode_sample(writer, volume);
                          writer.add_part(part_of({'n', 'e', 'e', 'd'}, kRequiredPart, "all"));
                        }};
  return write(feature);
}

void keep(const std::string& name, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(kFolder + name + ".8vo", std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

void write_missing() {
  if (!std::filesystem::exists(kFolder + "newer/required-part.8vo")) {
    keep("newer/required-part", file_with_required_part());
  }
  std::ofstream list(kFolder + "levels.txt", std::ios::binary);
  for (const Feature& feature : features()) {
    const std::string path = kFolder + feature.name + ".8vo";
    if (!std::filesystem::exists(path)) keep(feature.name, build(feature));
    list << lines_for(feature, *open_bytes(kept(feature.name)));
  }
}

class FeatureFile : public ::testing::TestWithParam<Feature> {
 protected:
  static void SetUpTestSuite() {
    static const bool is_written = [] {
      const bool is_asked = std::getenv("OCTAVO_WRITE_GOLDEN") != nullptr;
      if (is_asked) write_missing();
      return is_asked;
    }();
    (void)is_written;
  }
};

TEST_P(FeatureFile, GivesBackWhatItWasMadeOf) {
  const Feature& feature = GetParam();
  const auto reader = open_bytes(kept(feature.name));
  const std::vector<std::uint8_t> found = level_of(*reader, 0);
  const std::vector<std::byte> expected = voxels_of(feature);
  ASSERT_EQ(found.size(), expected.size());
  if (feature.options.max_error == 0 && feature.options.keep_details == 0) {
    EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size()), 0);
    return;
  }
  with_voxel_type(feature.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    double most = 0;
    for (std::size_t at = 0; at < found.size(); at += sizeof(T)) {
      T a, b;
      std::memcpy(&a, found.data() + at, sizeof a);
      std::memcpy(&b, expected.data() + at, sizeof b);
      most = std::max(most, std::abs(static_cast<double>(a) - static_cast<double>(b)));
    }
    if (feature.options.keep_details > 0) EXPECT_EQ(most, reader->max_error());
    else EXPECT_LE(most, feature.options.max_error);
  });
}

TEST_P(FeatureFile, EveryLevelIsAsListed) {
  std::ifstream list(kFolder + "levels.txt");
  std::string listed;
  for (std::string line; std::getline(list, line);) {
    if (line.starts_with(GetParam().name + ".8vo ")) listed += line + "\n";
  }
  EXPECT_EQ(lines_for(GetParam(), *open_bytes(kept(GetParam().name))), listed);
}

TEST_P(FeatureFile, HasAThumbnailOfItsVoxelsWhereOneIsAskedFor) {
  const auto reader = open_bytes(kept(GetParam().name));
  EXPECT_EQ(reader->thumbnail_bytes() > 0, GetParam().options.has_thumbnail);
  EXPECT_TRUE(!GetParam().options.has_thumbnail || has_true_thumbnail(*reader));
}

TEST(NewerFile, IsRejectedAsItsListSays) {
  std::ifstream list(kFolder + "newer/kinds.txt");
  int count = 0;
  for (std::string name, kind; list >> name >> kind; ++count) {
    try {
      open_bytes(kept("newer/" + name));
      ADD_FAILURE() << name << " is opened";
    } catch (const Error& error) {
      EXPECT_EQ(error_kind_name(error.kind()), kind) << name << ": " << error.detail();
    }
  }
  const auto is_8vo = [](const auto& entry) { return entry.path().extension() == ".8vo"; };
  EXPECT_EQ(count, std::ranges::count_if(std::filesystem::directory_iterator(kFolder + "newer"),
                                         std::filesystem::directory_iterator(), is_8vo));
  EXPECT_GT(count, 0);
}

INSTANTIATE_TEST_SUITE_P(Kept, FeatureFile, ::testing::ValuesIn(features()),
                         [](const auto& test) {
                           std::string name = test.param.name;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace octavo
