#include "common/task_run.h"

namespace octavo::cli {

TaskRun::TaskRun(Context& context) : progress_(context) {
  task_.threads = context.threads;
  task_.max_memory_bytes = context.max_memory_bytes;
  task_.progress = &progress_;
  task_.on_warning = [&context](const std::string& text) { context.warn(text); };
  task_.on_note = [&context](const std::string& text) { context.note(text); };
  task_.on_detail = [&context](const std::string& text) { context.detail(text); };
}

}  // namespace octavo::cli
