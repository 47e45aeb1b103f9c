#include "octavo/file/temporary.h"

#include <unistd.h>

#include <utility>

namespace octavo {

namespace {

constexpr int kMaxNameTries = 100;

}  // namespace

std::string temporary_prefix(const std::string& path) {
  constexpr std::size_t kLongestEnding = 32;
  const std::string base = base_name_of(path);
  std::string name = path.substr(0, path.size() - base.size());
  name += '.';
  name += base.substr(0, kMaxNameBytes - kLongestEnding);
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
