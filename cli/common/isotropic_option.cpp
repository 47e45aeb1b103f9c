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

void add_isotropic_option(Verb verb, std::string& method) {
  verb.add_option(kOption, method,
                  "Make planes between thick slices until voxels are cubes; labels by their shapes")
      ->type_name("[METHOD]")
      ->check(one_of(std::vector<std::string>(kMethods.begin(), kMethods.end())));
}

std::optional<PlaneInterpolation> isotropic_method(const std::string& method) {
  if (method.empty()) return std::nullopt;
  return method == "cubic" ? PlaneInterpolation::cubic : PlaneInterpolation::linear;
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
