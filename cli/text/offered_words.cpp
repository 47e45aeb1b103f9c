#include "text/offered_words.h"

#include <algorithm>
#include <functional>
#include <map>

#include "octavo/core/voxel_type.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/pictures/slice.h"
#include "octavo/tasks/pictures/transfer_file.h"

namespace octavo::cli {

namespace {

using Words = std::vector<std::string>;

Words windows() {
  Words words;
  for (const WindowPreset& preset : window_presets()) words.emplace_back(preset.name);
  words.emplace_back("auto");
  return words;
}

Words colors() {
  Words words;
  const std::string all = color_names();
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find(", ", at), all.size());
    words.push_back(all.substr(at, end - at));
    at = end + 2;
  }
  return words;
}

/// Sides of the patient, and what two or three of them join to.
Words viewpoints() {
  Words words;
  const auto add = [&](std::initializer_list<const char*> sides) {
    std::string word;
    for (const std::string side : sides) {
      if (!side.empty()) word += (word.empty() ? "" : "-") + side;
    }
    if (find_viewpoint(word)) words.push_back(word);
  };
  for (const char* across : {"", "left", "right"}) {
    for (const char* along : {"", "front", "back"}) {
      for (const char* up : {"", "top", "bottom"}) add({across, along, up});
    }
  }
  return words;
}

Words transfers() {
  Words words;
  for (const TransferPreset& preset : transfer_presets()) words.emplace_back(preset.name);
  return words;
}

/// Those of phantoms.
Words small_integers() {
  Words words;
  for (const VoxelType type : {VoxelType::int8, VoxelType::uint8, VoxelType::int16,
                               VoxelType::uint16}) {
    words.emplace_back(voxel_type_name(type));
  }
  return words;
}

}  // namespace

OfferedWords offered_words(const OptionEntry& option) {
  if (!option.choices.empty()) return {option.choices, false};
  static const std::map<std::string, std::function<Words()>> kByName = {
      {"WINDOW", windows},
      {"COLOR", colors},
      {"SIDE|X,Y,Z", viewpoints},
      {"PRESET|FILE", transfers},
      {"TYPE", small_integers},
      {"FILL", [] { return Words{"lowest", "coarse"}; }},
      {"N|off", [] { return Words{"off"}; }},
      {"TOKEN", [] { return Words{"auto"}; }}};
  const auto found = kByName.find(option.value);
  if (found == kByName.end()) return {};
  return {found->second(), option.value == "PRESET|FILE"};
}

}  // namespace octavo::cli
