// A small mesh with all that a description has, and the bytes of files of meshes.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "octavo/mesh/formats/mesh_file.h"
#include "support/memory_storage.h"

namespace octavo::testing {

inline const TriangleMesh kWritten = {{{0.5f, -2, 3}, {1, 0, 0.1f}, {0, 1e-7f, 0}, {0, 0, 1}},
                                      {{0, 2, 1}, {0, 1, 3}}};

/// Both triangles of kWritten, an object each, with normals; a name of characters that formats
/// escape.
struct Parts {
  std::vector<MeshPoint> normals = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  std::vector<MeshPart> parts = {{"left lung\n\"<&\xc3\xa4>\"", 7, LabelColor{1, 2, 255}, 0, 1},
                                 {"", 300, {}, 1, 2}};
  std::vector<LabelPair> pairs = {{7, 300}, {300, 0}};
};

inline std::string written(MeshFormat format, const MeshDescription& described) {
  MemoryStorage storage;
  PendingFile file(storage, "mesh");
  write_mesh(described, format, NoProgress(), file);
  file.seal();
  file.publish(false);
  const auto& bytes = *storage.files.at("mesh");
  return {bytes.begin(), bytes.end()};
}

template <class T>
T number_in(const std::string& bytes, std::size_t at) {
  T number{};
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

}  // namespace octavo::testing
