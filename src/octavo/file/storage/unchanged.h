// What a failure says of the file that would have been replaced.
#pragma once

#include <string>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// "; existing NAME unchanged": the end of a message.
std::string unchanged_words(const std::string& path);

/// A failure to write what would have replaced the file or folder at `path`, which still stands
/// there: it says so, once. Other kinds than io are as they were, and so is all where nothing
/// stands there.
Error with_unchanged(Storage& storage, const Error& error, const std::string& path);

}  // namespace octavo
