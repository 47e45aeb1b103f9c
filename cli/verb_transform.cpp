// octavo transform: volumes moved, turned, scaled, or brought onto another grid.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/affine_file.h"
#include "common/building.h"
#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/progress_line.h"
#include "octavo/builder/metadata_member.h"
#include "octavo/file/write/copy_described.h"
#include "octavo/io/source/place_known.h"
#include "octavo/ops/grid/resample.h"
#include "octavo/ops/mask/mask_transform.h"
#include "octavo/planes/computed_source.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/geometry_words.h"
#include "text/quantities.h"
#include "text/turn_words.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "transform", "Move, turn, mirror or scale a volume, or bring it onto another grid.",
    "--translate and --translate-mm move the whole volume: its origin changes, its bricks are\n"
    "copied and not decoded. --shift moves the voxels within the grid; what falls out is dropped.\n"
    "--rotate and --mirror move whole voxels, exactly, and may be repeated; the geometry follows,\n"
    "so that every voxel keeps its place in space. Rotations are right-handed in index space:\n"
    "z:90 lays along y what lay along x. --scale 2 makes a finer grid, --scale 1/2 takes the\n"
    "coarser level. With --in-place the direction and the center of the grid stay and the object\n"
    "turns, or grows, instead.\n\n"
    "--affine moves the object: a point p (mm, LPS) goes to M p. With --inverse M leads from the\n"
    "new place to the old one, as transforms of ITK's resampler do. The grid stays, or is that of\n"
    "--grid-of. Labels are taken from the nearest voxel, grey values interpolated. Voxels that\n"
    "come from outside are --fill.\n\n"
    "Examples:\n"
    "  octavo transform head.8vo --translate-mm 0,0,-12.5 -o moved.8vo\n"
    "  octavo transform head.8vo --rotate z:90 --rotate x:180 -o turned.8vo\n"
    "  octavo transform labels.8vo --grid-of head.8vo -o labels-on-head.8vo\n"
    "  octavo transform follow-up.8vo --affine register.txt --grid-of head.8vo -o aligned.8vo\n"
    "  octavo transform head.8vo --scale 1/2 -o half.8vo"};

struct Arguments {
  std::string input;
  std::string output;
  std::string translate;
  std::string translate_mm;
  std::string shift;
  std::vector<std::string> rotations;
  std::vector<std::string> mirrors;
  std::string scale;
  std::string affine;
  std::string grid_of;
  bool is_inverse = false;
  bool is_in_place = false;
  std::string interpolation;
  std::string fill;
  std::string preset = "small";
  std::string max_error = "0";
};

constexpr std::array<const char*, 3> kInterpolations = {"nearest", "linear", "cubic"};

enum class Way {
  copy,      ///< only the geometry changes
  move,      ///< whole voxels
  resample,  ///< values between voxels
};

/// What is to be done: the new grid, and where its voxels come from.
struct Plan {
  Way way = Way::copy;
  std::string operation;
  std::string said;  ///< what became of the voxels, for people
  nlohmann::ordered_json made_by;
  int level = 0;
  Size3 size;
  Geometry geometry;
  Affine to_source;
  std::optional<AxisTurn> turn;
  std::optional<Index3> shift;
  Interpolation interpolation = Interpolation::nearest;
  double outside = 0;
  /// The metadata of another file's grid that say where its spacing is from.
  nlohmann::ordered_json spacing_facts = nlohmann::ordered_json::object();
  bool is_placed = false;  ///< the grid is known to lie in a body, whatever is known of the input
};

// ---- what was asked for

/// The one operation, by its option.
std::string operation_of(const Arguments& arguments) {
  std::vector<std::string> asked;
  if (!arguments.translate.empty()) asked.emplace_back("translate");
  if (!arguments.translate_mm.empty()) asked.emplace_back("translate-mm");
  if (!arguments.shift.empty()) asked.emplace_back("shift");
  if (!arguments.rotations.empty()) asked.emplace_back("rotate");
  if (!arguments.mirrors.empty()) asked.emplace_back("mirror");
  if (!arguments.scale.empty()) asked.emplace_back("scale");
  if (!arguments.affine.empty()) asked.emplace_back("affine");
  else if (!arguments.grid_of.empty()) asked.emplace_back("grid-of");
  if (asked.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "transform needs one of --translate, --translate-mm, --shift, --rotate, --mirror, "
                "--scale, --affine and --grid-of");
  }
  if (asked.size() > 1) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--{} and --{} are two steps; transform does one at a time", asked[0],
                            asked[1]));
  }
  return asked.front();
}

void refuse_option(bool is_given, const char* option, bool is_of_use, const char* with) {
  if (!is_given || is_of_use) return;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{} changes nothing here; it goes with {}", option, with));
}

/// Refuses options that the operation would ignore.
void check_options(const Arguments& arguments, const std::string& operation) {
  const auto is_one_of = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), operation) != names.end();
  };
  refuse_option(!arguments.grid_of.empty(), "--grid-of", is_one_of({"affine", "grid-of"}),
                "--affine, or alone");
  refuse_option(arguments.is_inverse, "--inverse", is_one_of({"affine"}), "--affine");
  refuse_option(arguments.is_in_place, "--in-place", is_one_of({"rotate", "mirror", "scale"}),
                "--rotate, --mirror and --scale");
  refuse_option(!arguments.fill.empty(), "--fill", is_one_of({"shift", "affine", "grid-of"}),
                "--shift, --affine and --grid-of");
  refuse_option(!arguments.interpolation.empty(), "--interpolation",
                is_one_of({"affine", "grid-of"}) ||
                    (is_one_of({"scale"}) && arguments.scale.find('/') == std::string::npos),
                "--affine, --grid-of and --scale N");
  const bool is_copy = is_one_of({"translate", "translate-mm"});
  refuse_option(arguments.preset != "small", "--preset", !is_copy, "what makes new voxels");
  refuse_option(arguments.max_error != "0", "--max-error", !is_copy, "what makes new voxels");
}

Interpolation parse_interpolation(const Arguments& arguments, const VolumeDescription& volume) {
  const bool is_labels = volume.kind == VolumeKind::labels;
  if (arguments.interpolation.empty()) {
    return is_labels ? Interpolation::nearest : Interpolation::linear;
  }
  const auto found =
      std::find(kInterpolations.begin(), kInterpolations.end(), arguments.interpolation);
  const auto way = static_cast<Interpolation>(found - kInterpolations.begin());
  if (is_labels && way != Interpolation::nearest) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--interpolation {}: labels are names, between which there is nothing; "
                            "they are taken from the nearest voxel",
                            arguments.interpolation),
                arguments.input);
  }
  return way;
}

/// The stored value of voxels from outside: --fill, or 0 for labels and the least value of a grey
/// volume.
double parse_fill(const Arguments& arguments, const FileReader& reader) {
  const VolumeDescription& volume = reader.description();
  const bool is_labels = volume.kind == VolumeKind::labels;
  if (arguments.fill.empty()) return is_labels ? 0 : volume.voxel_of(reader.range().min);
  const double real = parse_number(arguments.fill, "--fill");
  const Rescale& rescale = volume.rescale;
  const double stored = is_labels ? real : (real - rescale.intercept) / rescale.slope;
  if (!is_integer(volume.type)) {
    const double voxel = static_cast<float>(stored);
    if (std::isfinite(voxel)) return voxel;
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--fill {}: is no value of float32", number_text(real)));
  }
  constexpr double kSlack = 1e-6;
  const ValueRange range = value_range(volume.type);
  const double whole = std::round(stored);
  if (std::abs(stored - whole) <= kSlack && whole >= static_cast<double>(range.min) &&
      whole <= static_cast<double>(range.max)) {
    return whole;
  }
  const auto ends = std::minmax({rescale.to_real(static_cast<double>(range.min)),
                                 rescale.to_real(static_cast<double>(range.max))});
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--fill {}: is no value of this volume; {} voxels hold {} to {} in steps "
                          "of {}",
                          arguments.fill, voxel_type_name(volume.type), number_text(ends.first),
                          number_text(ends.second), number_text(std::abs(rescale.slope))),
              arguments.input);
}

// ---- plans

Plan unchanged(const std::string& operation, const VolumeDescription& volume) {
  Plan plan;
  plan.operation = operation;
  plan.made_by = {{"operation", "transform"}, {"step", operation}};
  plan.size = volume.size;
  plan.geometry = volume.geometry;
  return plan;
}

Plan translation(const Arguments& arguments, const VolumeDescription& volume, Plan plan) {
  plan.said = "bricks copied, the origin moved";
  Point3& origin = plan.geometry.origin_mm;
  if (plan.operation == "translate") {
    const Index3 by = parse_index(arguments.translate, "--translate");
    origin = cropped(plan.geometry, by).origin_mm;
    plan.made_by["voxels"] = {by.x, by.y, by.z};
  } else {
    require_known_spacing(volume, arguments.input, "--translate-mm", "--translate");
    const Point3 by = parse_point(arguments.translate_mm, "--translate-mm");
    for (std::size_t i = 0; i < 3; ++i) origin[i] += by[i];
    plan.made_by["mm"] = by;
  }
  if (!is_valid(plan.geometry)) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--{}: the origin would no longer be a finite number", plan.operation));
  }
  return plan;
}

Plan shift(const Arguments& arguments, const FileReader& reader, Context& context, Plan plan) {
  plan.way = Way::move;
  plan.said = "voxels shifted within the grid";
  plan.outside = parse_fill(arguments, reader);
  plan.shift = parse_index(arguments.shift, "--shift");
  bool is_all_out = false;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t by = (*plan.shift)[axis];
    is_all_out = is_all_out || by >= plan.size[axis] || by <= -plan.size[axis];
    // Further out there is nothing more to drop.
    plan.shift->operator[](axis) =
        std::clamp((*plan.shift)[axis], -plan.size[axis], plan.size[axis]);
    plan.to_source.offset[static_cast<std::size_t>(axis)] =
        -static_cast<double>((*plan.shift)[axis]);
  }
  plan.made_by["voxels"] = {plan.shift->x, plan.shift->y, plan.shift->z};
  if (is_all_out) {
    context.warn(fmt::format("{}: --shift {} moves all of its {} voxels out of the grid",
                             arguments.input, arguments.shift, size_text(plan.size)));
  }
  return plan;
}

Plan turn(const Arguments& arguments, Plan plan) {
  const AxisTurn turn = parse_turn(arguments.rotations, arguments.mirrors);
  plan.way = Way::move;
  plan.turn = turn;
  plan.to_source = to_source(turn, plan.size);
  plan.geometry = arguments.is_in_place ? turned_object(plan.geometry, plan.size, turn)
                                        : turned(plan.geometry, plan.size, turn);
  plan.size = turned(plan.size, turn);
  plan.said = arguments.is_in_place ? "the object turned about the center of the grid"
                                    : "the grid turned, every voxel kept its place in space";
  if (arguments.is_in_place && plan.operation == "mirror") {
    plan.said = "the object mirrored about the center of the grid";
  }
  plan.made_by[plan.operation] =
      plan.operation == "rotate" ? arguments.rotations : arguments.mirrors;
  plan.made_by["in_place"] = arguments.is_in_place;
  return plan;
}

Plan finer(const Arguments& arguments, const VolumeDescription& volume, const Scale& scale,
           Plan plan) {
  const auto factor = static_cast<double>(scale.factor);
  plan.way = Way::resample;
  plan.interpolation = parse_interpolation(arguments, volume);
  const double first = 0.5 / factor - 0.5;
  plan.geometry.origin_mm = volume.geometry.to_world({first, first, first});
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    plan.size[axis] *= scale.factor;
    plan.geometry.spacing_mm[a] /= factor;
    plan.to_source.linear[4 * a] = 1 / factor;
    plan.to_source.offset[a] = first;
  }
  plan.said = fmt::format("{} x finer", scale.factor);
  return plan;
}

Plan coarser(const FileReader& reader, const Scale& scale, Plan plan) {
  const Levels& levels = reader.levels();
  plan.way = Way::move;
  plan.level = scale.doublings();
  if (plan.level >= levels.count()) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--scale 1/{}: the volume has only {} levels", scale.factor,
                            levels.count()),
                reader.source().name());
  }
  plan.size = levels.size(plan.level);
  plan.geometry = levels.geometry(plan.geometry, plan.level);
  plan.said = fmt::format("level {}", plan.level);
  for (int axis = 0; axis < 3; ++axis) {
    const int halvings = levels.halving_count(plan.level, axis);
    if (halvings == plan.level) continue;
    plan.said += fmt::format(", in which {} is halved {}", "xyz"[axis],
                             counted_text(halvings, "time"));
  }
  return plan;
}

Plan scaling(const Arguments& arguments, const FileReader& reader, Plan plan) {
  const VolumeDescription& volume = reader.description();
  const Scale scale = parse_scale(arguments.scale);
  plan.made_by["factor"] = arguments.scale;
  plan.made_by["in_place"] = arguments.is_in_place;
  plan = scale.is_up ? finer(arguments, volume, scale, plan) : coarser(reader, scale, plan);
  if (!arguments.is_in_place) {
    plan.said += "; every voxel kept its place in space";
    return plan;
  }
  Point3 spacing = plan.geometry.spacing_mm;
  const auto factor = static_cast<double>(scale.factor);
  for (double& mm : spacing) mm = scale.is_up ? mm * factor : mm / factor;
  plan.geometry = recentered(volume.geometry, volume.size, plan.size, spacing);
  plan.said += scale.is_up ? "; the object grew about the center of the grid"
                           : "; the object shrank about the center of the grid";
  return plan;
}

Plan resampling(const Arguments& arguments, const FileReader& reader, Context& context,
                Plan plan) {
  const VolumeDescription& volume = reader.description();
  plan.way = Way::resample;
  plan.interpolation = parse_interpolation(arguments, volume);
  plan.outside = parse_fill(arguments, reader);
  plan.said = fmt::format(
      "{}{}",
      plan.interpolation == Interpolation::nearest ? "nearest voxels taken" : "interpolated",
      plan.interpolation == Interpolation::cubic ? " (cubic)" : "");
  Affine back;
  if (!arguments.affine.empty()) {
    Affine map = read_affine(arguments.affine);
    if (arguments.is_inverse) map = *inverse(map);
    const std::optional<Affine> inverted = inverse(map);
    if (!inverted) {
      throw Error(ErrorKind::source_rejected, "the matrix has no inverse", arguments.affine);
    }
    back = *inverted;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (std::size_t row = 0; row < 3; ++row) {
      rows.push_back({map.linear[3 * row], map.linear[3 * row + 1], map.linear[3 * row + 2],
                      map.offset[row]});
    }
    plan.made_by["matrix_mm"] = rows;
    if (!is_spacing_known(metadata_of(volume))) {
      context.warn(arguments.input + ": its spacing is not known; the matrix is taken for voxels "
                                     "of 1 mm");
    }
  }
  if (!arguments.grid_of.empty()) {
    const std::shared_ptr<const FileReader> other = open_octavo(arguments.grid_of, context);
    plan.size = other->description().size;
    plan.geometry = other->description().geometry;
    plan.is_placed = is_place_known(other->description());
    plan.said += ", on the grid of " + arguments.grid_of;
    const nlohmann::ordered_json grid_facts = metadata_of(other->description());
    plan.spacing_facts["spacing_known"] = is_spacing_known(grid_facts);
    plan.spacing_facts["spacing_source"] = grid_facts.value("spacing_source", "file");
    warn_of_unknown_spacing(other->description(), arguments.grid_of, volume, arguments.input,
                            context);
  }
  plan.made_by["interpolation"] = kInterpolations[static_cast<std::size_t>(plan.interpolation)];
  plan.made_by["outside"] = volume.kind == VolumeKind::labels
                                ? plan.outside
                                : volume.rescale.to_real(plan.outside);
  // A voxel of the grid, where it is in space, where it came from, and which voxel that was.
  const std::optional<Affine> to_index = inverse(index_to_world(volume.geometry));
  plan.to_source =
      chained(chained(index_to_world(plan.geometry), back), to_index.value_or(Affine{}));
  if (!may_meet(plan.to_source, plan.size, volume.size)) {
    context.warn(fmt::format("{}: none of it lies in the new grid, every voxel comes from outside; "
                             "the grid fills {} mm, the input {} mm{}",
                             arguments.input, extent_text(plan.geometry, plan.size),
                             extent_text(volume.geometry, volume.size),
                             arguments.affine.empty() ? "" : " before it is moved"));
  }
  return plan;
}

Plan make_plan(const Arguments& arguments, const FileReader& reader, Context& context) {
  const std::string operation = operation_of(arguments);
  check_options(arguments, operation);
  const Plan plan = unchanged(operation, reader.description());
  if (operation == "translate" || operation == "translate-mm") {
    return translation(arguments, reader.description(), plan);
  }
  if (operation == "shift") return shift(arguments, reader, context, plan);
  if (operation == "scale") return scaling(arguments, reader, plan);
  if (operation == "rotate" || operation == "mirror") return turn(arguments, plan);
  return resampling(arguments, reader, context, plan);
}

// ---- what is done

/// The description of the new volume; its metadata are those for a file made from the input.
VolumeDescription new_description(const std::shared_ptr<const FileReader>& reader,
                                  const Plan& plan) {
  VolumeDescription volume = FilePlanes(reader, plan.level, 1).description();
  volume.size = plan.size;
  volume.geometry = plan.geometry;
  if (plan.way == Way::resample) volume.coding.reset();
  // An origin and axes that moved say no more of the body than they did before.
  if (!plan.is_placed && !is_place_known(reader->description())) {
    volume.metadata_json = with_member(volume.metadata_json, "place_known", "false");
  }
  for (const auto& [name, value] : plan.spacing_facts.items()) {
    volume.metadata_json = with_member(volume.metadata_json, name, value.dump());
  }
  volume.metadata_json = with_member(volume.metadata_json, "made_by", plan.made_by.dump());
  return volume;
}

/// Planes computed at once: as many as a brick is high, where they are not too large.
std::int64_t planes_at_once(const VolumeDescription& volume) {
  constexpr std::uint64_t kMostBytes = std::uint64_t{128} << 20;
  std::uint64_t planes = 64;
  while (planes > 8 && planes * plane_bytes(volume) > kMostBytes) planes /= 2;
  return std::min(static_cast<std::int64_t>(planes), volume.size.z);
}

BuildOptions build_options(const Arguments& arguments, const VolumeDescription& volume,
                           const Context& context) {
  BuildOptions options;
  options.kind = volume.kind;
  options.is_resumable = false;
  options.preset = arguments.preset == "fast" ? Preset::fast : Preset::small;
  options.max_error = parse_number(arguments.max_error, "--max-error");
  if (options.max_error < 0) {
    throw Error(ErrorKind::invalid_argument, "--max-error: must not be negative");
  }
  return with_context(options, context);
}

/// True where the octree of a mask does the same without its voxels.
bool is_for_mask_tree(const FileReader& reader, const Plan& plan) {
  const ValueRange range = reader.range();
  const VolumeDescription& volume = reader.description();
  return (plan.turn || (plan.shift && plan.outside == 0)) && volume.kind == VolumeKind::labels &&
         volume.type == VoxelType::uint8 && range.min >= 0 && range.max <= 1;
}

std::uint64_t build_from(const VolumeDescription& volume, const FillBox& fill,
                         const BuildOptions& options, const Arguments& arguments,
                         const Context& context) {
  const auto source = make_computed_source(volume, fill, planes_at_once(volume));
  ProgressLine progress(context);
  return build_file(*source, local_storage(), arguments.output, options, progress).file_bytes;
}

std::uint64_t write_volume(const Arguments& arguments,
                           const std::shared_ptr<const FileReader>& reader, const Plan& plan,
                           const VolumeDescription& volume, const Context& context) {
  const BuildOptions options = build_options(arguments, volume, context);
  const std::uint64_t source_bytes =
      plane_bytes(volume) * static_cast<std::uint64_t>(planes_at_once(volume));
  require_room_for(volume, options, source_bytes, arguments.output,
                   plan.operation == "scale" ? "take a smaller --scale"
                                             : "take a smaller volume or grid");
  if (is_for_mask_tree(*reader, plan)) {
    MaskTree mask = read_mask(*reader, 0, {{1, 1}}, context);
    on_threads(context, [&] {
      mask = plan.turn ? turned(mask, *plan.turn) : shifted(mask, *plan.shift);
    });
    const auto fill = [&](const Box& box, std::byte* voxels) {
      fill_voxels(mask, box, reinterpret_cast<std::uint8_t*>(voxels));
    };
    return build_from(volume, fill, options, arguments, context);
  }
  const Resampler resampler(*reader, plan.level, plan.to_source, plan.interpolation, plan.outside);
  const auto fill = [&](const Box& box, std::byte* voxels) {
    on_threads(context, [&] { resampler.fill(box, voxels); });
  };
  return build_from(volume, fill, options, arguments, context);
}

std::uint64_t copy_file(const Arguments& arguments, const VolumeDescription& volume,
                        const Context& context) {
  ProgressLine progress(context);
  return copy_described(open_bytes(arguments.input), volume, local_storage(), arguments.output,
                        context.force, progress);
}

/// " of 1 x 1 x 2 mm, origin 0, 0, 0 mm"
std::string grid_text(const VolumeDescription& volume) {
  if (!is_spacing_known(metadata_of(volume))) return " (spacing not known)";
  return fmt::format(" of {} mm, origin {} mm", point_text(volume.geometry.spacing_mm),
                     point_text(volume.geometry.origin_mm, ", "));
}

void report(const Arguments& arguments, const Plan& plan, const VolumeDescription& volume,
            std::uint64_t file_bytes, const Context& context) {
  if (context.json) {
    print_json({{"output", arguments.output},
                {"operation", plan.operation},
                {"bricks", plan.way == Way::copy ? "copied" : "made"},
                {"size", {volume.size.x, volume.size.y, volume.size.z}},
                {"spacing_mm", if_in_mm(volume, volume.geometry.spacing_mm)},
                {"origin_mm", if_in_mm(volume, volume.geometry.origin_mm)},
                {"direction", volume.geometry.direction},
                {"file_bytes", file_bytes},
                {"warnings", context.warnings}});
  } else if (!context.quiet) {
    print(fmt::format("{}: {} voxels{}; {}\n", arguments.output, size_text(volume.size),
                      grid_text(volume), plan.said));
  }
}

int run_transform(const Arguments& arguments, Context& context) {
  require_computed_output(arguments.output, {arguments.input}, context);
  const std::shared_ptr<const FileReader> reader = open_octavo(arguments.input, context);
  const Plan plan = make_plan(arguments, *reader, context);
  const VolumeDescription volume = new_description(reader, plan);
  const std::uint64_t bytes = plan.way == Way::copy
                                  ? copy_file(arguments, volume, context)
                                  : write_volume(arguments, reader, plan, volume, context);
  report(arguments, plan, volume, bytes, context);
  return kExitDone;
}

}  // namespace

void add_transform(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_transform(*arguments, context); });
  const auto add = [&](const char* name, std::string& value, const char* text, const char* type) {
    return verb.add_option(name, value, text)->type_name(type);
  };
  add("file", arguments->input, "An .8vo file or a URL of one", "FILE")->required();
  add("-o,--output", arguments->output, "The .8vo file to write", "FILE")->required();
  const char* const kOperation = "Operation";
  add("--translate", arguments->translate, "Move the volume by x,y,z voxels: its origin", "X,Y,Z")
      ->group(kOperation);
  add("--translate-mm", arguments->translate_mm, "Move the volume by x,y,z mm (LPS): its origin",
      "X,Y,Z")
      ->group(kOperation);
  add("--shift", arguments->shift, "Move the voxels by x,y,z within the grid", "X,Y,Z")
      ->group(kOperation);
  verb.add_option("--rotate", arguments->rotations, "Quarter turns about an index axis")
      ->type_name("AXIS:DEGREES")
      ->allow_extra_args(false)
      ->group(kOperation);
  verb.add_option("--mirror", arguments->mirrors, "Reverse an index axis: x, y or z")
      ->type_name("AXIS")
      ->allow_extra_args(false)
      ->group(kOperation);
  add("--scale", arguments->scale, "A grid N times as fine, or 1/N: a coarser level", "N")
      ->group(kOperation);
  add("--affine", arguments->affine, "Move the object by a 4 x 4 matrix in a text file (mm, LPS)",
      "FILE")
      ->group(kOperation);
  add("--grid-of", arguments->grid_of, "Resample onto the grid of this .8vo file", "FILE")
      ->group(kOperation);
  verb.add_flag("--inverse", arguments->is_inverse, "Take the inverse of the matrix");
  verb.add_flag("--in-place", arguments->is_in_place,
                "Keep direction and center of the grid: the object turns or grows");
  add("--interpolation", arguments->interpolation,
      "nearest, linear or cubic (default: linear; labels: nearest)", "NAME")
      ->check(one_of({"nearest", "linear", "cubic"}));
  add("--fill", arguments->fill,
      "Real value from outside (default: the least of the volume; labels: 0)", "V");
  add("--preset", arguments->preset, "small: fewest bytes; fast: several times faster", "NAME")
      ->check(one_of({"small", "fast"}))
      ->capture_default_str();
  add("--max-error", arguments->max_error, "Every new voxel within E of what was computed", "E")
      ->capture_default_str();
}

}  // namespace octavo::cli
