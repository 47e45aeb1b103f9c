#include "octavo/file/storage/temporary.h"

#include <unistd.h>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr int kMaxNameTries = 100;
constexpr int kMaxMakeTries = 10;
constexpr std::size_t kLongestEnding = 31;

// A name of so many bytes; names that differ only behind its end get others.
std::string shortened(const std::string& name, std::size_t bytes) {
  char ending[16];
  std::snprintf(ending, sizeof ending, "~%08x",
                crc32c({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()}));
  return name.substr(0, bytes - std::strlen(ending)) + ending;
}

}  // namespace

std::string hidden_prefix(const std::string& path, std::size_t longest_ending) {
  const std::size_t kept = kMaxNameBytes - 1 - longest_ending;
  const std::string base = base_name_of(path);
  std::string name = path.substr(0, path.size() - base.size());
  name += '.';
  name += base.size() <= kept ? base : shortened(base, kept);
  return name;
}

std::string temporary_prefix(const std::string& path) {
  return hidden_prefix(path, kLongestEnding) + ".tmp-";
}

std::string earlier_name(const std::string& path) { return temporary_prefix(path) + "earlier"; }

namespace {

// Takes a number from 1 to `most`, as std::to_string writes it, off the front of `text`.
bool take_positive(std::string_view& text, int most) {
  int number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc{} || text.front() == '0' || number < 1 || number > most) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

}  // namespace

std::optional<TemporaryType> temporary_type(std::string_view ending) {
  if (!take_positive(ending, std::numeric_limits<int>::max())) return std::nullopt;
  if (ending.starts_with('-')) {
    ending.remove_prefix(1);
    if (!take_positive(ending, kMaxNameTries - 1)) return std::nullopt;
  }
  if (ending.empty()) return TemporaryType::growing;
  if (ending == kJournalEnding) return TemporaryType::journal;
  return std::nullopt;
}

std::vector<std::string> list_temporaries(Storage& storage, const std::string& path) {
  const std::string prefix = temporary_prefix(path);
  std::vector<std::string> names = storage.list(prefix);
  std::erase_if(names, [&](const std::string& name) {
    return !temporary_type(std::string_view(name).substr(prefix.size()));
  });
  return names;
}

namespace {

using Make = std::unique_ptr<StorageFile> (Storage::*)(const std::string& path,
                                                       const std::string& target);

TemporaryFile create(Storage& storage, const std::string& path, const std::string& target,
                     Make make) {
  storage.remove_stale(temporary_prefix(path));
  for (int attempt = 1;; ++attempt) {
    std::string name = free_temporary_name(storage, path);
    try {
      auto file = (storage.*make)(name, target);
      return {std::move(name), std::move(file)};
    } catch (const Error&) {
      // In another container a program of the same number may have been faster.
      if (attempt == kMaxMakeTries || !storage.exists(name)) throw;
    }
  }
}

}  // namespace

std::string free_temporary_name(Storage& storage, const std::string& path) {
  const std::string prefix = temporary_prefix(path);
  for (int attempt = 0; attempt < kMaxNameTries; ++attempt) {
    std::string name = prefix + std::to_string(::getpid());
    if (attempt > 0) name.append("-").append(std::to_string(attempt));
    if (!storage.exists(name) && !storage.exists(name + kJournalEnding)) return name;
  }
  throw Error(ErrorKind::io,
              "unfinished files of it lie beside it, " + escaped(base_name_of(prefix)) + "* (" +
                  std::to_string(kMaxNameTries) +
                  " of them), which are locked or may not be removed; remove them",
              path);
}

TemporaryFile create_temporary(Storage& storage, const std::string& path,
                               const std::string& target) {
  return create(storage, path, target, &Storage::create_replacement);
}

TemporaryFile create_temporary(Storage& storage, const std::string& path) {
  return create_temporary(storage, path, path);
}

TemporaryFile create_temporary_folder(Storage& storage, const std::string& path) {
  return create(storage, path, path, &Storage::create_folder);
}

Error retold(const Error& error, ErrorKind kind, const std::string& detail,
             const std::string& path) {
  Error other(kind, detail, path, error.offset());
  for (const OptionHint& hint : error.hints()) other = other.with_field(hint.field, hint.value);
  return other;
}

Error with_final_name(const Error& error, const std::string& path) {
  if (error.path().rfind(temporary_prefix(path), 0) != 0) return error;
  return retold(error, error.kind(), error.detail(), path);
}

void sync_new_name(Storage& storage, const std::string& path) {
  try {
    storage.sync_folder(folder_of(path));
  } catch (const Error& error) {
    throw retold(error, error.kind(),
                 error.detail() + "; what is new stands there, whole, but may not outlast a power "
                                  "cut",
                 path);
  }
}

void remove_quietly(Storage& storage, const std::string& path) noexcept {
  try {
    storage.remove(path);
  } catch (...) {
    // The failure that led here is the one to report.
  }
}

void settle_new_name(Storage& storage, const std::string& path, bool has_replaced) {
  if (has_replaced) return sync_new_name(storage, path);
  try {
    storage.sync_folder(folder_of(path));
  } catch (const Error& error) {
    remove_quietly(storage, path);
    throw retold(error, error.kind(), error.detail(), path);
  }
}

}  // namespace octavo
