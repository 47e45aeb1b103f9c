// Numbers and words on their way into a file, one after another.
#pragma once

#include <string_view>

#include "octavo/core/progress.h"
#include "octavo/mesh/formats/mesh_bytes.h"

namespace octavo {

/// Appends to a file; what is left is written by `finish`. With every megabyte it throws
/// Error{cancelled} where the one who watches asked to stop.
class FileText {
 public:
  FileText(PendingFile& file, const Progress& watcher) : bytes_(file, watcher) {}

  FileText& text(std::string_view text) {
    bytes_.text(text);
    return *this;
  }
  /// The shortest digits that read back as the same number.
  template <class T>
  FileText& digits(T value) {
    bytes_.digits(value);
    return *this;
  }
  /// The bytes of a number, the lowest first.
  template <class T>
  FileText& number(T value) {
    bytes_.number(value);
    return *this;
  }
  void finish() { bytes_.flush(); }

 private:
  MeshBytes bytes_;
};

}  // namespace octavo
