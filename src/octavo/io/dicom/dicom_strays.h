// Files beside DICOM ones that are no slices: which of them go without a word.
#pragma once

#include <string>
#include <vector>

namespace octavo {

/// Files that lie in a folder of DICOM files and are not DICOM themselves.
class DicomStrays {
 public:
  /// is_alone  nothing else was given
  /// Throws Error{source_rejected} where `path` must be a slice: it is alone or named .dcm, or
  ///        empty and no companion; Error{io}
  void add(const std::string& path, bool is_alone);

  /// What to say of those that may have been slices: companions of scans (texts, pages, previews,
  /// programs, hidden files) are not. Empty where there are none.
  std::string warning() const;

 private:
  std::vector<std::string> paths_;
};

}  // namespace octavo
