#include "octavo/tasks/components/components_in_parts.h"

#include <span>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/components/component_numbers.h"
#include "octavo/tasks/components/component_planes.h"
#include "octavo/tasks/components/component_rows.h"
#include "octavo/tasks/files/part_result.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"

namespace octavo {

namespace {

constexpr const char* kComponentsKind = "components";

void require_name_of_numbers(const Output& output) {
  if (output.path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument,
                "is the name of a volume; a join writes the numbers of all components, from which "
                "the label map is made",
                output.path);
  }
  require_free(output);
}

/// One file, of the mask and with the connectivity that are asked for.
PartOfComponents found_in(const std::string& path, const FileReader& mask,
                          const std::string& question, const TaskContext& context) {
  const FoundPart file = read_part_result(path, kComponentsKind, context);
  if (file.lines.empty() || file.lines.front().text() != question) {
    throw Error(ErrorKind::invalid_argument,
                "is part of other components: of another mask or connectivity", path);
  }
  return of_part_result(path, [&] {
    return components_of_lines(std::span(file.lines).subspan(1), file.part,
                               mask.description().size);
  });
}

std::uint64_t bytes_of_part(const PartOfComponents& part) {
  // Of a component: itself and its sums, here and in the whole, and what joins them.
  constexpr std::uint64_t kComponentBytes = 512;
  return part.components.size() * kComponentBytes +
         (part.first_plane.size() + part.last_plane.size()) * sizeof(LabelRun);
}

/// Those of the parts, with 0 in place of labels above `kept`.
LabelsOfParts kept_labels(LabelsOfParts labels, std::size_t kept) {
  for (std::vector<std::uint32_t>& of_part : labels) {
    for (std::uint32_t& label : of_part) {
      if (label > kept) label = 0;
    }
  }
  return labels;
}

}  // namespace

std::size_t components_of_part(const ComponentsPartOptions& options, const TaskContext& context) {
  require_part(options.part);
  require_free(options.output);
  require_no_input(options.output.path, {options.input});
  const auto mask = open_labels(options.input, context, kAsMask);
  const MaskOfPart part(*mask, options.part, options.connectivity, context.max_memory_bytes,
                        context);
  const PartOfComponents found = part_of_components(part.components(), options.part);
  std::vector<JsonObject> lines = lines_of_components(found);
  lines.insert(lines.begin(), question_of(*mask, options.connectivity));
  write_part_result(options.output, kComponentsKind, options.part, lines);
  return found.components.size();
}

ComponentsResult join_components(const JoinComponentsOptions& options,
                                 const TaskContext& context) {
  const ComponentsOptions& asked = options.components;
  if (asked.output) {
    require_name_of_numbers(*asked.output);
    require_no_input(asked.output->path, {asked.input});
    require_no_input(asked.output->path, options.parts);
  }
  const auto mask = open_labels(asked.input, context, kAsMask);
  require_usable(asked, mask->description());
  const std::string question = question_of(*mask, asked.connectivity).text();
  std::vector<PartOfComponents> parts;
  std::uint64_t bytes = 0;
  for (const std::string& path : options.parts) {
    context.stop_if_cancelled();
    parts.push_back(found_in(path, *mask, question, context));
    bytes += bytes_of_part(parts.back());
    context.require_memory(bytes, "the components of all parts");
  }

  JoinedComponents joined = joined_components(parts, asked.connectivity);
  ComponentsResult result =
      table_of_components(joined.components, mask->description(), asked, bytes, context);
  if (!asked.output) return result;
  write_component_numbers({asked, result.found, result.kept,
                           kept_labels(std::move(joined.labels), result.kept)},
                          *mask, *asked.output);
  result.file_bytes = local_storage().open_read(asked.output->path)->size();
  return result;
}

}  // namespace octavo
