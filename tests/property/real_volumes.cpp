// The laws of the file on real scans: every voxel and level comes back, levels are means (or most
// frequent labels), the file does not depend on threads. The CT head comes from Debian's
// invesalius-examples; the shared volumes take part where they are present.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "octavo/codec/grey/octant_transform.h"
#include "octavo/io/open_source.h"
#include "support/ct_head.h"
#include "support/goal_cases.h"
#include "support/shared_data.h"

namespace octavo::testing {
namespace {

/// Level-0 voxels as numbers, with what is known of the volume.
struct RealVolume {
  VolumeDescription description;
  std::vector<std::byte> bytes;
  std::vector<std::int32_t> voxels;
};

RealVolume load(const std::string& path, VolumeKind kind) {
  const auto source = open_source({path}, {});
  RealVolume volume;
  volume.description = source->description();
  volume.description.kind = kind;
  const Size3 size = volume.description.size;
  const auto plane_bytes =
      static_cast<std::size_t>(size.x * size.y * bytes_per_voxel(volume.description.type));
  volume.bytes.resize(plane_bytes * static_cast<std::size_t>(size.z));
  for (std::size_t z = 0; z < static_cast<std::size_t>(size.z); ++z) {
    source->read_plane(std::span(volume.bytes).subspan(z * plane_bytes, plane_bytes));
  }
  with_voxel_type(volume.description.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const T* const values = reinterpret_cast<const T*>(volume.bytes.data());
    volume.voxels.reserve(static_cast<std::size_t>(size.voxel_count()));
    for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
      volume.voxels.push_back(static_cast<std::int32_t>(values[i]));
    }
  });
  return volume;
}

std::vector<std::int32_t> read_numbers(const FileReader& reader, const Box& box, int level) {
  const std::vector<std::byte> bytes = read_box(reader, box, level);
  std::vector<std::int32_t> numbers;
  with_voxel_type(reader.description().type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const T* const values = reinterpret_cast<const T*>(bytes.data());
    for (std::size_t i = 0; i < bytes.size() / sizeof(T); ++i) {
      numbers.push_back(static_cast<std::int32_t>(values[i]));
    }
  });
  return numbers;
}

/// The most frequent label of every octant, the smallest of several.
/// voxel_counts  how many voxels lie below every sample
std::vector<std::int32_t> vote(const std::vector<std::int32_t>& fine,
                               const std::vector<double>& voxel_counts, const Size3& size,
                               HalvingMask mask) {
  const Size3 coarse = halved(size, mask);
  std::vector<std::int32_t> labels;
  for (std::int64_t z = 0; z < coarse.z; ++z) {
    for (std::int64_t y = 0; y < coarse.y; ++y) {
      for (std::int64_t x = 0; x < coarse.x; ++x) {
        std::map<std::int32_t, double> votes;
        const Index3 at{x, y, z};
        Box box;
        for (int axis = 0; axis < 3; ++axis) {
          const std::int64_t step = mask >> axis & 1 ? 2 : 1;
          box.lo[axis] = at[axis] * step;
          box.hi[axis] = std::min(box.lo[axis] + step, size[axis]);
        }
        for (std::int64_t k = box.lo.z; k < box.hi.z; ++k) {
          for (std::int64_t j = box.lo.y; j < box.hi.y; ++j) {
            for (std::int64_t i = box.lo.x; i < box.hi.x; ++i) {
              const auto from = static_cast<std::size_t>((k * size.y + j) * size.x + i);
              votes[fine[from]] += voxel_counts[from];
            }
          }
        }
        const auto winner = std::max_element(
            votes.begin(), votes.end(),
            [](const auto& a, const auto& b) { return a.second < b.second; });
        labels.push_back(winner->first);
      }
    }
  }
  return labels;
}

/// Sums of level-0 voxels and their number below every sample of a level.
struct Sums {
  std::vector<double> sum;
  std::vector<double> count;
};
Sums sum_below(const Sums& fine, const Size3& size, HalvingMask mask) {
  const Size3 coarse = halved(size, mask);
  Sums result{std::vector<double>(static_cast<std::size_t>(coarse.voxel_count())),
              std::vector<double>(static_cast<std::size_t>(coarse.voxel_count()))};
  std::size_t i = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x, ++i) {
        const std::int64_t cx = x >> (mask & 1);
        const std::int64_t cy = y >> (mask >> 1 & 1);
        const std::int64_t cz = z >> (mask >> 2 & 1);
        const auto at = static_cast<std::size_t>((cz * coarse.y + cy) * coarse.x + cx);
        result.sum[at] += fine.sum[i];
        result.count[at] += fine.count[i];
      }
    }
  }
  return result;
}

/// Every sample is within 1.5 of the mean of the voxels below it, and their mean deviation is
/// expected to be at most 0.25.
void expect_means(const std::vector<std::int32_t>& samples, const Sums& exact, int level) {
  double worst = 0;
  double total = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double deviation = samples[i] - exact.sum[i] / exact.count[i];
    worst = std::max(worst, std::abs(deviation));
    total += deviation;
  }
  EXPECT_LE(worst, 1.5) << "level " << level;
  const auto count = static_cast<double>(samples.size());
  if (count >= 1000) {
    // Deviations scatter by about 0.42: what the mean of so many may miss its expectation by.
    const double chance = 3 * 0.42 / std::sqrt(count);
    EXPECT_LT(std::abs(total / count), 0.25 + chance) << "level " << level;
  }
}

/// A level of a volume as if it were one brick.
BrickShape shape_of_level(const Levels& levels, int level) {
  BrickShape shape;
  shape.first_level = level;
  shape.level_count = 1;
  shape.size[0] = levels.size(level);
  shape.halving[0] = levels.halving(level);
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t each = std::int64_t{1} << levels.halving_count(level, axis);
    shape.weights.each[axis] = each;
    shape.weights.last[axis] = levels.size(0)[axis] - (levels.size(level)[axis] - 1) * each;
  }
  return shape;
}

void expect_levels(const FileReader& reader, const RealVolume& volume) {
  const Levels& levels = reader.levels();
  const bool is_grey = volume.description.kind == VolumeKind::grey;
  std::vector<std::int32_t> reference = volume.voxels;
  Sums exact{std::vector<double>(reference.begin(), reference.end()),
             std::vector<double>(reference.size(), 1.0)};
  for (int level = 0; level < levels.count(); ++level) {
    const Size3 size = levels.size(level);
    const std::vector<std::int32_t> samples = read_numbers(reader, box_of(size), level);
    ASSERT_TRUE(samples == reference) << "level " << level << " is not the reference pyramid";
    if (is_grey && level > 0) expect_means(samples, exact, level);
    const HalvingMask mask = levels.halving(level);
    if (is_grey) {
      reference = coarser_level(reference, shape_of_level(levels, level), 0, reader.axis_order());
    } else {
      reference = vote(reference, exact.count, size, mask);
    }
    exact = sum_below(exact, size, mask);
  }
}

void expect_boxes(const FileReader& reader, const RealVolume& volume) {
  std::mt19937_64 random(5);
  const Size3 size = volume.description.size;
  const std::int64_t width = bytes_per_voxel(volume.description.type);
  for (int i = 0; i < 40; ++i) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      const auto extent = static_cast<std::uint64_t>(size[axis]);
      box.lo[axis] = static_cast<std::int64_t>(random() % extent);
      const auto room =
          static_cast<std::uint64_t>(std::min<std::int64_t>(70, size[axis] - box.lo[axis]));
      box.hi[axis] = box.lo[axis] + 1 + static_cast<std::int64_t>(random() % room);
    }
    ASSERT_TRUE(read_box(reader, box, 0) == crop(volume.bytes, size, width, box));
  }
}

void expect_laws(const std::string& path, VolumeKind kind) {
  SCOPED_TRACE(path);
  const RealVolume volume = load(path, kind);
  const ScratchFolder folder;
  const std::string file = folder.file("volume.8vo");
  build_volume({volume.description, volume.bytes}, file, 2);
  const auto reader = open_file(file);
  EXPECT_EQ(reader->description().geometry, volume.description.geometry);
  EXPECT_EQ(reader->description().rescale, volume.description.rescale);
  expect_levels(*reader, volume);
  expect_boxes(*reader, volume);
}

TEST(RealVolumes, CtHeadKeepsEveryLaw) {
  const ScratchFolder folder;
  const auto header = ct_head_in(folder);
  if (!header) GTEST_SKIP() << kMissingCtHead;
  expect_laws(*header, VolumeKind::grey);
  const RealVolume volume = load(*header, VolumeKind::grey);
  std::string first;
  const std::vector<int> counts = is_full_form() ? std::vector{1, 2, 3, 8} : std::vector{1, 3};
  for (const int threads : counts) {
    const std::string file = folder.file("threads.8vo");
    std::filesystem::remove(file);
    build_volume({volume.description, volume.bytes}, file, threads);
    const std::string bytes = bytes_of_file(file);
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << threads << " threads";
  }
}

struct SharedVolume {
  const char* name;
  VolumeKind kind;
};

class SharedVolumes : public ::testing::TestWithParam<SharedVolume> {};

TEST_P(SharedVolumes, KeepEveryLaw) {
  const auto path = shared_file(GetParam().name);
  if (!path) GTEST_SKIP() << missing_shared_file(GetParam().name);
  expect_laws(path->string(), GetParam().kind);
}

INSTANTIATE_TEST_SUITE_P(
    All, SharedVolumes,
    ::testing::Values(SharedVolume{"ct_chest_lidc0314", VolumeKind::grey},
                      SharedVolume{"microct_trabecular_bone", VolumeKind::grey},
                      SharedVolume{"microct_mouse_head/C57BL6_J_.nii.gz", VolumeKind::grey},
                      SharedVolume{"lightsheet_brain_half", VolumeKind::grey},
                      SharedVolume{"mr/chris_t1.nii.gz", VolumeKind::grey},
                      SharedVolume{"mr/chris_MRA.nii.gz", VolumeKind::grey},
                      SharedVolume{"labels/totalseg_ct.nii.gz", VolumeKind::grey},
                      SharedVolume{"labels/aal.nii.gz", VolumeKind::labels},
                      SharedVolume{"labels/inia19-NeuroMaps.nii.gz", VolumeKind::labels},
                      SharedVolume{"labels/totalseg_ct_labels.nii.gz", VolumeKind::labels},
                      SharedVolume{"microct_rock_berea/berea400.nrrd", VolumeKind::labels},
                      SharedVolume{"binary_bone/bone_7H3A_B1.tif", VolumeKind::labels}));

}  // namespace
}  // namespace octavo::testing
