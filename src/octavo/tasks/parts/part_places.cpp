#include "octavo/tasks/parts/part_places.h"

#include <filesystem>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/parts/part_numbers.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/standing_part.h"

namespace octavo {

namespace {

constexpr std::size_t kNamedParts = 200;  // bytes of a list in a message

bool is_there_at(const std::string& path) {
  return local_storage().path_type(path) != PathType::missing;
}

}  // namespace

PartPlaces places_of(const JoinOptions& options) {
  if (options.parts.empty()) return {folder_of(options.plan), {}};
  for (const std::string& path : options.parts) {
    if (local_storage().path_type(path) != PathType::folder) continue;
    if (options.parts.size() == 1) return {path, {}};
    throw Error(ErrorKind::invalid_argument,
                "is a folder: give one folder that has all parts, or the parts themselves", path);
  }
  return {"", options.parts};
}

std::string path_of_part(const std::string& folder, const std::string& plan_path,
                         std::int64_t part, std::int64_t count) {
  return (std::filesystem::path(folder) / part_name(plan_path, part, count)).string();
}

std::map<std::int64_t, std::string> found_parts(const BuildPlan& plan, const PartPlaces& places,
                                                const std::string& plan_path) {
  std::map<std::int64_t, std::string> found;
  for (const std::string& path : places.files) {
    const std::int64_t number = number_of(plan, *PartFile::open(local_storage(), path));
    const auto [other, is_new] = found.emplace(number, path);
    if (is_new) continue;
    throw Error(ErrorKind::invalid_argument,
                "is part " + std::to_string(number) + ", as is " + escaped(other->second) +
                    "; give each part once",
                path);
  }
  for (std::int64_t part = 0; !places.folder.empty() && part < plan.part_count; ++part) {
    std::string path = path_of_part(places.folder, plan_path, part, plan.part_count);
    if (is_there_at(path)) found.emplace(part, std::move(path));
  }
  return found;
}

void require_all_found(const BuildPlan& plan, const std::map<std::int64_t, std::string>& found,
                       const PartPlaces& places, const std::string& plan_path) {
  std::vector<std::int64_t> missing;
  for (std::int64_t part = 0; part < plan.part_count; ++part) {
    if (!found.contains(part)) missing.push_back(part);
  }
  if (missing.empty()) return;
  std::string list = part_list_text(missing);
  if (list.size() > kNamedParts) list = list.substr(0, list.rfind(',', kNamedParts)) + ", ...";
  throw Error(ErrorKind::io,
              std::to_string(missing.size()) + " of " +
                  counted_text(plan.part_count, "part") + (missing.size() == 1 ? " is" : " are") +
                  " missing: " + list,
              places.folder.empty() ? plan_path : places.folder)
      .with_field("parts.missing", std::to_string(missing.front()))
      .with_field("parts.plan_path", plan_path);
}

}  // namespace octavo
