#include "text/label_words.h"

#include <fmt/format.h>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/utf8.h"
#include "text/fact_json.h"

namespace octavo::cli {

nlohmann::ordered_json name_json(const LabelNames& names, std::int64_t label) {
  return text_json(names.name_of(label));
}

std::string name_suffix(const LabelNames& names, std::int64_t label) {
  const std::string& name = names.name_of(label);
  return name.empty() ? "" : " " + escaped(name);
}

std::string csv_cell(const std::string& text) {
  const std::string shown = has_control(text) ? escaped(text) : text;
  if (shown.find_first_of(",\"") == std::string::npos) return shown;
  std::string quoted = "\"";
  for (const char c : shown) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + "\"";
}

std::string named_labels_text(const LabelNames& names) {
  constexpr std::size_t kShown = 3;
  std::string text;
  std::size_t named = 0;
  for (const auto& [label, entry] : names.all()) {
    if (entry.name.empty() || named++ >= kShown) continue;
    text += fmt::format("{}{} {}", named == 1 ? "" : ", ", label, escaped(entry.name));
  }
  if (named == 0) return "";
  return count_text(static_cast<std::int64_t>(named)) + " named: " + text +
         (named > kShown ? ", ..." : "");
}

}  // namespace octavo::cli
