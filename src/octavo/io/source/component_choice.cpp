#include "octavo/io/source/component_choice.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source_options.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxNamesShown = 8;
constexpr std::int64_t kMaxChannels = std::int64_t{1} << 16;

/// "4 channels (red, green, blue, alpha)".
std::string channels_text(const SourceComponents& components) {
  std::string names;
  const std::size_t shown = std::min(components.channel_names.size(), kMaxNamesShown);
  for (std::size_t i = 0; i < shown; ++i) {
    names += (i == 0 ? "" : ", ") + escaped(components.channel_names[i]);
  }
  if (shown < components.channel_names.size()) names += " ...";
  return std::to_string(components.channels) +
         (components.channels == 1 ? " channel" : " channels") +
         (names.empty() ? "" : " (" + names + ")");
}

std::string times_text(const SourceComponents& components) {
  return std::to_string(components.times) +
         (components.times == 1 ? " point in time" : " points in time") +
         (components.times_told_by.empty() ? "" : " (" + components.times_told_by + ")");
}

/// What can be given for a channel; nothing where there is only one.
std::string channels_to_give(const SourceComponents& components) {
  if (components.channels == 1) return "";
  const std::string by_name = components.channel_names.empty() ? "" : "one of these names or ";
  return by_name + numbers_to_give(components.channels);
}

std::string times_to_give(const SourceComponents& components) {
  return components.times == 1 ? "" : numbers_to_give(components.times);
}

Error missing_choice(const SourceComponents& components, bool lacks_channel, bool lacks_time,
                     const std::string& path) {
  const std::string both = lacks_channel && lacks_time ? " and " : "";
  const std::string found = (lacks_channel ? channels_text(components) : "") + both +
                            (lacks_time ? times_text(components) : "");
  Error failure(ErrorKind::source_rejected,
                found + ", but a volume has one value at each voxel", path);
  if (lacks_channel) failure = failure.with_field("channel", channels_to_give(components));
  if (lacks_time) failure = failure.with_field("time", times_to_give(components));
  return failure;
}

Error no_channel(const SourceComponents& components, const std::string& text,
                 const std::string& path) {
  return Error(ErrorKind::invalid_argument,
               "channel " + escaped(text) + " is not there: the source has " +
                   channels_text(components),
               path)
      .with_field("channel", channels_to_give(components));
}

std::int64_t parse_channel(const SourceComponents& components, const std::string& text,
                           const std::string& path) {
  std::int64_t number = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure == std::errc() && end == text.data() + text.size()) {
    if (number >= 0 && number < components.channels) return number;
    throw no_channel(components, text, path);
  }
  const std::vector<std::string>& names = components.channel_names;
  const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    return lower_case(name) == lower_case(text);
  });
  if (found != names.end()) return found - names.begin();
  throw no_channel(components, text, path);
}

std::int64_t require_time(const SourceComponents& components, std::int64_t time,
                          const std::string& path) {
  if (time >= 0 && time < components.times) return time;
  throw Error(ErrorKind::invalid_argument,
              "time " + std::to_string(time) + " is not there: the source has " +
                  times_text(components),
              path)
      .with_field("time", times_to_give(components));
}

}  // namespace

std::string numbers_to_give(std::int64_t count) {
  return count == 2 ? "0 or 1" : "0 to " + std::to_string(count - 1);
}

std::vector<std::string> color_names(std::int64_t channels) {
  if (channels == 3) return {"red", "green", "blue"};
  if (channels == 4) return {"red", "green", "blue", "alpha"};
  return {};
}

ComponentChoice choose_component(const SourceComponents& components, const SourceOptions& options,
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
    throw missing_choice(components, lacks_channel, lacks_time, path);
  }
  ComponentChoice choice;
  if (!options.channel.empty()) choice.channel = parse_channel(components, options.channel, path);
  if (options.time) choice.time = require_time(components, *options.time, path);
  return choice;
}

std::optional<ChoiceNote> choice_note(const SourceComponents& components,
                                      const ComponentChoice& choice) {
  if (components.channels <= 1 && components.times <= 1) return std::nullopt;
  ChoiceNote note;
  if (components.channels > 1) {
    note.channel = {components.channels, choice.channel, std::nullopt};
    if (!components.channel_names.empty()) {
      note.channel->name = components.channel_names[static_cast<std::size_t>(choice.channel)];
    }
  }
  if (components.times > 1) note.time = {components.times, choice.time, std::nullopt};
  return note;
}

}  // namespace octavo
