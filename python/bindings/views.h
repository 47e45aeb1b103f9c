// Views of volumes from a side, for Python.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_views(nanobind::module_& module);

}  // namespace octavo::python
