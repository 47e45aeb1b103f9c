#include "octavo/ops/measure/label_moments.h"

#include <algorithm>
#include <cstddef>
#include <map>

#include "octavo/ops/label/label_portions.h"
#include "octavo/ops/measure/cube_moments.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

// Cubes of 64^3 whose sums are held until they are added.
constexpr std::size_t kCubesAtOnce = 256;

using SumsByLabel = std::map<std::uint32_t, MomentSums>;

class LabelMoments {
 public:
  explicit LabelMoments(const LabelTree& tree)
      : tree_(tree),
        sums_(tree.labels().size()),
        portions_([&tree] { return LabelPortions(tree); }) {}

  std::vector<MomentSums> make() {
    const std::vector<LabelPlace> places = label_places(
        tree_, [&](int rank, std::uint64_t code, std::uint32_t label, std::uint64_t bits) {
          if (is_background(label)) return;
          add_children(bits, child_side(rank), corner_of({2 * (rank + 2), code}), sums_[label]);
        });
    for (std::size_t begin = 0; begin < places.size(); begin += kCubesAtOnce) {
      std::vector<SumsByLabel> of_cubes(std::min(kCubesAtOnce, places.size() - begin));
      parallel_for(std::size_t{0}, of_cubes.size(), [&](std::size_t i) {
        of_cubes[i] = sums_in(places[begin + i], portions_.local());
      });
      for (const SumsByLabel& of_cube : of_cubes) {
        for (const auto& [label, sums] : of_cube) sums_[label].add(sums);
      }
    }
    return std::move(sums_);
  }

 private:
  bool is_background(std::uint32_t label) const { return tree_.labels()[label] == 0; }

  SumsByLabel sums_in(const LabelPlace& at, LabelPortions& portions) const {
    SumsByLabel sums;
    const LabelCube& cube = tree_.cubes(1)[at.place];
    const Index3 corner = corner_of({6, at.code});
    tree_.visit_runs(1, cube, [&](std::uint32_t label, std::uint64_t bits) {
      if (!is_background(label)) add_children(bits, child_side(1), corner, sums[label]);
    });
    std::uint64_t child = cube.first;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const Index3 at_child = child_box(corner, std::countr_zero(left), child_side(1)).lo;
      for (const LabelPortion& portion : portions.in_cube(child++)) {
        MomentSums& to = sums[portion.label];
        add_children(portion.full, child_side(0), at_child, to);
        add_words(portion.mixed, portion.words.data(), at_child, to);
      }
    }
    return sums;
  }

  const LabelTree& tree_;
  std::vector<MomentSums> sums_;
  PerThread<LabelPortions> portions_;
};

}  // namespace

std::vector<MomentSums> label_moments(const LabelTree& tree) { return LabelMoments(tree).make(); }

}  // namespace octavo
