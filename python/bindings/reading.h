// An .8vo file that Python has open.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "facts.h"
#include "octavo/file/reader.h"

namespace octavo::python {

class OpenFile {
 public:
  /// Seconds and bytes of each.
  using Answers = std::vector<std::pair<double, std::uint64_t>>;

  /// Of a path. Throws as FileReader::open
  OpenFile(const std::string& path, std::uint64_t cache_bytes);
  /// Of what `read_at(offset, length)` gives as bytes: `size` of them. `name` stands in messages.
  /// fetch    a function of (offsets, lengths) that gives a list of bytes, for all that a read
  ///          needs, the seconds that took and the bytes it asked for; or None: all is at hand
  /// answers  of the server so far
  OpenFile(nanobind::object read_at, nanobind::object fetch, std::uint64_t size,
           const std::string& name, std::uint64_t cache_bytes, const Answers& answers);

  const FileReader& reader() const { return *reader_; }
  std::shared_ptr<const FileReader> shared_reader() const { return reader_; }
  const std::shared_ptr<const ByteSource>& source() const { return source_; }
  /// Fetches everything anew from now on.
  void forget() const {
    if (forget_) forget_();
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  std::shared_ptr<FileReader> reader_;
  std::function<void()> forget_;
};

void bind_reading(nanobind::module_& module);

}  // namespace octavo::python
