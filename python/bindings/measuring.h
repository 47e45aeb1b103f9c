// What volumes measure, how they differ, and their surfaces.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_measuring(nanobind::module_& module);

}  // namespace octavo::python
