// What somebody may give as a label and as its name; what is in files already may be any.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace octavo {

/// Whether a voxel can hold a label: a whole number of at most 32 bits.
bool is_label(std::int64_t number) noexcept;

/// Why this is no name; empty where it is one: "is empty", "is longer than 512 bytes", "holds a
/// control character".
std::string label_name_fault(std::string_view name);

}  // namespace octavo
