// Parts that stand somewhere: whether they are whole, and of which plan.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/dist/build_plan.h"
#include "octavo/dist/part_file.h"

namespace octavo {

/// The part at `path`, which is to be that of the plan with this number. Its streams are not read.
/// Throws  as PartFile::open; Error{invalid_argument} for a part of another plan, or another part
std::shared_ptr<PartFile> open_part(const BuildPlan& plan, std::int64_t part,
                                    const std::string& path);

/// The same, with every byte proven. Throws also Error{corrupt}, Error{truncated}
std::shared_ptr<PartFile> open_whole_part(const BuildPlan& plan, std::int64_t part,
                                          const std::string& path);

/// The number of the part that holds these groups. Throws as open_part
std::int64_t number_of(const BuildPlan& plan, const PartFile& part);

}  // namespace octavo
