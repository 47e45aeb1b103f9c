// A 4 x 4 matrix out of a text file.
#pragma once

#include <string>

#include "octavo/ops/grid/affine.h"

namespace octavo {

/// The map in a text file of 12 or 16 numbers, row by row: a 4 x 4 matrix, the last row of which,
/// 0 0 0 1, may be left out. Numbers are separated by white space, commas or brackets; # begins a
/// comment.
/// Throws  Error{io} when the file cannot be read; Error{source_rejected} for anything else in it,
///         and for a matrix without an inverse
Affine read_affine(const std::string& path);

}  // namespace octavo
