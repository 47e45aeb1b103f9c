// Planes between thick slices: asked for by a build, repeated by whoever compares with its source.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "octavo/planes/between/isotropic_source.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// The planes of `source` with those in between, if any are needed; notes what is done.
/// name    of the source, for messages
/// method  linear or cubic; nothing: `source` itself. Labels are interpolated by shape.
/// Throws  as plan_isotropic; Error{invalid_argument} for a method that is not for labels
std::unique_ptr<PlaneSource> make_isotropic(const std::string& name,
                                            std::unique_ptr<PlaneSource> source,
                                            std::optional<PlaneInterpolation> method,
                                            VolumeKind kind, const TaskContext& context);

/// The planes of `source` with those in between that the description of a file built from it tells
/// of.
/// Throws  as plan_isotropic; Error{invalid_argument} for a method that is not known
std::unique_ptr<PlaneSource> repeat_isotropic(const std::string& name,
                                              std::unique_ptr<PlaneSource> source,
                                              const VolumeDescription& file,
                                              const TaskContext& context);

}  // namespace octavo
