#include "octavo/mesh/formats/mesh_bytes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/mesh/cancellation.h"

namespace octavo {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are");

MeshBytes::MeshBytes(PendingFile& file, const Progress& watcher)
    : MeshBytes([&file](ByteSpan bytes) { file.append(bytes); }, watcher) {}

MeshBytes::MeshBytes(std::function<void(ByteSpan)> take, const Progress& watcher)
    : take_(std::move(take)), watcher_(watcher) {}

void MeshBytes::flush() {
  stop_if_cancelled(watcher_);
  if (used_ > 0) take_({buffer_.data(), used_});
  used_ = 0;
}

std::uint8_t* MeshBytes::room(std::size_t size) {
  if (used_ + size > kBytes) flush();
  used_ += size;
  return buffer_.data() + used_ - size;
}

void MeshBytes::raw(const void* data, std::size_t size) {
  if (size <= kBytes) {
    std::memcpy(room(size), data, size);
    return;
  }
  flush();
  take_({static_cast<const std::uint8_t*>(data), size});
}

std::string space_words(MeshSpace space) {
  return std::string("SPACE=") + (space == MeshSpace::lps ? "LPS" : "RAS") + " UNIT=mm";
}

std::string line_text(std::string_view text) {
  std::string line(text);
  for (char& letter : line) {
    const auto code = static_cast<unsigned char>(letter);
    if (code < 0x20 || code == 0x7f) letter = ' ';
  }
  return line;
}

std::string short_lines(std::string_view start, std::string_view text) {
  constexpr std::size_t kMost = 250;
  const std::string line = line_text(text);
  const auto is_inside_letter = [&](std::size_t at) {
    return (static_cast<unsigned char>(line[at]) & 0xc0) == 0x80;
  };
  std::string lines;
  std::size_t begin = 0;
  do {
    std::size_t end = std::min(line.size(), begin + kMost - start.size());
    while (end < line.size() && end > begin + 1 && is_inside_letter(end)) --end;
    lines += std::string(start) + line.substr(begin, end - begin) + "\n";
    begin = end;
  } while (begin < line.size());
  return lines;
}

std::string coordinate_text(float value) {
  // Below, the shortest digits lie within half a step of floats, 2^-21 at most.
  constexpr float kFirstFixed = 16;
  constexpr int kDecimals = 6;
  char digits[64];
  char* const end = digits + sizeof digits;
  if (!(std::abs(value) >= kFirstFixed) || std::isinf(value)) {
    return {digits, std::to_chars(digits, end, value).ptr};
  }
  std::string_view text(digits,
                        std::to_chars(digits, end, value, std::chars_format::fixed, kDecimals).ptr);
  text = text.substr(0, text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.remove_suffix(1);
  return std::string(text);
}

std::vector<MeshPart> objects_of(const MeshDescription& mesh) {
  const std::size_t count = mesh.mesh.triangles.size();
  std::vector<MeshPart> objects(mesh.parts.begin(), mesh.parts.end());
  if (objects.empty()) objects.push_back({.begin = 0, .end = count});
  std::erase_if(objects, [](const MeshPart& part) { return part.begin == part.end; });
  return objects;
}

std::string part_name(const MeshPart& part) {
  if (!part.name.empty()) return part.name;
  return part.label ? "label " + std::to_string(*part.label) : "surface";
}

bool has_part_labels(const MeshDescription& mesh) {
  return !mesh.parts.empty() && std::all_of(mesh.parts.begin(), mesh.parts.end(),
                                            [](const MeshPart& part) { return part.label; });
}

void require_countable(std::uint64_t count, std::uint64_t most, const char* what,
                       const PendingFile& file) {
  if (count <= most) return;
  throw Error(ErrorKind::limit_exceeded,
              std::to_string(count) + " " + what + "; the format numbers " + std::to_string(most),
              file.path());
}

}  // namespace octavo
