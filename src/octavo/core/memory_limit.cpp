#include "octavo/core/memory_limit.h"

#include <string>

#include "octavo/core/error.h"

namespace octavo {

namespace {

// In the units of --max-memory, powers of 1024: whole ones, two digits at least.
std::string units_text(std::uint64_t bytes, bool is_rounded_up) {
  constexpr const char* kUnits[] = {" bytes", " KiB", " MiB", " GiB", " TiB"};
  constexpr std::uint64_t kMinimum = 10;
  std::size_t unit = 0;
  std::uint64_t one = 1;
  while (unit + 1 < std::size(kUnits) && bytes / one / 1024 >= kMinimum) {
    one *= 1024;
    ++unit;
  }
  const std::uint64_t whole = bytes / one + (is_rounded_up && bytes % one != 0 ? 1 : 0);
  return std::to_string(whole) + kUnits[unit];
}

}  // namespace

void require_memory_within(std::uint64_t needed_bytes, std::uint64_t limit_bytes,
                           std::string_view what, std::string_view advice) {
  if (limit_bytes == 0 || needed_bytes <= limit_bytes) return;
  throw Error(ErrorKind::limit_exceeded,
              std::string(what) + " would take about " + units_text(needed_bytes, true) +
                  " of memory; the limit is " + units_text(limit_bytes, false) + "; " +
                  std::string(advice));
}

}  // namespace octavo
