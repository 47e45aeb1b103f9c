#include "common/masks.h"

#include "common/task_run.h"

namespace octavo::cli {

namespace {

TaskRun run_of(const Context& context) { return TaskRun(const_cast<Context&>(context)); }

}  // namespace

OpenedMask open_mask(const std::string& path, const Context& context) {
  return octavo::open_mask(path, run_of(context).context());
}

MaskOnGrid open_mask_on(const VolumeDescription& volume, const std::string& name,
                        const std::string& path, Context& context) {
  return octavo::open_mask_on(volume, name, path, TaskRun(context).context());
}

MaskTree read_mask(const FileReader& reader, int level, const std::vector<ValueWindow>& windows,
                   const Context& context) {
  return octavo::read_mask(reader, level, windows, run_of(context).context());
}

void on_threads(const Context& context, const std::function<void()>& work) {
  run_of(context).context().on_threads(work);
}

BuildResult write_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const MadeBy& made_by, const std::string& output,
                       const Context& context) {
  return octavo::write_mask(mask, volume, made_by, {output, context.force}, context.verb,
                            run_of(context).context());
}

BuildResult write_labels(PlaneSource& source, const std::string& output, const Context& context) {
  return octavo::write_labels(source, {output, context.force}, context.verb,
                              run_of(context).context());
}

nlohmann::ordered_json mm3_json(std::uint64_t voxels, const VolumeDescription& volume) {
  return optional_json(mm3_of(voxels, volume));
}

void warn_of_unknown_spacing(const VolumeDescription& volume, const std::string& name,
                             const VolumeDescription& other, const std::string& other_name,
                             Context& context) {
  octavo::warn_of_unknown_spacing(volume, name, other, other_name, TaskRun(context).context());
}

void require_memory(std::uint64_t bytes, const char* what, const Context& context) {
  run_of(context).context().require_memory(bytes, what);
}

}  // namespace octavo::cli
