#include "text/offered_words.h"

#include <functional>
#include <map>

#include "octavo/core/voxel_type.h"
#include "octavo/tasks/files/serve.h"
#include "octavo/tasks/files/write_phantom.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/pictures/slice.h"
#include "octavo/tasks/pictures/transfer_file.h"

namespace octavo::cli {

namespace {

using Words = std::vector<std::string>;

Words colors() {
  const std::vector<std::string_view> names = named_colors();
  return {names.begin(), names.end()};
}

Words transfers() {
  Words words;
  for (const TransferPreset& preset : transfer_presets()) words.emplace_back(preset.name);
  return words;
}

Words only(std::initializer_list<std::string_view> words) { return {words.begin(), words.end()}; }

}  // namespace

std::vector<std::string> window_words() {
  Words words;
  for (const WindowPreset& preset : window_presets()) words.emplace_back(preset.name);
  words.emplace_back(kAutomatic);
  return words;
}

std::vector<std::string> phantom_type_words() {
  Words words;
  for (const VoxelType type : phantom_types()) words.emplace_back(voxel_type_name(type));
  return words;
}

OfferedWords offered_words(const OptionEntry& option) {
  if (!option.choices.empty()) return {option.choices, false};
  static const std::map<std::string, std::function<Words()>> kByName = {
      {"WINDOW", window_words},
      {"COLOR", colors},
      {"SIDE|X,Y,Z", viewpoint_names},
      {"PRESET|FILE", transfers},
      {"TYPE", phantom_type_words},
      {"FILL", [] { return only({kLowest, kCoarse}); }},
      {"N|off", [] { return only({kOff}); }},
      {"TOKEN", [] { return only({kNewToken}); }}};
  const auto found = kByName.find(option.value);
  if (found == kByName.end()) return {};
  return {found->second(), option.value == "PRESET|FILE"};
}

}  // namespace octavo::cli
