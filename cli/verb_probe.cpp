// octavo probe: the value, the place and the o-code of single voxels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/options.h"
#include "octavo/octree/o_code.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "probe", "Show value, place and o-code of a voxel.",
    "Several positions may be given. Millimeters are LPS world coordinates; the nearest voxel\n"
    "answers.\n\n"
    "Examples:\n"
    "  octavo probe head.8vo --at 128,100,54\n"
    "  octavo probe head.8vo --mm 12.5,-30,81 --level 2 --json"};

struct Arguments {
  std::string input;
  std::vector<std::string> at;
  std::vector<std::string> mm;
  int level = 0;
};

struct Probe {
  Index3 index;
  Point3 world_mm{};
  double stored = 0;
  OCode code;
  int root_level = 0;
  BrickEntry brick;
};

double read_sample(const FileReader& reader, const Index3& index, int level) {
  const Box box = {index, {index.x + 1, index.y + 1, index.z + 1}};
  return with_voxel_type(reader.description().type, [&](auto tag) {
    typename decltype(tag)::type voxel{};
    reader.read(box, level, &voxel);
    return static_cast<double>(voxel);
  });
}

/// The brick whose subtree holds a sample.
Index3 brick_position(const Levels& levels, const Index3& index, int level) {
  const int tier = Levels::tier_of(level);
  const int first = Levels::first_level(tier);
  const Size3 side = levels.brick_side(tier);
  Index3 position;
  for (int axis = 0; axis < 3; ++axis) {
    const int halvings = levels.halving_count(level, axis) - levels.halving_count(first, axis);
    position[axis] = (index[axis] << halvings) / side[axis];
  }
  return position;
}

Probe probe(const FileReader& reader, const Geometry& geometry, const Index3& index, int level) {
  Probe result;
  result.index = index;
  result.world_mm = geometry.to_world({static_cast<double>(index.x), static_cast<double>(index.y),
                                       static_cast<double>(index.z)});
  result.stored = read_sample(reader, index, level);
  // A sample of level k is a cube of level k; its digits are those of its place on the level's
  // grid.
  result.code = {level, interleave(index)};
  result.root_level = universe_level(reader.levels().size(level)) + level;
  result.brick =
      reader.brick(Levels::tier_of(level), brick_position(reader.levels(), index, level));
  return result;
}

void check_inside(const Index3& index, const Size3& size, const std::string& asked) {
  if (box_of(size).contains(index)) return;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{} is voxel {},{},{}; outside the volume of {} voxels", asked, index.x,
                          index.y, index.z, size_text(size)));
}

Index3 nearest_index(const Geometry& geometry, const Point3& world_mm) {
  const Point3 index = geometry.to_index(world_mm);
  const auto rounded = [](double v) {
    constexpr double kFar = 1e15;
    return static_cast<std::int64_t>(std::llround(std::clamp(v, -kFar, kFar)));
  };
  return {rounded(index[0]), rounded(index[1]), rounded(index[2])};
}

nlohmann::ordered_json probe_json(const Probe& p, const VolumeDescription& d) {
  return {{"index", {p.index.x, p.index.y, p.index.z}},
          {"level", p.code.level},
          {"world_mm", if_in_mm(d, p.world_mm)},
          {"stored", p.stored},
          {"real", d.rescale.to_real(p.stored)},
          {"o_code",
           {{"mixed_octal", to_mixed_octal(p.code, p.root_level)},
            {"hierarchical", to_hierarchical(p.code, p.root_level)},
            {"root_level", p.root_level}}},
          {"brick",
           {{"tier", p.brick.tier},
            {"position", {p.brick.brick.x, p.brick.brick.y, p.brick.brick.z}},
            {"code", p.brick.code},
            {"uniform", p.brick.is_uniform()},
            {"min", d.voxel_of(p.brick.range.min)},
            {"max", d.voxel_of(p.brick.range.max)},
            {"max_error", p.brick.max_error}}}};
}

std::string probe_text(const Probe& p, const VolumeDescription& d, const std::string& unit) {
  std::string value = real_text(d, unit, p.stored);
  if (!d.rescale.is_identity()) value += fmt::format(" (stored {})", number_text(p.stored));
  const BrickEntry& b = p.brick;
  const std::string place = is_spacing_known(metadata_of(d))
                                ? fmt::format(" at {} mm", point_text(p.world_mm, ", "))
                                : " (spacing not known)";
  return fmt::format(
      "voxel {},{},{} of level {}{}\n"
      "  value   {}\n"
      "  o-code  {} (hierarchical {}, root level {})\n"
      "  brick   {},{},{} of tier {}{}, stored values {} to {}{}\n",
      p.index.x, p.index.y, p.index.z, p.code.level, place, value,
      to_mixed_octal(p.code, p.root_level), to_hierarchical(p.code, p.root_level), p.root_level,
      b.brick.x, b.brick.y, b.brick.z, b.tier, b.is_uniform() ? ", uniform" : "",
      number_text(d.voxel_of(b.range.min)), number_text(d.voxel_of(b.range.max)),
      b.max_error > 0 ? ", within " + distance_text(d, unit, b.max_error) + " of the source" : "");
}

int run_probe(const Arguments& arguments, const Context& context) {
  if (arguments.at.empty() && arguments.mm.empty()) {
    throw Error(ErrorKind::invalid_argument, "probe needs a position: --at x,y,z or --mm x,y,z");
  }
  const auto reader = open_octavo(arguments.input, context);
  check_level(reader->levels(), arguments.level);
  const VolumeDescription& d = reader->description();
  const Geometry geometry = reader->levels().geometry(d.geometry, arguments.level);
  if (!arguments.mm.empty()) require_known_spacing(d, arguments.input, "--mm", "--at");
  std::vector<Index3> indices;
  const auto take = [&](const Index3& index, const std::string& asked) {
    check_inside(index, reader->levels().size(arguments.level), asked);
    indices.push_back(index);
  };
  for (const std::string& text : arguments.at) take(parse_index(text, "--at"), "--at " + text);
  for (const std::string& text : arguments.mm) {
    take(nearest_index(geometry, parse_point(text, "--mm")), "--mm " + text);
  }
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  const std::string unit = unit_of(metadata_of(d));
  for (const Index3& index : indices) {
    const Probe p = probe(*reader, geometry, index, arguments.level);
    if (context.json) points.push_back(probe_json(p, d));
    else print(probe_text(p, d, unit));
  }
  if (context.json) print_json({{"unit", unit}, {"points", points}});
  return kExitDone;
}

}  // namespace

void add_probe(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_probe(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("--at", arguments->at, "x,y,z in voxels of the level")
      ->type_name("INDEX")
      ->allow_extra_args(false);
  verb.add_option("--mm", arguments->mm, "x,y,z in mm")->type_name("MM")->allow_extra_args(false);
  verb.add_option("--level", arguments->level, "Level of detail")
      ->type_name("K")
      ->capture_default_str();
}

}  // namespace octavo::cli
