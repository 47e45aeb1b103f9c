#include "octavo/io/isolation/import_worker.h"

#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <thread>
#include <utility>

#include "octavo/core/unset_bytes.h"
#include "octavo/io/isolation/worker_protocol.h"
#include "octavo/io/source/described_source.h"
#include "octavo/io/source/prefetch_source.h"
#include "octavo/io/source/reader_notes.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMebibyte = std::uint64_t{1} << 20;
/// What a library may need besides the planes, and a thread besides its work (its stack and the
/// range of addresses that malloc reserves for it).
constexpr std::uint64_t kLibraryBytes = 1024 * kMebibyte;
constexpr std::uint64_t kThreadBytes = 192 * kMebibyte;
/// Buffers a decoder may hold for one plane: wider numbers, copies, tables.
constexpr std::uint64_t kPlaneCopies = 16;
/// More than any machine has, and still far from where sums wrap.
constexpr std::uint64_t kAllMemory = std::uint64_t{1} << 60;
/// Finding out what a source is may take as long as this many planes.
constexpr std::uint64_t kOpeningPlanes = 60;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
/// Sanitizers reserve terabytes of addresses.
constexpr bool kCanLimitMemory = false;
#else
constexpr bool kCanLimitMemory = true;
#endif

using Resource = decltype(RLIMIT_AS);

rlim_t soft_limit(Resource resource) {
  rlimit limit{RLIM_INFINITY, RLIM_INFINITY};
  ::getrlimit(resource, &limit);
  return limit.rlim_cur;
}

void set_soft_limit(Resource resource, rlim_t value) {
  rlimit limit{};
  if (::getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(limit.rlim_max, value);
  ::setrlimit(resource, &limit);
}

/// What is lower already stays.
void lower(Resource resource, rlim_t value) {
  set_soft_limit(resource, std::min(soft_limit(resource), value));
}

/// Bytes of addresses that this process has.
std::uint64_t address_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  file >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t machine_bytes() {
  return static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t thread_bytes(const ImportRequest& request) {
  return static_cast<std::uint64_t>(request.threads) * kThreadBytes;
}

/// What a worker may use, from the first byte of the source on and then plane by plane.
class ImportLimits {
 public:
  explicit ImportLimits(const ImportRequest& request) : request_(request) {
    // 1 and not 0: a core that goes to a program is rejected at 1 alone.
    lower(RLIMIT_CORE, 1);
    ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    // Where memory runs out for all, the system should take this process.
    std::ofstream("/proc/self/oom_score_adj") << 1000;
    lower(RLIMIT_FSIZE, 0);
    set_memory(request.options.max_memory_bytes != 0
                   ? std::min(request.options.max_memory_bytes, kAllMemory) + kLibraryBytes +
                         thread_bytes(request)
                   : machine_bytes());
    allow_time(kOpeningPlanes);
  }

  /// Once the planes are known: enough for those being decoded.
  void know(const PlaneSource& source) {
    const std::uint64_t bytes = plane_bytes(source.description());
    const auto threads = static_cast<std::uint64_t>(request_.threads);
    set_memory(kLibraryBytes + thread_bytes(request_) + kPlaneCopies * bytes * threads +
               source.resident_bytes());
    allow_time(1);
  }

  /// Processor time for another plane. The wall clock is watched from outside; this ends a worker
  /// that nobody watches any more.
  void allow_time(std::uint64_t planes) {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    const std::uint64_t one = (request_.limit_ms + 999) / 1000;
    const auto threads = static_cast<std::uint64_t>(request_.threads) + 1;
    const auto so_far = static_cast<std::uint64_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
    const std::uint64_t until = so_far + 1 + one * threads * planes;
    set_soft_limit(RLIMIT_CPU, std::min<rlim_t>(inherited_seconds_, until));
  }

  std::uint64_t memory_bytes() const { return memory_bytes_; }

 private:
  void set_memory(std::uint64_t bytes) {
    memory_bytes_ = request_.memory_bytes != 0 ? request_.memory_bytes : bytes;
    if (kCanLimitMemory) lower(RLIMIT_AS, address_bytes() + memory_bytes_);
  }

  const ImportRequest& request_;
  const rlim_t inherited_seconds_ = soft_limit(RLIMIT_CPU);
  std::uint64_t memory_bytes_ = 0;
};

extern "C" void on_crash(int signal) {
  note_crash();
  // The handler is gone by now: this ends the process as if it had never been there.
  ::raise(signal);
}

void note_crashes() {
  static std::array<char, 1 << 16> stack;
  stack_t alternative{};
  alternative.ss_sp = stack.data();
  alternative.ss_size = stack.size();
  ::sigaltstack(&alternative, nullptr);
  struct sigaction action = {};
  action.sa_handler = on_crash;
  sigemptyset(&action.sa_mask);
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER | SA_ONSTACK);
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGXCPU, SIGXFSZ, SIGSYS}) {
    ::sigaction(number, &action, nullptr);
  }
}

/// Keeps freed memory for the next plane. Decoders allocate whole planes again and again, which
/// malloc would otherwise fetch from the system each time, page by page.
void keep_freed_memory() {
  constexpr int kKeptBytes = 1 << 26;
  constexpr int kLargestKeptBytes = 1 << 25;  // the most that malloc takes
  ::mallopt(M_TRIM_THRESHOLD, kKeptBytes);
  ::mallopt(M_MMAP_THRESHOLD, kLargestKeptBytes);
}

/// Ends this process when nobody is left to read its answers.
void end_with_reader() {
  std::thread([] {
    pollfd answers{kAnswerDescriptor, 0, 0};
    while (::poll(&answers, 1, -1) < 0 && errno == EINTR) {
    }
    ::_exit(1);
  }).detach();
  // From here on the end of the thread that started this process means nothing.
  ::prctl(PR_SET_PDEATHSIG, 0, 0, 0, 0);
}

void send_bytes(const void* bytes, std::size_t count) {
  const auto* from = static_cast<const std::byte*>(bytes);
  while (count > 0) {
    const ssize_t written = ::write(kAnswerDescriptor, from, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    from += written;
    count -= static_cast<std::size_t>(written);
  }
}

void send(MessageKind kind, std::span<const std::uint8_t> payload, std::uint64_t index = 0) {
  const MessageHead head = head_for(kind, index, payload);
  send_bytes(&head, sizeof head);
  send_bytes(payload.data(), payload.size());
}

ImportRequest read_request() {
  struct stat status {};
  if (::fstat(kRequestDescriptor, &status) != 0) {
    throw Error(ErrorKind::io, "no request to be read");
  }
  Payload bytes(static_cast<std::size_t>(status.st_size));
  std::size_t at = 0;
  while (at < bytes.size()) {
    const ssize_t count = ::pread(kRequestDescriptor, bytes.data() + at, bytes.size() - at,
                                  static_cast<off_t>(at));
    if (count <= 0) throw Error(ErrorKind::io, "the request cannot be read");
    at += static_cast<std::size_t>(count);
  }
  return decode_request(bytes);
}

/// The planes that are asked for: first, and end.
std::pair<std::int64_t, std::int64_t> planes_of(const ImportRequest& request,
                                                const PlaneSource& source) {
  const std::int64_t count = source.description().size.z;
  return {request.first_plane, request.end_plane < 0 ? count : request.end_plane};
}

void send_planes(PlaneSource& source, const ImportRequest& request, ImportLimits& limits,
                 std::int64_t& z) {
  const auto [first, end] = planes_of(request, source);
  UnsetBytes plane(static_cast<std::size_t>(plane_bytes(source.description())));
  const std::span payload(reinterpret_cast<const std::uint8_t*>(plane.data()), plane.size());
  std::size_t warnings_sent = source.warnings().size();
  for (z = first; z < end; ++z) {
    source.read_plane(plane.bytes());
    if (source.warnings().size() != warnings_sent) {
      warnings_sent = source.warnings().size();
      send(MessageKind::warnings, encode(source.warnings()));
    }
    send(MessageKind::plane, payload, static_cast<std::uint64_t>(z));
    limits.allow_time(1);
  }
}

/// What ended the reading, as an Error with the words the program itself would have used.
Error failure_of(std::exception_ptr failure, std::int64_t z, const ImportLimits& limits,
                 const std::string& source) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_alloc&) {
    const ReaderNote note = reader_note(kNotesDescriptor, z);
    return Error(ErrorKind::source_rejected,
                 "the reader asked for more than the " +
                     std::to_string(limits.memory_bytes() / kMebibyte) +
                     " MiB of memory it may use: the file is damaged, or too large to be read here",
                 note.path.empty() ? source : note.path);
  } catch (const std::filesystem::filesystem_error& error) {
    return Error(ErrorKind::io, error.code().message(), error.path1().string());
  } catch (const std::exception& error) {
    return Error(ErrorKind::internal, std::string("internal error: ") + error.what() +
                                          "; please report this line");
  }
}

void read_and_send(const SourceOpener& opener, const ImportRequest& request,
                   ImportLimits& limits) {
  std::int64_t z = -1;
  // Outlives the failure: to end it may take long where one of its threads does not come back.
  std::unique_ptr<PlaneSource> source;
  try {
    source = opener(request.paths, request.options);
    source = make_prefetch_source(std::move(source), {.threads = request.threads});
    const auto [first, end] = planes_of(request, *source);
    source->seek(first, end);
    limits.know(*source);
    send(MessageKind::report,
         encode(SourceReport{source->description(), source->warnings(), source->resident_bytes(),
                             source->files()}));
    send_planes(*source, request, limits, z);
  } catch (...) {
    const std::string name = request.paths.empty() ? "" : request.paths.front();
    send(MessageKind::failure, encode(failure_of(std::current_exception(), z, limits, name)));
  }
}

}  // namespace

bool has_import_request() {
  std::array<std::uint8_t, 8> mark{};
  return ::pread(kRequestDescriptor, mark.data(), mark.size(), 0) == ssize_t{mark.size()} &&
         starts_a_request(mark);
}

void run_import_worker(const SourceOpener& opener) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
  try {
    // Programs that a reader might start must not hold the answers open.
    ::fcntl(kAnswerDescriptor, F_SETFD, FD_CLOEXEC);
    end_with_reader();
    const ImportRequest request = read_request();
    keep_reader_notes(kNotesDescriptor);
    note_crashes();
    keep_freed_memory();
    ImportLimits limits(request);
    read_and_send(opener, request, limits);
  } catch (const std::exception&) {
    ::_exit(1);
  }
  // Without the destructors of libraries that may have seen a damaged file.
  ::_exit(0);
}

}  // namespace octavo
