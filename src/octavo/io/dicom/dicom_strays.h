// Files beside slices that are none: which of them may have been slices, and which go without a
// word.
#pragma once

#include <string>
#include <vector>

#include "octavo/io/dicom/dicom_file.h"

namespace octavo {

/// Proves that a file without pixel data has none by its kind: a directory, a report, a plan.
/// Throws Error{source_rejected} where it is a picture by its SOP class or by Rows and Columns,
///        does not say what it is, or ends with its file meta information: it may have been cut
void require_no_picture(const DicomFile& file);

/// Files that lie among slices and are left out.
class DicomStrays {
 public:
  /// A file that is not DICOM.
  /// is_alone  nothing else was given
  /// Throws Error{source_rejected} where `path` must be a slice: it is alone or named .dcm, or
  ///        empty and no companion; Error{io}
  void add(const std::string& path, bool is_alone);
  /// A DICOM file that has no picture by its kind.
  void add_without_picture(const std::string& path) { without_picture_.push_back(path); }

  /// What to say of them. Of files that are not DICOM, companions of scans (texts, pages, previews,
  /// programs, hidden files) are not worth a word.
  std::vector<std::string> warnings() const;

 private:
  std::vector<std::string> without_picture_;
  std::vector<std::string> not_dicom_;
};

}  // namespace octavo
