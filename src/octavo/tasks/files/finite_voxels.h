// Whether a volume of floats holds any number at all.
#pragma once

#include "octavo/file/reader.h"

namespace octavo {

/// Whether a voxel is finite, as far as one sample says: of lossless float32 the coarsest is NaN
/// where none is.
bool has_finite_voxels(const FileReader& reader);

}  // namespace octavo
