#include "common/volume_options.h"

#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/value_ranges.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

const NamedValues<Connectivity> kConnectivities = {
    {"6", Connectivity::faces}, {"18", Connectivity::edges}, {"26", Connectivity::corners}};

bool is_whole_number(const std::string& text) {
  const std::size_t digits = text.starts_with('-') ? 1 : 0;
  return text.size() > digits && text.find_first_not_of("0123456789", digits) == std::string::npos;
}

}  // namespace

Option add_mask_input(Verb verb, std::string& path) {
  return verb.add_option("mask FILE", path, "A label map, .8vo").required();
}

Option add_level(Verb verb, int& level, const std::string& help) {
  return verb.add_option("--level K", level, help).capture_default_str();
}

Option add_connectivity(Verb verb, Connectivity& connectivity, const std::string& help) {
  return verb.add_word("--connectivity N", connectivity, kConnectivities, help);
}

Option add_connectivity(Verb verb, std::optional<Connectivity>& connectivity,
                        const std::string& help) {
  return verb.add_word("--connectivity N", connectivity, kConnectivities, help);
}

Option add_label_option(Verb verb, AskedLabels& labels, const std::string& help) {
  return verb.add_texts("--label LABEL", help + ": its number or name (may repeat)",
                        [&labels](const std::string& text, const std::string& option) {
                          take_label(labels, text, option);
                        });
}

void take_label(AskedLabels& labels, const std::string& text, const std::string& option) {
  if (is_whole_number(text)) labels.numbers.push_back(parse_integer(text, option));
  else labels.names.push_back(text);
}

Option add_tissues(Verb verb, std::vector<std::string>& tissues) {
  return verb.add_list("--tissue NAME", tissues, "A range by name").check(one_of(tissue_names()));
}

Option add_preset(Verb verb, Preset& preset) {
  return verb.add_word("--preset NAME", preset, "small: fewest bytes; fast: several times faster");
}

}  // namespace octavo::cli
