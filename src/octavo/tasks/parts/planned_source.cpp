#include "octavo/tasks/parts/planned_source.h"

#include <utility>

#include "octavo/core/error.h"
#include "octavo/tasks/files/named_labels.h"
#include "octavo/tasks/files/planes_between.h"
#include "octavo/tasks/open_scan.h"
#include "octavo/tasks/parts/scan_recipe.h"

namespace octavo {

namespace {

/// The context without what is said before `is_open`.
TaskContext quiet_until(const std::shared_ptr<const bool>& is_open, const TaskContext& context) {
  TaskContext quiet = context;
  quiet.on_note = [is_open, note = context.on_note](const std::string& text,
                                                    const std::string& field) {
    if (*is_open && note) note(text, field);
  };
  quiet.on_warning = [is_open, warn = context.on_warning](const Warning& warning) {
    if (*is_open && warn) warn(warning);
  };
  return quiet;
}

std::unique_ptr<PlaneSource> opened_scan(const BuildPlan& plan, const ScanRecipe& recipe,
                                         const TaskContext& context) {
  auto source = plan.stack ? open_slices(*plan.stack, recipe.scan, context)
                           : open_planes(plan.inputs, recipe.scan, context);
  source = make_isotropic(plan.inputs.front(), std::move(source), recipe.between,
                          plan.options.kind, context);
  const LabelNames& labels = plan.source.metadata.facts().labels;
  const bool drops_names = plan.options.kind == VolumeKind::grey &&
                           !source->description().metadata.facts().labels.is_empty();
  if (!recipe.has_given_names && !drops_names) return source;
  return with_label_names(std::move(source), recipe.has_given_names ? labels : LabelNames());
}

std::unique_ptr<PlaneSource> opened_work(const BuildPlan& plan, const ScanRecipe& recipe,
                                         const WorkParser& parser, const TaskContext& context) {
  if (parser) {
    return open_computed(with_inputs(parser(recipe.words), plan.inputs), context).planes;
  }
  throw Error(ErrorKind::invalid_argument,
              "a volume is planned that is computed, which is not understood here",
              plan.inputs.front());
}

}  // namespace

std::unique_ptr<PlaneSource> open_planned(const BuildPlan& plan, std::int64_t first,
                                          std::int64_t end, const TaskContext& context,
                                          const WorkParser& parser) {
  const auto is_open = std::make_shared<bool>(false);
  const TaskContext quiet = quiet_until(is_open, context);
  const ScanRecipe recipe = parse_recipe(plan.recipe);
  auto source = recipe.words.empty() ? opened_scan(plan, recipe, quiet)
                                     : opened_work(plan, recipe, parser, quiet);
  source->seek(first, end);
  *is_open = true;
  return source;
}

}  // namespace octavo
