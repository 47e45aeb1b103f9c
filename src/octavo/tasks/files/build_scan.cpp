#include "octavo/tasks/files/build_scan.h"

#include <filesystem>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/source/label_names_file.h"
#include "octavo/tasks/files/label_hint.h"
#include "octavo/tasks/files/named_labels.h"
#include "octavo/tasks/files/planes_between.h"
#include "octavo/tasks/files/two_values.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

/// What was asked for, what the source says, what its name hints at: in this order.
VolumeKind choose_kind(const BuildScanOptions& options, const VolumeDescription& description,
                       const TaskContext& context) {
  if (options.kind) return *options.kind;
  const std::string& name = options.inputs.front();
  if (description.kind == VolumeKind::labels) {
    context.note(name + ": the source says it holds labels: building as labels", "kind");
    return VolumeKind::labels;
  }
  if (const auto hint = label_hint(name, description)) {
    context.note(name + ": looks like labels (" + *hint + "): building as labels", "kind");
    return VolumeKind::labels;
  }
  return VolumeKind::grey;
}

/// A build never replaces the scan it reads; an .8vo file may be built anew.
void require_no_input(const std::string& output, const std::vector<std::string>& inputs) {
  std::error_code none;
  for (const std::string& input : inputs) {
    if (is_octavo_path(input) || !std::filesystem::equivalent(output, input, none)) continue;
    throw Error(ErrorKind::invalid_argument, "is the source itself; name another output", output);
  }
}

void require_inputs_and_output(const BuildScanOptions& options) {
  if (options.inputs.empty()) {
    throw Error(ErrorKind::invalid_argument, "a build needs a source");
  }
  if (!options.output.path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument, "a build writes .8vo files", options.output.path)
        .with_field("output.format");
  }
  require_free(options.output);
  require_no_input(options.output.path, options.inputs);
}

/// The source with the names that were asked for; grey values have none.
std::unique_ptr<PlaneSource> with_names(std::unique_ptr<PlaneSource> source, VolumeKind kind,
                                        const BuildScanOptions& options, const LabelNames& names) {
  if (kind == VolumeKind::grey && !options.label_names.empty()) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, no labels to be named",
                options.inputs.front())
        .with_field("label_names");
  }
  const bool has_names = !source->description().metadata.facts().labels.is_empty();
  const bool drops_names = has_names && kind == VolumeKind::grey;
  if (options.label_names.empty() && !drops_names) return source;
  return with_label_names(std::move(source), names);
}

/// Says that a volume of two values is mostly a mask.
void note_mask(const std::string& name, const std::pair<std::int64_t, std::int64_t>& values,
               const TaskContext& context) {
  context.note(name + ": holds two values only, " + std::to_string(values.first) + " and " +
                   std::to_string(values.second) + ", as masks do",
               "two_values");
}

BuildOptions build_options(const BuildScanOptions& options, VolumeKind kind) {
  BuildOptions build;
  build.kind = kind;
  build.preset = options.preset;
  build.access = options.access;
  build.max_error = options.max_error;
  build.keep_details = options.keep_details;
  build.repair = options.repair;
  if (options.is_resuming) build.interrupted = Interrupted::resume;
  return build;
}

}  // namespace

BuiltVolume build_scan(const BuildScanOptions& options, const TaskContext& context) {
  require_inputs_and_output(options);
  const std::string& name = options.inputs.front();
  LabelNames names;
  if (!options.label_names.empty()) names = read_label_names(options.label_names);
  auto source = open_planes(options.inputs, options.scan, context);
  const VolumeKind kind = choose_kind(options, source->description(), context);
  const auto two_values = std::make_shared<TwoValues>();
  const bool may_be_mask = kind == VolumeKind::grey && !options.kind;
  if (may_be_mask) source = watch_values(std::move(source), two_values);
  try {
    source = make_isotropic(name, std::move(source), options.between, kind, context);
    source = with_names(std::move(source), kind, options, names);
    BuiltVolume built =
        build_planes(*source, build_options(options, kind), options.output, "build", context);
    if (*two_values) note_mask(name, **two_values, context);
    return built;
  } catch (const Error& error) {
    const bool names_nothing = error.kind() == ErrorKind::source_rejected && error.path().empty();
    throw names_nothing ? error.with_path(name) : error;
  }
}

}  // namespace octavo
