// What the library throws, as exceptions of Python.
#pragma once

namespace octavo::python {

/// From now on Error becomes what octavo._errors.make_error makes of it.
void register_errors();

}  // namespace octavo::python
