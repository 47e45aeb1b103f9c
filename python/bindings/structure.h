// Distances, thickness and poses of masks.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_structure(nanobind::module_& module);

}  // namespace octavo::python
