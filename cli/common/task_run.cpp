#include "common/task_run.h"

#include "text/advice.h"

namespace octavo::cli {

TaskContext brief_task(Context& context) {
  TaskContext task;
  task.threads = context.threads;
  task.max_memory_bytes = context.max_memory_bytes;
  task.timeout_s = context.timeout_s;
  task.max_voxels = context.max_voxels;
  task.on_warning = [&context](const Warning& warning) {
    context.warn(with_advice(warning));
  };
  task.on_note = [&context](const std::string& text, const std::string& field) {
    const std::string advice = advice_for_note(field);
    context.note(advice.empty() ? text : text + "; " + advice);
  };
  task.on_detail = [&context](const std::string& text) { context.detail(text); };
  task.is_strict = context.strict;
  task.worker_command = {"/proc/self/exe", "import-worker"};
  return task;
}

TaskRun::TaskRun(Context& context) : progress_(context), task_(brief_task(context)) {
  task_.progress = &progress_;
}

}  // namespace octavo::cli
