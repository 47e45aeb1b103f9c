#include "octavo/tasks/files/planes_between.h"

#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/metadata.h"

namespace octavo {

namespace {

IsotropicPlan plan_for(const std::string& name, const PlaneSource& source,
                       PlaneInterpolation method) {
  try {
    return plan_isotropic(source.description(), method);
  } catch (const Error& error) {
    throw error.path().empty() ? error.with_path(name) : error;
  }
}

std::unique_ptr<PlaneSource> make_planned(const std::string& name,
                                          std::unique_ptr<PlaneSource> source,
                                          PlaneInterpolation method, const TaskContext& context) {
  const IsotropicPlan plan = plan_for(name, *source, method);
  context.note(plan.notice);
  return plan.is_needed ? make_isotropic_source(std::move(source), plan) : std::move(source);
}

/// How planes were made between the slices of the source; nothing where none were.
std::optional<std::string> noted_method(const VolumeDescription& file) {
  const std::optional<PreparedNote>& prepared = file.metadata.facts().prepared;
  if (!prepared || !prepared->isotropic) return std::nullopt;
  return prepared->isotropic->method;
}

}  // namespace

std::unique_ptr<PlaneSource> make_isotropic(const std::string& name,
                                            std::unique_ptr<PlaneSource> source,
                                            std::optional<PlaneInterpolation> method,
                                            VolumeKind kind, const TaskContext& context) {
  if (!method) return source;
  if (kind == VolumeKind::labels && *method != PlaneInterpolation::linear) {
    throw Error(ErrorKind::invalid_argument,
                "labels have no values in between, they are interpolated by their shapes", name)
        .with_field("between");
  }
  const bool is_by_shape = kind == VolumeKind::labels;
  return make_planned(name, std::move(source), is_by_shape ? PlaneInterpolation::shape : *method,
                      context);
}

std::unique_ptr<PlaneSource> repeat_isotropic(const std::string& name,
                                              std::unique_ptr<PlaneSource> source,
                                              const VolumeDescription& file,
                                              const TaskContext& context) {
  const std::optional<std::string> wanted = noted_method(file);
  if (!wanted) return source;
  for (const PlaneInterpolation method :
       {PlaneInterpolation::linear, PlaneInterpolation::cubic, PlaneInterpolation::shape}) {
    if (*wanted != interpolation_name(method)) continue;
    return make_planned(name, std::move(source), method, context);
  }
  throw Error(ErrorKind::invalid_argument,
              "the file was resampled by '" + escaped(*wanted) +
                  "', which this program does not know: its source cannot be prepared alike; "
                  "compare with a newer program",
              name);
}

}  // namespace octavo
