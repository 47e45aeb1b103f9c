// An .8vo file that Python has open.
#pragma once

#include <nanobind/nanobind.h>

#include <cstdint>
#include <memory>
#include <string>

#include "call.h"
#include "facts.h"
#include "octavo/file/reader.h"

namespace octavo::python {

class OpenFile {
 public:
  /// Of a path. Throws as FileReader::open
  OpenFile(const std::string& path, std::uint64_t cache_bytes);
  /// Of bytes that Python has:
  ///   name, size  the name stands in messages
  ///   read_at     a function of (offset, length) that gives bytes
  /// and where they come from a server:
  ///   fetch       a function of (offsets, lengths) that gives a list of bytes, for all that a read
  ///               needs, the seconds that took and the bytes it asked for
  ///   forget      a function that has all asked for anew from then on
  ///   answers     of the server so far: seconds and bytes of each
  ///   waiters     the Waiters that these functions ask while they wait
  OpenFile(const nanobind::dict& bytes, std::uint64_t cache_bytes);

  const FileReader& reader() const { return *reader_; }
  std::shared_ptr<const FileReader> shared_reader() const { return reader_; }
  const std::shared_ptr<const ByteSource>& source() const { return source_; }
  /// Of those who read it from a server; null where all is at hand.
  const std::shared_ptr<Waiters>& waiters() const { return waiters_; }

 private:
  std::shared_ptr<const ByteSource> source_;
  std::shared_ptr<FileReader> reader_;
  std::shared_ptr<Waiters> waiters_;
};

void bind_reading(nanobind::module_& module);

}  // namespace octavo::python
