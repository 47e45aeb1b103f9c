// Whether a volume that is read plane by plane holds two values only, as masks do.
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "octavo/planes/plane_source.h"

namespace octavo {

/// The two values of integer voxels, the smaller one first; nothing where there are more or fewer,
/// or floats. Shared with the source that fills it.
using TwoValues = std::optional<std::pair<std::int64_t, std::int64_t>>;

/// The planes of `source`, looked at on their way; after the last of them `found` says what they
/// hold, nothing once one was sought. It costs a pass over each plane while no third value has
/// come.
std::unique_ptr<PlaneSource> watch_values(std::unique_ptr<PlaneSource> source,
                                          std::shared_ptr<TwoValues> found);

}  // namespace octavo
