#include "octavo/io/volumes/nrrd_source.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/text.h"
#include "octavo/io/source/data_files.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/streamed_source.h"
#include "octavo/io/volumes/nrrd_geometry.h"
#include "octavo/io/volumes/nrrd_header.h"

namespace octavo {

namespace {

constexpr std::int64_t kMaxValuesPerVoxel = std::int64_t{1} << 16;

StoredType stored_type_of(const NrrdHeader& header) {
  static const std::map<std::string, StoredType> kTypes = {
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
      {"float", VoxelType::float32},
      {"longlong", WideType::int64},        {"long long", WideType::int64},
      {"long long int", WideType::int64},   {"signed long long", WideType::int64},
      {"signed long long int", WideType::int64}, {"int64", WideType::int64},
      {"int64_t", WideType::int64},         {"ulonglong", WideType::uint64},
      {"unsigned long long", WideType::uint64},
      {"unsigned long long int", WideType::uint64}, {"uint64", WideType::uint64},
      {"uint64_t", WideType::uint64},       {"double", WideType::float64}};
  const std::string name = header.text("type");
  const auto found = kTypes.find(lower_case(name));
  if (found == kTypes.end()) {
    reject(header.path(), "voxel type \"" + escaped(name) +
                              "\" is not supported; integers of 8 to 64 bits, float and double "
                              "are");
  }
  return found->second;
}

/// What each axis of the file is: directions in space stand together, with channels or time before
/// them (these alternate) or behind them (these follow one another).
struct NrrdAxes {
  std::vector<std::int64_t> sizes;     ///< of all axes, the fastest first
  std::vector<std::size_t> space;      ///< axes that are directions in space
  std::optional<std::size_t> channel;
  std::optional<std::size_t> time;
  SourceComponents components;

  bool is_before_space(std::size_t axis) const { return axis < space.front(); }
};

std::string axis_text(std::size_t axis) { return "axis " + std::to_string(axis + 1); }

/// The words of "space directions", one for each axis: "none" or a vector without its blanks.
std::vector<std::string> direction_words(const NrrdHeader& header) {
  std::string text;
  int depth = 0;
  for (const char c : header.text("space directions")) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    const bool is_blank = c == ' ' || c == '\t';
    if (is_blank && depth > 0) continue;
    text += c;
    if (c == ')') text += ' ';
  }
  return words(text);
}

bool is_space_kind(const std::string& kind) { return kind == "domain" || kind == "space"; }
bool is_unknown_kind(const std::string& kind) { return kind == "???" || kind == "none"; }

/// The kind of each axis in lower case; "" where the header is silent.
std::vector<std::string> axis_kinds(const NrrdHeader& header, std::size_t count) {
  std::vector<std::string> kinds = words(lower_case(header.text("kinds")));
  if (!kinds.empty() && kinds.size() != count) {
    reject(header.path(), "kinds has " +
                              counted_text(static_cast<std::int64_t>(kinds.size()), "word") +
                              " for " +
                              std::to_string(count) + " axes");
  }
  kinds.resize(count);
  for (std::string& kind : kinds) {
    if (is_unknown_kind(kind)) kind.clear();
    if (!kind.starts_with("complex")) continue;
    reject(header.path(), "complex numbers (an axis of kind \"complex\") are not read; take out "
                          "their magnitude or phase first");
  }
  return kinds;
}

/// Which axes are directions in space: those with a vector, else those of such a kind, else all.
std::vector<bool> find_space(const NrrdHeader& header, const std::vector<std::string>& kinds) {
  const std::size_t count = kinds.size();
  std::vector<bool> is_space(count, true);
  if (header.has("space directions")) {
    const std::vector<std::string> directions = direction_words(header);
    if (directions.size() != count) {
      reject(header.path(), "space directions: a vector or \"none\" for each of " +
                                std::to_string(count) + " axes expected, " +
                                std::to_string(directions.size()) + " found");
    }
    for (std::size_t i = 0; i < count; ++i) is_space[i] = lower_case(directions[i]) != "none";
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (kinds[i].empty() || is_space_kind(kinds[i]) == is_space[i]) continue;
    if (header.has("space directions")) {
      reject(header.path(), axis_text(i) + " is of kind \"" + escaped(kinds[i]) + "\" and has " +
                                (is_space[i] ? "a" : "no") + " direction in space: the header "
                                "contradicts itself");
    }
    is_space[i] = false;
  }
  return is_space;
}

std::vector<std::string> names_of_kind(const std::string& kind, std::int64_t channels) {
  return kind.find("rgb") == std::string::npos ? std::vector<std::string>{}
                                               : color_names(channels);
}

void take_other_axis(const NrrdHeader& header, const std::string& kind, std::size_t axis,
                     NrrdAxes& axes) {
  const bool is_time = kind == "time";
  std::optional<std::size_t>& place = is_time ? axes.time : axes.channel;
  if (place) {
    reject(header.path(), axis_text(*place) + " and " + axis_text(axis) + " both are " +
                              (is_time ? "times" : "channels") + "; take out one part first");
  }
  place = axis;
  (is_time ? axes.components.times : axes.components.channels) = axes.sizes[axis];
  if (!is_time) axes.components.channel_names = names_of_kind(kind, axes.sizes[axis]);
}

NrrdAxes read_axes(const NrrdHeader& header) {
  NrrdAxes axes;
  axes.sizes = header.field("sizes").integers();
  const std::int64_t dimension = header.field("dimension").integer();
  if (static_cast<std::int64_t>(axes.sizes.size()) != dimension) {
    reject(header.path(), "dimension is " + std::to_string(dimension) + ", sizes has " +
                              std::to_string(axes.sizes.size()) + " numbers");
  }
  if (std::ranges::any_of(axes.sizes, [](std::int64_t size) { return size < 1; })) {
    reject(header.path(), "sizes is " + escaped(header.text("sizes")) +
                              ", numbers from 1 on expected; repair the header");
  }
  const std::vector<std::string> kinds = axis_kinds(header, axes.sizes.size());
  const std::vector<bool> is_space = find_space(header, kinds);
  for (std::size_t i = 0; i < is_space.size(); ++i) {
    if (is_space[i]) {
      axes.space.push_back(i);
    } else {
      take_other_axis(header, kinds[i], i, axes);
    }
  }
  const std::size_t count = axes.space.size();
  if (count != 2 && count != 3) {
    reject(header.path(), std::to_string(count) + " directions in space: 2 or 3 are read" +
                              (count > 3 ? "; \"kinds\" or \"space directions\" must say which "
                                           "axis is time or channels"
                                         : ""));
  }
  if (axes.space.back() - axes.space.front() + 1 != count) {
    reject(header.path(), "channels or times stand between the directions in space; put them "
                          "first or last");
  }
  return axes;
}

Size3 size_of(const NrrdAxes& axes) {
  const auto at = [&](std::size_t i) { return axes.sizes[axes.space[i]]; };
  return {at(0), at(1), axes.space.size() == 3 ? at(2) : 1};
}

/// Points `run` at the voxels of one channel and time. The first of two axes on one side of space
/// is the faster one.
void take_component(const NrrdAxes& axes, const ComponentChoice& choice,
                    std::uint64_t volume_bytes, VoxelRun& run) {
  std::int64_t index_behind = 0;
  std::int64_t count_behind = 1;
  for (std::size_t axis = 0; axis < axes.sizes.size(); ++axis) {
    const bool is_time = axes.time == axis;
    if (!is_time && axes.channel != axis) continue;
    const std::int64_t index = is_time ? choice.time : choice.channel;
    const bool before = axes.is_before_space(axis);
    std::int64_t& place = before ? run.value_index : index_behind;
    std::int64_t& count = before ? run.values_per_voxel : count_behind;
    // index < sizes[axis], so that place + index * count stays below the product.
    const std::int64_t product = checked_count(count, axes.sizes[axis], "channels and times");
    place += index * count;
    count = product;
  }
  if (run.values_per_voxel > kMaxValuesPerVoxel) {
    reject(run.path, std::to_string(run.values_per_voxel) + " values at each voxel are too many; "
                     "65536 are read");
  }
  run.take_volume(index_behind, count_behind, volume_bytes);
}

/// True for "big", false for "little" and where nothing is said.
bool is_big_endian(const NrrdHeader& header) {
  if (!header.has("endian")) return false;
  const std::string endian = lower_case(header.text("endian"));
  if (endian != "big" && endian != "little") {
    reject(header.path(), "endian is \"" + escaped(header.text("endian")) +
                              "\", little or big expected; repair the header");
  }
  return endian == "big";
}

/// "data file" where it is a pattern: "a%03d.raw 1 20 1", with the dimension of a file behind it or
/// not; else nothing.
std::optional<PatternLine> file_pattern(const NrrdHeader& header) {
  std::optional<PatternLine> line = pattern_line(header.text("data file"), 4);
  return line && line->numbers.size() >= 3 ? line : std::nullopt;
}

bool has_several_files(const NrrdHeader& header) {
  return header.names_list() || file_pattern(header);
}

/// The files that such a header names; without a dimension each holds one index of the last axis.
std::vector<std::string> data_files(const NrrdHeader& header, const NrrdAxes& axes) {
  const std::int64_t usual = static_cast<std::int64_t>(axes.sizes.size()) - 1;
  if (const std::optional<PatternLine> line = file_pattern(header)) {
    const std::vector<std::int64_t>& n = line->numbers;
    return find_data_files(header.path(),
                           DataFileNames::of_pattern({line->pattern, n[0], n[1], n[2]}),
                           axes.sizes, n.size() > 3 ? n[3] : usual);
  }
  const std::vector<std::string> list = words(header.text("data file"));
  const std::int64_t dimension =
      list.size() > 1 ? FieldText{header.path(), "data file", dimension_digits(list[1])}.integer()
                      : usual;
  return find_data_files(header.path(), DataFileNames::of_list(header.file_list()), axes.sizes,
                         dimension);
}

/// Where the line behind `count` others starts, the first of them at `offset`.
std::uint64_t behind_lines(const std::string& path, std::uint64_t offset, std::int64_t count) {
  if (count == 0) return offset;
  const SourceFile file(path);
  std::vector<std::byte> buffer(std::size_t{1} << 16);
  std::int64_t found = 0;
  while (found < count) {
    const std::size_t read = file.read_some(offset, buffer);
    if (read == 0) {
      reject(path, "line skip: " + std::to_string(count) + " lines expected, " +
                       std::to_string(found) + " found; the file is cut or its header is wrong");
    }
    std::size_t at = 0;
    while (at < read && found < count) {
      if (buffer[at++] == std::byte{'\n'}) ++found;
    }
    offset += at;
  }
  return offset;
}

/// "line skip": in front of the voxels, and of their compression; 0 where "byte skip" counts from
/// the end of the file.
std::int64_t line_skip(const NrrdHeader& header) {
  if (!header.has("line skip")) return 0;
  const std::int64_t count = header.field("line skip").integer();
  if (count < 0) {
    reject(header.path(), "line skip is " + std::to_string(count) +
                              ", a number from 0 on expected; repair the header");
  }
  const bool is_from_end = header.has("byte skip") && header.field("byte skip").integer() == -1;
  return is_from_end ? 0 : count;
}

VoxelRun locate_voxels(const NrrdHeader& header) {
  VoxelRun run;
  run.path = header.path();
  run.start_offset = header.data_offset();
  if (header.has("data file")) {
    run.start_offset = 0;
    if (!has_several_files(header)) {
      run.path = sibling_path(header.path(), header.text("data file"));
    }
  }
  const std::string encoding = lower_case(header.text("encoding"));
  if (encoding == "gzip" || encoding == "gz") {
    run.coding = StreamCoding::deflated;
  } else if (encoding != "raw") {
    reject(header.path(), "encoding \"" + escaped(encoding) + "\" is not read; raw and gzip are");
  }
  run.big_endian = is_big_endian(header);
  return run;
}

/// "byte skip": before the first voxel of each file, behind decompression; nothing where it is -1,
/// which says that a plain file ends with its voxels.
std::optional<std::uint64_t> byte_skip(const NrrdHeader& header, StreamCoding coding) {
  if (!header.has("byte skip")) return 0;
  const std::int64_t skip = header.field("byte skip").integer();
  if (skip >= 0) return static_cast<std::uint64_t>(skip);
  if (skip == -1 && coding == StreamCoding::plain) return std::nullopt;
  reject(header.path(), "\"byte skip\" " + std::to_string(skip) + " does not fit its data file");
}

/// voxel_bytes  of all volumes of the file
void apply_byte_skip(const NrrdHeader& header, std::uint64_t voxel_bytes, VoxelRun& run) {
  if (const std::optional<std::uint64_t> skip = byte_skip(header, run.coding)) {
    run.skip_bytes = checked_add(run.skip_bytes, *skip, "byte skip");
    return;
  }
  run.start_offset = start_of_last(run.path, voxel_bytes);
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
  take_stored_type(facts, stored_type_of(header));
  const NrrdAxes axes = read_axes(header);
  description.size = size_of(axes);
  facts.components = axes.components;
  description.rescale = read_rescale(header);
  read_nrrd_geometry(header, {axes.space, axes.sizes.size()}, options, facts);
  VoxelRun run = locate_voxels(header);
  if (bytes_per_voxel(description.type) > 1 && !header.has("endian")) {
    reject(path, "the header does not say the byte order (endian)");
  }
  std::vector<std::string> files;
  if (has_several_files(header)) files = data_files(header, axes);
  else if (run.path != path) files = {run.path};
  facts.file_count = 1 + static_cast<std::int64_t>(files.size());
  settle(facts, options, path);
  const std::uint64_t volume_bytes =
      stored_plane_bytes(facts) * static_cast<std::uint64_t>(description.size.z);
  take_component(axes, facts.choice, volume_bytes, run);
  const std::uint64_t all_bytes = checked_add(
      checked_add(run.skip_bytes, run.bytes_behind, "volumes"),
      checked_mul(volume_bytes, static_cast<std::uint64_t>(run.values_per_voxel), "volume"),
      "volumes");
  if (has_several_files(header)) {
    std::optional<PieceStart> start;
    if (const auto skip = byte_skip(header, run.coding)) start = PieceStart{0, *skip};
    take_files(path, files, all_bytes, start, run);
    for (StreamPiece& piece : run.pieces) {
      piece.start.offset = behind_lines(piece.path, piece.start.offset, line_skip(header));
    }
  } else {
    run.start_offset = behind_lines(run.path, run.start_offset, line_skip(header));
    apply_byte_skip(header, all_bytes, run);
  }
  return make_streamed_source(std::move(facts), run);
}

}  // namespace octavo
