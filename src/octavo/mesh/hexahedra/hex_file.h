// Meshes of hexahedra in the formats of solvers: VTU, Abaqus, Gmsh and MFEM.
//
// | format | elements | hanging nodes | labels and materials |
// |---|---|---|---|
// | .vtu | VTK cells, appended binary | the array `masters`: nodes they are the mean of | arrays |
// | .inp | C3D8, C3D4; a pyramid is a C3D8 with four nodes in one | *EQUATION | ELSET, *MATERIAL |
// | .msh | Gmsh 4.1, text | not written | physical volumes |
// | .mesh | MFEM 1.0 | MFEM 1.1, vertex_parents | attributes, comments say of which label |
//
// Names and colors of labels are field data in .vtu, elsewhere comments; names of sets hold what is
// ASCII of them. The six sides of the box around the mesh are NSETs in .inp, of nodes that do not
// hang, and boundary attributes 1 to 6 in .mesh: x_min, x_max, y_min, y_max, z_min, z_max along
// the axes of the grid.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"
#include "octavo/core/progress.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/mesh/hexahedra/hex_mesh.h"

namespace octavo {

enum class HexFormat { vtu, abaqus, gmsh, mfem };

/// By the ending of a name, in letters of either case.
std::optional<HexFormat> hex_format_of(const std::string& path);

/// ".vtu, .inp, .msh or .mesh"
const char* hex_format_endings();

struct HexFileText {
  std::vector<std::string> comments;  ///< lines that say what the mesh was made of
  double poisson_ratio = 0.3;         ///< of all materials
  LabelNames names = {};              ///< and colors of the labels
};

/// Appends a mesh to a file, mm in LPS; moduli in MPa, densities of .inp in tonne/mm3.
/// Requires  of a mesh with hanging nodes a format that has them; for MFEM no face on which a
///           single smaller cell lies (has_lone_quarter)
/// Throws    as PendingFile; Error{cancelled}
/// Memory    a buffer of a megabyte; MFEM 4 bytes per node and more where faces are halved
void write_hex_mesh(const HexMesh& mesh, HexFormat format, const HexFileText& text,
                    const Progress& watcher, PendingFile& file);

/// The writers of single formats.
void write_hex_vtu(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                   PendingFile& file);
void write_hex_abaqus(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                      PendingFile& file);
void write_hex_gmsh(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                    PendingFile& file);
void write_hex_mfem(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                    PendingFile& file);

/// The numbers of groups in formats that have one number per element: those of their materials, or
/// their labels where there are none and all labels are above 0 and fit in 31 bits.
std::vector<std::int64_t> group_attributes(const HexMesh& mesh);

/// "LABEL_3", or "LABEL_3_left_kidney" where it has a name: ASCII letters and digits of that, up
/// to 40 of them, which every solver takes in names of sets.
std::string label_set_name(std::int64_t label, const LabelNames& names);

/// The set name of its label, with materials as "LABEL_3_MATERIAL_7".
std::string group_name(const HexMesh& mesh, std::size_t group, const LabelNames& names);

/// "label 3, left kidney, color 255 128 0" as far as they are known; one line.
std::string label_line(std::int64_t label, const LabelNames& names);

inline constexpr std::array<const char*, 6> kSideNames = {"X_MIN", "X_MAX", "Y_MIN",
                                                          "Y_MAX", "Z_MIN", "Z_MAX"};

}  // namespace octavo
