#include "octavo/tasks/morph.h"

#include <array>

#include "octavo/ops/mask/morphology.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// In the order of Morphology.
constexpr std::array kChanges = {dilate, erode, opening, closing};

Reach reach_of(const MorphOptions& options, const VolumeDescription& volume,
               std::uint64_t max_bytes) {
  if (!options.mm) {
    return Reach::in_steps(options.steps, options.connectivity, volume.size, max_bytes);
  }
  require_known_spacing(volume, options.input, "a distance in mm", "one in voxels");
  return Reach::within_mm(*options.mm, volume.geometry.spacing_mm, volume.size, max_bytes);
}

}  // namespace

MadeBy made_by_morph(const MorphOptions& options) {
  MadeBy made(word_of(options.morphology));
  if (options.mm) {
    made.set("mm", *options.mm);
  } else {
    made.set("steps", options.steps);
    made.set("connectivity", static_cast<int>(options.connectivity));
  }
  return made;
}

MaskTree morphed_mask(const MaskTree& mask, const VolumeDescription& volume,
                      const MorphOptions& options, const TaskContext& context) {
  const Reach reach = reach_of(options, volume, context.max_memory_bytes);
  // The mask, its surface, what it grows to in pieces and whole; the ball; a window per thread.
  context.require_memory(5 * mask.memory_bytes() + reach.memory_bytes() +
                             dilation_thread_bytes(reach, volume.size) *
                                 static_cast<std::uint64_t>(context.thread_count()),
                         "masks that grow");
  MaskTree made;
  context.on_threads([&] {
    made = kChanges[static_cast<std::size_t>(options.morphology)](
        mask, reach, context.watcher(), context.max_memory_bytes);
  });
  if (made.is_empty() && !mask.is_empty()) {
    const std::string name = options.output.path.empty() ? "the mask" : options.output.path;
    context.warn(name + ": is empty; no voxel of " + options.input + " is left");
  }
  return made;
}

MorphResult morph(const MorphOptions& options, const TaskContext& context) {
  require_computed(options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  MorphResult result{.volume = mask.volume(), .voxels_before = mask.tree.voxel_count()};
  const MaskTree made = morphed_mask(mask.tree, result.volume, options, context);
  result.voxels = made.voxel_count();
  result.file_bytes = write_mask(made, result.volume, made_by_morph(options), options.output,
                                 word_of(options.morphology), context)
                          .file_bytes;
  return result;
}

}  // namespace octavo
