// Mode transparency of `octavo render`: what lies inside shines through what lies around it.
#pragma once

#include <memory>
#include <string>

#include "common/context.h"
#include "common/options.h"
#include "common/render_scene.h"
#include "octavo/file/reader.h"

namespace octavo::cli {

void add_transparency_options(Verb verb, RenderArguments& arguments);

/// Throws Error{invalid_argument} when an option of this mode is given with another, or when there
/// are more pictures in a turntable than directions around a body.
void check_transparency_options(const RenderArguments& arguments);

/// Looks along the lines of voxels that are nearest to the direction asked for, and says so where
/// that is another.
/// Throws Error{invalid_argument} for labels and for ranges, colors or a window that make no
/// sense.
std::unique_ptr<RenderScene> make_transparency_scene(
    const std::shared_ptr<const FileReader>& reader, const RenderArguments& arguments,
    Context& context);

}  // namespace octavo::cli
