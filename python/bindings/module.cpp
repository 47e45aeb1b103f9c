// octavo._octavo: what the Python of the package is made on.
#include <nanobind/nanobind.h>

#include "building.h"
#include "errors.h"
#include "reading.h"

NB_MODULE(_octavo, module) {
  module.attr("version") = OCTAVO_VERSION;
  octavo::python::register_errors();
  octavo::python::bind_reading(module);
  octavo::python::bind_building(module);
}
