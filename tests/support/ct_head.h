// The CT head of Debian's invesalius-examples, the scan that tools/setup installs.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "support/built_file.h"
#include "support/source_folder.h"

namespace octavo::testing {

constexpr const char* kMissingCtHead =
    "invesalius-examples is not installed; tools/setup installs it";

/// A MetaImage header of the CT head in `folder`, its voxels beside it; nothing when it is not
/// installed.
inline std::optional<std::string> ct_head_in(const ScratchFolder& folder) {
  const std::string project = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
  if (!std::filesystem::exists(project)) return {};
  const std::string header = folder.file("head.mhd");
  const std::string convert = std::string("python3 ") + source_folder() +
                              "/tools/inv3_to_mhd.py " + project + " " + header + " > /dev/null";
  if (std::system(convert.c_str()) != 0) {
    throw Error(ErrorKind::internal, "tools/inv3_to_mhd.py failed", project);
  }
  return header;
}

}  // namespace octavo::testing
