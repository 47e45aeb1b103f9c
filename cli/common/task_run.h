// One call of a task from the command line: its progress on standard error, its warnings and notes
// where the global options want them, Ctrl-C as its cancellation.
#pragma once

#include "common/context.h"
#include "common/progress_line.h"
#include "octavo/tasks/task_context.h"

namespace octavo::cli {

/// The context of a task that ends soon and writes nothing: no progress is shown, and a signal ends
/// the program at once.
TaskContext brief_task(Context& context);

/// While it lives, SIGINT, SIGTERM and SIGHUP ask the task to stop.
class TaskRun {
 public:
  explicit TaskRun(Context& context);
  const TaskContext& context() const { return task_; }

 private:
  ProgressLine progress_;
  TaskContext task_;
};

/// Thrown where the context takes the options of a task.
struct OptionsTaken {};

/// The result of task(options, context).
template <class Result, class Options>
Result run_task(Result (*task)(const Options&, const TaskContext&), const Options& options,
                Context& context) {
  if (context.taken != nullptr) {
    *context.taken = options;
    throw OptionsTaken();
  }
  const TaskRun run(context);
  return task(options, run.context());
}

}  // namespace octavo::cli
