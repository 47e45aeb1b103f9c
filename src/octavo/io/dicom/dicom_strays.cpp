#include "octavo/io/dicom/dicom_strays.h"

#include <set>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

bool is_companion(const std::string& path) {
  static const std::set<std::string> kEndings = {
      ".txt", ".xml", ".pdf", ".ini", ".inf",  ".json", ".csv", ".html", ".htm", ".md", ".log",
      ".jpg", ".jpeg", ".png", ".bmp", ".gif", ".exe",  ".dll", ".js",   ".css"};
  static const std::set<std::string> kNames = {"thumbs.db", "readme", "license", "version"};
  const std::string name = lower_case(base_name(path));
  if (name.starts_with('.') || kNames.contains(name)) return true;
  const std::size_t dot = name.rfind('.');
  return dot != std::string::npos && kEndings.contains(name.substr(dot));
}

}  // namespace

void DicomStrays::add(const std::string& path, bool is_alone) {
  if (!is_alone && is_companion(path)) return;
  if (SourceFile(path).size() == 0) {
    const char* remedy =
        "; it may have been a slice: copy it again from its origin, or remove it from the folder";
    throw Error(ErrorKind::source_rejected,
                std::string("the file is empty") + (is_alone ? "" : remedy), path);
  }
  if (is_alone || has_ending(path, ".dcm")) {
    throw Error(ErrorKind::source_rejected,
                "not a DICOM file: the DICM mark is missing; remove it from the folder", path);
  }
  paths_.push_back(path);
}

std::string DicomStrays::warning() const {
  if (paths_.empty()) return "";
  const std::string example = escaped(base_name(paths_.front()));
  if (paths_.size() == 1) return "1 file that is not DICOM left out: " + example;
  return std::to_string(paths_.size()) + " files that are not DICOM left out, among them " +
         example;
}

}  // namespace octavo
