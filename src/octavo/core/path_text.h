// Paths as people write them.
#pragma once

#include <string>

namespace octavo {

/// `path` without slashes at its end; "/" stays what it is.
inline std::string without_end_slashes(std::string path) {
  while (path.size() > 1 && path.ends_with('/')) path.pop_back();
  return path;
}

}  // namespace octavo
