#include "octavo/ops/mask/component_parts.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/ops/mask/file_mask.h"
#include "support/built_file.h"
#include "support/dense_labels.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

/// The planes of a part alone.
DenseMask planes_alone(const DenseMask& mask, const WorkPart& part) {
  const PlanesOfPart planes = planes_of_part(mask.size.z, part);
  DenseMask alone{mask.size, std::vector<std::uint8_t>(mask.voxels.size())};
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    if (p.z >= planes.first && p.z < planes.end) alone.at(p) = mask.at(p);
  });
  return alone;
}

void expect_same_components(const std::vector<Component>& joined,
                            const std::vector<Component>& whole) {
  ASSERT_EQ(joined.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(joined[i].voxel_count, whole[i].voxel_count);
    EXPECT_EQ(joined[i].box, whole[i].box);
    EXPECT_EQ(joined[i].centroid, whole[i].centroid);
  }
}

/// Numbers, sizes, boxes, centers to the last digit, and the label of every voxel.
void expect_joined(const DenseMask& mask, Connectivity connectivity, std::int64_t count) {
  SCOPED_TRACE(::testing::Message() << count << " parts, " << static_cast<int>(connectivity));
  const MaskTree tree = testing::tree_of(mask);
  const Components whole(tree, connectivity);
  std::vector<PartOfComponents> parts;
  std::vector<std::uint32_t> labels(mask.voxels.size());
  std::vector<std::vector<std::uint32_t>> of_parts;
  for (std::int64_t number = count; number-- > 0;) {
    const MaskTree alone = testing::tree_of(planes_alone(mask, {number, count}));
    const Components found(alone, connectivity);
    parts.push_back(part_of_components(found, {number, count}));
    of_parts.emplace_back(mask.voxels.size());
    found.fill_labels(box_of(mask.size), of_parts.back().data());
  }
  const JoinedComponents joined = joined_components(parts, connectivity);
  expect_same_components(joined.components, whole.components());
  for (std::size_t i = 0; i < of_parts.size(); ++i) {
    const auto& label_of = joined.labels[static_cast<std::size_t>(parts[i].part.number)];
    for (std::size_t v = 0; v < labels.size(); ++v) {
      if (of_parts[i][v] != 0) labels[v] = label_of[of_parts[i][v] - 1];
    }
  }
  std::vector<std::uint32_t> expected(mask.voxels.size());
  whole.fill_labels(box_of(mask.size), expected.data());
  EXPECT_EQ(labels, expected);
}

/// Around the densities at which components grow long.
TEST(ComponentParts, JoinToTheComponentsOfTheWholeMask) {
  std::mt19937 random(5);
  const Size3 size{21, 18, 200};
  for (const unsigned percent : {8u, 12u, 31u, 50u}) {
    DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
    for (auto& voxel : mask.voxels) voxel = static_cast<std::uint8_t>(random() % 100 < percent);
    for (const Connectivity connectivity : testing::kConnectivities) {
      for (const std::int64_t count : {1, 2, 4}) expect_joined(mask, connectivity, count);
    }
  }
}

/// Full and empty cubes; more parts than there are cells, so that some have no plane.
TEST(ComponentParts, JoinWherePartsAreFullOrEmpty) {
  std::mt19937 random(6);
  for (int turn = 0; turn < 6; ++turn) {
    const DenseMask mask = testing::random_mask({70, 40, 150}, random);
    for (const Connectivity connectivity : testing::kConnectivities) {
      for (const std::int64_t count : {2, 7}) expect_joined(mask, connectivity, count);
    }
  }
}

/// A pair of voxels on both sides of a border, in every place where they touch or do not.
TEST(ComponentParts, TouchAcrossABorderAsVoxelsDo) {
  for (std::int64_t dy = -2; dy <= 2; ++dy) {
    for (std::int64_t dx = -2; dx <= 2; ++dx) {
      const Size3 size{5, 5, 128};
      DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
      mask.at({2, 2, 63}) = 1;
      mask.at({2 + dx, 2 + dy, 64}) = 1;
      for (const Connectivity connectivity : testing::kConnectivities) {
        expect_joined(mask, connectivity, 2);
      }
    }
  }
}

TEST(ComponentParts, OfAFileAreThePlanesOfTheParts) {
  std::mt19937 random(7);
  const DenseMask mask = testing::random_mask({50, 40, 150}, random);
  testing::DenseLabels voxels(mask.size);
  voxels.voxels.assign(mask.voxels.begin(), mask.voxels.end());
  const testing::ScratchFolder folder;
  testing::build_volume(testing::volume_of(voxels, 2), folder.file("m.8vo"), 1);
  const auto reader = testing::open_file(folder.file("m.8vo"));
  const ValueWindow ones[] = {{1, 1}};
  NoProgress progress;
  for (const WorkPart& part : {WorkPart{0, 1}, WorkPart{0, 2}, WorkPart{1, 2}, WorkPart{2, 5}}) {
    EXPECT_EQ(testing::dense_of(mask_of_file(*reader, 0, ones, progress, 0, part)),
              planes_alone(mask, part));
  }
}

TEST(ComponentParts, MoreComponentsThanLabelsAreRejected) {
  // Three rods along z that both parts see, and a voxel
  DenseMask mask{{9, 1, 128}, std::vector<std::uint8_t>(9 * 128)};
  for (std::int64_t z = 0; z < 128; ++z) {
    for (const std::int64_t x : {0, 2, 4}) mask.at({x, 0, z}) = 1;
  }
  mask.at({8, 0, 127}) = 1;
  std::vector<PartOfComponents> parts;
  for (const WorkPart& part : {WorkPart{0, 2}, WorkPart{1, 2}}) {
    const MaskTree alone = testing::tree_of(planes_alone(mask, part));
    parts.push_back(part_of_components(Components(alone, Connectivity::faces), part));
  }
  EXPECT_EQ(joined_components(parts, Connectivity::faces, 4).components.size(), 4u);
  try {
    joined_components(parts, Connectivity::faces, 3);
    ADD_FAILURE() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded) << error.what();
  }
}

TEST(ComponentParts, ThatMakeNoWholeAreRejected) {
  const MaskTree tree = testing::tree_of({{4, 4, 4}, std::vector<std::uint8_t>(64, 1)});
  const Components found(tree, Connectivity::faces);
  const PartOfComponents first = part_of_components(found, {0, 2});
  for (const std::vector<PartOfComponents>& parts :
       {std::vector<PartOfComponents>{}, {first}, {first, first}}) {
    EXPECT_THROW(joined_components(parts, Connectivity::faces), Error);
  }
  EXPECT_THROW(part_of_components(found, {2, 2}), Error);
}

}  // namespace
}  // namespace octavo
