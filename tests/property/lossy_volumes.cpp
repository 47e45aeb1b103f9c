// The max error holds through whole builds, for every voxel: random float32 volumes, and the CT
// head of Debian's invesalius-examples.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include "octavo/core/error.h"
#include "octavo/io/open_source.h"
#include "support/ct_head.h"
#include "support/goal_cases.h"

namespace octavo::testing {
namespace {

using Random = std::mt19937_64;

constexpr FloatRepair kRepair{.nan = -7.5f, .infinity = 12345.0f};

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

std::int64_t below(Random& random, std::int64_t n) {
  return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
}

/// Floats of one sort each: smooth, noise, any magnitude, any bits, subnormal, steps, lone peaks.
struct FloatVolume {
  VolumeDescription description;
  std::vector<float> voxels;

  explicit FloatVolume(Random& random) {
    const Size3 size{1 + below(random, 130), 1 + below(random, 70), 1 + below(random, 70)};
    description.type = VoxelType::float32;
    description.size = size;
    const auto sort = below(random, 7);
    const double magnitude = std::exp2(uniform(random, -40, 40));
    const double wave = uniform(random, 0.01, 1);
    voxels.resize(static_cast<std::size_t>(size.voxel_count()));
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      voxels[i] = voxel(sort, magnitude, wave, i, random);
    }
    for (std::int64_t special = below(random, 4); special > 0; --special) {
      constexpr float kSpecial[] = {-0.0f, 1e-45f, NAN, INFINITY, -INFINITY};
      voxels[random() % voxels.size()] = kSpecial[below(random, 5)];
    }
  }

  /// What the file is to be near to.
  float meant(std::size_t i) const {
    if (std::isnan(voxels[i])) return *kRepair.nan;
    return std::isinf(voxels[i]) ? std::copysign(*kRepair.infinity, voxels[i]) : voxels[i];
  }

  double largest() const {
    double most = 0;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      most = std::max(most, std::abs(double{meant(i)}));
    }
    return most;
  }

 private:
  static float voxel(std::int64_t sort, double magnitude, double wave, std::size_t i,
                     Random& random) {
    const auto at = static_cast<double>(i);
    switch (sort) {
      case 0: return static_cast<float>(magnitude * std::sin(at * wave));
      case 1: return static_cast<float>(magnitude * uniform(random, -1, 1));
      case 2: return static_cast<float>(std::exp2(uniform(random, -60, 60)));
      case 3: return std::bit_cast<float>(static_cast<std::uint32_t>(random()));
      case 4: return std::bit_cast<float>(static_cast<std::uint32_t>(random() & 0x7fffff));
      case 5: return static_cast<float>(magnitude * std::floor(at * wave / 64));
      default: return random() % 300 == 0 ? static_cast<float>(magnitude) : 0.0f;
    }
  }
};

BuildOptions options_of(Random& random, double max_error) {
  return {.preset = random() % 2 == 0 ? Preset::small : Preset::fast,
          .max_error = max_error,
          .repair = kRepair,
          .overwrite = true};
}

void expect_floats(const FileReader& reader, const FloatVolume& volume, double max_error) {
  std::vector<float> found(volume.voxels.size());
  reader.read(box_of(volume.description.size), 0, found.data());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double difference = std::abs(double{found[i]} - double{volume.meant(i)});
    const bool is_kept = max_error > 0 ? difference <= max_error
                                       : std::bit_cast<std::uint32_t>(found[i]) ==
                                             std::bit_cast<std::uint32_t>(volume.meant(i));
    ASSERT_TRUE(is_kept) << "voxel " << i << ": " << volume.voxels[i] << " became " << found[i]
                         << " within " << max_error;
  }
}

TEST(LossyVolumes, NoFloatBreaksTheBound) {
  constexpr std::uint64_t kThousand = 1000;
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  Random random(8);
  GoalCases goal("F1", "thousand float32 voxels within the bound", case_count(1000, 100'000));
  std::uint64_t voxels = 0;
  std::uint64_t rejected = 0;
  std::uint64_t built = 0;
  while (true) {
    const FloatVolume volume(random);
    // Now and then too small for the steps that a code can tell apart.
    const double max_error = volume.largest() * std::exp2(uniform(random, -33, 1));
    const auto source =
        make_memory_source(volume.description, std::as_bytes(std::span(volume.voxels)));
    NoProgress progress;
    try {
      build_file(*source, local_storage(), path, options_of(random, max_error), progress);
      expect_floats(*open_file(path), volume, max_error);
      if (HasFatalFailure()) return;
      voxels += volume.voxels.size();
      ++built;
    } catch (const Error& error) {
      // No file at all is right.
      ASSERT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
      ++rejected;
    }
    while (goal.done() < voxels / kThousand) {
      if (!goal.next()) {
        EXPECT_GT(built, rejected);
        goal.tell(std::to_string(built) + " volumes, " + std::to_string(rejected) + " rejected");
        return;
      }
    }
  }
}

std::vector<std::int16_t> voxels_of(PlaneSource& source) {
  const Size3 size = source.description().size;
  const auto plane = static_cast<std::size_t>(size.x * size.y);
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t z = 0; z < static_cast<std::size_t>(size.z); ++z) {
    source.read_plane(std::as_writable_bytes(std::span(voxels).subspan(z * plane, plane)));
  }
  return voxels;
}

int largest_difference(const FileReader& reader, const std::vector<std::int16_t>& meant) {
  std::vector<std::int16_t> found(meant.size());
  reader.read(box_of(reader.description().size), 0, found.data());
  int largest = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    largest = std::max(largest, std::abs(found[i] - meant[i]));
  }
  return largest;
}

TEST(LossyVolumes, CtHeadStaysWithinEveryMaxError) {
  const ScratchFolder folder;
  const auto header = ct_head_in(folder);
  if (!header) GTEST_SKIP() << kMissingCtHead;
  const std::string path = folder.file("head.8vo");
  const auto head = open_source({*header}, {});
  ASSERT_EQ(head->description().type, VoxelType::int16);
  const std::vector<std::int16_t> meant = voxels_of(*head);
  const std::vector<double> max_errors =
      is_full_form() ? std::vector{0.0, 0.5, 1.0, 4.0, 100.0} : std::vector{4.0};
  const std::vector<Preset> presets =
      is_full_form() ? std::vector{Preset::small, Preset::fast} : std::vector{Preset::fast};
  std::size_t voxels = 0;
  for (const double max_error : max_errors) {
    for (const Preset preset : presets) {
      const auto source = open_source({*header}, {});
      NoProgress progress;
      const BuildOptions options{.preset = preset, .max_error = max_error, .overwrite = true};
      build_file(*source, local_storage(), path, options, progress);
      const auto reader = open_file(path);
      const int largest = largest_difference(*reader, meant);
      EXPECT_LE(largest, max_error);
      EXPECT_EQ(largest, reader->achieved_error());
      voxels += meant.size();
    }
  }
  std::printf("goal F1: %zu voxels of the CT head within %zu max errors\n", voxels,
              max_errors.size());
}

}  // namespace
}  // namespace octavo::testing
