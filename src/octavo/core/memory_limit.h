// Limits of memory: one check and one wording for all work that would need more.
#pragma once

#include <cstdint>
#include <string_view>

namespace octavo {

/// Throws Error{limit_exceeded} that names both numbers when `needed_bytes` are above
/// `limit_bytes`.
/// limit_bytes  0: no limit
/// what         the subject of the message: "the mask"
/// advice       its end, what to do: "raise the limit"
void require_memory_within(std::uint64_t needed_bytes, std::uint64_t limit_bytes,
                           std::string_view what, std::string_view advice = "raise the limit");

}  // namespace octavo
