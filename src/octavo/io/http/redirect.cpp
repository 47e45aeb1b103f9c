#include "octavo/io/http/redirect.h"

#include <memory>

#include "octavo/core/error.h"
#include "octavo/io/http/curl_library.h"

namespace octavo {

namespace {

/// A URL in its parts.
class UrlParts {
 public:
  UrlParts() : parts_(curl_library().url()) {
    if (!parts_) throw Error(ErrorKind::out_of_memory, "no memory for a URL");
  }

  bool set(CURLUPart part, const std::string& text) {
    return curl_library().url_set(parts_.get(), part, text.c_str(), CURLU_NON_SUPPORT_SCHEME) ==
           CURLUE_OK;
  }

  /// Empty where there is none.
  std::string get(CURLUPart part) const {
    const unsigned flags = part == CURLUPART_PORT ? CURLU_DEFAULT_PORT : 0;
    char* text = nullptr;
    if (curl_library().url_get(parts_.get(), part, &text, flags) != CURLUE_OK) return "";
    const std::unique_ptr<char, decltype(&curl_free)> owner(text, curl_library().free);
    return text;
  }

 private:
  struct Cleanup {
    void operator()(CURLU* parts) const { curl_library().url_cleanup(parts); }
  };
  std::unique_ptr<CURLU, Cleanup> parts_;
};

}  // namespace

std::string redirect_target(const std::string& from, const std::string& location) {
  UrlParts origin;
  UrlParts target;
  // Setting a relative URL resolves it against the one that is there.
  const bool is_url = origin.set(CURLUPART_URL, from) && target.set(CURLUPART_URL, from) &&
                      target.set(CURLUPART_URL, location);
  if (!is_url) throw Error(ErrorKind::io, "the server redirects to what is no URL");
  const std::string scheme = target.get(CURLUPART_SCHEME);
  if (scheme != "http" && scheme != "https") {
    throw Error(ErrorKind::io, "the server redirects to a URL of '" + escaped(scheme) +
                                   "'; only http and https are followed");
  }
  if (scheme == "http" && origin.get(CURLUPART_SCHEME) == "https") {
    throw Error(ErrorKind::io, "the server redirects from https to http, which is not followed");
  }
  bool is_same_server = target.get(CURLUPART_USER).empty();
  for (const CURLUPart part : {CURLUPART_SCHEME, CURLUPART_HOST, CURLUPART_PORT}) {
    is_same_server = is_same_server && target.get(part) == origin.get(part);
  }
  if (is_same_server) {
    for (const CURLUPart part : {CURLUPART_USER, CURLUPART_PASSWORD}) {
      const std::string text = origin.get(part);
      if (!text.empty()) target.set(part, text);
    }
  }
  return target.get(CURLUPART_URL);
}

}  // namespace octavo
