// Files behind http(s) URLs, read through byte ranges.
#pragma once

#include <memory>
#include <string>

#include "octavo/file/storage/byte_source.h"

namespace octavo {

/// True for names that start with http:// or https://.
bool is_url(const std::string& path);

/// A thread-safe source over a URL. One request opens it and brings its first 64 KiB; small reads
/// go through a cache of 4 MiB in blocks of 64 KiB. Every answer must be a 206 with exactly the
/// asked range, of a file of the same length and validator (ETag, else Last-Modified) as the first;
/// lost connections and answers 429 and 5xx are tried again three times.
/// Throws Error{invalid_argument} when it is no URL; Error{io} when the server is out of reach,
///        answers an error, ignores ranges, compresses, or when the file was replaced meanwhile
std::shared_ptr<ByteSource> open_url(const std::string& url);

/// A URL, or a file of the local file system. Throws Error{io}.
std::shared_ptr<ByteSource> open_any(const std::string& path);

}  // namespace octavo
