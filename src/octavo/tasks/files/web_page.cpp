#include "octavo/tasks/files/web_page.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "octavo/core/error.h"
#include "octavo/core/json_text.h"
#include "octavo/core/url_text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/serve/request_head.h"

namespace octavo {

namespace {

namespace fs = std::filesystem;

/// Without these there is no page.
constexpr std::array<const char*, 5> kPageParts = {"index.html", "style.css", "viewer.js",
                                                   "worker.js", "octavo.wasm"};

bool is_one_of(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// What a published folder has besides the page.
bool is_of_site(const std::string& name) {
  return name == kWebListName || name.ends_with(".8vo");
}

}  // namespace

std::vector<std::string> web_page_files(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code none;
  if (!folder.empty()) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
      const std::string name = entry.path().filename().string();
      if (entry.is_regular_file(none) && !is_of_site(name)) names.push_back(name);
    }
  }
  std::sort(names.begin(), names.end());
  for (const char* part : kPageParts) {
    if (is_one_of(names, part)) continue;
    throw Error(ErrorKind::io,
                folder.empty() ? "the page of the viewer is not installed with this program"
                               : std::string("the page of the viewer has no ") + part,
                folder)
        .with_field("page_folder");
  }
  return names;
}

std::vector<std::string> web_names(const std::vector<std::string>& paths,
                                   const std::vector<std::string>& taken) {
  std::vector<std::string> used = taken;
  used.emplace_back(kWebListName);
  std::vector<std::string> names;
  for (const std::string& path : paths) {
    const std::string name = base_name_of(public_name(path));
    const std::size_t dot = name.rfind('.');
    const std::string stem = dot == std::string::npos ? name : name.substr(0, dot);
    const std::string ending = dot == std::string::npos ? "" : name.substr(dot);
    std::string free = name;
    for (int n = 2; is_one_of(used, free); ++n) free = stem + "-" + std::to_string(n) + ending;
    used.push_back(free);
    names.push_back(free);
  }
  return names;
}

std::string web_list(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) {
    list += list.empty() ? "[\n " : ",\n ";
    list += "{\"title\": " + json_string(name) +
            ", \"url\": " + json_string(percent_encoded(name)) + "}";
  }
  return list.empty() ? "[]\n" : list + "\n]\n";
}

}  // namespace octavo
