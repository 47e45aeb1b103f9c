// The table of components, whoever found them.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/ops/mask/components.h"
#include "octavo/tasks/components.h"

namespace octavo {

/// Table of the components of a whole mask, the largest first: how many are kept, and their rows.
/// volume      that of the mask
/// held_bytes  that the components take
/// Throws Error{limit_exceeded} when the rows take more than is left of the memory limit
ComponentsResult table_of_components(std::span<const Component> all,
                                     const VolumeDescription& volume,
                                     const ComponentsOptions& options, std::uint64_t held_bytes,
                                     const TaskContext& context);

/// Throws Error{invalid_argument} for a smallest volume where the spacing is not known.
void require_usable(const ComponentsOptions& options, const VolumeDescription& volume);

/// The description of the label map of components, of the smallest type that holds `kept`.
VolumeDescription description_of_components(std::size_t kept, const VolumeDescription& volume,
                                            const ComponentsOptions& options);

}  // namespace octavo
