// The numbers that a join gives to the components of all parts, as a file.
#pragma once

#include <cstddef>
#include <string>

#include "octavo/core/json_text.h"
#include "octavo/file/reader.h"
#include "octavo/tasks/components.h"
#include "octavo/tasks/components/component_lines.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct ComponentNumbers {
  ComponentsOptions options;  ///< connectivity, and which are kept
  std::size_t found = 0;
  std::size_t kept = 0;
  LabelsOfParts labels;
};

/// What all parts of one mask have in common.
JsonObject question_of(const FileReader& mask, Connectivity connectivity);

/// Throws as write_part_result
void write_component_numbers(const ComponentNumbers& numbers, const FileReader& mask,
                             const Output& output);

/// Throws  as read_part_result; Error{invalid_argument} for numbers of another mask
ComponentNumbers read_component_numbers(const std::string& path, const FileReader& mask,
                                        const TaskContext& context);

}  // namespace octavo
