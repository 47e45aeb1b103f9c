#include "common/isotropic_option.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/planes/between/isotropic_source.h"

namespace octavo::cli {

namespace {

constexpr const char* kOption = "--isotropic";
constexpr std::array<const char*, 2> kMethods = {"linear", "cubic"};

bool is_method(const std::string& word) {
  return std::find(kMethods.begin(), kMethods.end(), word) != kMethods.end();
}

IsotropicPlan plan_for(const std::string& name, const PlaneSource& source,
                       PlaneInterpolation method) {
  try {
    return plan_isotropic(source.description(), method);
  } catch (const Error& error) {
    throw error.path().empty() ? error.with_path(name) : error;
  }
}

std::unique_ptr<PlaneSource> make_planned(const std::string& name,
                                          std::unique_ptr<PlaneSource> source,
                                          PlaneInterpolation method, const Context& context) {
  const IsotropicPlan plan = plan_for(name, *source, method);
  context.note(plan.notice);
  return plan.is_needed ? make_isotropic_source(std::move(source), plan) : std::move(source);
}

}  // namespace

void add_isotropic_option(Verb verb, std::string& method) {
  verb.add_option(kOption, method,
                  "Make planes between thick slices until voxels are cubes; labels by their shapes")
      ->type_name("[METHOD]")
      ->check(one_of(std::vector<std::string>(kMethods.begin(), kMethods.end())));
}

std::vector<std::string> with_isotropic_method(int argc, const char* const* argv) {
  std::vector<std::string> words(argv, argv + argc);
  const auto end = std::find(words.begin(), words.end(), "--");
  for (auto word = words.begin(); word != end; ++word) {
    if (*word != kOption) continue;
    if (word + 1 == words.end() || !is_method(*(word + 1))) *word += "=linear";
  }
  return words;
}

std::unique_ptr<PlaneSource> make_isotropic(const std::string& name,
                                            std::unique_ptr<PlaneSource> source,
                                            const std::string& method, VolumeKind kind,
                                            const Context& context) {
  if (method.empty()) return source;
  if (kind == VolumeKind::labels && method != "linear") {
    throw Error(ErrorKind::invalid_argument,
                "--isotropic " + method +
                    ": labels have no values in between, they are interpolated by their shapes; "
                    "leave '" + method + "', or give --grey if these are measured values");
  }
  const PlaneInterpolation chosen = kind == VolumeKind::labels ? PlaneInterpolation::shape
                                    : method == "cubic"        ? PlaneInterpolation::cubic
                                                               : PlaneInterpolation::linear;
  return make_planned(name, std::move(source), chosen, context);
}

std::unique_ptr<PlaneSource> repeat_isotropic(const std::string& name,
                                              std::unique_ptr<PlaneSource> source,
                                              const nlohmann::ordered_json& metadata,
                                              const Context& context) {
  const nlohmann::ordered_json::json_pointer place("/prepared/isotropic/method");
  if (!metadata.contains(place) || !metadata.at(place).is_string()) return source;
  const std::string wanted = metadata.at(place).get<std::string>();
  for (const PlaneInterpolation method :
       {PlaneInterpolation::linear, PlaneInterpolation::cubic, PlaneInterpolation::shape}) {
    if (wanted != interpolation_name(method)) continue;
    return make_planned(name, std::move(source), method, context);
  }
  throw Error(ErrorKind::invalid_argument,
              "the file was resampled by '" + escaped(wanted) +
                  "', which this program does not know: its source cannot be prepared alike; "
                  "compare with a newer program",
              name);
}

}  // namespace octavo::cli
