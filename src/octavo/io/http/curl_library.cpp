#include "octavo/io/http/curl_library.h"

#include <dlfcn.h>

#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

#ifdef OCTAVO_CURL_LIBRARY

/// The address of a function, as loaded libraries give it.
class CurlFunction {
 public:
  CurlFunction(void* library, const char* name)
      : address_(library == nullptr ? nullptr : ::dlsym(library, name)) {
    if (address_ != nullptr) return;
    const char* const why = ::dlerror();
    throw Error(ErrorKind::io, std::string("libcurl, which reads URLs, cannot be loaded: ") +
                                   (why == nullptr ? name : why));
  }

  template <class Function>
  operator Function*() const {
    return reinterpret_cast<Function*>(address_);
  }

 private:
  void* address_;
};

CurlLibrary found_curl() {
  void* const library = ::dlopen(OCTAVO_CURL_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  const auto named = [&](const char* name) { return CurlFunction(library, name); };
  return {named("curl_global_init"),    named("curl_free"),
          named("curl_getdate"),        named("curl_easy_init"),
          named("curl_easy_setopt"),    named("curl_easy_perform"),
          named("curl_easy_cleanup"),   named("curl_easy_strerror"),
          named("curl_slist_append"),   named("curl_slist_free_all"),
          named("curl_url"),            named("curl_url_set"),
          named("curl_url_get"),        named("curl_url_cleanup")};
}

#else

CurlLibrary found_curl() {
  return {&::curl_global_init,   &::curl_free,          &::curl_getdate,
          &::curl_easy_init,     &::curl_easy_setopt,   &::curl_easy_perform,
          &::curl_easy_cleanup,  &::curl_easy_strerror, &::curl_slist_append,
          &::curl_slist_free_all, &::curl_url,          &::curl_url_set,
          &::curl_url_get,       &::curl_url_cleanup};
}

#endif

CurlLibrary started_curl() {
  const CurlLibrary curl = found_curl();
  if (curl.global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) {
    throw Error(ErrorKind::io, "libcurl does not start");
  }
  return curl;
}

}  // namespace

const CurlLibrary& curl_library() {
  static const CurlLibrary curl = started_curl();
  return curl;
}

}  // namespace octavo
