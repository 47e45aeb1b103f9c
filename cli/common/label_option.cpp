#include "common/label_option.h"

#include "text/quantities.h"

namespace octavo::cli {

namespace {

bool is_whole_number(const std::string& text) {
  const std::size_t digits = text.starts_with('-') ? 1 : 0;
  return text.size() > digits && text.find_first_not_of("0123456789", digits) == std::string::npos;
}

}  // namespace

Option add_label_option(Verb verb, std::vector<std::string>& labels, const std::string& help) {
  return verb.add_option("--label", labels, help + ": its number or name (may repeat)")
      ->type_name("LABEL")
      ->allow_extra_args(false);
}

AskedLabels parse_labels(const std::vector<std::string>& texts) {
  AskedLabels labels;
  for (const std::string& text : texts) {
    if (is_whole_number(text)) labels.numbers.push_back(parse_integer(text, "--label"));
    else labels.names.push_back(text);
  }
  return labels;
}

}  // namespace octavo::cli
