// Planes of a stack of which only the files are opened that they are made of.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source_options.h"
#include "octavo/planes/plane_source.h"
#include "octavo/planes/slice_stack.h"

namespace octavo {

/// Opens slices with SourceOptions::excerpt, as open_source does.
using SliceOpener = std::function<std::unique_ptr<PlaneSource>(const std::vector<std::string>&,
                                                               const SourceOptions&)>;

/// A source that opens nothing before a plane is sought or read, and then the slices of the planes
/// up to the end that was sought. Its description and files are those of the whole stack; the
/// warnings of opening, which the stack gave, are left out.
/// options  those that the stack was opened with
/// Throws   when planes are sought or read: what `open` throws, Error{source_rejected} naming a
///          slice where they are no longer of the stack's type, size and rescale
std::unique_ptr<PlaneSource> make_slice_source(SliceStack stack, const SourceOptions& options,
                                               SliceOpener open);

}  // namespace octavo
