#include "octavo/tasks/parts/scan_recipe.h"

#include <array>
#include <optional>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
#include "octavo/dist/plan_text.h"

namespace octavo {

namespace {

constexpr std::array<const char*, 4> kGapNames = {"rejected", "filled", "ignored", "resampled"};
constexpr std::array kMethods = {PlaneInterpolation::linear, PlaneInterpolation::cubic};

[[noreturn]] void fail_recipe(std::string_view member) {
  throw Error(ErrorKind::corrupt,
              "the plan has an unusable '" + escaped(member) + "'; plan again");
}

// --- Members, of which any may be left out

std::string recipe_word(const JsonObject& object, const char* member) {
  const std::string_view json = object.json_of(member);
  if (json.empty()) return "";
  JsonReader in(json);
  if (in.next() != JsonToken::string) fail_recipe(member);
  return bytes_of_word(in.string());
}

bool recipe_flag(const JsonObject& object, const char* member) {
  const std::string_view json = object.json_of(member);
  if (!json.empty() && json != "true") fail_recipe(member);
  return !json.empty();
}

std::vector<double> recipe_numbers(const JsonObject& object, const char* member) {
  const std::string_view json = object.json_of(member);
  std::vector<double> numbers;
  if (json.empty()) return numbers;
  JsonReader in(json);
  if (in.next() != JsonToken::begin_list) fail_recipe(member);
  for (JsonToken token = in.next(); token != JsonToken::end_list; token = in.next()) {
    const bool is_number = token == JsonToken::integer || token == JsonToken::number;
    if (!is_number || !in.number()) fail_recipe(member);
    numbers.push_back(*in.number());
  }
  return numbers;
}

std::vector<std::string> recipe_words(const JsonObject& object, const char* member) {
  const std::string_view json = object.json_of(member);
  std::vector<std::string> words;
  if (json.empty()) return words;
  JsonReader in(json);
  if (in.next() != JsonToken::begin_list) fail_recipe(member);
  for (JsonToken token = in.next(); token != JsonToken::end_list; token = in.next()) {
    if (token != JsonToken::string) fail_recipe(member);
    words.push_back(bytes_of_word(in.string()));
  }
  return words;
}

// --- Headerless voxels: [nx,ny,nz,bytes of the header] and the type behind them

void set_raw(const RawLayout& raw, JsonObject& object) {
  object.set("raw", std::vector<std::int64_t>{raw.size.x, raw.size.y, raw.size.z,
                                              static_cast<std::int64_t>(raw.header_bytes)});
  object.set("raw_type", stored_type_name(raw.type));
  if (raw.big_endian) object.set("raw_is_big_endian", true);
}

std::optional<RawLayout> raw_of(const JsonObject& object) {
  if (object.json_of("raw").empty()) return std::nullopt;
  JsonReader in(object.json_of("raw"));
  RawLayout raw;
  if (in.next() != JsonToken::begin_list) fail_recipe("raw");
  std::int64_t header_bytes = 0;
  for (std::int64_t* const number : {&raw.size.x, &raw.size.y, &raw.size.z, &header_bytes}) {
    if (in.next() != JsonToken::integer || !in.integer() || *in.integer() < 0) fail_recipe("raw");
    *number = *in.integer();
  }
  raw.header_bytes = static_cast<std::uint64_t>(header_bytes);
  const auto type = parse_stored_type(recipe_word(object, "raw_type"));
  if (!type) fail_recipe("raw_type");
  raw.type = *type;
  raw.big_endian = recipe_flag(object, "raw_is_big_endian");
  return raw;
}

SourceOptions source_of_recipe(const JsonObject& object) {
  SourceOptions source;
  source.raw = raw_of(object);
  if (const auto mm = recipe_numbers(object, "spacing_mm"); !mm.empty()) {
    if (mm.size() != 3) fail_recipe("spacing_mm");
    source.spacing_mm = Point3{mm[0], mm[1], mm[2]};
  }
  source.series = recipe_word(object, "series");
  if (const std::string name = recipe_word(object, "scan.on_gap"); !name.empty()) {
    std::size_t policy = 0;
    while (policy < kGapNames.size() && name != kGapNames[policy]) ++policy;
    if (policy == kGapNames.size()) fail_recipe("scan.on_gap");
    source.on_gap = static_cast<GapPolicy>(policy);
  }
  source.drop_duplicates = recipe_flag(object, "drop_duplicates");
  source.untilt = recipe_flag(object, "untilt");
  source.segment = recipe_word(object, "scan.segment");
  source.channel = recipe_word(object, "scan.channel");
  if (const auto time = recipe_numbers(object, "scan.time"); !time.empty()) {
    source.time = static_cast<std::int64_t>(time.front());
  }
  source.keep_identity = recipe_flag(object, "keep_identity");
  return source;
}

}  // namespace

std::string recipe_text(const ScanRecipe& recipe) {
  const SourceOptions& source = recipe.scan.source;
  JsonObject object;
  const auto set_word = [&](const char* member, const std::string& word) {
    if (!word.empty()) object.set(member, plan_word(word));
  };
  const auto set_flag = [&](const char* member, bool is_set) {
    if (is_set) object.set(member, true);
  };
  if (source.raw) set_raw(*source.raw, object);
  if (source.spacing_mm) {
    object.set("spacing_mm", std::vector<double>(source.spacing_mm->begin(),
                                                 source.spacing_mm->end()));
  }
  set_word("series", source.series);
  if (source.on_gap != GapPolicy::error) {
    object.set("scan.on_gap", kGapNames[static_cast<std::size_t>(source.on_gap)]);
  }
  set_flag("drop_duplicates", source.drop_duplicates);
  set_flag("untilt", source.untilt);
  set_word("scan.segment", source.segment);
  set_word("scan.channel", source.channel);
  if (source.time) object.set("scan.time", std::vector<std::int64_t>{*source.time});
  set_flag("keep_identity", source.keep_identity);
  set_flag("is_read_in_process", !recipe.scan.is_isolated);
  if (recipe.between) object.set("between", interpolation_name(*recipe.between));
  set_flag("has_given_names", recipe.has_given_names);
  std::vector<std::string> words;
  for (const std::string& word : recipe.words) words.push_back(plan_word(word));
  if (!words.empty()) object.set("words", words);
  set_word("root", recipe.root);
  object.sort_by_name();
  return object.text();
}

ScanRecipe parse_recipe(std::string_view text) {
  const JsonObject object = json_members(text);
  ScanRecipe recipe;
  recipe.scan.source = source_of_recipe(object);
  recipe.scan.is_isolated = !recipe_flag(object, "is_read_in_process");
  recipe.has_given_names = recipe_flag(object, "has_given_names");
  recipe.words = recipe_words(object, "words");
  recipe.root = recipe_word(object, "root");
  const std::string method = recipe_word(object, "between");
  for (const PlaneInterpolation one : kMethods) {
    if (method == interpolation_name(one)) recipe.between = one;
  }
  if (!method.empty() && !recipe.between) fail_recipe("between");
  // What another version wrote may mean more than is understood here.
  if (recipe_text(recipe) == text) return recipe;
  throw Error(ErrorKind::unsupported_version,
              "the plan says of its source what this program does not know; plan again with this "
              "one");
}

}  // namespace octavo
