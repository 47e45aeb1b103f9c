#include "octavo/tasks/open_scan.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/io/isolation/isolated_source.h"
#include "octavo/io/open_source.h"
#include "octavo/io/source/prefetch_source.h"
#include "octavo/io/source/slice_source.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

/// Passes the warnings of a source on as they come up.
class WatchedSource final : public PlaneSource {
 public:
  WatchedSource(std::unique_ptr<PlaneSource> source, TaskContext context)
      : source_(std::move(source)), context_(std::move(context)) {
    pass_warnings_on();
  }

  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  std::uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  const PlaneFiles& files() const override { return source_->files(); }

  void read_plane(std::span<std::byte> plane) override {
    source_->read_plane(plane);
    pass_warnings_on();
  }

  bool can_seek() const override { return source_->can_seek(); }
  void seek(std::int64_t first, std::int64_t end) override { source_->seek(first, end); }

 private:
  void pass_warnings_on() {
    const std::vector<Warning>& all = source_->warnings();
    while (passed_ < all.size()) context_.warn(all[passed_++]);
  }

  std::unique_ptr<PlaneSource> source_;
  TaskContext context_;
  std::size_t passed_ = 0;
};

/// The first option set here that says how a scan is read; or nothing. What is kept of its identity
/// is none.
const char* scan_field(const SourceOptions& options) {
  if (options.raw) return "scan.raw";
  if (options.spacing_mm) return "scan.spacing_mm";
  if (!options.channel.empty()) return "scan.channel";
  if (options.time) return "scan.time";
  if (!options.series.empty()) return "scan.series";
  if (!options.segment.empty()) return "scan.segment";
  if (options.on_gap != GapPolicy::error) return "scan.on_gap";
  if (options.drop_duplicates) return "scan.drop_duplicates";
  return options.untilt ? "scan.untilt" : nullptr;
}

IsolationOptions isolation_options(const TaskContext& context) {
  IsolationOptions options;
  options.command = context.worker_command;
  options.threads = context.thread_count();
  options.is_cancelled = [&watcher = context.watcher()] { return watcher.is_cancelled(); };
  options.on_output = [context](const std::string& output) {
    std::istringstream lines(output);
    for (std::string line; std::getline(lines, line);) context.detail("reader: " + line);
  };
  return options;
}

SourceOptions source_options(const ScanOptions& options, const TaskContext& context) {
  SourceOptions how = options.source;
  how.max_memory_bytes = context.max_memory_bytes;
  how.threads = context.thread_count();
  how.is_cancelled = [&watcher = context.watcher()] { return watcher.is_cancelled(); };
  return how;
}

/// In the process that the options and the files call for.
std::unique_ptr<PlaneSource> opened(const std::vector<std::string>& paths, bool is_isolated,
                                    const SourceOptions& how, const TaskContext& context) {
  if (is_isolated && !context.worker_command.empty() && needs_isolation(paths, how)) {
    return open_isolated_source(paths, how, isolation_options(context));
  }
  return make_prefetch_source(open_source(paths, how), {.threads = context.thread_count()});
}

}  // namespace

void require_scan_for_options(const std::vector<std::string>& paths, const ScanOptions& options) {
  const char* field = scan_field(options.source);
  if (field == nullptr || !std::all_of(paths.begin(), paths.end(), is_octavo_path)) return;
  throw Error(ErrorKind::invalid_argument, "is an .8vo file, not a scan to be read in a given way",
              paths.front())
      .with_field(field);
}

std::unique_ptr<PlaneSource> open_scan(const std::vector<std::string>& paths,
                                       const ScanOptions& options, const TaskContext& context) {
  auto source = opened(paths, options.is_isolated, source_options(options, context), context);
  context.require_voxels(source->description().size, paths.front());
  return std::make_unique<WatchedSource>(std::move(source), context);
}

std::unique_ptr<PlaneSource> open_slices(const SliceStack& stack, const ScanOptions& options,
                                         const TaskContext& context) {
  const auto open = [is_isolated = options.is_isolated, context](
                        const std::vector<std::string>& paths, const SourceOptions& how) {
    return opened(paths, is_isolated, how, context);
  };
  return std::make_unique<WatchedSource>(
      make_slice_source(stack, source_options(options, context), open), context);
}

std::unique_ptr<PlaneSource> open_planes(const std::vector<std::string>& paths,
                                         const ScanOptions& options, const TaskContext& context,
                                         OptionsOf which) {
  if (paths.size() == 1 && is_octavo_path(paths.front())) {
    if (which == OptionsOf::this_source) require_scan_for_options(paths, options);
    return std::make_unique<FilePlanes>(open_volume(paths.front(), context), 0,
                                        context.thread_count(), options.source.keep_identity);
  }
  return open_scan(paths, options, context);
}

}  // namespace octavo
