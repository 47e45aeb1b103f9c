// The folders in which a stack stands as one file a plane.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// "plane_0007.tif", with as many digits as the last plane needs, at least four.
std::string plane_name(std::int64_t z, std::int64_t plane_count);

/// True for what plane_name can return.
bool is_plane_name(std::string_view name);

/// What a folder holds.
struct PlaneList {
  std::vector<std::string> planes;  ///< names of files that are called as planes are
  std::string other;                ///< the name of one thing that is no such file; empty without
};

/// Lists a folder; a link to one is none.
/// Returns  false where it cannot be listed; errno says why
bool list_planes(const std::string& folder, PlaneList& list);

/// Removes a folder that holds planes and nothing else, and them with it. One that holds anything
/// else, or cannot be listed, stays as it is; so does a link, and what it leads to.
/// Returns  whether it is gone; errno says why not, ENOTEMPTY where something else is in it
bool remove_plane_folder(const std::string& folder);

}  // namespace octavo
