// Files out of arrays and of planes as they come.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_building(nanobind::module_& module);

}  // namespace octavo::python
