// How the memory limit is shared out among what draws rays: reader, bricks, meshes and pictures.
#pragma once

#include <cstdint>

#include "octavo/file/reader.h"
#include "octavo/render/rays/ray_bricks.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/pictures/scene_meshes.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Lists of layers where there are meshes, and of what throws shadows: each a share of the memory
/// limit.
inline constexpr std::uint64_t kLayerShare = 8;

/// What takes memory in a scene of rays.
struct RayMemory {
  const RenderOptions& asked;
  const FileReader& reader;
  const SceneMeshes& meshes;
  const LookSource* looks;
  const SampleSource& source;
};

/// Bricks get what all others leave of the limit.
/// Throws  Error{limit_exceeded} with the limit that would do, where not even one is left room for
RayBricks::Options ray_brick_options(const RayMemory& scene, const TaskContext& context);

}  // namespace octavo
