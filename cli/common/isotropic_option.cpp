#include "common/isotropic_option.h"

#include <algorithm>
#include <array>

namespace octavo::cli {

namespace {

constexpr const char* kOption = "--isotropic";
constexpr std::array<const char*, 2> kMethods = {"linear", "cubic"};

bool is_method(const std::string& word) {
  return std::find(kMethods.begin(), kMethods.end(), word) != kMethods.end();
}

}  // namespace

void add_isotropic_option(Verb verb, std::optional<PlaneInterpolation>& method) {
  verb.add_word(
      kOption + std::string(" [METHOD]"), method,
      {{kMethods[0], PlaneInterpolation::linear}, {kMethods[1], PlaneInterpolation::cubic}},
      "Make planes between thick slices until voxels are cubes; labels by their shapes");
}

std::vector<std::string> with_isotropic_method(std::vector<std::string> words) {
  const auto end = std::find(words.begin(), words.end(), "--");
  for (auto word = words.begin(); word != end; ++word) {
    if (*word != kOption) continue;
    if (word + 1 == words.end() || !is_method(*(word + 1))) *word += "=linear";
  }
  return words;
}

}  // namespace octavo::cli
