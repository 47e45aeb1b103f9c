#include "octavo/tasks/files/scan_planes.h"

#include <utility>

#include "octavo/io/source/label_names_file.h"
#include "octavo/tasks/files/label_hint.h"
#include "octavo/tasks/files/named_labels.h"
#include "octavo/tasks/files/planes_between.h"

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

/// The source with the names that were asked for; grey values have none.
std::unique_ptr<PlaneSource> with_names(std::unique_ptr<PlaneSource> source, VolumeKind kind,
                                        const BuildScanOptions& options, const LabelNames& names) {
  if (!options.label_names.empty()) require_labels_to_name(kind, options.inputs.front());
  const bool has_names = !source->description().metadata.facts().labels.is_empty();
  const bool drops_names = has_names && kind == VolumeKind::grey;
  if (options.label_names.empty() && !drops_names) return source;
  return with_label_names(std::move(source), names);
}

}  // namespace

ScanPlanes open_scan_planes(const BuildScanOptions& options, const TaskContext& context) {
  if (options.inputs.empty()) {
    throw Error(ErrorKind::invalid_argument, "a build needs a source");
  }
  const std::string& name = options.inputs.front();
  LabelNames names;
  if (!options.label_names.empty()) names = read_label_names(options.label_names);
  auto source = open_planes(options.inputs, options.scan, context);
  std::optional<SliceStack> stack = slice_stack_of(*source);
  const VolumeKind kind = choose_kind(options, source->description(), context);
  const auto two_values = std::make_shared<TwoValues>();
  const bool may_be_mask = kind == VolumeKind::grey && !options.kind;
  if (may_be_mask) source = watch_values(std::move(source), two_values);
  try {
    source = make_isotropic(name, std::move(source), options.between, kind, context);
    source = with_names(std::move(source), kind, options, names);
  } catch (const Error& error) {
    throw about_scan(error, name);
  }
  return {std::move(source), kind, std::move(stack), two_values};
}

BuildOptions build_options_of(const BuildScanOptions& options, VolumeKind kind) {
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

Error about_scan(const Error& error, const std::string& name) {
  const bool names_nothing = error.kind() == ErrorKind::source_rejected && error.path().empty();
  return names_nothing ? error.with_path(name) : error;
}

}  // namespace octavo
