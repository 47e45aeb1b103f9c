#include "octavo/io/volumes/nrrd_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/io/source/axis_check.h"
#include "octavo/io/source/length_unit.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

/// What "space" says of the axes of the world.
struct WorldAxes {
  Point3 to_lps = {1, 1, 1};  ///< +1 or -1 each
  std::string doubt;          ///< why nobody can tell where left is; empty where it is said
};

constexpr const char* kSpacesRead =
    "left-posterior-superior (LPS), right-anterior-superior (RAS), left-anterior-superior (LAS), "
    "scanner-xyz, 3D-right-handed and 3D-left-handed";

WorldAxes world_axes_of(const NrrdHeader& header) {
  static const std::map<std::string, Point3> kSigns = {
      {"left-posterior-superior", {1, 1, 1}},   {"lps", {1, 1, 1}},
      {"right-anterior-superior", {-1, -1, 1}}, {"ras", {-1, -1, 1}},
      {"left-anterior-superior", {1, -1, 1}},   {"las", {1, -1, 1}}};
  if (!header.has("space")) return {{1, 1, 1}, "the header names no space, so that it"};
  const std::string space = header.text("space");
  const std::string name = lower_case(space);
  if (const auto found = kSigns.find(name); found != kSigns.end()) return {found->second, ""};
  const std::string quoted = "the space \"" + escaped(space) + "\"";
  if (name == "scanner-xyz" || name == "3d-right-handed") return {{1, 1, 1}, quoted};
  if (name == "3d-left-handed") return {{1, 1, 1}, quoted + ", a mirror image of ours,"};
  reject(header.path(), quoted + " is not read; " + kSpacesRead +
                            " are (of those with time, write the time as an axis with the "
                            "direction \"none\")");
}

/// Notes that origin and directions say nothing of the body.
void leave_unplaced(SourceFacts& facts) { facts.place_known = false; }

/// The vectors "(a,b,c) none (d,e,f) ..." of a field; "none" is passed over.
/// length  numbers of each: 3, or 2 of vectors in the plane z = 0
std::vector<Point3> vectors(const FieldText& field, std::size_t length) {
  std::string flat(field.value);
  const auto count = static_cast<std::size_t>(std::count(flat.begin(), flat.end(), '('));
  std::replace_if(
      flat.begin(), flat.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  const std::string_view none = "none";
  const std::string lower = lower_case(flat);
  for (std::size_t at = lower.find(none); at != std::string::npos;
       at = lower.find(none, at + none.size())) {
    flat.replace(at, none.size(), none.size(), ' ');
  }
  const std::vector<double> numbers =
      FieldText{field.path, field.name, flat}.numbers(count * length);
  std::vector<Point3> result(count);
  for (std::size_t i = 0; i < numbers.size(); ++i) result[i / length][i % length] = numbers[i];
  return result;
}

/// The quoted words of "units" or "space units".
std::vector<std::string> quoted_words(std::string_view text) {
  std::vector<std::string> result;
  while (true) {
    const std::size_t start = text.find('"');
    const std::size_t end = start == std::string_view::npos ? start : text.find('"', start + 1);
    if (end == std::string_view::npos) return result;
    result.emplace_back(trimmed(text.substr(start + 1, end - start - 1)));
    text.remove_prefix(end + 1);
  }
}

/// Millimeters in each unit of a field, of which `count` are expected; 1 where none is named, and
/// where it is none of `lengths`.
std::vector<double> units_in_mm(const NrrdHeader& header, const std::string& field,
                                std::size_t count, const std::vector<std::size_t>& lengths,
                                const SourceOptions& options) {
  std::vector<double> factors(count, 1.0);
  if (!header.has(field)) return factors;
  const std::vector<std::string> units = quoted_words(header.text(field));
  if (units.size() != count) {
    reject(header.path(), "\"" + field + "\" names " +
                              counted_text(static_cast<std::int64_t>(units.size()), "unit") +
                              " in quotes, " + std::to_string(count) + " expected");
  }
  for (const std::size_t i : lengths) {
    if (units[i].empty() || units[i] == "???") continue;
    const std::optional<double> factor = unit_in_mm(units[i]);
    if (!factor && !options.spacing_mm) {
      throw Error(ErrorKind::source_rejected,
                  "\"" + field + "\" names \"" + escaped(units[i]) +
                      "\", which is no unit that is known here (" + kUnitsRead + ")",
                  header.path())
          .with_field("spacing_mm");
    }
    factors[i] = factor.value_or(1.0);
  }
  return factors;
}

/// Dimensions of the world: 3, or 2 of an image.
std::size_t world_dimension(const NrrdHeader& header, const NrrdSpaceAxes& space) {
  if (!header.has("space dimension")) return 3;
  const std::int64_t dimension = header.field("space dimension").integer();
  if (dimension == 3 || (dimension == 2 && space.axes.size() == 2)) {
    return static_cast<std::size_t>(dimension);
  }
  reject(header.path(), "space dimension is " + std::to_string(dimension) +
                            ", 3 expected; repair the header");
}

/// Millimeters in the unit of each axis of the world.
std::vector<double> units_in_space(const NrrdHeader& header, const NrrdSpaceAxes& space,
                                   const SourceOptions& options) {
  const std::size_t dimension = world_dimension(header, space);
  std::vector<std::size_t> lengths = {0, 1, 2};
  lengths.resize(dimension);
  std::vector<double> units = units_in_mm(header, "space units", dimension, lengths, options);
  units.resize(3, 1.0);
  return units;
}

/// "spacings", one for each axis, "nan" where an axis has none.
std::vector<double> given_spacings(const NrrdHeader& header, std::size_t axis_count) {
  if (!header.has("spacings")) {
    return std::vector<double>(axis_count, std::numeric_limits<double>::quiet_NaN());
  }
  std::vector<double> given = header.field("spacings").numbers();
  if (given.size() != axis_count) {
    reject(header.path(), "spacings: " + std::to_string(axis_count) + " numbers expected, " +
                              std::to_string(given.size()) + " found");
  }
  return given;
}

bool are_alike(double a, double b) { return std::abs(a - b) <= kAxisTolerance * std::abs(a); }

/// name   of the other field
/// other  what it says of the axis
[[noreturn]] void reject_spacing(const NrrdHeader& header, std::size_t axis, double spacing,
                                 const char* name, double other) {
  throw Error(ErrorKind::source_rejected,
              std::string("the lengths of axis ") + axis_name(axis) +
                  " contradict each other: spacings says " + precise_text(spacing) + ", " + name +
                  " " + precise_text(other) + "; take out the wrong one",
              header.path())
      .with_field("spacing_mm");
}

/// The format gives an axis a direction or a spacing; both are read where they agree.
void check_spacings_beside_directions(const NrrdHeader& header, const NrrdSpaceAxes& space,
                                      const SourceOptions& options, const Geometry& geometry) {
  if (!header.has("spacings") || options.spacing_mm) return;
  const std::vector<double> given = given_spacings(header, space.axis_count);
  const std::vector<double> units =
      units_in_mm(header, "units", space.axis_count, space.axes, options);
  const std::vector<double> space_units = units_in_space(header, space, options);
  for (std::size_t i = 0; i < space.axes.size(); ++i) {
    const std::size_t axis = space.axes[i];
    if (!std::isfinite(given[axis])) continue;
    const double unit_mm = header.has("units") ? units[axis] : space_units.front();
    const double spacing_mm = std::abs(given[axis]) * unit_mm;
    if (are_alike(spacing_mm, geometry.spacing_mm[i])) continue;
    reject_spacing(header, i, spacing_mm, "space directions", geometry.spacing_mm[i]);
  }
}

/// The format gives an axis a direction or borders.
void tell_of_borders_beside_directions(const NrrdHeader& header, SourceFacts& facts) {
  for (const char* name : {"axis mins", "axis maxs"}) {
    const std::vector<double> borders = header.field(name).numbers();
    if (std::ranges::none_of(borders, [](double v) { return std::isfinite(v); })) continue;
    facts.warnings.push_back("\"" + std::string(name) + "\" beside \"space directions\" are left "
                             "out: " + escaped(header.path()));
  }
}

/// Takes spacings and directions from the vectors of three axes, in millimeters.
void take_axes(const NrrdHeader& header, const std::vector<Point3>& axes, Geometry& geometry) {
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const Point3& v = axes[axis];
    const double length = std::sqrt(dot(v, v));
    if (!(length > 0)) {
      reject(header.path(), std::string("space directions: the vector of axis ") +
                                axis_name(axis) + " has no length; repair the header");
    }
    geometry.spacing_mm[axis] = length;
    for (std::size_t row = 0; row < 3; ++row) {
      geometry.direction[row * 3 + axis] = v[row] / length;
    }
  }
}

/// The normal of an image, 1 mm long.
Point3 normal_of(const Point3& a, const Point3& b) {
  const Point3 normal = cross(a, b);
  return dot(normal, normal) > 0 ? unit(normal) : Point3{0, 0, 1};
}

void read_space_directions(const NrrdHeader& header, const NrrdSpaceAxes& space,
                           const SourceOptions& options, SourceFacts& facts) {
  const std::size_t length = world_dimension(header, space);
  std::vector<Point3> axes = vectors(header.field("space directions"), length);
  if (axes.size() != space.axes.size()) {
    reject(header.path(), "space directions: " + std::to_string(space.axes.size()) +
                              " vectors expected, " + std::to_string(axes.size()) + " found");
  }
  const WorldAxes world = world_axes_of(header);
  facts.place_known = world.doubt.empty();
  if (!world.doubt.empty()) {
    facts.warnings.push_back(world.doubt + " does not say where left is: axes and origin are kept "
                                           "as in the file: " + escaped(header.path()));
  }
  Geometry& geometry = facts.description.geometry;
  Point3 signs = world.to_lps;
  const std::vector<double> units = units_in_space(header, space, options);
  for (std::size_t row = 0; row < 3; ++row) signs[row] *= units[row];
  for (Point3& v : axes) v = {signs[0] * v[0], signs[1] * v[1], signs[2] * v[2]};
  if (axes.size() == 2) axes.push_back(normal_of(axes[0], axes[1]));
  take_axes(header, axes, geometry);
  reject_shear(geometry, "space directions", header.path());
  check_spacings_beside_directions(header, space, options, geometry);
  tell_of_borders_beside_directions(header, facts);
  if (!header.has("space origin")) return;
  const std::vector<Point3> origin = vectors(header.field("space origin"), length);
  if (origin.size() != 1) reject(header.path(), "space origin: one vector expected");
  for (std::size_t row = 0; row < 3; ++row) geometry.origin_mm[row] = signs[row] * origin[0][row];
}

/// The words of "centers", one for each axis; "" where the header is silent.
std::vector<std::string> centers_of(const NrrdHeader& header, std::size_t axis_count) {
  std::vector<std::string> centers = words(lower_case(header.text("centers")));
  if (!centers.empty() && centers.size() != axis_count) {
    reject(header.path(), "centers has " +
                              counted_text(static_cast<std::int64_t>(centers.size()), "word") +
                              " for " +
                              std::to_string(axis_count) + " axes");
  }
  centers.resize(axis_count);
  return centers;
}

/// "axis mins" says where each axis starts, "nan" where it does not: at the border of the first
/// voxel where voxels are cells, at its center where they are nodes. Without "centers" they are
/// cells, as Teem and ITK have it.
/// units   millimeters in the unit of each axis of the file
void take_axis_mins(const NrrdHeader& header, const NrrdSpaceAxes& space,
                    const std::vector<double>& units, SourceFacts& facts) {
  if (!header.has("axis mins")) return;
  const std::vector<double> mins = header.field("axis mins").numbers();
  if (mins.size() != space.axis_count) {
    reject(header.path(), "axis mins: " + std::to_string(space.axis_count) +
                              " numbers expected, " + std::to_string(mins.size()) + " found");
  }
  const std::vector<std::string> centers = centers_of(header, space.axis_count);
  Geometry& geometry = facts.description.geometry;
  bool is_assumed = false;
  for (std::size_t i = 0; i < space.axes.size(); ++i) {
    const std::size_t axis = space.axes[i];
    if (!std::isfinite(mins[axis])) continue;
    const bool is_node = centers[axis] == "node";
    is_assumed = is_assumed || (!is_node && centers[axis] != "cell");
    const double step_mm = geometry.direction[i * 3 + i] * geometry.spacing_mm[i];
    geometry.origin_mm[i] = mins[axis] * units[axis] + (is_node ? 0 : step_mm / 2);
  }
  leave_unplaced(facts);
  if (!is_assumed) return;
  facts.warnings.push_back("the header gives \"axis mins\" without \"centers\": they are taken "
                           "as the borders of the first voxels: " + escaped(header.path()));
}

/// What "axis mins" and "axis maxs" say of each axis in space.
class AxisBorders {
 public:
  /// sizes  voxels along each axis in space
  AxisBorders(const NrrdHeader& header, const NrrdSpaceAxes& space, const Size3& sizes) {
    if (!header.has("axis mins") || !header.has("axis maxs")) return;
    const std::vector<double> mins = header.field("axis mins").numbers();
    const std::vector<double> maxs = header.field("axis maxs").numbers();
    if (mins.size() != space.axis_count || maxs.size() != space.axis_count) {
      reject(header.path(), "axis mins and axis maxs: " + std::to_string(space.axis_count) +
                                " numbers expected, " + std::to_string(mins.size()) + " and " +
                                std::to_string(maxs.size()) + " found");
    }
    const std::vector<std::string> centers = centers_of(header, space.axis_count);
    const std::array<std::int64_t, 3> counts = {sizes.x, sizes.y, sizes.z};
    for (std::size_t i = 0; i < space.axes.size(); ++i) {
      const std::size_t axis = space.axes[i];
      axes_.push_back({maxs[axis] - mins[axis], counts[i], centers[axis]});
    }
  }

  /// The distance of voxels along the axis `i` in space, below 0 where it runs backwards: between
  /// centers of nodes, else borders of cells. Nothing where they say none.
  std::optional<double> step(std::size_t i) const {
    return i < axes_.size() ? axes_[i].step(axes_[i].center == "node") : std::nullopt;
  }

  /// Whether a spacing contradicts them, be they of cells or of nodes where "centers" is silent.
  bool contradict(std::size_t i, double spacing) const {
    if (i >= axes_.size() || !step(i)) return false;
    const Axis& axis = axes_[i];
    const bool may_be_node = axis.center != "cell";
    const bool may_be_cell = axis.center != "node";
    const auto agrees = [&](bool is_node) {
      const std::optional<double> found = axis.step(is_node);
      return found && are_alike(*found, spacing);
    };
    return !(may_be_cell && agrees(false)) && !(may_be_node && agrees(true));
  }

 private:
  struct Axis {
    double length = 0;
    std::int64_t count = 0;
    std::string center;

    std::optional<double> step(bool is_node) const {
      const std::int64_t steps = count - (is_node ? 1 : 0);
      const double found = length / static_cast<double>(steps);
      return steps > 0 && std::isfinite(found) && found != 0 ? std::optional(found) : std::nullopt;
    }
  };

  std::vector<Axis> axes_;
};

/// Headers without space directions: spacings only, below 0 where an axis runs backwards; "nan"
/// says that an axis has none, which may have borders instead. False when an axis in space has
/// neither.
bool read_spacings(const NrrdHeader& header, const NrrdSpaceAxes& space,
                   const SourceOptions& options, SourceFacts& facts) {
  const std::vector<double> given = given_spacings(header, space.axis_count);
  const AxisBorders borders(header, space, facts.description.size);
  std::vector<double> steps;
  for (std::size_t i = 0; i < space.axes.size(); ++i) {
    const double spacing = given[space.axes[i]];
    const bool is_given = std::isfinite(spacing);
    if (is_given && !options.spacing_mm && borders.contradict(i, spacing)) {
      reject_spacing(header, i, spacing, "axis mins and axis maxs", *borders.step(i));
    }
    if (!is_given && !borders.step(i)) return false;
    steps.push_back(is_given ? spacing : *borders.step(i));
  }
  const std::vector<double> units =
      units_in_mm(header, "units", space.axis_count, space.axes, options);
  Geometry& geometry = facts.description.geometry;
  for (std::size_t i = 0; i < space.axes.size(); ++i) {
    const double step_mm = steps[i] * units[space.axes[i]];
    geometry.spacing_mm[i] = std::abs(step_mm);
    if (!(step_mm < 0)) continue;
    geometry.direction[i * 3 + i] = -1;
    leave_unplaced(facts);
  }
  take_axis_mins(header, space, units, facts);
  return true;
}

/// Tells what of the place of the voxels is not taken from a header without space directions.
void tell_what_is_left_out(const NrrdHeader& header, SourceFacts& facts) {
  if (header.has("space") || header.has("space origin")) {
    facts.warnings.push_back("the header names a space but gives no \"space directions\": "
                             "orientation and origin are left out: " + escaped(header.path()));
  }
  if (header.has("axis mins") && !facts.spacing_known) {
    facts.warnings.push_back("the header gives \"axis mins\" but no spacings: the origin is left "
                             "out: " + escaped(header.path()));
  }
}

}  // namespace

void read_nrrd_geometry(const NrrdHeader& header, const NrrdSpaceAxes& space,
                        const SourceOptions& options, SourceFacts& facts) {
  if (header.has("space directions")) {
    read_space_directions(header, space, options, facts);
    facts.spacing_known = true;
    return;
  }
  facts.spacing_known = read_spacings(header, space, options, facts);
  tell_what_is_left_out(header, facts);
}

}  // namespace octavo
