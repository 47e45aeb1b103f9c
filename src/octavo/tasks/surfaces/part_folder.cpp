#include "octavo/tasks/surfaces/part_folder.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/path_text.h"
#include "octavo/file/layout.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/mesh/formats/mesh_file.h"
#include "octavo/tasks/outputs.h"

namespace octavo {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEarlierEnding = ".earlier";

/// What a file that was replaced is called for a moment; nothing for other names.
std::string replaced_name(const std::string& name) {
  if (!name.starts_with('.') || !name.ends_with(kEarlierEnding)) return {};
  return name.substr(1, name.size() - 1 - kEarlierEnding.size());
}

/// Besides meshes: volumes, and the page that shows them.
constexpr std::array<std::string_view, 7> kSiteEndings = {".8vo",  ".html", ".js",  ".css",
                                                          ".wasm", ".json", ".md"};

bool has_part_name(const std::string& name) {
  return name.starts_with('.') || mesh_format_of(name) ||
         std::any_of(kSiteEndings.begin(), kSiteEndings.end(),
                     [&](std::string_view ending) { return name.ends_with(ending); });
}

}  // namespace

/// A file that a part folder can hold while it is hidden; volumes may have any name.
bool PartFolder::is_part_file(const std::string& path) const {
  std::error_code none;
  const fs::path place(path);
  if (fs::symlink_status(place, none).type() != fs::file_type::regular) return false;
  if (has_part_name(place.filename().string())) return true;
  try {
    const auto source = open_byte_source(storage_, path);
    std::vector<std::uint8_t> header(std::min<std::uint64_t>(kHeaderBytes, source->size()));
    source->read(0, header);
    parse_header(header, source->size());
    return true;
  } catch (const Error&) {
    return false;
  }
}

PartFolder::PartFolder(Storage& storage, std::string path, bool overwrite)
    : storage_(storage), path_(without_end_slashes(std::move(path))), overwrite_(overwrite) {
  const PathType type = storage_.path_type(path_);
  is_new_ = type == PathType::missing;
  if (is_new_) {
    require_folder_around(path_);
  } else if (type != PathType::folder) {
    throw Error(ErrorKind::io, "exists and is not a folder", path_);
  } else if (const std::string why = storage_.why_closed(path_); !why.empty()) {
    throw Error(ErrorKind::io, "cannot create files in it: " + why, path_);
  }
}

PartFolder::~PartFolder() { remove_hidden(); }

void PartFolder::require_free(const std::string& name) const {
  if (!is_new_) octavo::require_free({file(name), overwrite_});
}

/// Calls `f`; what fails carries the name that was asked for, not the hidden one.
template <class F>
auto PartFolder::named(F f) const {
  try {
    return f();
  } catch (const Error& error) {
    const std::string& path = error.path();
    if (hidden_.empty()) throw retold(error, error.kind(), error.detail(), path_);
    if (!path.starts_with(hidden_)) throw;
    throw retold(error, error.kind(), error.detail(), path_ + path.substr(hidden_.size()));
  }
}

void PartFolder::begin() {
  const std::string place = is_new_ ? path_ : file("parts");
  for (const std::string& left : list_temporaries(storage_, place)) remove_left(left);
  TemporaryFile made = create_temporary_folder(storage_, place);
  hidden_ = std::move(made.path);
  lock_ = std::move(made.file);
}

/// Removes what a killed process left; files that it had taken away to replace them come back.
void PartFolder::remove_left(const std::string& left) const {
  const auto lock = storage_.lock_left(left);
  if (!lock) return;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(left, none)) {
    if (!is_part_file(entry.path().string())) continue;
    const std::string replaced = replaced_name(entry.path().filename().string());
    if (!replaced.empty() && !is_new_ && !storage_.exists(file(replaced))) {
      storage_.rename(entry.path().string(), file(replaced));
    } else {
      fs::remove(entry.path(), none);
    }
  }
  fs::remove(left, none);
}

std::uint64_t PartFolder::add(const std::string& name,
                              const std::function<void(PendingFile&)>& write) {
  return named([&] {
    if (hidden_.empty()) begin();
    PendingFile grown(storage_, hidden(name), is_new_ ? hidden(name) : file(name));
    write(grown);
    grown.seal();
    grown.take_name(false);
    names_.push_back(name);
    return grown.size();
  });
}

void PartFolder::take_back(const std::string& name) {
  if (std::erase(names_, name) > 0) named([&] { storage_.remove(hidden(name)); });
}

std::shared_ptr<const ByteSource> PartFolder::open(const std::string& name) const {
  return named([&] { return open_byte_source(storage_, hidden(name)); });
}

void PartFolder::publish() {
  if (hidden_.empty()) return;
  named([&] {
    storage_.sync_folder(hidden_);
    if (is_new_) {
      storage_.rename_new(hidden_, path_);
      hidden_.clear();
      return sync_new_name(storage_, path_);
    }
    try {
      for (const std::string& name : names_) place(name);
      storage_.sync_folder(path_);
    } catch (...) {
      put_back();
      throw;
    }
    placed_.clear();
    remove_hidden();
  });
}

/// Gives one file its name.
void PartFolder::place(const std::string& name) {
  const std::string path = file(name);
  if (!overwrite_ || !storage_.exists(path)) {
    storage_.rename_new(hidden(name), path);
    placed_.push_back({name, ""});
    return;
  }
  if (storage_.exchange(hidden(name), path)) {
    placed_.push_back({name, hidden(name)});
    return;
  }
  const std::string earlier = hidden("." + name + std::string(kEarlierEnding));
  storage_.rename(path, earlier);
  placed_.push_back({name, earlier});
  storage_.rename(hidden(name), path);
}

void PartFolder::put_back() noexcept {
  for (const Placed& placed : placed_) {
    try {
      if (placed.earlier.empty()) storage_.remove(file(placed.name));
      else storage_.rename(placed.earlier, file(placed.name));
    } catch (...) {
      // The failure that led here is the one to report; the rest comes back.
    }
  }
  placed_.clear();
}

void PartFolder::remove_hidden() noexcept {
  if (hidden_.empty()) return;
  for (const std::string& name : names_) {
    remove_quietly(storage_, hidden(name));
    remove_quietly(storage_, hidden("." + name + std::string(kEarlierEnding)));
  }
  std::error_code ignored;
  fs::remove(hidden_, ignored);
  hidden_.clear();
  lock_.reset();
}

}  // namespace octavo
