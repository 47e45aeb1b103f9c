#include "octavo/io/dicom/dicom_strays.h"

#include <set>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr DicomTag kSopClass = 0x00080016;
constexpr DicomTag kRows = 0x00280010;
constexpr DicomTag kColumns = 0x00280011;
constexpr DicomTag kFirstOfDirectory = 0x00040000;
constexpr DicomTag kFirstOfIdentity = 0x00080000;
constexpr std::string_view kStorage = "1.2.840.10008.5.1.4.1.1.";
constexpr const char* kRemedy =
    "; it may have been a slice: copy it again from its origin, or leave it out";

/// True of the storage classes whose objects always have pixel data. Each number stands for those
/// that go on with it, too; a dose (481.2) may be curves alone.
/// Source: DICOM PS3.4, B.5 (Standard SOP Classes)
bool is_picture_class(const std::string& uid) {
  static const std::set<std::string_view> kPictures = {
      "1",  "2",  "3",   "4",   "5",    "6",    "7",    "12",   "13",   "14",   "20",
      "30", "77", "128", "130", "66.4", "66.7", "66.8", "81.1", "82.1", "481.1"};
  static const std::set<std::string_view> kOthers = {
      "4.2",        // MR Spectroscopy Storage
      "77.1.5.3"};  // Stereometric Relationship Storage
  if (!uid.starts_with(kStorage)) return false;
  std::string_view number = std::string_view(uid).substr(kStorage.size());
  if (kOthers.contains(number)) return false;
  while (!kPictures.contains(number)) {
    const std::size_t dot = number.rfind('.');
    if (dot == std::string_view::npos) return false;
    number = number.substr(0, dot);
  }
  return true;
}

bool has_spectra(const std::string& uid) { return uid == std::string(kStorage) + "4.2"; }

/// True where a file holds an element of `first` or above, and below `end`.
bool holds_any(const DicomFile& file, DicomTag first, DicomTag end) {
  const auto found = file.element_counts.lower_bound(first);
  return found != file.element_counts.end() && found->first < end;
}

std::string left_out_text(const std::vector<std::string>& paths, const char* one,
                          const char* several) {
  const std::string example = escaped(base_name(paths.front()));
  if (paths.size() == 1) return std::string("1 ") + one + " left out: " + example;
  return std::to_string(paths.size()) + " " + several + " left out, among them " + example;
}

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

void require_no_picture(const DicomFile& file) {
  const auto reject = [&](const char* why) {
    throw Error(ErrorKind::source_rejected, std::string(why) + kRemedy, file.path);
  };
  const bool is_directory = holds_any(file, kFirstOfDirectory, kFirstOfIdentity);
  if (file.private_count == 0 && !holds_any(file, kFirstOfDirectory, ~DicomTag{0})) {
    reject("nothing stands behind its file meta information (group 0002)");
  }
  const std::string own_class = file.data.text(kSopClass);
  const std::string& sop_class = own_class.empty() ? file.media_class : own_class;
  const bool has_size = file.data.has(kRows) || file.data.has(kColumns);
  if (is_picture_class(sop_class) || (has_size && !has_spectra(sop_class))) {
    reject("a picture without pixel data (7fe0,0010)");
  }
  if (sop_class.empty() && !is_directory) {
    reject("it holds no pixel data and does not say what it is (SOP Class UID (0008,0016))");
  }
}

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
  not_dicom_.push_back(path);
}

std::vector<std::string> DicomStrays::warnings() const {
  std::vector<std::string> texts;
  if (!without_picture_.empty()) {
    texts.push_back(left_out_text(without_picture_,
                                  "DICOM file without a picture (directories, reports)",
                                  "DICOM files without a picture (directories, reports)"));
  }
  if (!not_dicom_.empty()) {
    texts.push_back(left_out_text(not_dicom_, "file that is not DICOM",
                                  "files that are not DICOM"));
  }
  return texts;
}

}  // namespace octavo
