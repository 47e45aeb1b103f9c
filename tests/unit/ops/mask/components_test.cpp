#include "octavo/ops/mask/components.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "octavo/core/error.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

struct DenseComponents {
  std::vector<std::uint32_t> labels;  // as Components numbers them
  std::vector<Component> components;
};

// Voxel by voxel, with a stack.
DenseComponents flooded(const DenseMask& mask, Connectivity connectivity) {
  DenseComponents all;
  std::vector<std::uint32_t> found(mask.voxels.size());
  std::vector<std::uint64_t> first_codes;
  const auto place = [&](const Index3& p) {
    return static_cast<std::size_t>((p.z * mask.size.y + p.y) * mask.size.x + p.x);
  };
  testing::for_each_voxel(mask.size, [&](const Index3& seed) {
    if (mask.at(seed) == 0 || found[place(seed)] != 0) return;
    Component component;
    component.box = {seed, seed};
    std::uint64_t first = interleave(seed);
    std::vector<Index3> stack = {seed};
    const auto label = static_cast<std::uint32_t>(all.components.size() + 1);
    found[place(seed)] = label;
    while (!stack.empty()) {
      const Index3 p = stack.back();
      stack.pop_back();
      ++component.voxel_count;
      first = std::min(first, interleave(p));
      for (int axis = 0; axis < 3; ++axis) {
        component.box.lo[axis] = std::min(component.box.lo[axis], p[axis]);
        component.box.hi[axis] = std::max(component.box.hi[axis], p[axis] + 1);
        component.centroid[static_cast<std::size_t>(axis)] += static_cast<double>(p[axis]);
      }
      for (int i = 0; i < static_cast<int>(connectivity); ++i) {
        const Direction& d = kDirections[static_cast<std::size_t>(i)];
        const Index3 q{p.x + d.x, p.y + d.y, p.z + d.z};
        if (!box_of(mask.size).contains(q) || mask.at(q) == 0 || found[place(q)] != 0) continue;
        found[place(q)] = label;
        stack.push_back(q);
      }
    }
    for (double& sum : component.centroid) sum /= static_cast<double>(component.voxel_count);
    all.components.push_back(component);
    first_codes.push_back(first);
  });
  std::vector<std::uint32_t> order(all.components.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto key = [&](std::uint32_t i) {
      return std::pair(~all.components[i].voxel_count, first_codes[i]);
    };
    return key(a) < key(b);
  });
  std::vector<std::uint32_t> rank(order.size() + 1);
  std::vector<Component> sorted;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    rank[order[i] + 1] = i + 1;
    sorted.push_back(all.components[order[i]]);
  }
  all.components = sorted;
  for (const std::uint32_t label : found) all.labels.push_back(rank[label]);
  return all;
}

void expect_components(const DenseMask& mask, Connectivity connectivity) {
  const DenseComponents expected = flooded(mask, connectivity);
  const MaskTree tree = testing::tree_of(mask);
  const Components found(tree, connectivity);
  ASSERT_EQ(found.components().size(), expected.components.size());
  for (std::size_t i = 0; i < expected.components.size(); ++i) {
    EXPECT_EQ(found.components()[i].voxel_count, expected.components[i].voxel_count);
    EXPECT_EQ(found.components()[i].box, expected.components[i].box);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(found.components()[i].centroid[axis], expected.components[i].centroid[axis],
                  1e-9);
    }
  }
  std::vector<std::uint32_t> labels(mask.voxels.size());
  found.fill_labels(box_of(mask.size), labels.data());
  ASSERT_EQ(labels, expected.labels);
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    const auto i = static_cast<std::size_t>((p.z * mask.size.y + p.y) * mask.size.x + p.x);
    ASSERT_EQ(found.label_of(p), labels[i]);
  });
}

constexpr Connectivity kAll[] = {Connectivity::faces, Connectivity::edges, Connectivity::corners};

TEST(Components, AreThoseOfAFloodOverBoxes) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 3; ++turn) {
      const DenseMask mask = testing::random_mask(size, random);
      for (const Connectivity connectivity : kAll) expect_components(mask, connectivity);
    }
  }
}

TEST(Components, AreThoseOfAFloodOverNoise) {
  // Around the densities at which components grow long.
  std::mt19937 random(2);
  const Size3 size{70, 68, 66};
  for (const unsigned percent : {6u, 10u, 14u, 31u, 50u}) {
    DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
    for (auto& voxel : mask.voxels) voxel = static_cast<std::uint8_t>(random() % 100 < percent);
    for (const Connectivity connectivity : kAll) expect_components(mask, connectivity);
  }
}

TEST(Components, MeetAcrossCubesOfEverySize) {
  // Cubes of full children beside single voxels, touching by a face, an edge and a corner.
  for (const std::int64_t side : {1, 2, 4, 8, 16, 32, 64}) {
    for (const Direction& d : kDirections) {
      const Size3 size{192, 192, 192};
      DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
      testing::for_each_voxel({side, side, side}, [&](const Index3& p) {
        mask.at({64 + p.x, 64 + p.y, 64 + p.z}) = 1;
      });
      const auto beside = [&](int step) { return step < 0 ? 63 : step > 0 ? 64 + side : 64; };
      mask.at({beside(d.x), beside(d.y), beside(d.z)}) = 1;
      const int steps = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
      const MaskTree tree = testing::tree_of(mask);
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t expected = steps <= static_cast<int>(i) + 1 ? 1u : 2u;
        EXPECT_EQ(Components(tree, kAll[i]).components().size(), expected) << side;
      }
    }
  }
}

TEST(Components, SelectKeepsThoseAskedFor) {
  std::mt19937 random(3);
  DenseMask mask = testing::random_mask({90, 70, 80}, random);
  for (auto& voxel : mask.voxels) voxel &= static_cast<std::uint8_t>(random() % 10 != 0);
  const MaskTree tree = testing::tree_of(mask);
  const Components all(tree, Connectivity::faces);
  std::vector<bool> keep(all.components().size());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = random() % 2 == 0;
  const MaskTree selected = all.select(keep);
  ASSERT_TRUE(is_valid(selected));
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    const std::uint32_t label = all.label_of(p);
    ASSERT_EQ(selected.contains(p), label != 0 && keep[label - 1]);
  });
  EXPECT_EQ(all.select(std::vector<bool>(keep.size(), true)), tree);
  EXPECT_TRUE(all.select(std::vector<bool>(keep.size())).is_empty());
}

TEST(Components, DoNotDependOnTheThreads) {
  std::mt19937 random(4);
  DenseMask mask = testing::random_mask({130, 120, 110}, random);
  for (auto& voxel : mask.voxels) voxel ^= static_cast<std::uint8_t>(random() % 4 == 0);
  const MaskTree tree = testing::tree_of(mask);
  std::vector<std::vector<std::uint32_t>> labels;
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena(threads).execute([&] {
      const Components found(tree, Connectivity::edges);
      labels.emplace_back(mask.voxels.size());
      found.fill_labels(box_of(mask.size), labels.back().data());
    });
  }
  EXPECT_EQ(labels[0], labels[1]);
  EXPECT_EQ(labels[0], labels[2]);
}

TEST(Components, StayBelowALimitOfMemory) {
  // A checkerboard: every other voxel is a component.
  DenseMask mask{{64, 64, 32}, {}};
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    mask.voxels.push_back(static_cast<std::uint8_t>((p.x + p.y + p.z) % 2));
  });
  const MaskTree tree = testing::tree_of(mask);
  const Components all(tree, Connectivity::faces);
  EXPECT_EQ(all.components().size(), 64U * 64 * 16);
  EXPECT_GE(all.memory_bytes(), all.components().size() * (sizeof(Component) + 12));
  EXPECT_EQ(Components(tree, Connectivity::faces, 3 * all.memory_bytes()).components().size(),
            all.components().size());
  for (const std::uint64_t limit : {std::uint64_t{1} << 18, all.memory_bytes()}) {
    EXPECT_THROW(Components(tree, Connectivity::faces, limit), Error);
  }
}

}  // namespace
}  // namespace octavo
