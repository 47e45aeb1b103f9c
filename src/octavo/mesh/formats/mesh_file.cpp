#include "octavo/mesh/formats/mesh_file.h"

#include <cctype>
#include <filesystem>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/mesh/formats/mesh_formats.h"

namespace octavo {

std::optional<MeshFormat> mesh_format_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension();
  for (char& letter : ending) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  if (ending == ".stl") return MeshFormat::stl;
  if (ending == ".ply") return MeshFormat::ply;
  if (ending == ".obj") return MeshFormat::obj;
  if (ending == ".vtp") return MeshFormat::vtp;
  if (ending == ".glb") return MeshFormat::glb;
  if (ending == ".3mf") return MeshFormat::three_mf;
  return std::nullopt;
}

const char* mesh_format_endings() { return ".stl, .ply, .obj, .glb, .vtp or .3mf"; }

bool has_normals(MeshFormat format) {
  return format != MeshFormat::stl && format != MeshFormat::three_mf;
}

void require_label(MeshFormat format, std::int64_t label, const std::string& path) {
  using Limits = std::numeric_limits<std::int32_t>;
  if (format != MeshFormat::ply) return;
  if (label >= Limits::min() && label <= Limits::max()) return;
  throw Error(ErrorKind::limit_exceeded,
              "label " + std::to_string(label) + "; the format has labels from " +
                  std::to_string(Limits::min()) + " to " + std::to_string(Limits::max()),
              path);
}

void write_mesh(const MeshDescription& mesh, MeshFormat format, const Progress& watcher,
                PendingFile& file) {
  switch (format) {
    case MeshFormat::stl: write_stl(mesh, watcher, file); break;
    case MeshFormat::ply: write_ply(mesh, watcher, file); break;
    case MeshFormat::obj: write_obj(mesh, watcher, file); break;
    case MeshFormat::glb: write_glb(mesh, watcher, file); break;
    case MeshFormat::vtp: write_vtp(mesh, watcher, file); break;
    case MeshFormat::three_mf: write_three_mf(mesh, watcher, file); break;
  }
}

}  // namespace octavo
