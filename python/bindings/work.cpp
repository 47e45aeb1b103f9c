#include "work.h"

#include <nanobind/stl/string.h>

#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/io/http/http_source.h"

namespace octavo {

namespace {

// Tasks open their inputs on the thread that calls them.
thread_local std::map<std::string, std::shared_ptr<const ByteSource>> named_sources;

/// The bytes of a file that is open already.
class BorrowedSource final : public ByteSource {
 public:
  explicit BorrowedSource(std::shared_ptr<const ByteSource> source) : source_(std::move(source)) {}
  std::uint64_t size() const override { return source_->size(); }
  const std::string& name() const override { return source_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    source_->read(offset, out);
  }
  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override {
    return source_->missing(ranges);
  }
  std::uint64_t fetched_bytes_kept() const override { return source_->fetched_bytes_kept(); }
  std::uint64_t bytes_per_round() const override { return source_->bytes_per_round(); }
  void fetch(std::span<const ByteRange> ranges) const override { source_->fetch(ranges); }
  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges) const override {
    return source_->hold(ranges);
  }
  bool forget(std::span<const ByteRange> ranges) const override { return source_->forget(ranges); }

 private:
  std::shared_ptr<const ByteSource> source_;
};

}  // namespace

// In the place of the library's own: what Python has open is not opened anew, and URLs are read
// through fsspec, so that no client for them is linked.
std::shared_ptr<ByteSource> open_any(const std::string& path, const HttpOptions&) {
  const auto named = named_sources.find(path);
  if (named != named_sources.end()) return std::make_shared<BorrowedSource>(named->second);
  if (is_url(path)) {
    throw Error(ErrorKind::invalid_argument, "open it with octavo.open first", public_name(path));
  }
  return open_byte_source(local_storage(), path);
}

}  // namespace octavo

namespace octavo::python {

namespace nb = nanobind;

Work::Inputs::Inputs(const std::vector<NamedFile>& files)
    : around_(std::exchange(named_sources, {})) {
  for (const NamedFile& file : files) {
    if (file.file != nullptr) named_sources[file.name] = file.file->source();
  }
}

Work::Inputs::~Inputs() { named_sources = std::move(around_); }

FilesRead Work::files_read(const std::vector<NamedFile>& files) {
  FilesRead read;
  for (const NamedFile& file : files) {
    if (file.file != nullptr) read.push_back(file.file->waiters());
  }
  return read;
}

Work::Work(const nb::dict& given) : call_(given["progress"]) {
  context_.threads = nb::cast<int>(given["threads"]);
  context_.max_memory_bytes = nb::cast<std::uint64_t>(given["max_memory"]);
  context_.progress = &call_;
  context_.on_warning = [this, caller = PyThread_get_thread_ident()](const Warning& warning) {
    call_.with_python([&] {
      nb::module_::import_("octavo._work").attr("warn_of")(nb::make_tuple(warning.text), caller);
    });
  };
}

}  // namespace octavo::python
