// The process an import worker runs in, seen by the one that started it.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/source/reader_notes.h"

namespace octavo {

/// A descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(other.number_) { other.number_ = -1; }
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }
  void close() noexcept;

 private:
  int number_;
};

/// A worker from its start to its end. It gets no standard input; what it writes to standard output
/// and standard error is kept apart, up to 64 KiB; it is a process group of its own, so that Ctrl-C
/// at a terminal reaches only who started it. Not thread-safe.
class WorkerProcess {
 public:
  /// command  a program and its arguments
  /// request  what the worker finds behind kRequestDescriptor
  /// Throws   Error{io} when no process can be started
  WorkerProcess(const std::vector<std::string>& command, std::span<const std::uint8_t> request);
  /// Ends the worker if it still runs.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// The end of the pipe to read answers from; reads do not wait.
  int answers() const { return answers_.number(); }

  ReaderNote note(std::int64_t z) const { return reader_note(notes_.number(), z); }

  /// Bytes the worker has read from files and pipes so far; 0 where the system does not tell.
  std::uint64_t bytes_read() const;

  /// Waits up to `patience_ms` for the worker to end by itself, then ends it; returns its status as
  /// waitpid gives it, -1 when somebody else has waited for it.
  int end(int patience_ms) noexcept;

  /// What the worker has written to standard output and standard error.
  std::string output() const;

 private:
  pid_t process_ = -1;
  int status_ = -1;
  Descriptor answers_;
  Descriptor notes_;
  Descriptor output_;
};

}  // namespace octavo
