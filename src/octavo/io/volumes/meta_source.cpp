#include "octavo/io/volumes/meta_source.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/levels.h"
#include "octavo/core/text.h"
#include "octavo/io/source/axis_check.h"
#include "octavo/io/source/data_files.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/length_unit.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/streamed_source.h"
#include "octavo/io/volumes/meta_header.h"

namespace octavo {

namespace {

StoredType stored_type_of(const MetaHeader& header) {
  static const std::map<std::string, StoredType> kTypes = {
      {"MET_CHAR", VoxelType::int8},    {"MET_UCHAR", VoxelType::uint8},
      {"MET_SHORT", VoxelType::int16},  {"MET_USHORT", VoxelType::uint16},
      {"MET_INT", VoxelType::int32},    {"MET_UINT", VoxelType::uint32},
      {"MET_FLOAT", VoxelType::float32}, {"MET_DOUBLE", WideType::float64},
      {"MET_LONG", VoxelType::int32},    {"MET_ULONG", VoxelType::uint32},
      {"MET_LONG_LONG", WideType::int64}, {"MET_ULONG_LONG", WideType::uint64}};
  const std::string name = header.text("ElementType");
  const auto found = kTypes.find(name);
  if (found == kTypes.end()) {
    reject(header.path(), "voxel type \"" + escaped(name) + "\" is not supported; integers of 8 "
                          "to 64 bits, MET_FLOAT and MET_DOUBLE are");
  }
  return found->second;
}

Size3 read_size(const MetaHeader& header) {
  const std::vector<std::int64_t> size = header.field({"DimSize"}).integers();
  const std::int64_t dimensions = header.field({"NDims"}).integer();
  if (static_cast<std::int64_t>(size.size()) != dimensions || dimensions < 2) {
    reject(header.path(), "NDims is " + std::to_string(dimensions) + ", DimSize has " +
                              std::to_string(size.size()) + " numbers");
  }
  if (std::ranges::any_of(size, [](std::int64_t count) { return count < 1; })) {
    reject(header.path(), "DimSize is " + escaped(header.text("DimSize")) +
                              ", numbers from 1 on expected; repair the header");
  }
  if (dimensions > 4) {
    reject(header.path(), std::to_string(dimensions) +
                              " dimensions: 2, 3 and, with time, 4 are read; take out one first");
  }
  return {size[0], size[1], dimensions >= 3 ? size[2] : 1};
}

/// A fourth axis is time; channels alternate.
SourceComponents components_of(const MetaHeader& header) {
  SourceComponents components;
  const FieldText channels = header.field({"ElementNumberOfChannels"});
  if (!channels.value.empty()) components.channels = channels.integer();
  const std::vector<std::int64_t> size = header.field({"DimSize"}).integers();
  if (size.size() == 4) components.times = size[3];
  return components;
}

/// Millimeters in the unit of lengths; 1 where the header names none.
double unit_of(const MetaHeader& header, const SourceOptions& options) {
  const std::string unit = header.text("DistanceUnits");
  if (unit.empty() || unit == "?") return 1;
  const std::optional<double> factor = unit_in_mm(unit);
  if (!factor && !options.spacing_mm) {
    throw Error(ErrorKind::source_rejected,
                "DistanceUnits is \"" + escaped(unit) +
                    "\", which is no unit that is known here (" + kUnitsRead + ")",
                header.path())
        .with_field("spacing_mm");
  }
  return factor.value_or(1);
}

/// Columns of another length than 1 contradict the spacing, unless that is given by the user: then
/// only where they point counts.
void settle_axis_lengths(const FieldText& matrix, const SourceOptions& options,
                         Geometry& geometry) {
  if (has_unit_axes(geometry)) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = axis_length(geometry, axis);
    const bool is_unit = std::abs(length - 1) <= kAxisTolerance;
    if (!(length > 0) || (!is_unit && !options.spacing_mm)) {
      const Error failure(ErrorKind::source_rejected,
                          escaped(matrix.name) + ": the vector of axis " + axis_name(axis) +
                              " has length " + precise_text(length) +
                              ", 1 expected, since the spacing stands in ElementSpacing; repair "
                              "the header",
                          matrix.path);
      throw length > 0 ? failure.with_field("spacing_mm") : failure;
    }
    for (std::size_t row = 0; row < 3; ++row) geometry.direction[row * 3 + axis] /= length;
  }
}

/// A 2-D image lies in the plane z = 0; of time nothing is taken.
void read_direction(const MetaHeader& header, std::size_t dimensions, const SourceOptions& options,
                    Geometry& geometry) {
  const FieldText matrix = header.agreed_field({"TransformMatrix", "Rotation", "Orientation"});
  if (matrix.value.empty()) return;
  const std::vector<double> rows = matrix.numbers(dimensions * dimensions);
  const std::size_t axes = std::min<std::size_t>(dimensions, 3);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    for (std::size_t row = 0; row < axes; ++row) {
      geometry.direction[row * 3 + axis] = rows[axis * dimensions + row];
    }
  }
  reject_shear(geometry, escaped(matrix.name), header.path());
  settle_axis_lengths(matrix, options, geometry);
}

/// The first three numbers of a field times the unit; false where the header has no such field.
bool read_lengths(const FieldText& field, std::size_t dimensions, double unit_mm, Point3& target) {
  if (field.value.empty()) return false;
  const std::vector<double> lengths = field.numbers(dimensions);
  for (std::size_t axis = 0; axis < std::min<std::size_t>(dimensions, 3); ++axis) {
    target[axis] = lengths[axis] * unit_mm;
  }
  return true;
}

/// Spacing, origin and directions; false where the header gives no spacing.
bool read_geometry(const MetaHeader& header, std::size_t dimensions, const SourceOptions& options,
                   Geometry& geometry) {
  const double unit_mm = unit_of(header, options);
  read_lengths(header.agreed_field({"Offset", "Position", "Origin"}), dimensions, unit_mm,
               geometry.origin_mm);
  read_direction(header, dimensions, options, geometry);
  return read_lengths(header.field({"ElementSpacing", "ElementSize"}), dimensions, unit_mm,
                      geometry.spacing_mm);
}

/// Whether the header says how the patient lies. "???" is what programs write that do not know,
/// with a mark for each axis.
std::optional<bool> place_known_of(const MetaHeader& header, const Geometry& geometry) {
  const std::string orientation = header.text("AnatomicalOrientation");
  if (orientation.empty() || !header.has("TransformMatrix")) return std::nullopt;
  if (orientation.find_first_not_of('?') != std::string::npos) return true;
  if (geometry.direction == Geometry{}.direction) return false;
  return std::nullopt;
}

void reject_unreadable(const MetaHeader& header) {
  if (header.has("BinaryData") && !header.is_true({"BinaryData"})) {
    reject(header.path(), "voxels written as text are not read; convert the file to binary");
  }
}

/// The words of "LIST", with the dimension of a file behind it or not; none where it is no list.
std::vector<std::string> list_words(const MetaHeader& header) {
  const std::vector<std::string> data = words(header.text("ElementDataFile"));
  const bool is_list = !data.empty() && data.size() <= 2 && data[0] == "LIST";
  return is_list ? data : std::vector<std::string>{};
}

/// Without a dimension each file holds one index of the last axis.
std::vector<std::string> listed_files(const MetaHeader& header,
                                      const std::vector<std::string>& list) {
  const std::vector<std::int64_t> sizes = header.field({"DimSize"}).integers();
  const auto all = static_cast<std::int64_t>(sizes.size());
  const std::int64_t asked =
      list.size() > 1
          ? FieldText{header.path(), "ElementDataFile", dimension_digits(list[1])}.integer()
          : 0;
  const std::int64_t dimension = asked < 1 || asked > all ? all - 1 : asked;
  const DataFileNames names = header.file_list();
  if (dimension == all && names.count() != 1) {
    reject(header.path(), "the header names " + std::to_string(names.count()) +
                              " data files of all its " + std::to_string(all) +
                              " dimensions, 1 expected; repair the header");
  }
  return find_data_files(header.path(), names, sizes, dimension);
}

/// The numbers are 1 to the size of the last axis, in steps of 1, where the pattern has none.
std::vector<std::string> numbered_files(const MetaHeader& header, const PatternLine& line) {
  const std::vector<std::int64_t> sizes = header.field({"DimSize"}).integers();
  const auto number = [&](std::size_t i, std::int64_t otherwise) {
    return i < line.numbers.size() ? line.numbers[i] : otherwise;
  };
  const NumberedNames names{line.pattern, number(0, 1), number(1, sizes.back()), number(2, 1)};
  return find_data_files(header.path(), DataFileNames::of_pattern(names), sizes,
                         static_cast<std::int64_t>(sizes.size()) - 1);
}

/// The files that a list or a pattern names; none where one file has all voxels.
std::vector<std::string> several_files(const MetaHeader& header) {
  if (const auto list = list_words(header); !list.empty()) return listed_files(header, list);
  const auto line = pattern_line(header.text("ElementDataFile"), 3);
  return line ? numbered_files(header, *line) : std::vector<std::string>{};
}

/// HeaderSize: where the voxels start in each file; nothing where it is -1, which says that a plain
/// file ends with them.
std::optional<std::uint64_t> header_size(const MetaHeader& header, StreamCoding coding) {
  const FieldText field = header.field({"HeaderSize"});
  const std::int64_t bytes = field.value.empty() ? 0 : field.integer();
  if (bytes >= 0) return static_cast<std::uint64_t>(bytes);
  if (bytes == -1 && coding == StreamCoding::plain) return std::nullopt;
  reject(header.path(), "HeaderSize " + std::to_string(bytes) + " is not usable");
}

/// voxel_bytes  of all volumes of the file
VoxelRun locate_voxels(const MetaHeader& header, std::uint64_t voxel_bytes) {
  VoxelRun run;
  // The order has a key for each kind of header; both may be there.
  run.big_endian = header.is_true({"ElementByteOrderMSB", "BinaryDataByteOrderMSB"});
  if (header.is_true({"CompressedData"})) run.coding = StreamCoding::deflated;
  const std::optional<std::uint64_t> start = header_size(header, run.coding);
  if (const std::vector<std::string> files = several_files(header); !files.empty()) {
    take_files(header.path(), files, voxel_bytes,
               start ? std::optional(PieceStart{*start, 0}) : std::nullopt, run);
    return run;
  }
  const std::string data = header.text("ElementDataFile");
  const bool is_local = lower_case(data) == "local";
  run.path = is_local ? header.path() : sibling_path(header.path(), data);
  if (!start) {
    run.start_offset = start_of_last(run.path, voxel_bytes);
  } else if (*start > 0) {
    run.start_offset = *start;
  } else if (is_local) {
    run.start_offset = header.data_offset();
  }
  return run;
}

}  // namespace

std::unique_ptr<PlaneSource> open_meta_source(const std::string& path,
                                              const SourceOptions& options) {
  const MetaHeader header(path);
  reject_unreadable(header);
  SourceFacts facts;
  facts.format = "MetaImage";
  facts.identity = header.identity();
  VolumeDescription& description = facts.description;
  take_stored_type(facts, stored_type_of(header));
  description.size = read_size(header);
  const std::size_t dimensions = header.field({"DimSize"}).integers().size();
  facts.spacing_known = read_geometry(header, dimensions, options, description.geometry);
  facts.place_known = place_known_of(header, description.geometry);
  if (header.has("ElementToIntensityFunctionSlope")) {
    description.rescale.slope = header.field({"ElementToIntensityFunctionSlope"}).numbers(1)[0];
  }
  if (header.has("ElementToIntensityFunctionOffset")) {
    description.rescale.intercept =
        header.field({"ElementToIntensityFunctionOffset"}).numbers(1)[0];
  }
  checked_voxel_count(description.size);
  const std::uint64_t volume_bytes =
      stored_plane_bytes(facts) * static_cast<std::uint64_t>(description.size.z);
  facts.components = components_of(header);
  facts.choice = choose_component(facts.components, options, path);
  const auto channels = static_cast<std::uint64_t>(facts.components.channels);
  const auto times = static_cast<std::uint64_t>(facts.components.times);
  VoxelRun run = locate_voxels(
      header, checked_mul(checked_mul(volume_bytes, channels, "volume"), times, "volumes"));
  run.values_per_voxel = facts.components.channels;
  run.value_index = facts.choice.channel;
  run.take_volume(facts.choice.time, facts.components.times, volume_bytes);
  if (run.path != path) facts.file_count = 1 + static_cast<std::int64_t>(run.files().size());
  settle(facts, options, path);
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
