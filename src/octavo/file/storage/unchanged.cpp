#include "octavo/file/storage/unchanged.h"

#include "octavo/core/path_text.h"

namespace octavo {

namespace {

bool stands(Storage& storage, const std::string& path) {
  try {
    return storage.exists(path);
  } catch (const Error&) {
    return false;  // the failure that led here is the one to report
  }
}

}  // namespace

std::string unchanged_words(const std::string& path) {
  return "; existing " + escaped(base_name_of(without_end_slashes(path))) + " unchanged";
}

Error with_unchanged(Storage& storage, const Error& error, const std::string& path) {
  const std::string words = unchanged_words(path);
  const bool is_said = error.detail().find(words) != std::string::npos;
  if (error.kind() != ErrorKind::io || is_said || !stands(storage, path)) return error;
  return error.with_detail(error.detail() + words);
}

}  // namespace octavo
