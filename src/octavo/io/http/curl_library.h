// libcurl, loaded when the first URL is opened: with what it needs itself it costs a quarter of the
// program's start. Where OCTAVO_CURL_LIBRARY is not defined, as in the Python wheel, it is linked.
#pragma once

#include <curl/curl.h>

namespace octavo {

/// The functions of libcurl that are called, by their names without "curl_".
struct CurlLibrary {
  decltype(&::curl_global_init) global_init;
  decltype(&::curl_free) free;
  decltype(&::curl_getdate) getdate;
  decltype(&::curl_easy_init) easy_init;
  decltype(&::curl_easy_setopt) easy_setopt;
  decltype(&::curl_easy_perform) easy_perform;
  decltype(&::curl_easy_cleanup) easy_cleanup;
  decltype(&::curl_easy_strerror) easy_strerror;
  decltype(&::curl_slist_append) slist_append;
  decltype(&::curl_slist_free_all) slist_free_all;
  decltype(&::curl_url) url;
  decltype(&::curl_url_set) url_set;
  decltype(&::curl_url_get) url_get;
  decltype(&::curl_url_cleanup) url_cleanup;
};

/// Loads and starts it where that was not done yet. Threads may call this at once.
/// Throws Error{io} where it is not installed, or does not start
const CurlLibrary& curl_library();

}  // namespace octavo
