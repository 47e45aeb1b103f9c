#include "octavo/tasks/parts/standing_part.h"

#include "octavo/builder/build_setup.h"
#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

std::int64_t number_of(const BuildPlan& plan, const PartFile& part) {
  const PartPlace& place = part.place();
  if (place.plan != plan.id) {
    throw Error(ErrorKind::invalid_argument, "is a part of another plan", part.path());
  }
  if (const auto number = part_at(plan, place)) return *number;
  throw Error(ErrorKind::corrupt, "holds other groups than any part of the plan; make it anew",
              part.path());
}

std::shared_ptr<PartFile> open_part(const BuildPlan& plan, std::int64_t part,
                                    const std::string& path) {
  std::shared_ptr<PartFile> file = PartFile::open(local_storage(), path);
  const std::int64_t number = number_of(plan, *file);
  if (number == part) return file;
  throw Error(ErrorKind::invalid_argument,
              "is part " + std::to_string(number) + ", not part " + std::to_string(part), path);
}

std::shared_ptr<PartFile> open_whole_part(const BuildPlan& plan, std::int64_t part,
                                          const std::string& path) {
  std::shared_ptr<PartFile> file = open_part(plan, part, path);
  const Levels levels = levels_of(plan.source);
  file->require_groups(levels, first_plane_of(plan, file->place().first_group) /
                                   levels.brick_side(0).z);
  file->prove();
  return file;
}

}  // namespace octavo
