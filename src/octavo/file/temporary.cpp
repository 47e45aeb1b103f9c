#include "octavo/file/temporary.h"

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

#include "octavo/codec/crc32c.h"

namespace octavo {

namespace {

constexpr int kMaxNameTries = 100;
constexpr std::size_t kLongestEnding = 32;
constexpr std::size_t kKeptNameBytes = kMaxNameBytes - kLongestEnding;

// A name of kKeptNameBytes; names that differ only behind its end get others.
std::string shortened(const std::string& name) {
  char ending[16];
  std::snprintf(ending, sizeof ending, "~%08x",
                crc32c({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}));
  return name.substr(0, kKeptNameBytes - std::strlen(ending)) + ending;
}

}  // namespace

std::string temporary_prefix(const std::string& path) {
  const std::string base = base_name_of(path);
  std::string name = path.substr(0, path.size() - base.size());
  name += '.';
  name += base.size() <= kKeptNameBytes ? base : shortened(base);
  return name + ".tmp-";
}

namespace {

using Make = std::unique_ptr<StorageFile> (Storage::*)(const std::string&);

TemporaryFile create(Storage& storage, const std::string& path, Make make) {
  const std::string prefix = temporary_prefix(path);
  storage.remove_stale(prefix);
  for (int attempt = 0;; ++attempt) {
    std::string name = prefix + std::to_string(::getpid());
    if (attempt > 0) name.append("-").append(std::to_string(attempt));
    const bool is_taken = storage.exists(name) || storage.exists(name + kJournalEnding);
    if (attempt + 1 < kMaxNameTries && is_taken) continue;
    auto file = (storage.*make)(name);
    return {std::move(name), std::move(file)};
  }
}

}  // namespace

TemporaryFile create_temporary(Storage& storage, const std::string& path) {
  return create(storage, path, &Storage::create_exclusive);
}

TemporaryFile create_temporary_folder(Storage& storage, const std::string& path) {
  return create(storage, path, &Storage::create_folder);
}

}  // namespace octavo
