// Names that are given to labels.
#pragma once

#include <memory>

#include "octavo/core/label_names.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// Proves that the labels of a volume can be named.
/// path    of what holds it, for the message; may be empty
/// Throws  Error{invalid_argument} of field "label_names" for grey values
void require_labels_to_name(VolumeKind kind, const std::string& path);

/// Names the labels so in metadata, and no other way; no names at all leave none.
/// Throws  Error{corrupt} for metadata that cannot be read; Error{limit_exceeded} where metadata
///         cannot hold the names besides what they hold
void set_label_names(Metadata& metadata, const LabelNames& names);

/// The planes of `source`, named by set_label_names. Throws as that does
std::unique_ptr<PlaneSource> with_label_names(std::unique_ptr<PlaneSource> source,
                                              const LabelNames& names);

}  // namespace octavo
