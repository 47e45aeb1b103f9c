// Files of trees against the files of their voxels.
#include "octavo/builder/tree_builder.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>

#include "octavo/core/error.h"
#include "octavo/planes/computed_source.h"
#include "support/built_file.h"
#include "support/dense_labels.h"
#include "support/dense_mask.h"
#include "support/memory_storage.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::MemoryStorage;

constexpr const char* kName = "a.8vo";
const std::vector<int> kThreads = {1, 2, 8};

VolumeDescription description_of(const Size3& size, VoxelType type, const Point3& spacing_mm) {
  VolumeDescription description;
  description.kind = VolumeKind::labels;
  description.type = type;
  description.size = size;
  description.geometry.spacing_mm = spacing_mm;
  return description;
}

// The bytes of a file that `build` writes.
template <class Build>
std::vector<std::uint8_t> bytes_of(Build build) {
  MemoryStorage storage;
  build(storage);
  EXPECT_EQ(storage.files.size(), 1u);
  return *storage.files.at(kName);
}

// The file of the voxels of a tree, read plane by plane.
template <class Tree>
std::vector<std::uint8_t> bytes_of_planes(const Tree& tree, const VolumeDescription& description) {
  const auto source = make_computed_source(description, [&](const Box& box, std::byte* voxels) {
    with_voxel_type(description.type, [&](auto id) {
      using T = typename decltype(id)::type;
      if constexpr (std::is_integral_v<T>) {
        fill_voxels(tree, box, reinterpret_cast<T*>(voxels));
      }
    });
  });
  return bytes_of([&](Storage& storage) {
    NoProgress progress;
    build_file(*source, storage, kName,
               {.kind = VolumeKind::labels, .is_resumable = false, .threads = 2}, progress);
  });
}

BuildResult build_tree(const MaskTree& tree, const VolumeDescription& description,
                       Storage& storage, const TreeBuildOptions& options, Progress& progress) {
  return build_mask_file({tree, description}, storage, kName, options, progress);
}
BuildResult build_tree(const LabelTree& tree, const VolumeDescription& description,
                       Storage& storage, const TreeBuildOptions& options, Progress& progress) {
  return build_label_file({tree, description}, storage, kName, options, progress);
}

template <class Tree>
void expect_same_file(const Tree& tree, VoxelType type, const Point3& spacing_mm,
                      const std::vector<int>& threads = kThreads) {
  const VolumeDescription description = description_of(tree.size(), type, spacing_mm);
  const auto expected = bytes_of_planes(tree, description);
  for (const int count : threads) {
    const auto found = bytes_of([&](Storage& storage) {
      NoProgress progress;
      const BuildResult result =
          build_tree(tree, description, storage, {.threads = count}, progress);
      EXPECT_EQ(result.threads, count);
      EXPECT_EQ(result.file_bytes, expected.size());
    });
    ASSERT_TRUE(found == expected) << count << " threads";
  }
}

const std::vector<Point3> kSpacings = {{1, 1, 1}, {1, 1, 2}, {0.5, 0.5, 5}, {3, 1, 1}};

TEST(TreeBuilder, MasksOfOddSizesAndSpacingsHaveTheFileOfTheirVoxels) {
  std::mt19937 random(41);
  std::vector<Size3> sizes = testing::odd_sizes();
  sizes.insert(sizes.end(), {{64, 64, 65}, {129, 128, 3}, {300, 20, 20}});
  for (std::size_t i = 0; i < 2 * sizes.size(); ++i) {
    const MaskTree mask =
        testing::tree_of(testing::random_mask(sizes[i % sizes.size()], random));
    expect_same_file(mask, VoxelType::uint8, kSpacings[i % kSpacings.size()]);
  }
}

TEST(TreeBuilder, LabelMapsOfEveryTypeHaveTheFileOfTheirVoxels) {
  std::mt19937 random(42);
  const std::vector<std::pair<VoxelType, std::vector<std::int32_t>>> cases = {
      {VoxelType::int8, {-128, -1, 127}},
      {VoxelType::uint8, {1, 2, 255}},
      {VoxelType::int16, {-32768, 5, 32767}},
      {VoxelType::uint16, {1, 65535}},
      {VoxelType::int32, {-2147483647, -1, 1, 2147483647}},
      {VoxelType::uint32, {1, 2147483647}}};
  std::size_t round = 0;
  for (const auto& [type, names] : cases) {
    for (const Size3& size : {Size3{1, 1, 1}, Size3{70, 66, 65}, Size3{130, 67, 21}}) {
      const LabelTree tree = testing::tree_of(testing::random_labels(size, names, random));
      expect_same_file(tree, type, kSpacings[round++ % kSpacings.size()]);
    }
  }
}

TEST(TreeBuilder, ManyLabelsHaveTheFileOfTheirVoxels) {
  std::mt19937 random(43);
  std::vector<std::int32_t> names(5000);
  for (std::int32_t& name : names) name = static_cast<std::int32_t>(random() % 1000000);
  const LabelTree grains =
      testing::tree_of(testing::random_labels({90, 80, 70}, names, random));
  expect_same_file(grains, VoxelType::int32, {1, 1, 1}, {2});

  // Bricks of more labels than are coded: these are stored.
  DenseLabels noise({70, 64, 64});
  for (std::int32_t& voxel : noise.voxels) voxel = static_cast<std::int32_t>(random() >> 2);
  expect_same_file(testing::tree_of(noise), VoxelType::int32, {1, 1, 1}, {2});
}

TEST(TreeBuilder, EmptyAndFullMasksHaveTheFileOfTheirVoxels) {
  for (const Size3& size : {Size3{1, 1, 1}, Size3{64, 64, 64}, Size3{65, 130, 200},
                            Size3{256, 256, 256}}) {
    expect_same_file(MaskTree(size), VoxelType::uint8, {1, 1, 1});
    expect_same_file(box_mask(size, box_of(size)), VoxelType::uint8, {1, 1, 1});
    expect_same_file(box_mask(size, box_of(size)), VoxelType::int16, {1, 1, 2});
    expect_same_file(LabelTree(size), VoxelType::int8, {1, 1, 1});
  }
}

// 32 MiB make a group.
TEST(TreeBuilder, BricksOfOneLabelEachHaveTheFileOfTheirVoxels) {
  constexpr std::int64_t kSide = 64;
  const Size3 size{150, 100, 130};
  DenseLabels labels(size);
  visit_cells(box_of(size), {kSide, kSide, kSide}, [&](const Index3& cell) {
    const Index3 lo{cell.x * kSide, cell.y * kSide, cell.z * kSide};
    const Box box{lo, {lo.x + kSide, lo.y + kSide, lo.z + kSide}};
    labels.fill(intersection(box, box_of(size)), (cell.x + cell.y + cell.z) % 2 == 0 ? 2 : 3);
    return true;
  });
  expect_same_file(testing::tree_of(labels), VoxelType::uint16, {1, 1, 1});
}

TEST(TreeBuilder, VolumesOfSeveralGroupsHaveTheFileOfTheirVoxels) {
  const Size3 size{420, 400, 260};
  std::mt19937 random(44);
  DenseLabels labels(size);
  const auto below = [&](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  for (int i = 0; i < 60; ++i) {
    const Index3 lo{below(size.x), below(size.y), below(size.z)};
    labels.fill({lo, {lo.x + 1 + below(90), lo.y + 1 + below(90), lo.z + 1 + below(90)}}, i % 7);
  }
  // 41 MiB a layer as uint32, 20 as uint16.
  expect_same_file(testing::tree_of(labels), VoxelType::uint32, {1, 1, 1}, {2});
  expect_same_file(testing::tree_of(labels), VoxelType::uint16, {1, 1, 1}, {8});
}

// ---- what goes wrong

MaskTree some_mask(const Size3& size) {
  std::mt19937 random(45);
  return testing::tree_of(testing::random_mask(size, random));
}

TEST(TreeBuilder, EveryFailingCallLeavesNothing) {
  const MaskTree mask = some_mask({130, 70, 66});
  const VolumeDescription description =
      description_of(mask.size(), VoxelType::uint8, {1, 1, 1});
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    storage.fail_at = k;
    NoProgress progress;
    bool has_thrown = false;
    try {
      build_tree(mask, description, storage, {.threads = 2}, progress);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io) << error.what();
      has_thrown = true;
    }
    EXPECT_EQ(has_thrown, storage.has_failed) << "call " << k;
    if (!storage.has_failed) {
      EXPECT_GT(k, 10u);
      return;
    }
    const bool was_named = storage.calls.back() == "sync_folder";
    ASSERT_EQ(storage.files.size(), was_named ? 1u : 0u) << "call " << k;
  }
}

TEST(TreeBuilder, AStopAtAnyLookLeavesNothing) {
  const MaskTree mask = some_mask({200, 130, 66});
  const VolumeDescription description =
      description_of(mask.size(), VoxelType::uint8, {1, 1, 1});
  for (const int threads : {1, 2}) {
    for (int k = 0;; ++k) {
      MemoryStorage storage;
      testing::StoppingProgress progress(k);
      ErrorKind kind = ErrorKind::internal;
      try {
        build_tree(mask, description, storage, {.threads = threads}, progress);
        kind = ErrorKind::io;
      } catch (const Error& error) {
        kind = error.kind();
      }
      EXPECT_EQ(progress.ends_, 1);
      if (progress.questions_ <= k) {
        EXPECT_GT(k, 10);
        EXPECT_EQ(storage.files.size(), 1u);
        break;
      }
      EXPECT_EQ(kind, ErrorKind::cancelled);
      ASSERT_TRUE(storage.files.empty()) << "look " << k;
    }
  }
}

TEST(TreeBuilder, ProgressCountsEveryPlane) {
  for (const Size3& size : {Size3{1, 1, 1}, Size3{70, 70, 300}, Size3{600, 520, 200}}) {
    MemoryStorage storage;
    testing::StoppingProgress progress(1 << 30);
    build_tree(box_mask(size, {{0, 0, 0}, {30, 50, 70}}),
               description_of(size, VoxelType::uint8, {1, 1, 1}), storage, {.threads = 2},
               progress);
    EXPECT_EQ(progress.total_, size.z);
    EXPECT_EQ(progress.done_, size.z);
    EXPECT_EQ(progress.ends_, 1);
  }
}

ErrorKind kind_of_failure(const LabelTree& tree, const VolumeDescription& description,
                          const TreeBuildOptions& options) {
  MemoryStorage storage;
  testing::StoppingProgress progress(1 << 30);
  try {
    build_tree(tree, description, storage, options, progress);
  } catch (const Error& error) {
    EXPECT_TRUE(storage.calls.empty());
    EXPECT_EQ(progress.total_, 0);
    return error.kind();
  }
  ADD_FAILURE() << "it was built";
  return ErrorKind::internal;
}

TEST(TreeBuilder, WhatDoesNotFitTheTreeIsRejectedBeforeAnythingIsDone) {
  const LabelTree tree = testing::tree_of(DenseLabels({5, 6, 7}, 256));
  const Point3 spacing{1, 1, 1};
  for (const VolumeDescription& description :
       {description_of({5, 6, 8}, VoxelType::uint16, spacing),
        description_of({5, 6, 7}, VoxelType::uint8, spacing),
        description_of({5, 6, 7}, VoxelType::float32, spacing)}) {
    EXPECT_EQ(kind_of_failure(tree, description, {}), ErrorKind::invalid_argument);
  }
  const auto fitting = description_of({5, 6, 7}, VoxelType::uint16, spacing);
  EXPECT_EQ(kind_of_failure(tree, fitting, {.interrupted = Interrupted::resume}),
            ErrorKind::invalid_argument);
  const std::uint64_t need = tree_build_memory_bytes(fitting, 1);
  EXPECT_EQ(kind_of_failure(tree, fitting, {.threads = 1, .max_memory_bytes = need - 1}),
            ErrorKind::limit_exceeded);
}

TEST(TreeBuilder, AnExistingFileIsKeptUnlessOverwriteIsAsked) {
  const testing::ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  std::ofstream(path) << "precious";
  const MaskTree mask = some_mask({20, 20, 20});
  const auto description = description_of(mask.size(), VoxelType::uint8, {1, 1, 1});
  NoProgress progress;
  EXPECT_THROW(build_mask_file({mask, description}, local_storage(), path, {}, progress), Error);
  EXPECT_EQ(testing::bytes_of_file(path), "precious");
  build_mask_file({mask, description}, local_storage(), path, {.overwrite = true}, progress);
  EXPECT_NE(testing::bytes_of_file(path), "precious");
}

}  // namespace
}  // namespace octavo
