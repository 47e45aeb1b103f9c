// The words of boxes of trees against dense arrays.
#include "octavo/octree/tree_words.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "octavo/octree/o_code.h"
#include "support/dense_labels.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseLabels;

// The words of a box by their definition, voxel by voxel.
LabelWords words_of_voxels(const DenseLabels& labels, const Box& box) {
  std::map<std::int32_t, std::uint32_t> places;
  testing::for_each_voxel(box.size(), [&](const Index3& p) {
    places[labels.at({box.lo.x + p.x, box.lo.y + p.y, box.lo.z + p.z})] = 0;
  });
  LabelWords words;
  for (auto& [label, place] : places) {
    place = static_cast<std::uint32_t>(words.labels.size());
    words.labels.push_back(label);
  }
  for (std::size_t word = 0; word < LabelWords::kCount; ++word) {
    words.first[word] = static_cast<std::uint32_t>(words.parts.size());
    std::map<std::uint32_t, std::uint64_t> parts;
    for (std::uint64_t bit = 0; bit < 64; ++bit) {
      const Index3 p = deinterleave(64 * word + bit);
      const Index3 voxel{box.lo.x + p.x, box.lo.y + p.y, box.lo.z + p.z};
      if (box.contains(voxel)) parts[places[labels.at(voxel)]] |= std::uint64_t{1} << bit;
    }
    for (const auto& [label, bits] : parts) words.parts.push_back({label, bits});
  }
  words.first.back() = static_cast<std::uint32_t>(words.parts.size());
  return words;
}

// Calls visit(box) for the bricks of a volume whose sides are `side`.
template <class Visit>
void for_each_brick(const Size3& size, const Size3& side, Visit visit) {
  visit_cells(box_of(size), side, [&](const Index3& brick) {
    const Index3 lo{brick.x * side.x, brick.y * side.y, brick.z * side.z};
    visit(intersection({lo, {lo.x + side.x, lo.y + side.y, lo.z + side.z}}, box_of(size)));
    return true;
  });
}

const std::vector<Size3> kSides = {{64, 64, 64}, {64, 64, 16}, {64, 32, 8}, {4, 64, 64},
                                   {8, 8, 64}};

template <class Tree>
void expect_words(const Tree& tree, const DenseLabels& labels, const Size3& side) {
  LabelWords words;
  for_each_brick(labels.size, side, [&](const Box& box) {
    const LabelWords expected = words_of_voxels(labels, box);
    words_of(tree, box, words);
    ASSERT_EQ(words, expected);
    const auto only = only_label(tree, box);
    ASSERT_EQ(only.has_value(), expected.is_uniform());
    ASSERT_EQ(only.value_or(expected.labels.front()), expected.labels.front());
  });
}

TEST(TreeWords, AreThoseOfTheVoxelsOfEveryBrick) {
  std::mt19937 random(5);
  for (const Size3& size : testing::odd_sizes()) {
    const testing::DenseMask mask = testing::random_mask(size, random);
    DenseLabels labels(size);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i) labels.voxels[i] = mask.voxels[i];
    const std::vector<std::int32_t> names = {-7, 1, 2, 3, 70000};
    const DenseLabels many = testing::random_labels(size, names, random);
    for (const Size3& side : kSides) {
      expect_words(testing::tree_of(mask), labels, side);
      expect_words(testing::tree_of(many), many, side);
    }
  }
}

TEST(TreeWords, OfCubesThatAreNotStoredHaveOneLabel) {
  const Size3 size{200, 130, 70};
  for (const std::int32_t label : {0, 1}) {
    const DenseLabels labels(size, label);
    expect_words(testing::tree_of(labels), labels, {64, 64, 64});
    expect_words(box_mask(size, label == 0 ? Box{} : box_of(size)), labels, {64, 64, 64});
  }
}

TEST(LabelWords, FilledOnesAreThoseOfAUniformBrick) {
  LabelWords words;
  for (const Size3& size : {Size3{64, 64, 64}, Size3{1, 1, 1}, Size3{5, 64, 63}}) {
    fill_words(size, -9, words);
    EXPECT_EQ(words, words_of_voxels(DenseLabels(size, -9), box_of(size)));
  }
}

}  // namespace
}  // namespace octavo
