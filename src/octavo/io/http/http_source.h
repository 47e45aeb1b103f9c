// Files behind http(s) URLs, read through byte ranges.
#pragma once

#include <memory>
#include <string>

#include "octavo/file/storage/byte_source.h"
#include "octavo/io/http/http_options.h"

namespace octavo {

/// A thread-safe source over a URL. One request opens it and brings its first 64 KiB; small reads
/// go through a cache of 4 MiB in blocks of 64 KiB. What is fetched before it is read comes over
/// several connections and is kept: 64 MiB of it, or what readings at the same time hold, two parts
/// of 16 MB, or of one brick, each, where that is more. Every answer must be a 206 that begins as
/// asked, of a file of the same length and validator (ETag, else Last-Modified) as the first; the
/// rest of a short one is asked for. Lost connections and answers 429 and 5xx are tried again three
/// times. What a reader finds damaged is asked for once more (read_twice.h). Its name is the
/// URL without its secrets.
/// Throws Error{invalid_argument} when it is no URL; Error{io} when the server is out of reach or
///        too slow, answers an error, ignores ranges, compresses, or when the file was replaced
///        meanwhile; Error{cancelled}
std::shared_ptr<ByteSource> open_url(const std::string& url, const HttpOptions& options = {});

/// A URL, or a file of the local file system. Throws Error{io, cancelled}.
std::shared_ptr<ByteSource> open_any(const std::string& path, const HttpOptions& options = {});

}  // namespace octavo
