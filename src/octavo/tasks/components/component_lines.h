// Components of a part of a mask, and the numbers that all parts give them, as lines of a file.
//
//     {"planes":[64],"counts":[2,1,1]}          of components, runs of the first and the last plane
//     {"of":"components","numbers":[28],"all":[9216,0,64,..]}             14 numbers each
//     {"of":"first plane","numbers":[4],"all":[17,3,40,1]}                y, begin, end, label
//     {"of":"last plane","numbers":[4],"all":[20,0,12,2]}
//
// Lists longer than a line holds go on in the next one.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/json_text.h"
#include "octavo/ops/mask/component_parts.h"

namespace octavo {

std::vector<JsonObject> lines_of_components(const PartOfComponents& found);

/// The opposite.
/// size  of the whole mask
/// Throws Error{corrupt} for what no part of such a mask finds
PartOfComponents components_of_lines(std::span<const JsonObject> lines, const WorkPart& part,
                                     const Size3& size);

/// The labels that a join gave to the components of each part; 0 for those that are not kept.
using LabelsOfParts = std::vector<std::vector<std::uint32_t>>;

std::vector<JsonObject> lines_of_labels(const LabelsOfParts& labels);

/// The opposite.
/// part_count  of the lists
/// most        the largest label
/// Throws Error{corrupt}
LabelsOfParts labels_of_lines(std::span<const JsonObject> lines, std::int64_t part_count,
                              std::size_t most);

}  // namespace octavo
