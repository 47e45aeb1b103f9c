// Which channel and which point in time of a source becomes the volume: a voxel has one value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/metadata_facts.h"

namespace octavo {

struct SourceOptions;

/// What a source holds at one place. Counts are at least 1.
struct SourceComponents {
  std::int64_t channels = 1;
  std::vector<std::string> channel_names;  ///< one for each channel, or none
  std::int64_t times = 1;
  std::string times_told_by;  ///< what tells them apart, with its numbers; empty: their order
};

/// The one that is taken, counted from 0.
struct ComponentChoice {
  std::int64_t channel = 0;
  std::int64_t time = 0;
  bool operator==(const ComponentChoice&) const = default;
};

/// "0 or 1", "0 to 3": the numbers of so many things, of which one is chosen.
std::string numbers_to_give(std::int64_t count);

/// "red", "green", "blue" and "alpha" for 3 or 4 channels of color; nothing for other counts.
std::vector<std::string> color_names(std::int64_t channels);

/// What options.channel (a number from 0 or a name) and options.time say.
/// Throws Error{source_rejected} with the counts where there are several and none is chosen;
///        Error{invalid_argument} where the one chosen is not there
ComponentChoice choose_component(const SourceComponents& components, const SourceOptions& options,
                                 const std::string& path);

/// The choice for the metadata; nothing where there was none to make.
std::optional<ChoiceNote> choice_note(const SourceComponents& components,
                                      const ComponentChoice& choice);

}  // namespace octavo
