#include "errors.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>

#include "octavo/core/error.h"

namespace octavo::python {

namespace nb = nanobind;

namespace {

nb::object exception_of(const Error& error) {
  nb::list hints;
  for (const OptionHint& hint : error.hints()) {
    hints.append(nb::make_tuple(hint.field, hint.value));
  }
  const nb::object offset = error.offset() ? nb::cast(*error.offset()) : nb::none();
  return nb::module_::import_("octavo._errors")
      .attr("make_error")(error_kind_name(error.kind()), error.detail(), error.path(), offset,
                          hints);
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const Error& error) {
    const nb::object exception = exception_of(error);
    PyErr_SetObject(exception.type().ptr(), exception.ptr());
  } catch (const nb::cast_error&) {
    const nb::object exception = exception_of(
        Error(ErrorKind::invalid_argument, "an argument is of a type that has no meaning here"));
    PyErr_SetObject(exception.type().ptr(), exception.ptr());
  }
}

}  // namespace

void register_errors() { nb::register_exception_translator(translate); }

}  // namespace octavo::python
