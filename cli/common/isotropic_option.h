// --isotropic: in-between planes for thick slices, asked for by a build and repeated by verify.
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/context.h"
#include "common/options.h"
#include "octavo/planes/plane_source.h"

namespace octavo::cli {

/// method  "linear" or "cubic"; empty when it is not given
void add_isotropic_option(Verb verb, std::string& method);

/// The words of a command line, where an --isotropic without a method gets the one it means, so
/// that the name behind it is not taken for one.
std::vector<std::string> with_isotropic_method(int argc, const char* const* argv);

/// The planes of `source` with those in between, if any are needed; tells what is done.
/// name    of the source, for messages
/// method  as from add_isotropic_option; empty: `source` itself. Labels are interpolated by shape.
/// Throws  as plan_isotropic; Error{invalid_argument} for a method that is not for labels
std::unique_ptr<PlaneSource> make_isotropic(const std::string& name,
                                            std::unique_ptr<PlaneSource> source,
                                            const std::string& method, VolumeKind kind,
                                            const Context& context);

/// The planes of `source` with those in between that the metadata of a file built from it tell of.
/// Throws  as plan_isotropic
std::unique_ptr<PlaneSource> repeat_isotropic(const std::string& name,
                                              std::unique_ptr<PlaneSource> source,
                                              const nlohmann::ordered_json& metadata,
                                              const Context& context);

}  // namespace octavo::cli
