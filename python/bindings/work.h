// What tasks get beside their options, from Python: threads, memory, progress; and the files
// that Python has open, which tasks know by their names.
#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "call.h"
#include "octavo/file/storage/byte_source.h"
#include "octavo/tasks/task_context.h"
#include "reading.h"

namespace octavo::python {

/// A file and the name that a task knows it by; null where a task gets none.
struct NamedFile {
  std::string name;
  const OpenFile* file = nullptr;
};

/// One call of a task.
class Work {
 public:
  /// given  threads, max_memory, progress (a function or None)
  explicit Work(const nanobind::dict& given);

  const TaskContext& context() const { return context_; }

  /// Runs `work` without the GIL, with the files of that call in the place of their names.
  template <class Task>
  auto run(const std::vector<NamedFile>& files, Task&& task) {
    const auto with_inputs = [&] {
      const Inputs inputs(files);
      return task();
    };
    if constexpr (std::is_void_v<decltype(task())>) {
      call_.run_reading(files_read(files), with_inputs);
      call_.throw_kept();
    } else {
      auto result = call_.run_reading(files_read(files), with_inputs);
      call_.throw_kept();
      return result;
    }
  }
  /// The same for work that reads no file.
  template <class Task>
  auto run(Task&& task) {
    return run({}, std::forward<Task>(task));
  }

 private:
  /// The files of a call while it lives; then those of the call that it is made amid.
  class Inputs {
   public:
    explicit Inputs(const std::vector<NamedFile>& files);
    ~Inputs();
    Inputs(const Inputs&) = delete;
    Inputs& operator=(const Inputs&) = delete;

   private:
    std::map<std::string, std::shared_ptr<const ByteSource>> around_;
  };

  static FilesRead files_read(const std::vector<NamedFile>& files);

  Call call_;
  TaskContext context_;
};

/// The result of task(options, context), which reads these files.
/// given  as Work gets it
template <class Result, class Options>
Result run_task(Result (*task)(const Options&, const TaskContext&), const Options& options,
                const std::vector<NamedFile>& files, const nanobind::dict& given) {
  Work work(given);
  return work.run(files, [&] { return task(options, work.context()); });
}

}  // namespace octavo::python
