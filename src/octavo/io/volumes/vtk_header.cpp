#include "octavo/io/volumes/vtk_header.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string_view>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxVtkLineBytes = 4096;
constexpr std::size_t kMaxTitleBytes = 256;
constexpr int kMaxHeaderLines = 64;
constexpr int kMaxLinesBehind = 1 << 16;
/// Of a color: bytes where voxels are binary, numbers where they are text.
constexpr std::uint64_t kColorParts = 4;

/// The lines of a file from some place on.
class Lines {
 public:
  Lines(const SourceFile& file, std::uint64_t offset) : file_(file), offset_(offset) {}

  /// Goes to the next line; false at the end of the file.
  bool next() {
    std::array<std::byte, kMaxVtkLineBytes> bytes{};
    const std::size_t found = file_.read_some(offset_, bytes);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), found);
    const std::size_t end = text.find('\n');
    text_ = trimmed(text.substr(0, end));
    offset_ += end == std::string_view::npos ? found : end + 1;
    return found > 0;
  }
  bool next_filled() {
    for (int i = 0; i < kMaxHeaderLines && next(); ++i) {
      if (!text_.empty()) return true;
    }
    return false;
  }
  /// False when the file ends earlier.
  bool skip(std::uint64_t bytes) {
    if (bytes > file_.size() - offset_) return false;
    offset_ += bytes;
    return true;
  }

  const std::string& text() const { return text_; }
  /// The first word in lower case; VTK's keywords have any case.
  std::string keyword() const { return lower_case(text_.substr(0, text_.find_first_of(" \t"))); }
  std::string behind_keyword() const {
    const std::size_t blank = text_.find_first_of(" \t");
    return blank == std::string::npos ? "" : std::string(trimmed(text_.substr(blank)));
  }
  /// Of the byte behind the line.
  std::uint64_t offset() const { return offset_; }

 private:
  const SourceFile& file_;
  std::uint64_t offset_;
  std::string text_;
};

/// The four lines that every legacy file starts with: the title and the coding of the voxels.
void read_start(Lines& lines, const std::string& path, VtkHeader& header) {
  lines.next();
  if (!lines.text().starts_with("# vtk DataFile Version")) {
    reject(path, "not a legacy VTK file: its first line must start with \"# vtk DataFile "
                 "Version\"; check what it is, or copy it again from its origin");
  }
  lines.next();
  header.title = lines.text().substr(0, kMaxTitleBytes);
  lines.next_filled();
  header.is_text = lines.keyword() == "ascii";
  if (!header.is_text && lines.keyword() != "binary") {
    reject(path, "its third line is \"" + escaped(lines.text()) +
                     "\", BINARY or ASCII expected; it is damaged, or written by a faulty "
                     "program");
  }
  lines.next_filled();
  if (lines.keyword() != "dataset" || lower_case(lines.behind_keyword()) != "structured_points") {
    reject(path, "it says \"" + escaped(lines.text()) +
                     "\", DATASET STRUCTURED_POINTS expected: only even grids are read; resample "
                     "it to one");
  }
}

/// True for words that start an array or the section of one.
bool starts_array(const std::string& keyword) {
  static const std::set<std::string> kWords = {
      "scalars", "color_scalars", "vectors", "normals", "tensors", "tensors6", "field",
      "texture_coordinates", "global_ids", "pedigree_ids", "edge_flags", "cell_data", "point_data"};
  return kWords.contains(keyword);
}

[[noreturn]] void reject_before_scalars(const Lines& lines, const std::string& path) {
  if (lines.keyword() == "cell_data") {
    reject(path, "its first values are those of cells (CELL_DATA), which are not read; save one "
                 "array of the points (POINT_DATA) as its own file");
  }
  if (starts_array(lines.keyword())) {
    reject(path, "its first array is \"" + escaped(lines.text()) +
                     "\": one value per voxel is read (SCALARS); save one array of that kind as "
                     "its own file");
  }
  reject(path, "its header says \"" + escaped(lines.text()) +
                   "\" where DIMENSIONS, SPACING, ORIGIN, POINT_DATA or SCALARS is expected");
}

using VtkFields = std::map<std::string, std::string>;

/// The lines from DATASET to SCALARS, by keyword; the reader stands at the SCALARS line then.
VtkFields read_fields(Lines& lines, const std::string& path) {
  static const std::set<std::string> kKnown = {"dimensions", "spacing", "origin", "point_data"};
  VtkFields fields;
  while (lines.next_filled()) {
    std::string keyword = lines.keyword();
    if (keyword == "scalars" || keyword == "color_scalars") return fields;
    if (keyword == "aspect_ratio") keyword = "spacing";
    if (!kKnown.contains(keyword)) reject_before_scalars(lines, path);
    if (!fields.emplace(keyword, lines.behind_keyword()).second) {
      reject(path, "its header gives \"" + keyword + "\" twice; it is damaged, or written by a "
                   "faulty program");
    }
  }
  reject(path, "its header has no SCALARS line: volumes of one scalar per point are read");
}

StoredType stored_type_of(const std::string& name, const std::string& path) {
  static const std::map<std::string, StoredType> kTypes = {
      {"char", VoxelType::int8},           {"signed_char", VoxelType::int8},
      {"unsigned_char", VoxelType::uint8}, {"short", VoxelType::int16},
      {"unsigned_short", VoxelType::uint16}, {"int", VoxelType::int32},
      {"unsigned_int", VoxelType::uint32}, {"float", VoxelType::float32},
      {"long", WideType::int64},           {"unsigned_long", WideType::uint64},
      {"long_long", WideType::int64},      {"unsigned_long_long", WideType::uint64},
      {"vtktypeint64", WideType::int64},   {"vtktypeuint64", WideType::uint64},
      {"double", WideType::float64}};
  const auto found = kTypes.find(lower_case(name));
  if (found != kTypes.end()) return found->second;
  reject(path, "voxels of type " + escaped(name) +
                   " are not read; integers of 8 to 64 bits, float and double are");
}

/// COLOR_SCALARS name [values per point]: bytes, or in text shares of 255. VTK writes every volume
/// of bytes so.
StoredType read_color_line(const Lines& lines, bool is_text, const std::string& path) {
  const std::vector<std::string> found = words(lines.text());
  if (found.size() != 3) {
    reject(path, "its COLOR_SCALARS line has " + std::to_string(found.size()) +
                     " words, 3 expected: COLOR_SCALARS, a name, values per point");
  }
  if (found[2] != "1") {
    reject(path, escaped(found[2]) +
                     " values per voxel (color): one is read; take out one first");
  }
  if (is_text) {
    reject(path, "its voxels are bytes in the form of colors (COLOR_SCALARS), which in text are "
                 "rounded numbers from 0 to 1; save it as binary");
  }
  return VoxelType::uint8;
}

/// SCALARS name type [values per point].
StoredType read_scalars_line(const Lines& lines, const std::string& path) {
  const std::vector<std::string> found = words(lines.text());
  if (found.size() < 3 || found.size() > 4) {
    reject(path, "its SCALARS line has " + std::to_string(found.size()) +
                     " words, 3 or 4 expected: SCALARS, a name, a type, values per point");
  }
  if (found.size() == 4 && found[3] != "1") {
    reject(path, escaped(found[3]) +
                     " values per voxel (color or vectors): one is read; take out one first");
  }
  return stored_type_of(found[2], path);
}

/// Moves behind the line of the color table, which some programs leave out.
std::uint64_t voxel_offset(Lines lines) {
  const std::uint64_t behind_scalars = lines.offset();
  return lines.next_filled() && lines.keyword() == "lookup_table" ? lines.offset()
                                                                  : behind_scalars;
}

Point3 three_numbers(const VtkFields& fields, const std::string& keyword, const std::string& path) {
  const std::vector<double> found = FieldText{path, keyword, fields.at(keyword)}.numbers(3);
  return {found[0], found[1], found[2]};
}

/// DIMENSIONS, proven against POINT_DATA.
Size3 read_size(const VtkFields& fields, const std::string& path) {
  for (const char* keyword : {"dimensions", "point_data"}) {
    if (fields.contains(keyword)) continue;
    reject(path, std::string("its header has no line \"") + keyword +
                     "\" before SCALARS; it is damaged, or written by a faulty program");
  }
  const std::string& text = fields.at("dimensions");
  const std::vector<std::int64_t> found = FieldText{path, "dimensions", text}.integers();
  if (found.size() != 3 || *std::min_element(found.begin(), found.end()) < 1) {
    reject(path, "its DIMENSIONS are \"" + escaped(text) + "\", three numbers from 1 on expected");
  }
  const std::int64_t points =
      checked_count(checked_count(found[0], found[1], "volume"), found[2], "volume");
  const std::int64_t stated = FieldText{path, "point_data", fields.at("point_data")}.integer();
  if (stated != points) {
    reject(path, "POINT_DATA says " + std::to_string(stated) + " points, DIMENSIONS say " +
                     std::to_string(points) + "; it is damaged, or written by a faulty program");
  }
  return {found[0], found[1], found[2]};
}

/// How a color table stands in the file.
using SkipColors = std::function<void(Lines& lines, std::uint64_t count)>;

/// Goes over what may follow the voxels: blanks, notes up to a blank line, a color table. True
/// where there is a color table.
bool read_behind(Lines lines, const std::string& path, const SkipColors& skip_colors) {
  bool has_color_table = false;
  bool is_in_notes = false;
  for (int i = 0; i < kMaxLinesBehind; ++i) {
    const std::uint64_t start = lines.offset();
    if (!lines.next()) return has_color_table;
    is_in_notes = (is_in_notes && !lines.text().empty()) || lines.keyword() == "metadata";
    if (is_in_notes || lines.text().empty()) continue;
    if (starts_array(lines.keyword())) {
      reject(path, "it holds several arrays: behind the voxels of the first one stands \"" +
                       escaped(lines.text()) + "\"; save the one you want as its own file");
    }
    const std::vector<std::string> found = words(lines.text());
    if (lines.keyword() != "lookup_table" || found.size() != 3) {
      reject(path, "behind its voxels, at byte " + std::to_string(start) +
                       ", stands what is no part of them; it is damaged, or its header does not "
                       "fit: copy it again from its origin");
    }
    const std::int64_t colors = FieldText{path, "LOOKUP_TABLE", found[2]}.integer();
    skip_colors(lines, static_cast<std::uint64_t>(std::max<std::int64_t>(colors, 0)));
    has_color_table = true;
  }
  reject(path, "more than " + std::to_string(kMaxLinesBehind) +
                   " lines of notes stand behind its voxels; save it again without them");
}

[[noreturn]] void reject_short(const std::string& path, const std::string& needed,
                               std::uint64_t found) {
  reject(path, "the file is too short: " + needed + ", " + std::to_string(found) +
                   " found; it is cut");
}

/// Proves that the values are all there, and what follows them.
void prove_binary(const SourceFile& file, std::uint64_t points, VtkHeader& header) {
  const auto value_bytes = static_cast<std::uint64_t>(bytes_per_value(header.type));
  const std::uint64_t end = checked_add(
      header.voxel_offset, checked_mul(points, value_bytes, "volume"), "file length");
  if (file.size() < end) {
    reject_short(file.path(), std::to_string(end) + " bytes needed", file.size());
  }
  header.bytes_behind = file.size() - end;
  const auto skip_colors = [&](Lines& lines, std::uint64_t count) {
    if (lines.skip(checked_mul(count, kColorParts, "color table"))) return;
    reject(file.path(), "the file ends early: its color table is to have " +
                            std::to_string(count) + " colors; copy it again from its origin");
  };
  header.has_color_table = read_behind(Lines(file, end), file.path(), skip_colors);
}

/// Each number takes a digit and a blank at least; only reading them tells more.
void check_text_length(const SourceFile& file, std::uint64_t points, const VtkHeader& header) {
  const std::uint64_t end =
      checked_add(header.voxel_offset, checked_mul(points, 2, "volume"), "file length");
  if (file.size() >= end) return;
  reject_short(file.path(), "at least " + std::to_string(end) + " bytes needed", file.size());
}

}  // namespace

VtkHeader read_vtk_header(const std::string& path) {
  const SourceFile file(path);
  Lines lines(file, 0);
  VtkHeader header;
  read_start(lines, path, header);
  const VtkFields fields = read_fields(lines, path);
  header.size = read_size(fields, path);
  const bool is_color = lines.keyword() == "color_scalars";
  header.type = is_color ? read_color_line(lines, header.is_text, path)
                         : read_scalars_line(lines, path);
  if (fields.contains("spacing")) header.spacing_mm = three_numbers(fields, "spacing", path);
  if (fields.contains("origin")) header.origin_mm = three_numbers(fields, "origin", path);
  header.voxel_offset = is_color ? lines.offset() : voxel_offset(lines);
  const auto points = static_cast<std::uint64_t>(header.size.x * header.size.y * header.size.z);
  if (header.is_text) {
    check_text_length(file, points, header);
  } else {
    prove_binary(file, points, header);
  }
  return header;
}

bool read_behind_vtk_text(TextVoxels& voxels) {
  const SourceFile file(voxels.path());
  const auto skip_colors = [&](Lines& lines, std::uint64_t count) {
    TextVoxels colors(file.path(), lines.offset());
    std::array<std::byte, kColorParts * sizeof(float)> color{};
    for (std::uint64_t i = 0; i < count; ++i) colors.read(VoxelType::float32, color);
    lines.skip(colors.offset() - lines.offset());
  };
  return read_behind(Lines(file, voxels.offset()), file.path(), skip_colors);
}

}  // namespace octavo
