#include "octavo/io/isolation/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/isolation/worker_protocol.h"

extern char** environ;

namespace octavo {

namespace {

constexpr int kPipeBytes = 1 << 20;
constexpr int kFirstFreeDescriptor = 10;
constexpr std::size_t kOutputBytes = std::size_t{1} << 16;

[[noreturn]] void fail(const std::string& doing, int error) {
  throw Error(ErrorKind::io, "cannot start a process to read in (" + doing + ": " +
                                 std::strerror(error) + ")")
      .with_field("isolation");
}

/// The same file under a number above those a worker finds its ends at.
Descriptor above_worker_ends(Descriptor low, const char* doing) {
  if (low.number() < 0) fail(doing, errno);
  Descriptor high(::fcntl(low.number(), F_DUPFD_CLOEXEC, kFirstFreeDescriptor));
  if (high.number() < 0) fail(doing, errno);
  return high;
}

struct Pipe {
  Descriptor from;
  Descriptor to;
};

Pipe make_pipe() {
  std::array<int, 2> ends = {-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("pipe", errno);
  Descriptor from(ends[0]);
  Descriptor to(ends[1]);
  return {above_worker_ends(std::move(from), "pipe"), above_worker_ends(std::move(to), "pipe")};
}

Descriptor memory_file(const char* name, std::span<const std::uint8_t> bytes, std::size_t size) {
  Descriptor file = above_worker_ends(Descriptor(::memfd_create(name, MFD_CLOEXEC)), "memory file");
  if (::ftruncate(file.number(), static_cast<off_t>(size)) != 0) fail("memory file", errno);
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t count = ::pwrite(file.number(), bytes.data() + at, bytes.size() - at,
                                   static_cast<off_t>(at));
    if (count <= 0) fail("memory file", count < 0 ? errno : ENOSPC);
    at += static_cast<std::size_t>(count);
  }
  return file;
}

/// What a new process starts with.
class SpawnPlan {
 public:
  SpawnPlan() {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    sigset_t none;
    sigset_t ignored;
    sigemptyset(&none);
    sigemptyset(&ignored);
    for (const int number : {SIGPIPE, SIGINT, SIGTERM, SIGHUP, SIGABRT, SIGXCPU, SIGXFSZ}) {
      sigaddset(&ignored, number);
    }
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &ignored);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                               POSIX_SPAWN_SETPGROUP);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  }
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  void give(const Descriptor& descriptor, int number) {
    posix_spawn_file_actions_adddup2(&actions_, descriptor.number(), number);
  }

  pid_t start(const std::vector<std::string>& command) const {
    std::vector<char*> words;
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    pid_t process = -1;
    const int error =
        ::posix_spawn(&process, words.front(), &actions_, &attributes_, words.data(), environ);
    if (error != 0) fail(command.front(), error);
    return process;
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

void set_non_blocking(const Descriptor& descriptor) {
  const int flags = ::fcntl(descriptor.number(), F_GETFL);
  if (flags < 0 || ::fcntl(descriptor.number(), F_SETFL, flags | O_NONBLOCK) != 0) {
    fail("pipe", errno);
  }
}

}  // namespace

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

void Descriptor::close() noexcept {
  if (number_ >= 0) ::close(number_);
  number_ = -1;
}

WorkerProcess::WorkerProcess(const std::vector<std::string>& command,
                             std::span<const std::uint8_t> request) {
  if (command.empty()) throw Error(ErrorKind::invalid_argument, "no program to read with");
  const Descriptor request_file = memory_file("octavo-request", request, request.size());
  notes_ = memory_file("octavo-notes", {}, kReaderNotesBytes);
  Pipe answers = make_pipe();
  Pipe output = make_pipe();
  // A larger pipe saves switches between the processes; a smaller one does as well.
  ::fcntl(answers.to.number(), F_SETPIPE_SZ, kPipeBytes);
  set_non_blocking(answers.from);
  // Neither end of the output waits: nobody reads it before the worker is done.
  set_non_blocking(output.from);
  set_non_blocking(output.to);
  SpawnPlan plan;
  plan.give(output.to, STDOUT_FILENO);
  plan.give(output.to, STDERR_FILENO);
  plan.give(request_file, kRequestDescriptor);
  plan.give(answers.to, kAnswerDescriptor);
  plan.give(notes_, kNotesDescriptor);
  process_ = plan.start(command);
  answers_ = std::move(answers.from);
  output_ = std::move(output.from);
}

WorkerProcess::~WorkerProcess() { end(0); }

std::uint64_t WorkerProcess::bytes_read() const {
  std::ifstream file("/proc/" + std::to_string(process_) + "/io");
  std::string name;
  std::uint64_t value = 0;
  return file >> name >> value && name == "rchar:" ? value : 0;
}

int WorkerProcess::end(int patience_ms) noexcept {
  for (int waited_ms = 0; process_ > 0; waited_ms += 5) {
    if (waited_ms >= patience_ms) ::kill(process_, SIGKILL);
    const int options = waited_ms >= patience_ms ? 0 : WNOHANG;
    int status = -1;
    const pid_t found = ::waitpid(process_, &status, options);
    if (found == 0) {
      ::poll(nullptr, 0, 5);
      continue;
    }
    if (found < 0 && errno == EINTR) continue;
    status_ = found == process_ ? status : -1;
    process_ = -1;
  }
  return status_;
}

std::string WorkerProcess::output() const {
  std::string text(kOutputBytes, '\0');
  const ssize_t count = ::read(output_.number(), text.data(), text.size());
  text.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return text;
}

}  // namespace octavo
