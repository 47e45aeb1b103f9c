// What a caller hands to a task besides its options: how much of the machine it may use, who
// watches it, and who hears what the caller should know.
//
// A task is one function per verb: options in, result out. Every program calls the same ones, the
// command line included; none of them prints, asks or exits.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/progress.h"
#include "octavo/core/warning.h"

namespace octavo {

/// What it passes on to its listeners holds no secrets of URLs.
struct TaskContext {
  using Listener = std::function<void(const std::string&)>;
  using WarningListener = std::function<void(const Warning&)>;
  /// field  of the option that would change what the text says, as in OptionHint; may be empty
  using NoteListener = std::function<void(const std::string& text, const std::string& field)>;

  int threads = 0;                     ///< 0: all cores
  std::uint64_t max_memory_bytes = 0;  ///< 0: no limit
  double timeout_s = 60;               ///< of servers behind URLs, as in HttpOptions
  /// Of a volume that a task reads or makes; 0: no limit.
  std::uint64_t max_voxels = std::uint64_t{1} << 40;
  /// Watches the work; its is_cancelled() ends the task with Error{cancelled}.
  Progress* progress = nullptr;
  /// Told what the user should know although the task goes on. May throw, which ends the task.
  WarningListener on_warning;
  /// Told what was done otherwise than asked, or takes long, in passing; on any thread.
  NoteListener on_note;
  /// Told how the work is done, for those who look closely.
  Listener on_detail;
  /// Warnings are errors: what would come with one is not written.
  bool is_strict = false;
  /// Starts a process that calls run_import_worker at once, for scans that code of others reads;
  /// empty: they are read in this process.
  std::vector<std::string> worker_command;

  /// Throws Error{source_rejected} where is_strict.
  void warn(const Warning& warning) const;
  void note(const std::string& text, const std::string& field = "") const;
  void detail(const std::string& text) const;

  /// `progress`, or one that watches nothing.
  Progress& watcher() const;

  /// Threads to start: `threads`, or the cores of this machine.
  int thread_count() const;

  /// Runs `work` on that many threads. Throws as stop_if_cancelled does, before and after it.
  void on_threads(const std::function<void()>& work) const;

  /// Throws Error{cancelled} once the one who watches asked to stop.
  void stop_if_cancelled() const;

  /// Throws Error{limit_exceeded} when `bytes` are above max_memory_bytes.
  /// what  the subject of the message: "the mask"
  void require_memory(std::uint64_t bytes, const char* what) const;

  /// Throws Error{limit_exceeded} about `path` when a volume has more voxels than max_voxels.
  void require_voxels(const Size3& size, const std::string& path) const;
};

}  // namespace octavo
