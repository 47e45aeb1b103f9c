#include "octavo/tasks/parts/standing_part.h"

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

std::int64_t number_of(const BuildPlan& plan, const PartFile& part) {
  const PartPlace& place = part.place();
  if (place.plan != plan.id) {
    throw Error(ErrorKind::invalid_argument, "is a part of another plan", part.path());
  }
  // Parts differ by one group at most: the number is found where the groups are evenly dealt out.
  std::int64_t low = 0;
  for (std::int64_t high = plan.part_count; high - low > 1;) {
    const std::int64_t middle = low + (high - low) / 2;
    (first_group_of(plan, middle) <= place.first_group ? low : high) = middle;
  }
  if (first_group_of(plan, low) == place.first_group &&
      first_group_of(plan, low + 1) == place.end_group) {
    return low;
  }
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
  file->prove();
  return file;
}

}  // namespace octavo
