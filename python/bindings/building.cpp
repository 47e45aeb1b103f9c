#include "building.h"

#include <unistd.h>

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "asked.h"
#include "call.h"
#include "facts.h"
#include "octavo/builder/builder.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/source/narrowing.h"
#include "octavo/io/zarr/zarr_source.h"
#include "octavo/planes/plane_cursor.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/files/exported_voxels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

/// A plane, [y][x], of the type that was announced.
using Plane = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;

/// Planes of voxels or of wide numbers that `plane_at(z)` gives, in any order.
class PythonPlanes final : public PlaneSource {
 public:
  PythonPlanes(VolumeDescription description, nb::object plane_at, Call& call)
      : description_(std::move(description)), plane_at_(std::move(plane_at)), call_(call) {}

  /// Decides by the first planes what voxels these numbers become.
  /// Throws as choose_narrowing; what Python raised
  void narrow_from(WideType from) {
    const std::uint64_t count =
        plane_bytes(description_) / bytes_per_value(description_.type);
    wide_.resize(count * bytes_per_value(from));
    narrowing_ = choose_narrowing(
        from, description_.size.z, wide_.size(),
        [&](std::int64_t z, std::span<std::byte> numbers) { take_plane(z, numbers); });
    description_.type = narrowing_->to;
    if (narrowing_->rounds) warnings_.push_back(float_rounding_warning());
  }

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  bool can_seek() const override { return true; }
  void seek(std::int64_t first, std::int64_t end) override {
    if (first < 0 || first > end || end > description_.size.z) {
      throw Error(ErrorKind::invalid_argument, "no such planes");
    }
    next_ = first;
  }

  void read_plane(std::span<std::byte> plane) override {
    if (narrowing_) {
      take_plane(next_, wide_);
      narrow(*narrowing_, wide_, plane, {kNoPath, description_.size.x, next_, 0});
    } else {
      take_plane(next_, plane);
    }
    ++next_;
  }

 private:
  void take_plane(std::int64_t z, std::span<std::byte> plane) {
    call_.with_python([&] {
      const auto given = nb::cast<Plane>(plane_at_(z));
      if (given.nbytes() != plane.size()) {
        throw Error(ErrorKind::source_rejected, "plane " + std::to_string(z) + " has " +
                    std::to_string(given.nbytes()) + " bytes instead of " +
                    std::to_string(plane.size()));
      }
      std::memcpy(plane.data(), given.data(), plane.size());
    });
  }

  static inline const std::string kNoPath;  // of an array

  VolumeDescription description_;
  nb::object plane_at_;
  Call& call_;
  std::optional<Narrowing> narrowing_;  // of wide numbers
  std::vector<std::byte> wide_;         // a plane of them
  std::vector<Warning> warnings_;
  std::int64_t next_ = 0;
};

BuildOptions options_of(const nb::dict& given) {
  BuildOptions options;
  options.kind = asked_word<VolumeKind>(given, "kind");
  options.preset = asked_word<Preset>(given, "preset");
  options.access = asked_word_if<Access>(given, "access");
  options.max_error = asked_for<double>(given, "max_error");
  options.keep_details = asked_for<int>(given, "keep_details");
  options.repair = {asked_for<std::optional<float>>(given, "nan"),
                    asked_for<std::optional<float>>(given, "inf")};
  options.has_thumbnail = asked_for<bool>(given, "thumbnail");
  options.overwrite = asked_for<bool>(given, "overwrite");
  const bool is_resuming = asked_for<bool>(given, "resume");
  options.interrupted = is_resuming           ? Interrupted::resume
                        : options.overwrite   ? Interrupted::discard
                                              : Interrupted::reject;
  options.threads = asked_for<int>(given, "threads");
  options.max_memory_bytes = asked_for<std::uint64_t>(given, "max_memory");
  return options;
}

/// Proves words of a build that another program makes. Throws Error{invalid_argument}
void require_words(const nb::dict& given) {
  asked_word_if<VolumeKind>(given, "kind");
  asked_word<Preset>(given, "preset");
  asked_word_if<Access>(given, "access");
}

/// The texts of what a build warns of in passing.
class BuildWarnings {
 public:
  BuildWarnings() {
    context_.on_warning = [this](const Warning& one) { texts_.push_back(one.text); };
  }
  BuildWarnings(const BuildWarnings&) = delete;
  BuildWarnings& operator=(const BuildWarnings&) = delete;

  /// Must not outlive this.
  ClippedListener listener(const std::string& path) const {
    return clipped_listener(path, context_);
  }
  const TaskContext& context() const { return context_; }
  void add(const std::vector<Warning>& of_planes) {
    for (const Warning& one : of_planes) context_.on_warning(one);
  }
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  TaskContext context_;
  std::vector<std::string> texts_;
};

/// Returns what it warns of.
std::vector<std::string> build(const std::string& path, const Zyx& shape, const nb::dict& facts,
                               nb::object plane_at, const nb::dict& given,
                               nb::object on_progress) {
  Call call(std::move(on_progress));
  PythonPlanes planes(description_of(shape, facts), std::move(plane_at), call);
  BuildOptions options = options_of(given);
  BuildWarnings warnings;
  options.on_clipped = warnings.listener(path);
  const std::optional<WideType> wide = given_type(facts).wide();
  call.run_apart([&] {
    require_free({path, options.overwrite});
    if (wide) planes.narrow_from(*wide);
    build_file(planes, local_storage(), path, options, call);
  });
  warnings.add(planes.warnings());
  return warnings.texts();
}

/// Builds what open_zarr_source reads. Returns the warnings (of the source, of the build).
nb::tuple build_zarr(const std::string& source, const std::string& path, const nb::dict& asked,
                     const nb::dict& given, nb::object on_progress) {
  Call call(std::move(on_progress));
  SourceOptions how;
  how.channel = asked_for<std::string>(asked, "channel");
  how.time = asked_for<std::optional<std::int64_t>>(asked, "time");
  if (const auto zyx = asked_for<std::optional<std::array<double, 3>>>(asked, "spacing")) {
    how.spacing_mm = xyz_of(*zyx);
  }
  how.max_memory_bytes = asked_for<std::uint64_t>(given, "max_memory");
  const int threads = asked_for<int>(given, "threads");
  how.threads = threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency());
  const auto kind = asked_word_if<VolumeKind>(asked, "kind");
  const int level = asked_for<int>(asked, "level");
  BuildOptions options = options_of(given);
  const BuildWarnings of_build;
  options.on_clipped = of_build.listener(path);
  std::vector<Warning> warnings;
  call.run_apart([&] {
    require_free({path, options.overwrite});
    const auto planes = open_zarr_source(source, how, level);
    options.kind = kind.value_or(planes->description().kind);
    const BuildResult built = build_file(*planes, local_storage(), path, options, call);
    compare_with_export(planes->files().voxels_sha256, options.repair, built, source, path,
                        of_build.context());
    warnings = planes->warnings();
  });
  return nb::make_tuple(list_of(warnings, [](const Warning& one) { return one.text; }),
                        of_build.texts());
}

/// Planes that one thread hands over and another one, the builder's, takes: one waits at a time.
class HandedPlanes final : public PlaneSource {
 public:
  explicit HandedPlanes(VolumeDescription description) : description_(std::move(description)) {}

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  bool can_seek() const override { return false; }

  void seek(std::int64_t first, std::int64_t) override {
    if (first < taken_) {
      throw Error(ErrorKind::invalid_argument,
                  "planes that came one after another cannot be read again: give an array that "
                  "can, or more memory").with_field("max_memory");
    }
    pass_until(first);
  }

  void read_plane(std::span<std::byte> plane) override {
    std::unique_lock guard(lock_);
    changed_.wait(guard, [&] { return is_full_ || is_over_; });
    if (!is_full_) throw Error(ErrorKind::cancelled, "stopped");
    std::memcpy(plane.data(), plane_.data(), plane.size());
    is_full_ = false;
    ++taken_;
    changed_.notify_all();
  }

  /// Waits until there is room. False when the builder takes no more.
  /// Throws Error{cancelled} when `call` is to end
  bool hand_over(std::span<const std::byte> plane, const Call& call) {
    std::unique_lock guard(lock_);
    while (!changed_.wait_for(guard, kPause, [&] { return !is_full_ || is_over_; })) {
      if (call.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    }
    if (is_over_) return false;
    plane_.assign(plane.begin(), plane.end());
    is_full_ = true;
    changed_.notify_all();
    return true;
  }

  /// Waits until nobody takes any more. False when that lasts longer than a look for signals may.
  bool wait_for_end() {
    std::unique_lock guard(lock_);
    return changed_.wait_for(guard, kPause, [&] { return is_over_; });
  }

  /// Nobody gives or takes any more.
  void end() {
    const std::lock_guard guard(lock_);
    is_over_ = true;
    changed_.notify_all();
  }

 private:
  static constexpr std::chrono::milliseconds kPause{50};  // between two looks for signals

  void pass_until(std::int64_t first) {
    std::vector<std::byte> passed(plane_bytes(description_));
    while (taken_ < first) read_plane(passed);
  }

  VolumeDescription description_;
  std::vector<Warning> warnings_;
  std::mutex lock_;  // of all below
  std::condition_variable changed_;
  std::vector<std::byte> plane_;
  bool is_full_ = false;
  bool is_over_ = false;
  std::int64_t taken_ = 0;  // by the builder alone
};

/// Cancels the build of a writer that was closed early.
class Stop final : public Progress {
 public:
  void begin(std::string_view, std::int64_t, std::string_view) override {}
  void advance(std::int64_t) override {}
  void end() override {}
  bool is_cancelled() const override { return is_stopped; }
  std::atomic<bool> is_stopped{false};
};

/// Planes that come once cannot choose first what wide numbers become.
/// Throws Error{invalid_argument} for them
void require_voxels(StoredType type) {
  if (!type.wide()) return;
  throw Error(ErrorKind::invalid_argument,
              "what " + std::string(stored_type_name(type)) +
                  " becomes follows from the values, and planes that come one after another are "
                  "not read twice: give them as int32, uint32 or float32")
      .with_field("dtype");
}

/// A build whose planes are pushed: a thread of its own pulls them.
class PlaneWriter {
 public:
  PlaneWriter(const std::string& path, const Zyx& shape, const nb::dict& facts,
              const nb::dict& given)
      : planes_(description_of(shape, facts)), options_(options_of(given)), path_(path) {
    require_voxels(given_type(facts));
    require_free({path, options_.overwrite});
    options_.on_clipped = warnings_.listener(path);
    thread_ = std::thread([this] { work(); });
  }

  ~PlaneWriter() {
    const nb::gil_scoped_release release;
    stop();
  }

  /// Throws what the build threw, from then on with every plane.
  void add(const Plane& plane) {
    const Turn turn(turn_);
    const VolumeDescription& volume = planes_.description();
    if (plane.nbytes() != plane_bytes(volume)) {
      throw Error(ErrorKind::invalid_argument, "the plane has another size than the others",
                  path_);
    }
    if (added_ == volume.size.z) {
      throw Error(ErrorKind::invalid_argument, "all " + std::to_string(added_.load()) +
                  " planes were added", path_);
    }
    const std::span bytes(static_cast<const std::byte*>(plane.data()), plane.nbytes());
    // With the last plane the builder would seal the file, which is for finish() to say.
    if (added_ + 1 == volume.size.z) last_.assign(bytes.begin(), bytes.end());
    else hand_over(bytes);
    ++added_;
  }

  /// Seals the file. Returns what its build warns of.
  std::vector<std::string> finish() {
    const Turn turn(turn_);
    const std::int64_t wanted = planes_.description().size.z;
    if (added_ != wanted) {
      {
        const nb::gil_scoped_release release;
        stop();
      }
      throw Error(ErrorKind::invalid_argument, std::to_string(added_.load()) + " of " +
                  std::to_string(wanted) + " planes were added; nothing was written", path_);
    }
    hand_over(last_);
    wait();
    if (failure_) std::rethrow_exception(failure_);
    return warnings_.texts();
  }

  /// Leaves nothing under the name; what can be resumed is kept where that was asked for.
  void abandon() {
    const Turn turn(turn_);
    const nb::gil_scoped_release release;
    stop();
  }

  std::int64_t added() const { return added_; }

 private:
  /// One thread of Python after the other; who waits lets go of the GIL.
  class Turn {
   public:
    explicit Turn(std::mutex& turn) : guard_(turn, std::defer_lock) {
      const nb::gil_scoped_release release;
      guard_.lock();
    }

   private:
    std::unique_lock<std::mutex> guard_;
  };

  void hand_over(std::span<const std::byte> plane) {
    Call call;
    call.run([&] {
      if (!planes_.hand_over(plane, call)) join();
    });
    if (failure_) std::rethrow_exception(failure_);
  }

  /// Until the file is sealed. Throws what a signal handler raised meanwhile, which ends the build.
  void wait() {
    Call call;
    call.run([&] {
      while (!planes_.wait_for_end()) {
        if (!call.is_cancelled()) continue;
        stop_.is_stopped = true;
        break;
      }
      join();
    });
    call.throw_kept();
  }

  void work() {
    try {
      build_file(planes_, local_storage(), path_, options_, stop_);
    } catch (...) {
      failure_ = std::current_exception();
    }
    planes_.end();
  }

  void join() {
    if (thread_.joinable()) thread_.join();
  }

  void stop() {
    stop_.is_stopped = true;
    planes_.end();
    join();
  }

  HandedPlanes planes_;
  BuildOptions options_;
  std::string path_;
  std::vector<std::byte> last_;  // plane of all
  Stop stop_;
  BuildWarnings warnings_;       // these two are read once the thread has ended
  std::exception_ptr failure_;
  std::mutex turn_;
  std::atomic<std::int64_t> added_ = 0;
  std::thread thread_;
};

/// A writer of the process that opened it. In forked ones, where its threads are not, it is left as
/// it is: nothing waits for them, and the file stays with that process.
class OwnedWriter {
 public:
  OwnedWriter(const std::string& path, const Zyx& shape, const nb::dict& facts,
              const nb::dict& given)
      : writer_(std::make_unique<PlaneWriter>(path, shape, facts, given)), path_(path) {}

  ~OwnedWriter() {
    // Of another process, its locks may be held by threads that are not here.
    if (!is_own()) static_cast<void>(writer_.release());
  }

  void add(const Plane& plane) { own().add(plane); }
  std::vector<std::string> finish() { return own().finish(); }
  void abandon() {
    if (is_own()) writer_->abandon();
  }
  std::int64_t added() const { return writer_->added(); }

 private:
  bool is_own() const { return process_ == getpid(); }

  PlaneWriter& own() {
    if (is_own()) return *writer_;
    throw Error(ErrorKind::invalid_argument,
                "the writer was opened by another process, which alone adds planes and seals the "
                "file",
                path_);
  }

  std::unique_ptr<PlaneWriter> writer_;
  std::string path_;
  pid_t process_ = getpid();
};

}  // namespace

void bind_building(nb::module_& module) {
  module.def("build", &build, "path"_a, "shape"_a, "facts"_a, "plane_at"_a, "options"_a,
             "on_progress"_a.none());
  module.def("build_zarr", &build_zarr, "source"_a, "path"_a, "asked"_a, "options"_a,
             "on_progress"_a.none());
  module.def("require_words", &require_words, "options"_a);
  module.def("is_zarr", &is_zarr_source, "path"_a);
  nb::class_<OwnedWriter>(module, "PlaneWriter")
      .def(nb::init<const std::string&, const Zyx&, const nb::dict&, const nb::dict&>(), "path"_a,
           "shape"_a, "facts"_a, "options"_a)
      .def("add", &OwnedWriter::add, "plane"_a)
      .def("finish", &OwnedWriter::finish)
      .def("abandon", &OwnedWriter::abandon)
      .def_prop_ro("added", &OwnedWriter::added);
}

}  // namespace octavo::python
