#include "octavo/dist/part_place.h"

namespace octavo {

namespace {

std::string run_text(const char* one, std::int64_t first, std::int64_t end) {
  const std::string name = one;
  return end - first == 1 ? name + " " + std::to_string(first)
                          : name + "s " + std::to_string(first) + " to " + std::to_string(end - 1);
}

}  // namespace

std::string place_text(const PartPlace& place) {
  const std::string groups = run_text("group", place.first_group, place.end_group);
  if (!place.is_band()) return groups;
  return run_text("brick", place.first_brick, place.end_brick) + " of " + groups;
}

}  // namespace octavo
