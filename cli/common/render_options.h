// The options of `render`, for every program that has the verb.
#pragma once

#include "common/options.h"
#include "octavo/tasks/pictures/render.h"

namespace octavo::cli {

void add_render_options(Verb verb, RenderOptions& options);

/// Whether a mode casts rays.
bool is_of_rays(RenderMode mode);

}  // namespace octavo::cli
