// A scan whose labels are given names.
#pragma once

#include <memory>

#include "octavo/core/label_names.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// The planes of `source`, the metadata of which name its labels so and no other way; no names at
/// all leave none.
/// Throws  Error{corrupt} for metadata that cannot be read; Error{limit_exceeded} where metadata
///         cannot hold the names besides what they hold
std::unique_ptr<PlaneSource> with_label_names(std::unique_ptr<PlaneSource> source,
                                              const LabelNames& names);

}  // namespace octavo
