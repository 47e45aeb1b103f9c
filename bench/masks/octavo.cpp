#include "bench/masks/engine.h"
#include "octavo/octree/mask_accessor.h"
#include "octavo/ops/mask/components.h"
#include "octavo/ops/mask/mask_build.h"
#include "octavo/ops/mask/set_operations.h"
#include "octavo/ops/measure/mask_moments.h"

namespace octavo::bench {
namespace {

MaskTree tree_of(const MaskVolume& volume) {
  const Size3& size = volume.size;
  return make_mask({volume.voxels.data(), VoxelType::int16, size, size.x, size.x * size.y},
                   {static_cast<double>(volume.lowest), 32767});
}

class OctavoMasks : public MaskEngine {
 public:
  OctavoMasks(const MaskVolume& a, const MaskVolume& b)
      : volume_(a), a_(tree_of(a)), b_(tree_of(b)) {}

  std::string name() const override { return "octavo"; }
  std::uint64_t memory_bytes() const override { return a_.memory_bytes(); }

  std::vector<MaskOperation> operations() override {
    const auto set = [this](const char* name, SetOperation operation) {
      return MaskOperation{
          name, [this, operation] { return combine(a_, b_, operation).voxel_count(); }, {}};
    };
    return {{"mask from planes", [this] { return tree_of(volume_).voxel_count(); }, {}},
            set("union", SetOperation::unite),
            set("intersection", SetOperation::intersect),
            set("difference", SetOperation::subtract),
            {"components",
             [this] { return Components(a_, Connectivity::faces).components().size(); },
             {}},
            {"volume and moments", [this] { return mask_moments(a_).count; }, {}},
            {"random voxels",
             [this] {
               std::uint64_t hits = 0;
               const MaskAccessor accessor(a_);
               for_random_voxels(a_.size(), [&](std::int64_t x, std::int64_t y, std::int64_t z) {
                 hits += accessor.contains({x, y, z}) ? 1u : 0u;
               });
               return hits;
             },
             {}}};
  }

 private:
  const MaskVolume& volume_;
  MaskTree a_;
  MaskTree b_;
};

}  // namespace

std::unique_ptr<MaskEngine> make_octavo_masks(const MaskVolume& a, const MaskVolume& b) {
  return std::make_unique<OctavoMasks>(a, b);
}

}  // namespace octavo::bench
