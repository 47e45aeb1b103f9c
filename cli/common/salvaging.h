// --salvage: damaged bricks are filled and named instead of refused.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/context.h"
#include "common/options.h"
#include "octavo/file/repair/salvage.h"

namespace octavo::cli {

/// The option as it was given.
struct SalvageArguments {
  bool is_asked = false;
  std::string fill;  ///< "lowest", "coarse" or a number in real units
};

void add_salvage_option(Verb verb, SalvageArguments& arguments);

/// `reader` itself, or with --salvage a SalvageReader over it. With --strict damage stays an error:
/// what would be a warning must not leave a file behind.
/// Throws Error{invalid_argument} when the fill is no voxel of the file.
std::shared_ptr<const FileReader> salvaging(std::shared_ptr<const FileReader> reader,
                                            const SalvageArguments& arguments,
                                            const Context& context);

/// Runs `read`, which reads voxels of an opened file; damage points to --salvage where that was not
/// given.
void read_or_hint(const SalvageArguments& arguments, const Context& context,
                  const std::function<void()>& read);

/// One warning for each damaged place that was filled, for ten at most, and a count of the others.
void warn_of_salvaged(const FileReader& reader, Context& context);

/// {"bricks", "damages"}, or null for a reader that fills nothing.
nlohmann::ordered_json salvaged_json(const FileReader& reader);

}  // namespace octavo::cli
