// Pictures of volumes as arrays of pixels.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_pictures(nanobind::module_& module);

}  // namespace octavo::python
