// octavo phantom: a test scan of any size, made plane by plane.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/files/write_phantom.h"
#include "text/built_words.h"
#include "text/offered_words.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kPhantomText = {
    "phantom", "Make a test scan: a spherical shell with two cylinders inside.",
    "Writes an .8vo file, or plain voxels as .raw or .mhd (with a .raw beside it). The same\n"
    "options give the same voxels on every machine.\n\n"
    "Examples:\n"
    "  octavo phantom --size 256 --noise 12 -o phantom.8vo\n"
    "  octavo phantom --size 1024,1024,512 --type uint8 --seed 7 -o planes.mhd"};

struct PhantomArguments {
  std::string output;
  std::string size = "256";
  std::string type = "int16";
  std::string spacing = "1";
  std::string radii;
  std::string densities;
  double noise = 0;
  std::uint64_t seed = 1;
};

Size3 parse_size(const std::string& text) {
  Index3 sides;
  if (text.find(',') == std::string::npos) {
    sides.x = sides.y = sides.z = parse_integer(text, "--size");
  } else {
    sides = parse_index(text, "--size");
  }
  if (std::min({sides.x, sides.y, sides.z}) < 1) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--size: '{}'; must be 1 or more", escaped(text)));
  }
  return {sides.x, sides.y, sides.z};
}

VoxelType parse_type(const std::string& text) {
  const auto type = parse_voxel_type(text);
  if (type && std::ranges::find(phantom_types(), *type) != phantom_types().end()) return *type;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--type: '{}'; expected one of {}", escaped(text),
                          fmt::join(phantom_type_words(), ", ")));
}

PhantomOptions phantom_options(const PhantomArguments& arguments) {
  PhantomOptions options = phantom_options_for(parse_type(arguments.type));
  options.size = parse_size(arguments.size);
  options.spacing_mm = parse_spacing(arguments.spacing, "--spacing");
  options.noise_sigma = arguments.noise;
  options.seed = arguments.seed;
  if (!arguments.radii.empty()) {
    const auto radii = parse_numbers(arguments.radii, "--radii", 2, "OUTER,INNER");
    options.outer_radius = radii[0];
    options.inner_radius = radii[1];
  }
  if (!arguments.densities.empty()) {
    const auto d = parse_numbers(arguments.densities, "--densities", 5,
                                 "BACKGROUND,SHELL,INSIDE,CYLINDER1,CYLINDER2");
    options.background = d[0];
    options.shell = d[1];
    options.inside = d[2];
    options.first_cylinder = d[3];
    options.second_cylinder = d[4];
  }
  return options;
}

void print_planes(const PlaneWriteResult& result, const VolumeDescription& volume,
                  const Context& context) {
  print_result(context, {{"files", result.files}, {"bytes", result.bytes}},
               fmt::format("{}: {} {}, {}\n", result.files.front(), size_text(volume.size),
                           voxel_type_name(volume.type), bytes_text(result.bytes)));
}

int run_phantom(const PhantomArguments& arguments, Context& context) {
  const WritePhantomOptions options = {phantom_options(arguments),
                                       {arguments.output, context.force}};
  const WritePhantomResult result = run_task(write_phantom, options, context);
  if (const auto* built = std::get_if<BuiltVolume>(&result.written)) {
    print_built(*built, arguments.output, context);
  } else {
    print_planes(std::get<PlaneWriteResult>(result.written), result.volume, context);
  }
  return kExitDone;
}

}  // namespace

void add_phantom(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kPhantomText, run_phantom);
  verb.add_output(arguments.output, "The .8vo, .raw or .mhd file to write");
  verb.add_option("--size N", arguments.size, "Voxels, x,y,z or one side for a cube")
      .capture_default_str();
  verb.add_option("--type TYPE", arguments.type,
                  fmt::format("One of {}", fmt::join(phantom_type_words(), ", ")))
      .capture_default_str();
  verb.add_option("--spacing MM", arguments.spacing, "Voxel distances in mm, x,y,z or one for all")
      .capture_default_str();
  verb.add_option("--noise SIGMA", arguments.noise, "Standard deviation of Gaussian noise")
      .capture_default_str();
  verb.add_option("--seed N", arguments.seed, "Of the noise").capture_default_str();
  verb.add_option("--radii R,R", arguments.radii,
                  "Of the shell, OUTER,INNER in 0 .. 1 (default 0.9,0.8)");
  verb.add_option("--densities D,D,D,D,D", arguments.densities,
                  "BACKGROUND,SHELL,INSIDE,CYLINDER1,CYLINDER2 (default fits the type)");
}

}  // namespace octavo::cli
