#include "octavo/io/nrrd_source.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "octavo/io/header_text.h"
#include "octavo/io/source_file.h"
#include "octavo/io/streamed_source.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;

[[noreturn]] void reject(const std::string& path, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, path);
}

/// The fields of a header, names in lower case, and where the empty line behind it ends.
class NrrdHeader {
 public:
  explicit NrrdHeader(const std::string& path) : path_(path) {
    const std::vector<std::byte> head = file_head(path, kMaxHeaderBytes);
    const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
    if (!text.starts_with("NRRD000"))
      reject(path, "not a NRRD header: it does not start with NRRD000");
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const std::string_view line = trimmed(text.substr(at, end - at));
      at = std::min(end + 1, text.size());
      if (line.empty()) {
        data_offset_ = at;
        return;
      }
      take_line(line);
    }
    data_offset_ = text.size();
    if (!has("data file")) reject(path, "the NRRD header has no end: the file is cut");
  }

  const std::string& path() const { return path_; }
  std::uint64_t data_offset() const { return data_offset_; }
  bool has(const std::string& name) const { return fields_.contains(name); }
  FieldText field(const std::string& name) const {
    const auto found = fields_.find(name);
    if (found == fields_.end()) return {path_, "", {}};
    return {path_, found->first, found->second};
  }
  std::string text(const std::string& name) const { return std::string(field(name).value); }
  /// What says nothing of the voxels.
  const SourceIdentity& identity() const { return identity_; }

 private:
  void take_line(std::string_view line) {
    if (line.starts_with('#')) {
      identity_.note("comment", std::string(trimmed(line.substr(1))));
      return;
    }
    const std::size_t colon = line.find(": ");
    // A key of its own program's choice keeps its sign, so that it is never taken for a field.
    const std::size_t key_end = line.find(":=");
    if (key_end < colon) {
      identity_.note("key/value pair", std::string(line));
      fields_[std::string(line.substr(0, key_end + 2))] = trimmed(line.substr(key_end + 2));
      return;
    }
    if (colon == std::string_view::npos) return;
    std::string name = lower_case(std::string(line.substr(0, colon)));
    if (name == "datafile") name = "data file";
    if (name == "lineskip") name = "line skip";
    if (name == "byteskip") name = "byte skip";
    fields_[name] = trimmed(line.substr(colon + 2));
    if (name == "content" || name == "labels") identity_.note(name, fields_[name]);
    else if (!is_of_the_format(name)) identity_.note("other field", std::string(line));
  }

  static bool is_of_the_format(const std::string& name) {
    static const std::set<std::string> kNames = {
        "axis maxs",   "axis mins",   "axismaxs",     "axismins",        "block size",
        "blocksize",   "byte skip",   "centerings",   "centers",         "data file",
        "dimension",   "encoding",    "endian",       "kinds",           "line skip",
        "max",         "min",         "number",       "measurement frame", "old max",
        "old min",     "oldmax",      "oldmin",       "sample units",    "sampleunits",
        "sizes",       "space",       "space dimension", "space directions", "space origin",
        "space units", "spacings",    "thicknesses",  "type",            "units"};
    return kNames.contains(name);
  }

  std::string path_;
  SourceIdentity identity_;
  std::map<std::string, std::string> fields_;
  std::uint64_t data_offset_ = 0;
};

VoxelType voxel_type_of(const NrrdHeader& header) {
  static const std::map<std::string, VoxelType> kTypes = {
      {"signed char", VoxelType::int8},     {"int8", VoxelType::int8},
      {"int8_t", VoxelType::int8},          {"uchar", VoxelType::uint8},
      {"unsigned char", VoxelType::uint8},  {"uint8", VoxelType::uint8},
      {"uint8_t", VoxelType::uint8},        {"short", VoxelType::int16},
      {"short int", VoxelType::int16},      {"signed short", VoxelType::int16},
      {"signed short int", VoxelType::int16}, {"int16", VoxelType::int16},
      {"int16_t", VoxelType::int16},        {"ushort", VoxelType::uint16},
      {"unsigned short", VoxelType::uint16}, {"unsigned short int", VoxelType::uint16},
      {"uint16", VoxelType::uint16},        {"uint16_t", VoxelType::uint16},
      {"int", VoxelType::int32},            {"signed int", VoxelType::int32},
      {"int32", VoxelType::int32},          {"int32_t", VoxelType::int32},
      {"uint", VoxelType::uint32},          {"unsigned int", VoxelType::uint32},
      {"uint32", VoxelType::uint32},        {"uint32_t", VoxelType::uint32},
      {"float", VoxelType::float32}};
  const std::string name = header.text("type");
  const auto found = kTypes.find(lower_case(name));
  if (found == kTypes.end()) {
    reject(header.path(), "voxel type \"" + escaped(name) +
                              "\" is not supported; integers of 8, 16 or 32 bits or float are");
  }
  return found->second;
}

Size3 read_size(const NrrdHeader& header) {
  const std::vector<std::int64_t> sizes = header.field("sizes").integers();
  const std::int64_t dimension = header.field("dimension").integer();
  if (static_cast<std::int64_t>(sizes.size()) != dimension) {
    reject(header.path(), "dimension is " + std::to_string(dimension) + ", sizes has " +
                              std::to_string(sizes.size()) + " numbers");
  }
  if (dimension != 2 && dimension != 3) {
    reject(header.path(), std::to_string(dimension) +
                              " dimensions (colour, vectors or time): only volumes of 2 or 3 are "
                              "read; take out one first");
  }
  return {sizes[0], sizes[1], dimension == 3 ? sizes[2] : 1};
}

/// Refuses an axis that is not a direction in space.
void check_kinds(const NrrdHeader& header) {
  for (const std::string& kind : words(lower_case(header.text("kinds")))) {
    if (kind == "domain" || kind == "space" || kind == "???" || kind == "none") continue;
    reject(header.path(), "an axis of kind \"" + escaped(kind) +
                              "\" is no direction in space; take out one component first");
  }
}

/// +1 or -1 per world axis: what turns the named space into LPS.
Point3 signs_to_lps(const std::string& space) {
  static const std::map<std::string, Point3> kSigns = {
      {"right-anterior-superior", {-1, -1, 1}},
      {"ras", {-1, -1, 1}},
      {"left-anterior-superior", {1, -1, 1}},
      {"las", {1, -1, 1}}};
  const auto found = kSigns.find(space);
  return found == kSigns.end() ? Point3{1, 1, 1} : found->second;
}

/// The vectors "(a,b,c) (d,e,f) ..." of a field; "none" is refused.
std::vector<Point3> vectors(const FieldText& field) {
  std::string flat(field.value);
  const auto count = static_cast<std::size_t>(std::count(flat.begin(), flat.end(), '('));
  std::replace_if(
      flat.begin(), flat.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  if (flat.find("none") != std::string::npos) {
    reject(field.path, "an axis without direction (colour, vector or time): take out one "
                       "component first");
  }
  const std::vector<double> numbers = FieldText{field.path, field.name, flat}.numbers(count * 3);
  std::vector<Point3> result;
  for (std::size_t i = 0; i < count; ++i) {
    result.push_back({numbers[i * 3], numbers[i * 3 + 1], numbers[i * 3 + 2]});
  }
  return result;
}

bool read_space_directions(const NrrdHeader& header, std::size_t dimension, Geometry& geometry) {
  const std::vector<Point3> axes = vectors(header.field("space directions"));
  if (axes.size() != dimension || dimension != 3) {
    reject(header.path(), "space directions: " + std::to_string(dimension) +
                              " vectors of 3 numbers expected, " + std::to_string(axes.size()) +
                              " found");
  }
  const Point3 signs = signs_to_lps(lower_case(header.text("space")));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Point3& v = axes[axis];
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    geometry.spacing_mm[axis] = length;
    for (std::size_t row = 0; row < 3; ++row) {
      geometry.direction[row * 3 + axis] = signs[row] * v[row] / length;
    }
  }
  if (!header.has("space origin")) return true;
  const std::vector<Point3> origin = vectors(header.field("space origin"));
  if (origin.size() != 1) reject(header.path(), "space origin: one vector expected");
  for (std::size_t row = 0; row < 3; ++row) geometry.origin_mm[row] = signs[row] * origin[0][row];
  return true;
}

/// Old headers: spacings only; "nan" says that an axis has none.
bool read_spacings(const NrrdHeader& header, std::size_t dimension, Geometry& geometry) {
  if (!header.has("spacings")) return false;
  const std::vector<double> mm = header.field("spacings").numbers();
  if (mm.size() != dimension) {
    reject(header.path(), "spacings: " + std::to_string(dimension) + " numbers expected, " +
                              std::to_string(mm.size()) + " found");
  }
  if (std::any_of(mm.begin(), mm.end(), [](double v) { return !std::isfinite(v); })) return false;
  for (std::size_t axis = 0; axis < dimension; ++axis)
    geometry.spacing_mm[axis] = std::abs(mm[axis]);
  return true;
}

VoxelRun locate_voxels(const NrrdHeader& header) {
  VoxelRun run;
  run.path = header.path();
  run.start_offset = header.data_offset();
  if (header.has("data file")) {
    const std::string data = header.text("data file");
    if (lower_case(data).starts_with("list") || data.find('%') != std::string::npos) {
      reject(header.path(), "a NRRD that lists several data files is not read; join them first");
    }
    run.path = sibling_path(header.path(), data);
    run.start_offset = 0;
  }
  const std::string encoding = lower_case(header.text("encoding"));
  if (encoding == "gzip" || encoding == "gz") {
    run.coding = StreamCoding::deflated;
  } else if (encoding != "raw") {
    reject(header.path(), "encoding \"" + escaped(encoding) + "\" is not read; raw and gzip are");
  }
  if (header.has("line skip") && header.field("line skip").integer() != 0) {
    reject(header.path(), "\"line skip\" is not read; use \"byte skip\"");
  }
  run.big_endian = lower_case(header.text("endian")) == "big";
  return run;
}

/// "byte skip": before the voxels, behind decompression; -1 counts them from the end of a plain
/// file.
void apply_byte_skip(const NrrdHeader& header, std::uint64_t voxel_bytes, VoxelRun& run) {
  if (!header.has("byte skip")) return;
  const std::int64_t skip = header.field("byte skip").integer();
  if (skip >= 0) {
    run.skip_bytes = static_cast<std::uint64_t>(skip);
    return;
  }
  const std::uint64_t length = SourceFile(run.path).size();
  if (skip != -1 || run.coding != StreamCoding::plain || length < voxel_bytes) {
    reject(header.path(), "\"byte skip\" " + std::to_string(skip) + " does not fit its data file");
  }
  run.start_offset = length - voxel_bytes;
}

/// The slope and intercept that the export of stored values notes as keys.
Rescale read_rescale(const NrrdHeader& header) {
  Rescale rescale;
  if (header.has("rescale_slope:=")) rescale.slope = header.field("rescale_slope:=").numbers(1)[0];
  if (header.has("rescale_intercept:="))
    rescale.intercept = header.field("rescale_intercept:=").numbers(1)[0];
  return rescale;
}

}  // namespace

std::unique_ptr<PlaneSource> open_nrrd_source(const std::string& path,
                                              const SourceOptions& options) {
  const NrrdHeader header(path);
  SourceFacts facts;
  facts.format = "NRRD";
  facts.identity = header.identity();
  VolumeDescription& description = facts.description;
  description.type = voxel_type_of(header);
  description.size = read_size(header);
  description.rescale = read_rescale(header);
  check_kinds(header);
  const std::size_t dimension = header.field("sizes").integers().size();
  facts.spacing_known = header.has("space directions")
                            ? read_space_directions(header, dimension, description.geometry)
                            : read_spacings(header, dimension, description.geometry);
  VoxelRun run = locate_voxels(header);
  if (run.path != path) facts.file_count = 2;
  if (bytes_per_voxel(description.type) > 1 && !header.has("endian")) {
    reject(path, "the header does not say the byte order (endian)");
  }
  settle(facts, options, path);
  apply_byte_skip(header, plane_bytes(description) * static_cast<std::uint64_t>(description.size.z),
                  run);
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
