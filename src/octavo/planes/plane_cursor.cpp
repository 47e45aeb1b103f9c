#include "octavo/planes/plane_cursor.h"

#include <string>

#include "octavo/core/error.h"

namespace octavo {

void PlaneCursor::seek(std::int64_t first, std::int64_t end) {
  if (first < 0 || first > end || end > count_) {
    throw Error(ErrorKind::invalid_argument,
                "planes " + std::to_string(first) + " up to " + std::to_string(end) + " of " +
                    std::to_string(count_) + " asked for");
  }
  next_ = first;
  end_ = end;
}

std::int64_t PlaneCursor::take() {
  if (is_done()) {
    throw Error(ErrorKind::invalid_argument,
                "no plane is left: " + std::to_string(end_) + " of " + std::to_string(count_) +
                    " is behind those asked for");
  }
  return next_++;
}

}  // namespace octavo
