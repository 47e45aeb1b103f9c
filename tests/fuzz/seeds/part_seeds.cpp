// Plans and parts of small volumes, of every kind that a plan tells apart.

#include <string>

#include "fuzz/seeds/seed_folder.h"
#include "octavo/builder/group_reader.h"
#include "octavo/dist/plan_text.h"
#include "support/small_parts.h"

namespace octavo::fuzz {

namespace {

using testing::SmallVolume;

std::vector<SmallVolume> seed_volumes() {
  std::vector<SmallVolume> all;
  const Size3 size = {9, 7, 130};
  all.push_back(testing::small_volume("grey", VoxelType::int16, size));
  all.back().options.max_error = 1;
  all.push_back(testing::small_volume("details", VoxelType::uint8, size));
  all.back().options.keep_details = 1;
  all.push_back(testing::small_volume("labels", VoxelType::uint16, size, VolumeKind::labels));
  all.push_back(testing::small_volume("floats", VoxelType::float32, size));
  all.back().options.repair = {1.5f, -2.0f};
  return all;
}

void save_text(SeedFolder& seeds, const BuildPlan& plan) {
  const std::string text = plan_text(plan);
  seeds.save("plan", {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// The same plan of slices in a file each, straight, and moved and mixed.
void save_stacks(SeedFolder& seeds, BuildPlan plan) {
  const std::int64_t planes = plan.source.size.z;
  SliceStack stack{plan.source, {}};
  stack.files.outline.emplace();
  for (std::int64_t z = 0; z < planes; ++z) {
    plan.files.push_back({"/scan/s" + std::to_string(z), 126, 1'700'000'000'000'000'000 + z});
    stack.files.paths.push_back(plan.files.back().path);
    stack.files.of_plane.push_back({z, z + 1});
  }
  plan.inputs = {"/scan"};
  plan.stack = stack;
  plan.id = id_of(plan);
  save_text(seeds, plan);
  SliceOutline& outline = *plan.stack->files.outline;
  for (std::int64_t z = 0; z < planes; ++z) {
    outline.planes.push_back({static_cast<std::size_t>(z), z % 3 == 1 && z + 1 < planes ? 0.5 : 0});
    if (outline.planes.back().weight_above > 0) {
      ++plan.stack->files.of_plane[static_cast<std::size_t>(z)].end;
    }
  }
  outline.padding = -2000;
  outline.tilt = TiltRemoval{3.5, {}, plan.source.size.x, plan.source.size.y, -1000};
  outline.tilt->shift.resize(static_cast<std::size_t>(planes), {0.5, 1});
  plan.id = id_of(plan);
  save_text(seeds, plan);
}

}  // namespace

void save_parts(SeedFolder& seeds) {
  const SmallGroups groups(1 << 11);
  for (const SmallVolume& volume : seed_volumes()) {
    const BuildPlan plan = testing::planned(volume);
    save_text(seeds, plan);
    if (volume.name == "grey") save_stacks(seeds, plan);
    testing::MemoryStorage storage;
    testing::make_part(volume, plan, {1, 3}, storage);
    Bytes input;
    put(input, static_cast<std::uint16_t>(volume.description.size.z - 1));
    put(input, std::uint16_t{1});
    put_bytes(input, *storage.files.at(testing::part_name({1, 3})));
    seeds.save("part", input);
  }
}

}  // namespace octavo::fuzz
