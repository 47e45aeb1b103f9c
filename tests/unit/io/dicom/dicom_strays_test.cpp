// Files without a picture among slices.
#include "octavo/io/dicom/dicom_strays.h"

#include <gtest/gtest.h>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kClassTag = 0x00080016;
constexpr const char* kStorage = "1.2.840.10008.5.1.4.1.1.";

void write_slices(const TempFolder& folder) {
  for (int z = 0; z < 3; ++z) {
    ct_elements(3, 2, 8, z).write(folder.file("s" + std::to_string(z)), kExplicitLittle);
  }
}

/// A file of a SOP class that says nothing else, not even the class where that is empty.
DicomElements file_of_class(const std::string& sop_class) {
  DicomElements file;
  if (!sop_class.empty()) file.set(kClassTag, "UI", sop_class);
  file.set(0x00080060, "CS", "OT");
  file.set(0x0020000e, "UI", "1.2.3");
  return file;
}

DicomElements with_size(DicomElements file) {
  file.set_number(0x00280010, 2);
  file.set_number(0x00280011, 3);
  return file;
}

/// Writes `file` with its class in the file meta information alone.
void write_with_meta_class(const std::string& path, const std::string& sop_class,
                           const DicomElements& file) {
  DicomElements meta;
  meta.set(0x00020002, "UI", sop_class);
  meta.set(0x00020010, "UI", kExplicitLittle);
  write_file(path, std::string(128, '\0') + "DICM" + meta.bytes() + file.bytes());
}

TEST(DicomStrays, ASliceCutAnywhereIsRejectedByItsName) {
  const TempFolder folder;
  write_slices(folder);
  const std::string whole = read_file(folder.file("s2"));
  for (std::size_t size = 132; size < whole.size(); ++size) {
    write_file(folder.file("s2"), whole.substr(0, size));
    const Error error = source_error({folder.path()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << size;
    EXPECT_TRUE(contains(error, "s2")) << size << error.what();
    EXPECT_TRUE(contains(error, "copy it again from its origin")) << size << error.what();
  }
}

TEST(DicomStrays, APictureWithoutPixelDataIsRejectedByItsName) {
  const TempFolder folder;
  write_slices(folder);
  const std::string path = folder.file("lost");
  for (const char* number : {"1", "1.1.1", "2", "2.1", "4", "4.1", "5", "6.1", "7", "12.1", "14.1",
                             "20", "30", "66.4", "66.7", "77.1.6", "128", "130", "481.1"}) {
    file_of_class(std::string(kStorage) + number).write(path, kExplicitLittle);
    expect_rejected(folder.path(), {"lost", "without pixel data", "may have been a slice"});
    write_with_meta_class(path, std::string(kStorage) + number, file_of_class(""));
    expect_rejected(folder.path(), {"lost", "without pixel data", "may have been a slice"});
  }
  for (const std::string& sop_class :
       {std::string(), std::string("1.3.12.2.1107.5.9.1"), kStorage + std::string("481.2")}) {
    with_size(file_of_class(sop_class)).write(path, kExplicitLittle);
    expect_rejected(folder.path(), {"lost", "without pixel data", "may have been a slice"});
  }
  file_of_class("").write(path, kExplicitLittle);
  expect_rejected(folder.path(), {"lost", "does not say what it is"});
  write_with_meta_class(path, kStorage + std::string("88.11"), DicomElements());
  expect_rejected(folder.path(), {"lost", "nothing stands behind"});
}

TEST(DicomStrays, WhatHoldsNoPictureByItsKindIsLeftOutByName) {
  const TempFolder folder;
  write_slices(folder);
  std::vector<DicomElements> files;
  for (const char* number : {"11.1", "66", "66.1", "66.5", "77.1.5.3", "88.11", "104.1", "481.2",
                             "481.3", "481.5", "481.10"}) {
    files.push_back(file_of_class(std::string(kStorage) + number));
  }
  files.push_back(with_size(file_of_class(std::string(kStorage) + "4.2")));  // of spectra
  files.push_back(file_of_class("1.3.12.2.1107.5.9.1"));
  for (const DicomElements& file : files) {
    file.write(folder.file("report"), kExplicitLittle);
    const auto source = open_source({folder.path()}, {});
    EXPECT_EQ(source->description().size.z, 3);
    EXPECT_EQ(source->warnings(),
              std::vector<Warning>{"1 DICOM file without a picture (directories, reports) left "
                                   "out: report"});
  }
  write_with_meta_class(folder.file("DICOMDIR"), "1.2.840.10008.1.3.10", file_of_class(""));
  EXPECT_EQ(open_source({folder.path()}, {})->warnings(),
            std::vector<Warning>{"2 DICOM files without a picture (directories, reports) left "
                                 "out, among them DICOMDIR"});
}

TEST(DicomStrays, AloneNothingIsLeftOut) {
  const TempFolder folder;
  file_of_class(kStorage + std::string("88.11")).write(folder.file("sr"), kExplicitLittle);
  expect_rejected(folder.file("sr"), {"no DICOM file with a picture found"});
  file_of_class(kStorage + std::string("2")).write(folder.file("ct"), kExplicitLittle);
  expect_rejected(folder.file("ct"), {"ct", "without pixel data"});
}

}  // namespace
}  // namespace octavo::testing
