#include "octavo/mesh/hexahedra/hex_file.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <numeric>

#include "octavo/mesh/formats/mesh_bytes.h"

namespace octavo {

std::optional<HexFormat> hex_format_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension();
  for (char& letter : ending) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  if (ending == ".vtu") return HexFormat::vtu;
  if (ending == ".inp") return HexFormat::abaqus;
  if (ending == ".msh") return HexFormat::gmsh;
  if (ending == ".mesh") return HexFormat::mfem;
  return std::nullopt;
}

const char* hex_format_endings() { return ".vtu, .inp, .msh or .mesh"; }

void write_hex_mesh(const HexMesh& mesh, HexFormat format, const HexFileText& text,
                    const Progress& watcher, PendingFile& file) {
  switch (format) {
    case HexFormat::vtu: write_hex_vtu(mesh, text, watcher, file); break;
    case HexFormat::abaqus: write_hex_abaqus(mesh, text, watcher, file); break;
    case HexFormat::gmsh: write_hex_gmsh(mesh, text, watcher, file); break;
    case HexFormat::mfem: write_hex_mfem(mesh, text, watcher, file); break;
  }
}

std::vector<std::int64_t> group_attributes(const HexMesh& mesh) {
  const auto fits = [](std::int64_t label) {
    return label > 0 && label <= std::numeric_limits<std::int32_t>::max();
  };
  std::vector<std::int64_t> attributes;
  for (const HexGroup& group : mesh.groups()) attributes.push_back(mesh.labels()[group.label]);
  if (mesh.has_materials() || !std::all_of(attributes.begin(), attributes.end(), fits)) {
    std::iota(attributes.begin(), attributes.end(), std::int64_t{1});
  }
  return attributes;
}

std::string label_set_name(std::int64_t label, const LabelNames& names) {
  constexpr std::size_t kMostLetters = 40;
  std::string word;
  for (const char letter : names.name_of(label)) {
    const auto byte = static_cast<unsigned char>(letter);
    const bool is_kept = byte < 0x80 && std::isalnum(byte) != 0;
    if (is_kept) word += letter;
    else if (!word.empty() && word.back() != '_') word += '_';
    if (word.size() == kMostLetters) break;
  }
  if (word.ends_with('_')) word.pop_back();
  // Names of sets have no minus.
  const std::string number = label < 0 ? "NEG" + std::to_string(label).substr(1)
                                       : std::to_string(label);
  return "LABEL_" + number + (word.empty() ? "" : "_" + word);
}

std::string group_name(const HexMesh& mesh, std::size_t group, const LabelNames& names) {
  std::string name = label_set_name(mesh.labels()[mesh.groups()[group].label], names);
  if (mesh.has_materials()) name += "_MATERIAL_" + std::to_string(group + 1);
  return name;
}

std::string label_line(std::int64_t label, const LabelNames& names) {
  std::string line = "label " + std::to_string(label);
  const std::string& name = names.name_of(label);
  if (!name.empty()) line += ", " + line_text(name);
  const auto entry = names.all().find(label);
  if (entry == names.all().end() || !entry->second.color) return line;
  line += ", color";
  for (const std::uint8_t value : *entry->second.color) line += " " + std::to_string(value);
  return line;
}

}  // namespace octavo
