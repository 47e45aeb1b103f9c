#include "octavo/tasks/pictures/ray_memory.h"

#include <algorithm>

#include "octavo/core/memory_advice.h"
#include "octavo/core/memory_limit.h"
#include "octavo/render/rays/ray_caster.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/pictures/ray_mode.h"
#include "octavo/tasks/pictures/render_scene.h"
#include "octavo/tasks/pictures/scene_looks.h"

namespace octavo {

namespace {

/// Of a pixel: the values of rays, and three times its color, as in picture_bytes.
constexpr std::uint64_t kPixelBytes = sizeof(double) + 9;

/// What others than bricks take of the memory limit of the context.
std::uint64_t bytes_beside_bricks(const RayMemory& scene, const TaskContext& context) {
  const RenderOptions& asked = scene.asked;
  const std::uint64_t limit = context.max_memory_bytes;
  std::uint64_t bytes = cache_bytes(context) +
                        decoding_bytes(scene.reader.description(), context) + field_bytes(asked) +
                        kPixelBytes * static_cast<std::uint64_t>(asked.width * asked.height) +
                        scene.meshes.memory_bytes();
  if (!scene.meshes.is_empty()) bytes += limit / kLayerShare;
  if (!scene.meshes.is_empty() && asked.has_shadows) bytes += limit / kLayerShare;
  if (!asked.mask.empty()) bytes += limit / kLookShare;
  if (!asked.label_map.empty()) bytes += limit / kLookShare;
  return bytes;
}

/// The smallest limit, in whole MiB, that leaves bricks so many bytes.
std::uint64_t limit_for(const RayMemory& scene, TaskContext context, std::uint64_t brick_bytes) {
  constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20;
  std::uint64_t low = context.max_memory_bytes / kMebibyte;
  std::uint64_t high = std::uint64_t{1} << 40;
  while (low + 1 < high) {
    const std::uint64_t middle = low + (high - low) / 2;
    context.max_memory_bytes = middle * kMebibyte;
    const bool fits =
        bytes_beside_bricks(scene, context) + brick_bytes <= context.max_memory_bytes;
    (fits ? high : low) = middle;
  }
  return high * kMebibyte;
}

}  // namespace

std::uint64_t field_bytes(const RenderOptions& options) {
  const std::uint64_t bytes = ray_field_bytes(options.width, options.height);
  // At edges there are up to four rays a pixel.
  return options.has_smooth_edges ? 4 * bytes : bytes;
}

RayBricks::Options ray_brick_options(const RayMemory& scene, const TaskContext& context) {
  RayBricks::Options options;
  options.looks = scene.looks;
  options.nan = nan_place(scene.asked.mode, scene.reader.description().rescale);
  const std::uint64_t limit = context.max_memory_bytes;
  if (limit == 0) return options;
  const std::uint64_t taken = bytes_beside_bricks(scene, context);
  const std::uint64_t fewest = RayBricks::fewest_bytes(scene.source, options);
  if (taken + fewest > limit) {
    require_memory_within(limit_for(scene, context, fewest), limit, "drawing with rays",
                          memory_advice(context.thread_count()));
  }
  options.memory_bytes = std::min(options.memory_bytes, limit - taken);
  return options;
}

}  // namespace octavo
