// Volumes out of volumes: transforms, condensed ones, OME-Zarr images.
#pragma once

#include <nanobind/nanobind.h>

namespace octavo::python {

void bind_remaking(nanobind::module_& module);

}  // namespace octavo::python
