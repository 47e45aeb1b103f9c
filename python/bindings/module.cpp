// octavo._octavo: what the Python of the package is made on.
#include <nanobind/nanobind.h>

#include "building.h"
#include "errors.h"
#include "label_maps.h"
#include "measuring.h"
#include "octavo/core/text_order.h"
#include "pictures.h"
#include "reading.h"
#include "remaking.h"
#include "structure.h"
#include "surfaces.h"
#include "views.h"

NB_MODULE(_octavo, module) {
  module.attr("version") = OCTAVO_VERSION;
#ifdef NDEBUG
  // Processes that end without taking down their modules, as those of workers do, are no fault.
  nanobind::set_leak_warnings(false);
#endif
  octavo::set_text_order(octavo::TextOrder::zyx);
  octavo::python::register_errors();
  octavo::python::bind_reading(module);
  octavo::python::bind_building(module);
  octavo::python::bind_label_maps(module);
  octavo::python::bind_measuring(module);
  octavo::python::bind_pictures(module);
  octavo::python::bind_remaking(module);
  octavo::python::bind_structure(module);
  octavo::python::bind_surfaces(module);
  octavo::python::bind_views(module);
}
