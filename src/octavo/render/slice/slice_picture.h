// One slice of a file as a picture for people.
#pragma once

#include <optional>

#include "octavo/file/reader.h"
#include "octavo/render/picture.h"
#include "octavo/render/slice_orientation.h"
#include "octavo/render/window.h"

namespace octavo {

struct SliceOptions {
  int axis = 2;                       ///< index axis the slice lies across: 0 x, 1 y, 2 z
  std::optional<std::int64_t> index;  ///< in samples of `level`; default the middle
  int level = 0;
  std::optional<Window>
      window;  ///< real units; default from the values of the slice; not for labels
  bool scale_bar = true;
  bool sides = true;              ///< R L A P S I at the edges
  std::int64_t least_side = 256;  ///< smaller pictures are enlarged by a whole number
  int threads = 0;
};

struct SlicePicture {
  Picture picture;      ///< grey, or colors for labels
  Window window;        ///< the one used; meaningless for labels
  double pixel_mm = 1;  ///< side of a pixel
  SliceOrientation orientation;
};

/// Draws a slice with square pixels, as fine as the finer of its two spacings: grey values linearly
/// interpolated, labels never. Only the bricks that the slice touches are read.
/// Throws Error{invalid_argument} when axis, level, index or window make no sense,
///        Error{limit_exceeded} above 2^28 pixels, and what the reader throws
SlicePicture render_slice(const FileReader& reader, const SliceOptions& options);

}  // namespace octavo
