#include "octavo/io/dicom/dicom_library.h"

#include <dlfcn.h>

#include "octavo/core/error.h"

#ifndef OCTAVO_GDCM_LIBRARY
extern "C" const octavo::DicomLibrary* octavo_gdcm();
#endif

namespace octavo {

namespace {

#ifdef OCTAVO_GDCM_LIBRARY

const DicomLibrary* loaded_library() {
  using Function = const DicomLibrary*();
  void* const library = ::dlopen(OCTAVO_GDCM_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  void* const symbol = library == nullptr ? nullptr : ::dlsym(library, "octavo_gdcm");
  if (symbol != nullptr) return reinterpret_cast<Function*>(symbol)();
  const char* const why = ::dlerror();
  throw Error(ErrorKind::io, std::string("the DICOM reader cannot be loaded: ") +
                                 (why == nullptr ? OCTAVO_GDCM_LIBRARY : why));
}

#else

const DicomLibrary* loaded_library() { return octavo_gdcm(); }

#endif

}  // namespace

const DicomLibrary& dicom_library() {
  static const DicomLibrary& library = *loaded_library();
  return library;
}

}  // namespace octavo
