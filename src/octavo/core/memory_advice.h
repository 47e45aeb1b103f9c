// What to do about a limit of memory.
#pragma once

#include <string_view>

namespace octavo {

/// The end of a message about a limit that work on so many threads is above, each of which takes
/// memory of its own.
constexpr std::string_view memory_advice(int threads) {
  return threads > 1 ? "raise the limit or use fewer threads" : "raise the limit";
}

}  // namespace octavo
