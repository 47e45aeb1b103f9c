// A file that is written in small pieces, and what the formats of meshes write alike.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/progress.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/mesh/formats/mesh_description.h"

namespace octavo {

/// Appends small pieces to a file, a megabyte at a time; the watcher can end it with each. Both
/// outlive this.
/// Throws  Error{cancelled}; as PendingFile, or as what takes the bytes
class MeshBytes {
 public:
  MeshBytes(PendingFile& file, const Progress& watcher);
  /// The bytes go to `take` instead.
  MeshBytes(std::function<void(ByteSpan)> take, const Progress& watcher);

  /// As it is in memory, which is little-endian.
  template <class T>
  void number(T value) {
    raw(&value, sizeof value);
  }
  void text(std::string_view text) { raw(text.data(), text.size()); }
  /// The shortest digits that read back as the same number.
  template <class T>
  void digits(T value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value);
    raw(digits, static_cast<std::size_t>(end.ptr - digits));
  }
  /// Room for some bytes, unset: at most a megabyte, to be filled before anything else is appended.
  std::uint8_t* room(std::size_t size);
  void flush();

 private:
  static constexpr std::size_t kBytes = 1 << 20;

  void raw(const void* data, std::size_t size);

  std::function<void(ByteSpan)> take_;
  const Progress& watcher_;
  Bytes buffer_ = Bytes(kBytes);
  std::size_t used_ = 0;  // of the buffer
};

/// A point or a normal in the axes that are asked for.
inline MeshPoint in_space(const MeshPoint& point, MeshSpace space) {
  if (space == MeshSpace::lps) return point;
  // Not the negative, which is -0 for 0.
  return {0 - point[0], 0 - point[1], point[2]};
}

/// "SPACE=LPS UNIT=mm", as 3D Slicer writes it.
std::string space_words(MeshSpace space);

/// Text for one line: spaces in place of control characters.
std::string line_text(std::string_view text);

/// Lines of at most 250 bytes that each begin with `start`; joined, what is behind it is line_text.
/// MeshLab rejects headers with lines of 512 bytes.
std::string short_lines(std::string_view start, std::string_view text);

/// Digits that read back as the same float, and as a double within 1e-6 of it.
std::string coordinate_text(float value);

/// Where no color is given.
constexpr LabelColor kPlainColor = {230, 225, 210};

/// The parts that have triangles, with names; the whole mesh where none are described.
std::vector<MeshPart> objects_of(const MeshDescription& mesh);

/// "liver", "label 3" where it has no name, "surface" where it has no label either.
std::string part_name(const MeshPart& part);

/// Whether every triangle lies in a part that has a label.
bool has_part_labels(const MeshDescription& mesh);

/// Throws  Error{limit_exceeded} that names the file where `count` is above `most`
void require_countable(std::uint64_t count, std::uint64_t most, const char* what,
                       const PendingFile& file);

}  // namespace octavo
