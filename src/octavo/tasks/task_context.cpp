#include "octavo/tasks/task_context.h"

#include <algorithm>
#include <thread>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/memory_limit.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/threads/arena.h"

namespace octavo {

void TaskContext::warn(const Warning& warning) const {
  if (is_strict) throw Error(ErrorKind::source_rejected, warning.text).with_field("is_strict");
  if (on_warning) on_warning(Warning(without_secrets(warning.text), warning.field));
}

void TaskContext::note(const std::string& text, const std::string& field) const {
  if (on_note) on_note(without_secrets(text), field);
}

void TaskContext::detail(const std::string& text) const {
  if (on_detail) on_detail(without_secrets(text));
}

Progress& TaskContext::watcher() const {
  static NoProgress nobody;
  return progress != nullptr ? *progress : nobody;
}

int TaskContext::thread_count() const {
  if (threads > 0) return threads;
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

void TaskContext::on_threads(const std::function<void()>& work) const {
  stop_if_cancelled();
  run_in_arena(thread_count(), work);
  stop_if_cancelled();
}

void TaskContext::stop_if_cancelled() const {
  if (watcher().is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
}

void TaskContext::require_memory(std::uint64_t bytes, const char* what) const {
  require_memory_within(bytes, max_memory_bytes, what);
}

void TaskContext::require_voxels(const Size3& size, const std::string& path) const {
  const auto voxels = static_cast<std::uint64_t>(checked_voxel_count(size));
  if (max_voxels == 0 || voxels <= max_voxels) return;
  throw Error(ErrorKind::limit_exceeded,
              "a volume of " + size_text(size) + " voxels; the limit is " +
                  std::to_string(max_voxels),
              path)
      .with_field("max_voxels");
}

}  // namespace octavo
