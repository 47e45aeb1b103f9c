#include "octavo/tasks/files/label_hint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <vector>

namespace octavo {

namespace {

// Words that stand for measured values as well ("atlas", "masked") are not among them.
constexpr std::array<std::string_view, 11> kLabelWords = {
    "label",    "labels",        "labelmap",      "labelmaps",    "labelfield", "mask",
    "masks",    "seg",           "segmentation",  "segmentations", "parcellation"};

/// The words of a name in lower case: "brainMask_v2" gives brain, mask, v2.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  bool was_lower = false;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool starts_word = std::isupper(byte) != 0 && was_lower;
    if ((std::isalnum(byte) == 0 || starts_word) && !words.back().empty()) words.emplace_back();
    if (std::isalnum(byte) != 0) words.back() += static_cast<char>(std::tolower(byte));
    was_lower = std::islower(byte) != 0;
  }
  return words;
}

std::string last_component(const std::string& path) {
  std::filesystem::path p(path);
  if (!p.has_filename()) p = p.parent_path();
  return p.filename().string();
}

}  // namespace

std::optional<std::string> label_hint(const std::string& path,
                                      const VolumeDescription& description) {
  if (!is_integer(description.type) || !description.rescale.is_identity()) return std::nullopt;
  const std::optional<ChoiceNote>& chosen = description.metadata.facts().chosen;
  const bool is_color = chosen && chosen->channel && chosen->channel->name;
  if (is_color) return std::nullopt;
  for (const std::string& word : words_of(last_component(path))) {
    if (std::find(kLabelWords.begin(), kLabelWords.end(), word) != kLabelWords.end()) {
      return fmt::format("its name contains '{}'", word);
    }
  }
  return std::nullopt;
}

}  // namespace octavo
