#include "octavo/io/isolation/isolated_source.h"

#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/isolation/worker_process.h"
#include "octavo/io/isolation/worker_protocol.h"
#include "octavo/io/source/described_source.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kCancelInterval{200};
constexpr int kEndPatienceMs = 2000;
/// Of reports, warnings and failures: metadata have 16 MiB at most in a file.
constexpr std::uint64_t kMaxWordsBytes = std::uint64_t{64} << 20;

/// What a user can do about a reader that failed.
constexpr const char* kAdvice =
    "; the file is probably damaged: copy it again from its origin, or convert it with another "
    "program";

std::string hex(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", value);
  return text;
}

std::string signal_text(int signal) {
  const char* name = ::strsignal(signal);
  return std::to_string(signal) + (name == nullptr ? "" : " (" + std::string(name) + ")");
}

class IsolatedSource final : public PlaneSource {
 public:
  IsolatedSource(const ImportRequest& request, const IsolationOptions& options)
      : options_(options),
        request_(request),
        name_(request.paths.front()),
        worker_(std::make_unique<WorkerProcess>(options.command, encode(request))),
        report_(take_report()),
        plane_bytes_(plane_bytes(report_.description)),
        cursor_(report_.description.size.z) {
    cursor_.seek(request.first_plane, end_plane());
  }

  const VolumeDescription& description() const override { return report_.description; }
  const std::vector<Warning>& warnings() const override { return report_.warnings; }
  std::uint64_t resident_bytes() const override {
    constexpr std::uint64_t kPlanes = 2;  // of the worker: one is being decoded, one is being sent
    return report_.resident_bytes + kPlanes * plane_bytes_;
  }
  const PlaneFiles& files() const override { return report_.files; }

  void read_plane(std::span<std::byte> plane) override {
    if (cursor_.is_done() || plane.size() != plane_bytes_ || !worker_) {
      throw Error(ErrorKind::invalid_argument, "no such plane, or a buffer of another size");
    }
    z_ = cursor_.next();
    MessageHead head = take_head();
    if (head.kind == MessageKind::warnings) {
      report_.warnings = understood([&] { return decode_warnings(take_words(head)); });
      head = take_head();
    }
    if (head.kind != MessageKind::plane || head.index != static_cast<std::uint64_t>(z_) ||
        head.length != plane.size()) {
      reject("the reader sent something else" + place() + kAdvice);
    }
    take_payload(head, {reinterpret_cast<std::uint8_t*>(plane.data()), plane.size()});
    cursor_.take();
    if (z_ + 1 == end_plane()) finish(kEndPatienceMs);
  }

  /// A worker that sends the planes sought, and has sent none of them, goes on; else a new one
  /// opens the source again.
  void seek(std::int64_t first, std::int64_t end) override {
    const bool goes_on = worker_ && first == cursor_.next() && first >= request_.first_plane &&
                         end <= end_plane();
    cursor_.seek(first, end);
    if (first == end || goes_on) return;
    if (worker_) finish(0);
    request_.first_plane = first;
    request_.end_plane = end;
    z_ = -1;
    worker_ = std::make_unique<WorkerProcess>(options_.command, encode(request_));
    SourceReport report = take_report();
    const VolumeDescription& now = report.description;
    const VolumeDescription& before = report_.description;
    if (now.size != before.size || now.type != before.type || now.kind != before.kind ||
        now.geometry != before.geometry || now.metadata.text() != before.metadata.text() ||
        report.files != report_.files) {
      reject("the source changed since it was opened");
    }
    report_ = std::move(report);
  }

 private:
  /// Behind the last plane that the worker sends.
  std::int64_t end_plane() const {
    return request_.end_plane < 0 ? report_.description.size.z : request_.end_plane;
  }

  // --- Messages

  SourceReport take_report() {
    const MessageHead head = take_head();
    if (head.kind != MessageKind::report) reject("the reader sent no description first");
    return understood([&] { return decode_report(take_words(head)); });
  }

  /// The next head; a failure in its place is thrown.
  MessageHead take_head() {
    MessageHead head;
    take({reinterpret_cast<std::uint8_t*>(&head), sizeof head});
    if (!is_sound(head)) {
      reject("what the reader sent" + place() + " is damaged: the head fails its checksum" +
             kAdvice);
    }
    if (head.kind == MessageKind::failure) {
      const Error failure = understood([&] { return decode_failure(take_words(head)); });
      finish(0);
      throw failure;
    }
    return head;
  }

  Payload take_words(const MessageHead& head) {
    if (head.length > kMaxWordsBytes) {
      reject("the reader sent a text of " + std::to_string(head.length) + " bytes, at most " +
             std::to_string(kMaxWordsBytes) + " are allowed");
    }
    Payload words(static_cast<std::size_t>(head.length));
    take_payload(head, words);
    return words;
  }

  void take_payload(const MessageHead& head, std::span<std::uint8_t> payload) {
    take(payload);
    const std::uint32_t found = crc32c(payload);
    if (checksum_matches(found, head.payload_crc)) return;
    reject("what the reader sent" + place() + " is damaged: checksum " + hex(found) + ", " +
           hex(head.payload_crc) + " expected" + kAdvice);
  }

  /// Runs a decoder; what it finds wrong is the worker's fault.
  template <class F>
  auto understood(F&& decode) -> decltype(decode()) {
    try {
      return decode();
    } catch (const Error& error) {
      const bool is_decoder = error.path().empty() && (error.kind() == ErrorKind::corrupt ||
                                                       error.kind() == ErrorKind::limit_exceeded);
      if (!is_decoder) throw;
      reject("what the reader sent" + place() + " makes no sense: " + error.detail() + kAdvice);
    }
  }

  // --- Bytes

  void take(std::span<std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::read(worker_->answers(), bytes.data(), bytes.size());
      if (count > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(count));
      } else if (count == 0) {
        reject_stopped();
      } else if (errno == EAGAIN) {
        await_bytes();
      } else if (errno != EINTR) {
        throw Error(ErrorKind::io, std::string("cannot hear the reader: ") + std::strerror(errno),
                    name_);
      }
    }
  }

  /// Returns once there is something to read, or the end of it. A worker that still reads its files
  /// is given more time.
  void await_bytes() {
    Clock::time_point deadline = Clock::now() + options_.plane_limit;
    std::uint64_t bytes_read = worker_->bytes_read();
    for (;;) {
      const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
      if (left.count() <= 0) {
        const std::uint64_t by_now = worker_->bytes_read();
        if (by_now == bytes_read) reject_silent();
        bytes_read = by_now;
        deadline = Clock::now() + options_.plane_limit;
        continue;
      }
      pollfd answers{worker_->answers(), POLLIN, 0};
      const milliseconds slice = options_.is_cancelled ? std::min(left, kCancelInterval) : left;
      if (::poll(&answers, 1, static_cast<int>(std::min<std::int64_t>(slice.count(), 1 << 30))) > 0)
        return;
      if (options_.is_cancelled && options_.is_cancelled()) {
        finish(0);
        throw Error(ErrorKind::cancelled, "stopped while reading planes");
      }
    }
  }

  // --- Ends

  std::string place() const { return place_at(z_); }

  static std::string place_at(std::int64_t z) {
    return z < 0 ? " while opening it" : " at plane " + std::to_string(z);
  }

  /// Ends the worker and passes on what it wrote. Returns its status.
  int finish(int patience_ms) {
    const std::unique_ptr<WorkerProcess> worker = std::exchange(worker_, nullptr);
    const int status = worker->end(patience_ms);
    const std::string output = worker->output();
    if (options_.on_output && !output.empty()) options_.on_output(output);
    return status;
  }

  [[noreturn]] void reject(const std::string& why) { reject(why, worker_->note(z_)); }

  [[noreturn]] void reject(const std::string& why, const ReaderNote& note) {
    finish(0);
    throw Error(ErrorKind::source_rejected, why, note.path.empty() ? name_ : note.path);
  }

  [[noreturn]] void reject_silent() {
    const double seconds = std::chrono::duration<double>(options_.plane_limit).count();
    reject("the reader gave nothing for " + precise_text(seconds) + " s" + place() +
           "; the file is damaged, or the drive it lies on does not answer");
  }

  [[noreturn]] void reject_stopped() {
    const int status = worker_->end(kEndPatienceMs);
    const ReaderNote note = worker_->note(z_);
    // It read ahead: the plane it was at is not the one waited for.
    const std::string at = place_at(note.plane >= 0 ? note.plane : z_);
    if (status >= 0 && WIFSIGNALED(status)) {
      const int signal = WTERMSIG(status);
      const char* cause = signal == SIGKILL ? ", perhaps because memory ran out" : "";
      reject("the reader stopped by signal " + signal_text(signal) + at + cause + kAdvice, note);
    }
    if (status >= 0 && WIFEXITED(status)) {
      reject("the reader ended with code " + std::to_string(WEXITSTATUS(status)) + at + kAdvice,
             note);
    }
    reject("the reader ended" + at + kAdvice, note);
  }

  IsolationOptions options_;
  ImportRequest request_;
  std::string name_;
  std::int64_t z_ = -1;  ///< the plane waited for; -1: the description
  std::unique_ptr<WorkerProcess> worker_;
  SourceReport report_;
  std::uint64_t plane_bytes_ = 0;
  PlaneCursor cursor_;
};

}  // namespace

std::unique_ptr<PlaneSource> open_isolated_source(const std::vector<std::string>& paths,
                                                  const SourceOptions& source_options,
                                                  const IsolationOptions& options) {
  if (paths.empty()) throw Error(ErrorKind::invalid_argument, "no source given");
  if (options.plane_limit.count() <= 0) {
    throw Error(ErrorKind::invalid_argument, "the time for a plane must be positive");
  }
  ImportRequest request;
  request.paths = paths;
  request.options = source_options;
  request.threads = std::max(1, options.threads);
  request.memory_bytes = options.memory_bytes;
  request.first_plane = options.first_plane;
  request.end_plane = options.end_plane;
  request.limit_ms = static_cast<std::uint64_t>(options.plane_limit.count());
  return std::make_unique<IsolatedSource>(request, options);
}

}  // namespace octavo
