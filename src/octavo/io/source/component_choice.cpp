#include "octavo/io/source/component_choice.h"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source_options.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxNamesTold = 8;
constexpr std::int64_t kMaxChannels = std::int64_t{1} << 16;

/// "4 channels (red, green, blue, alpha)".
std::string channels_text(const Components& components) {
  std::string names;
  const std::size_t told = std::min(components.channel_names.size(), kMaxNamesTold);
  for (std::size_t i = 0; i < told; ++i) {
    names += (i == 0 ? "" : ", ") + escaped(components.channel_names[i]);
  }
  if (told < components.channel_names.size()) names += " ...";
  return std::to_string(components.channels) +
         (components.channels == 1 ? " channel" : " channels") +
         (names.empty() ? "" : " (" + names + ")");
}

std::string times_text(const Components& components) {
  return std::to_string(components.times) +
         (components.times == 1 ? " point in time" : " points in time");
}

std::string range_text(std::int64_t count) {
  return count == 2 ? "0 or 1" : "0 to " + std::to_string(count - 1);
}

[[noreturn]] void refuse_missing_choice(const Components& components, bool lacks_channel,
                                        bool lacks_time, const std::string& path) {
  const std::string both = lacks_channel && lacks_time ? " and " : "";
  const std::string found = (lacks_channel ? channels_text(components) : "") + both +
                            (lacks_time ? times_text(components) : "");
  const std::string by_name = components.channel_names.empty() ? "" : "one of these names or ";
  const std::string remedy =
      (lacks_channel ? "--channel with " + by_name + range_text(components.channels) : "") + both +
      (lacks_time ? "--time with " + range_text(components.times) : "");
  throw Error(ErrorKind::source_rejected,
              found + ", but a volume has one value at each voxel; give " + remedy, path);
}

std::int64_t require_below(std::int64_t value, std::int64_t count, const std::string& option,
                           const std::string& found, const std::string& path) {
  if (value >= 0 && value < count) return value;
  throw Error(ErrorKind::invalid_argument,
              option + " " + std::to_string(value) + " is not there: the source has " + found +
                  (count == 1 ? "; leave the option out" : ", counted from 0"),
              path);
}

std::int64_t parse_channel(const Components& components, const std::string& text,
                           const std::string& path) {
  std::int64_t number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure == std::errc() && end == text.data() + text.size()) {
    return require_below(number, components.channels, "--channel", channels_text(components), path);
  }
  const std::vector<std::string>& names = components.channel_names;
  const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    return lower_case(name) == lower_case(text);
  });
  if (found != names.end()) return found - names.begin();
  throw Error(ErrorKind::invalid_argument,
              "--channel " + escaped(text) + " is not there: the source has " +
                  channels_text(components) + "; give a name of these, or a number from 0",
              path);
}

}  // namespace

std::vector<std::string> color_names(std::int64_t channels) {
  if (channels == 3) return {"red", "green", "blue"};
  if (channels == 4) return {"red", "green", "blue", "alpha"};
  return {};
}

ComponentChoice choose_component(const Components& components, const SourceOptions& options,
                                 const std::string& path) {
  if (components.channels < 1 || components.channels > kMaxChannels || components.times < 1) {
    throw Error(ErrorKind::source_rejected,
                "it claims " + channels_text(components) + " and " + times_text(components) +
                    "; from 1 to " + std::to_string(kMaxChannels) + " channels are read",
                path);
  }
  const bool lacks_channel = components.channels > 1 && options.channel.empty();
  const bool lacks_time = components.times > 1 && !options.time;
  if (lacks_channel || lacks_time) {
    refuse_missing_choice(components, lacks_channel, lacks_time, path);
  }
  ComponentChoice choice;
  if (!options.channel.empty()) choice.channel = parse_channel(components, options.channel, path);
  if (options.time) {
    choice.time =
        require_below(*options.time, components.times, "--time", times_text(components), path);
  }
  return choice;
}

std::string choice_json(const Components& components, const ComponentChoice& choice) {
  nlohmann::json chosen = nlohmann::json::object();
  if (components.channels > 1) {
    chosen["channel"] = {{"index", choice.channel}, {"count", components.channels}};
    if (!components.channel_names.empty()) {
      const auto index = static_cast<std::size_t>(choice.channel);
      chosen["channel"]["name"] = components.channel_names[index];
    }
  }
  if (components.times > 1) {
    chosen["time"] = {{"index", choice.time}, {"count", components.times}};
  }
  if (chosen.empty()) return "";
  return chosen.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace octavo
