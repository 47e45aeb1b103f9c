// Where the shared volumes of tests/README.md are, when this machine has them.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace octavo::testing {

/// The folder of shared volumes: $OCTAVO_SHARED_DATA, or shared/data beside a folder above this
/// source file; nothing when there is none.
inline std::optional<std::filesystem::path> shared_data() {
  namespace fs = std::filesystem;
  if (const char* const given = std::getenv("OCTAVO_SHARED_DATA")) {
    if (fs::is_directory(given)) return fs::path(given);
    return {};
  }
  for (fs::path folder = fs::absolute(__FILE__).parent_path(); folder != folder.root_path();
       folder = folder.parent_path()) {
    if (fs::is_directory(folder / "shared" / "data")) return folder / "shared" / "data";
  }
  return {};
}

/// One shared file; nothing when it is not there.
inline std::optional<std::filesystem::path> shared_file(const std::string& name) {
  const auto folder = shared_data();
  if (!folder || !std::filesystem::exists(*folder / name)) return {};
  return *folder / name;
}

/// What a test says when it is skipped for want of `name`.
inline std::string missing_shared_file(const std::string& name) {
  return name + " is not here; set OCTAVO_SHARED_DATA to the folder of shared volumes";
}

}  // namespace octavo::testing
