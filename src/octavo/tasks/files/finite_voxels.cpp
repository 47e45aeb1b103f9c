#include "octavo/tasks/files/finite_voxels.h"

#include <cmath>

#include "octavo/core/error.h"

namespace octavo {

bool has_finite_voxels(const FileReader& reader) {
  const auto& coding = reader.description().coding;
  if (!coding || !coding->is_exact) return true;
  float sample = 0;
  try {
    reader.read({{0, 0, 0}, {1, 1, 1}}, reader.levels().count() - 1, &sample);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::corrupt) throw;
  }
  return !std::isnan(sample);
}

}  // namespace octavo
