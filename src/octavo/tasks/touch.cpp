#include "octavo/tasks/touch.h"

#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

std::optional<double> area_mm2(const std::array<std::uint64_t, 3>& faces,
                               const VolumeDescription& volume) {
  if (!is_spacing_known(volume)) return std::nullopt;
  const Point3& s = volume.geometry.spacing_mm;
  return static_cast<double>(faces[0]) * s[1] * s[2] + static_cast<double>(faces[1]) * s[0] * s[2] +
         static_cast<double>(faces[2]) * s[0] * s[1];
}

TouchMasksResult touch_masks(const TouchMasksOptions& options, const TaskContext& context) {
  const OpenedMask a = open_mask(options.a, context);
  const OpenedMask b = open_mask(options.b, context);
  require_same_grid(a.volume(), a.path, b.volume(), b.path);
  TouchMasksResult result{a.volume(), {}};
  context.on_threads([&] { result.found = interference(a.tree, b.tree, options.connectivity); });
  return result;
}

TouchLabelsResult touch_labels(const TouchLabelsOptions& options, const TaskContext& context) {
  const auto labels = open_labels(options.labels, context, kAsLabels);
  // A brick per thread, with its labels widened.
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  context.require_memory(12 * kMiB * static_cast<std::uint64_t>(context.thread_count()), "labels");
  TouchLabelsResult result{labels->description(), {}};
  context.on_threads([&] {
    result.contacts = label_contacts(*labels, options.connectivity, context.watcher());
  });
  return result;
}

}  // namespace octavo
