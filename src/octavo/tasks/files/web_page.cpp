#include "octavo/tasks/files/web_page.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
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

/// A string that stands in JSON; nothing where the value is none.
std::optional<std::string> text_of(std::string_view json) {
  if (!json.starts_with('"')) return std::nullopt;
  JsonReader in(json);
  in.next();
  return in.string();
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

std::vector<WebListRow> web_rows(const std::vector<std::string>& names) {
  std::vector<WebListRow> rows;
  for (const std::string& name : names) rows.push_back({name, percent_encoded(name)});
  return rows;
}

std::string web_list(const std::vector<WebListRow>& rows) {
  std::string list;
  for (const WebListRow& row : rows) {
    list += list.empty() ? "[\n " : ",\n ";
    list += "{\"title\": " + json_string(row.title) + ", \"url\": " + json_string(row.url) + "}";
  }
  return list.empty() ? "[]\n" : list + "\n]\n";
}

std::vector<WebListRow> read_web_list(std::string_view list) {
  std::vector<WebListRow> rows;
  for (const std::string_view item : json_items(list)) {
    if (!item.starts_with('{')) continue;
    const JsonObject row = json_members(item);
    const std::optional<std::string> title = text_of(row.json_of("title"));
    const std::optional<std::string> url = text_of(row.json_of("url"));
    if (title && url) rows.push_back({*title, *url});
  }
  return rows;
}

}  // namespace octavo
