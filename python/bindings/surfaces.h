// Surfaces and meshes for Python: arrays, and files.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_surfaces(nanobind::module_& module);

}  // namespace octavo::python
