#include "octavo/core/work_part.h"

#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

[[noreturn]] void reject_parts(const std::string& why) {
  throw Error(ErrorKind::invalid_argument, "the parts make no whole: " + why);
}

}  // namespace

void require_part(const WorkPart& part) {
  if (part.number >= 0 && part.number < part.count && part.count <= WorkPart::kMostParts) return;
  const std::string what =
      "part " + std::to_string(part.number) + " of " + std::to_string(part.count) + ": ";
  if (part.count < 1) {
    throw Error(ErrorKind::invalid_argument, what + "a work has 1 part or more");
  }
  if (part.count > WorkPart::kMostParts) {
    throw Error(ErrorKind::invalid_argument,
                what + "a work has " + std::to_string(WorkPart::kMostParts) + " parts at most");
  }
  throw Error(ErrorKind::invalid_argument,
              what + "the number of a part runs from 0 to " + std::to_string(part.count - 1));
}

std::vector<std::size_t> order_of_all_parts(std::span<const WorkPart> parts) {
  if (parts.empty()) reject_parts("there are none");
  require_part(parts.front());
  const std::int64_t count = parts.front().count;
  std::vector<std::size_t> places(static_cast<std::size_t>(count), parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    require_part(parts[i]);
    if (parts[i].count != count) {
      reject_parts("some are of " + std::to_string(count) + ", some of " +
                   std::to_string(parts[i].count));
    }
    std::size_t& place = places[static_cast<std::size_t>(parts[i].number)];
    if (place < parts.size()) {
      reject_parts("number " + std::to_string(parts[i].number) + " is there twice");
    }
    place = i;
  }
  std::string missing;
  for (std::size_t number = 0; number < places.size(); ++number) {
    if (places[number] < parts.size()) continue;
    missing += (missing.empty() ? "" : ", ") + std::to_string(number);
  }
  if (!missing.empty()) {
    reject_parts("of " + std::to_string(count) + " these are missing: " + missing);
  }
  return places;
}

}  // namespace octavo
