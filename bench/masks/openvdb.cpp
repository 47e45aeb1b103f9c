#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Prune.h>

#include "bench/masks/engine.h"

namespace octavo::bench {
namespace {

using Tree = openvdb::MaskTree;
using Leaf = Tree::LeafNodeType;

// Leaf by leaf, straight from the voxels; full leaves become tiles.
Tree::Ptr tree_of(const MaskVolume& volume) {
  const Size3& size = volume.size;
  auto tree = std::make_shared<Tree>();
  constexpr std::int64_t kSide = Leaf::DIM;
  for (std::int64_t z = 0; z < size.z; z += kSide) {
    for (std::int64_t y = 0; y < size.y; y += kSide) {
      for (std::int64_t x = 0; x < size.x; x += kSide) {
        const openvdb::Coord origin(static_cast<int>(x), static_cast<int>(y),
                                    static_cast<int>(z));
        auto leaf = std::make_unique<Leaf>(origin, false, false);
        const Box box = intersection({{x, y, z}, {x + kSide, y + kSide, z + kSide}},
                                     box_of(size));
        for (std::int64_t k = z; k < box.hi.z; ++k) {
          for (std::int64_t j = y; j < box.hi.y; ++j) {
            const std::int16_t* const row = volume.voxels.data() + (k * size.y + j) * size.x;
            for (std::int64_t i = x; i < box.hi.x; ++i) {
              if (row[i] < volume.lowest) continue;
              leaf->setValueOn(static_cast<openvdb::Index>((i - x) * kSide * kSide +
                                                           (j - y) * kSide + k - z));
            }
          }
        }
        if (!leaf->isEmpty()) tree->addLeaf(leaf.release());
      }
    }
  }
  openvdb::tools::prune(*tree);
  return tree;
}

// By way of a dense array of bits, as the library offers it.
Tree::Ptr tree_by_copying(const MaskVolume& volume) {
  const Size3& size = volume.size;
  const openvdb::CoordBBox box(0, 0, 0, static_cast<int>(size.x - 1), static_cast<int>(size.y - 1),
                               static_cast<int>(size.z - 1));
  openvdb::tools::Dense<bool, openvdb::tools::LayoutXYZ> dense(box);
  bool* const to = dense.data();
  for (std::size_t i = 0; i < volume.voxels.size(); ++i) to[i] = volume.voxels[i] >= volume.lowest;
  auto tree = std::make_shared<Tree>();
  openvdb::tools::copyFromDense(dense, *tree, false);
  openvdb::tools::prune(*tree);
  return tree;
}

class OpenVdbMasks : public MaskEngine {
 public:
  OpenVdbMasks(const MaskVolume& a, const MaskVolume& b)
      : volume_(a), a_(tree_of(a)), b_(tree_of(b)) {}

  std::string name() const override { return "openvdb"; }
  std::uint64_t memory_bytes() const override { return a_->memUsage(); }

  std::vector<MaskOperation> operations() override {
    return {{"mask from planes", [this] { return tree_of(volume_)->activeVoxelCount(); }, {}},
            {"mask from planes by copyFromDense",
             [this] { return tree_by_copying(volume_)->activeVoxelCount(); },
             {}},
            set("union", [](Tree& to, const Tree& other) { to.topologyUnion(other); }),
            set("intersection",
                [](Tree& to, const Tree& other) { to.topologyIntersection(other); }),
            set("difference", [](Tree& to, const Tree& other) { to.topologyDifference(other); }),
            in_place("union",
                     [](Tree& to, const Tree& other) { to.topologyUnion(other); }),
            in_place("intersection",
                     [](Tree& to, const Tree& other) { to.topologyIntersection(other); }),
            in_place("difference",
                     [](Tree& to, const Tree& other) { to.topologyDifference(other); }),
            {"components",
             [this] {
               const auto grid = openvdb::MaskGrid::create(a_);
               std::vector<openvdb::MaskGrid::Ptr> parts;
               openvdb::tools::segmentActiveVoxels(*grid, parts);
               return parts.size();
             },
             {}},
            {"random voxels",
             [this] {
               std::uint64_t hits = 0;
               openvdb::tree::ValueAccessor<const Tree> accessor(*a_);
               for_random_voxels(volume_.size,
                                 [&](std::int64_t x, std::int64_t y, std::int64_t z) {
                                   hits += accessor.isValueOn({static_cast<int>(x),
                                                               static_cast<int>(y),
                                                               static_cast<int>(z)})
                                               ? 1u
                                               : 0u;
                                 });
               return hits;
             },
             {}}};
  }

 private:
  using SetFunction = std::function<void(Tree&, const Tree&)>;

  // A new tree, both inputs kept: what the other libraries do.
  MaskOperation set(const char* name, const SetFunction& operation) {
    return {name,
            [this, operation] {
              Tree result(*a_);
              operation(result, *b_);
              return result.activeVoxelCount();
            },
            {}};
  }

  // The first tree is overwritten; its copy is not timed, nor is the count.
  MaskOperation in_place(const std::string& name, const SetFunction& operation) {
    return {name + " in place",
            [this, operation] {
              operation(*scratch_, *b_);
              return std::uint64_t{0};
            },
            [this] { scratch_ = std::make_shared<Tree>(*a_); }};
  }

  const MaskVolume& volume_;
  Tree::Ptr a_;
  Tree::Ptr b_;
  Tree::Ptr scratch_;
};

}  // namespace

std::unique_ptr<MaskEngine> make_openvdb_masks(const MaskVolume& a, const MaskVolume& b) {
  openvdb::initialize();
  return std::make_unique<OpenVdbMasks>(a, b);
}

}  // namespace octavo::bench
