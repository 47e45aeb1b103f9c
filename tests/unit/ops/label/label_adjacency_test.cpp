#include "octavo/ops/label/label_adjacency.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

constexpr Connectivity kConnectivities[] = {Connectivity::faces, Connectivity::edges,
                                            Connectivity::corners};

struct LabelScene : public testing::ScratchFolder {
  // Slabs that fill whole bricks, a ball across them, single voxels of negative and large labels.
  LabelScene() : size{200, 150, 140}, labels(static_cast<std::size_t>(size.voxel_count())) {
    std::mt19937 random(1);
    std::size_t i = 0;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x, ++i) {
          std::int16_t label = x >= 128 ? 3 : x >= 64 && z >= 64 ? 5 : 0;
          if (std::hypot(x - 62, y - 40, z - 64) < 25) label = 7;
          if (std::hypot(x - 30, y - 90, z - 100) < 20) label = -2;
          if (random() % 9000 == 0) label = 30000;
          labels[i] = label;
        }
      }
    }
    testing::Volume volume;
    volume.description.size = size;
    volume.description.type = VoxelType::int16;
    volume.description.kind = VolumeKind::labels;
    volume.voxels.resize(2 * labels.size());
    std::memcpy(volume.voxels.data(), labels.data(), volume.voxels.size());
    testing::build_volume(volume, file("labels.8vo"), 2);
    reader = testing::open_file(file("labels.8vo"));
  }

  std::int64_t at(const Index3& p) const {
    if (!box_of(size).contains(p)) return 0;
    return labels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
  }

  // Every pair is met from both sides.
  std::vector<LabelContact> expected(Connectivity connectivity) const {
    std::map<std::pair<std::int64_t, std::int64_t>, LabelContact> pairs;
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          const std::int64_t a = at({x, y, z});
          for (std::size_t i = 0; a != 0 && i < static_cast<std::size_t>(connectivity); ++i) {
            const Direction& d = kDirections[i];
            const std::int64_t b = at({x + d.x, y + d.y, z + d.z});
            if (b == 0 || a >= b) continue;
            LabelContact& contact = pairs[{a, b}];
            contact.first = a;
            contact.second = b;
            ++contact.voxel_pairs;
            if (i < 6) ++contact.face_pairs[d.x != 0 ? 0 : d.y != 0 ? 1 : 2];
          }
        }
      }
    }
    std::vector<LabelContact> contacts;
    for (const auto& [pair, contact] : pairs) contacts.push_back(contact);
    return contacts;
  }

  Size3 size;
  std::vector<std::int16_t> labels;
  std::shared_ptr<FileReader> reader;
};

const LabelScene& scene() {
  static const LabelScene scene;
  return scene;
}

TEST(LabelContacts, AreThoseOfEveryPairOfVoxels) {
  NoProgress progress;
  for (const Connectivity connectivity : kConnectivities) {
    const auto expected = scene().expected(connectivity);
    EXPECT_EQ(expected.size(), 6U);
    EXPECT_EQ(label_contacts(*scene().reader, connectivity, progress), expected);
  }
}

TEST(LabelContacts, DoNotDependOnThreads) {
  NoProgress progress;
  std::vector<LabelContact> alone;
  tbb::task_arena(1).execute(
      [&] { alone = label_contacts(*scene().reader, Connectivity::corners, progress); });
  tbb::task_arena(4).execute([&] {
    EXPECT_EQ(label_contacts(*scene().reader, Connectivity::corners, progress), alone);
  });
}

TEST(LabelContacts, RejectGreyVolumes) {
  const testing::ScratchFolder folder;
  testing::Volume volume;
  volume.description.size = {4, 4, 4};
  volume.description.type = VoxelType::uint8;
  volume.voxels.resize(64);
  testing::build_volume(volume, folder.file("g.8vo"), 1);
  NoProgress progress;
  EXPECT_THROW(label_contacts(*testing::open_file(folder.file("g.8vo")), Connectivity::faces,
                              progress),
               Error);
}

}  // namespace
}  // namespace octavo
